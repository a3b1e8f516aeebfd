#include "fields/field/field_error.h"

#include <gtest/gtest.h>

#include "fields/field/field_precompute.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/with_threads.h"

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

/// Returns the field without any occlusion.
VisibilityField open_field(VisibilityField field) {
    CubemapTree open;
    for (Quadtree& face : open.faces) face.scaling = 1;
    PackedTrees packed;
    pack_trees(open, packed);
    QuadtreePoolBuilder pool(16);
    pool.add(packed);
    field.pool = std::move(pool).finish();
    for (auto* handles : {&field.planar_handles, &field.spherical_handles})
        std::fill(handles->begin(), handles->end(), 0);
    return field;
}

TEST(FieldError, IsOneWhereTheFieldHasNoOcclusion) {
    const PreparedMesh mesh = example_mesh();
    const EntityOcclusion occlusion(mesh);
    const FieldError error = field_error(open_field(field_of(mesh, occlusion, 0, 100)), occlusion);
    EXPECT_NEAR(error.planar.relative, 1, 1e-6);
    EXPECT_NEAR(error.spherical.relative, 1, 1e-6);
}

TEST(FieldError, OfAMissingSphereFollowsItsSolidAngle) {
    const PreparedMesh mesh = prepared_as_is(sphere_mesh({0, 0, 0}, 1, 40));
    const EntityOcclusion occlusion(mesh);
    const VisibilityField field = open_field(field_of(mesh, occlusion, 0, 0));
    const SamplerError error = field_error(field, occlusion).spherical;
    EXPECT_EQ(error.band[0], 1);  // inside: not measured
    for (std::size_t band = 9; band < SamplerError::bands; ++band) {
        const auto share = [&](std::size_t end) {  // fraction of all directions
            const double distance = distance_at(double(end) / SamplerError::bands,
                                                field.spherical.outer_radius, field.spherical.growth);
            return (1 - std::sqrt(1 - 1 / (distance * distance))) / 2;
        };
        const double square = double(error.band[band]) * double(error.band[band]);
        const auto to_open = [](double blocked) { return blocked / (1 - blocked); };
        EXPECT_LT(square, 1.05 * to_open(share(band))) << band;
        EXPECT_GT(square, 0.85 * to_open(share(band + 1))) << band;
    }
}

TEST(FieldError, InsideARoomIsRelativeToTheVisibility) {
    // Walls of a room that is open on one side, viewed from its centre.
    Mesh walls = box_mesh({-1, -1, -1}, {1, 1, 1});
    for (auto& triangle : walls.triangles) std::swap(triangle[0], triangle[1]);
    std::erase_if(walls.triangles, [&](const auto& t) {
        return std::ranges::all_of(t, [&](std::uint32_t v) { return walls.positions[v].x > 0.9f; });
    });
    const PreparedMesh mesh = prepared_as_is(walls);
    const EntityOcclusion occlusion(mesh);
    const SamplerError error = field_error(field_of(mesh, occlusion, 0.5f, 500), occlusion).spherical;
    // At the centre, one sixth is open.
    EXPECT_GT(error.band[2], error.relative * std::sqrt(5.0f) * 0.5f);
}

TEST(FieldError, FallsWithMoreSamplesAndLessTruncation) {
    const PreparedMesh mesh = example_mesh();
    const EntityOcclusion occlusion(mesh);
    const FieldError fine = field_error(field_of(mesh, occlusion, 0, 6000), occlusion),
                     coarse = field_error(field_of(mesh, occlusion, 0, 300), occlusion),
                     truncated = field_error(field_of(mesh, occlusion, 0.4f, 6000), occlusion);
    EXPECT_GT(fine.planar.relative, 0.001f);
    EXPECT_LT(fine.planar.relative, 0.3f);
    EXPECT_GT(fine.spherical.relative, 0.001f);
    EXPECT_LT(fine.spherical.relative, 0.5f);
    EXPECT_GT(coarse.planar.relative, 1.5f * fine.planar.relative);
    EXPECT_GT(coarse.spherical.relative, 1.5f * fine.spherical.relative);
    EXPECT_GT(truncated.planar.relative, fine.planar.relative + 0.05f);
    EXPECT_GT(truncated.spherical.relative, fine.spherical.relative + 0.05f);
}

TEST(FieldError, IsStoredInTheFieldAndDoesNotDependOnTheThreads) {
    const PreparedMesh mesh = example_mesh();
    const EntityOcclusion occlusion(mesh);
    const VisibilityField field = field_of(mesh, occlusion, 0.1f, 500);
    EXPECT_GT(field.error.planar.relative, 0);
    for (const std::size_t threads : {1u, 2u, 8u}) {
        EXPECT_EQ(with_threads(threads, [&] { return field_error(field, occlusion); }), field.error);
    }
}

}  // namespace
}  // namespace haarfield
