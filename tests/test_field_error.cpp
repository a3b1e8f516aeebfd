#include "fields/field_error.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "fields/field_precompute.h"
#include "tests/example_meshes.h"

namespace haarfield {
namespace {

PreparedMesh example_mesh() {
    return prepared_as_is(
        joined_meshes(sphere_mesh({0, 0.6f, 0}, 0.4f, 12), box_mesh({-0.8f, 0, -0.1f}, {0.8f, 0.3f, 0.1f})));
}

VisibilityField field_of(const PreparedMesh& mesh, const EntityOcclusion& occlusion, float relative_l2_error,
                         std::uint32_t samples) {
    return *precompute_field("example", mesh, occlusion, {16, 0, relative_l2_error, samples, samples});
}

TEST(FieldError, IsOneWhereTheFieldKnowsOfNoOcclusion) {
    const PreparedMesh mesh = example_mesh();
    const EntityOcclusion occlusion(mesh);
    VisibilityField field = field_of(mesh, occlusion, 0, 100);
    CubemapTree open;
    for (Quadtree& face : open.faces) face.scaling = 1;
    PackedTrees packed;
    pack_trees(open, packed);
    QuadtreePoolBuilder pool(16);
    pool.add(packed);
    field.pool = std::move(pool).finish();
    for (auto* handles : {&field.planar_handles, &field.spherical_handles})
        std::fill(handles->begin(), handles->end(), 0);
    const FieldError error = field_error(field, occlusion);
    EXPECT_NEAR(error.planar, 1, 1e-6);
    EXPECT_NEAR(error.spherical, 1, 1e-6);
}

TEST(FieldError, FallsWithMoreSamplesAndLessTruncation) {
    const PreparedMesh mesh = example_mesh();
    const EntityOcclusion occlusion(mesh);
    const FieldError fine = field_error(field_of(mesh, occlusion, 0, 6000), occlusion),
                     coarse = field_error(field_of(mesh, occlusion, 0, 300), occlusion),
                     truncated = field_error(field_of(mesh, occlusion, 0.4f, 6000), occlusion);
    EXPECT_GT(fine.planar, 0.001f);
    EXPECT_LT(fine.planar, 0.3f);
    EXPECT_GT(fine.spherical, 0.001f);
    EXPECT_LT(fine.spherical, 0.5f);
    EXPECT_GT(coarse.planar, 1.5f * fine.planar);
    EXPECT_GT(coarse.spherical, 1.5f * fine.spherical);
    EXPECT_GT(truncated.planar, fine.planar + 0.05f);
    EXPECT_GT(truncated.spherical, fine.spherical + 0.05f);
}

TEST(FieldError, IsStoredInTheFieldAndDoesNotDependOnTheThreads) {
    const PreparedMesh mesh = example_mesh();
    const EntityOcclusion occlusion(mesh);
    const VisibilityField field = field_of(mesh, occlusion, 0.1f, 500);
    EXPECT_GT(field.error.planar, 0);
    for (const std::size_t threads : {1u, 2u, 8u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        EXPECT_EQ(field_error(field, occlusion), field.error);
    }
}

}  // namespace
}  // namespace haarfield
