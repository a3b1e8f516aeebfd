#include "fields/field/visibility_field.h"

#include <gtest/gtest.h>

#include "fields/field/field_precompute.h"
#include "fields/rasterizer/visibility_rasterizer.h"
#include "fields/wavelets/haar_transform.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/unpacked_face.h"

namespace haarfield {
namespace {

const PreparedMesh& example_mesh() {
    static const PreparedMesh mesh = prepared_as_is(box_mesh({-0.5f, 0, -0.5f}, {0.5f, 1, 0.5f}, 2));
    return mesh;
}

const VisibilityField& example_field() {
    static const VisibilityField field =
        *precompute_field("box", example_mesh(), EntityOcclusion(example_mesh()), {16, 0, 0, 800, 900});
    return field;
}

std::vector<float> exact_visibility(const Vec3f& point) {
    VisibilityRasterizer rasterizer(16);
    const Occluder occluder = make_occluder(example_mesh().coarse);
    std::vector<float> visibility;
    for (const std::uint8_t open : rasterizer.open_samples(occluder, point))
        visibility.push_back(static_cast<float>(open) / 8);
    return visibility;
}

std::vector<float> cubemap_texels(const CubemapTree& tree, int size) {
    std::vector<float> texels;
    for (const Quadtree& face : tree.faces)
        for (const float t : quadtree_texels(face, size)) texels.push_back(t);
    return texels;
}

TEST(VisibilityField, HasNoDefect) {
    EXPECT_EQ(field_defect(example_field()), "");
}

TEST(VisibilityField, LookupIsExactAtSamples) {
    const VisibilityField& field = example_field();
    for (std::uint32_t sample = field.spherical.sample_count() / 2; sample < field.spherical.sample_count();
         sample += 37) {
        const Vec3f p = field.spherical.sample_position(sample);
        const auto found = cubemap_texels(
            interpolated_visibility(field, field.spherical_handles, field.spherical.interpolation(p)), 16);
        const auto wanted = exact_visibility(p);
        double error = 0;
        for (std::size_t i = 0; i < wanted.size(); ++i) error += std::abs(found[i] - wanted[i]);
        EXPECT_LT(error / double(wanted.size()), 1e-3) << "sample " << sample;
    }
}

TEST(VisibilityField, LookupBetweenSamplesIsTheWeightedMeanOfTheirTexels) {
    const VisibilityField& field = example_field();
    const Vec3f p(1.234f, 0.0f, 0.777f);
    const Interpolation weights = field.planar.interpolation(p);
    std::vector<double> wanted(6 * 16 * 16, weights.open);
    for (int i = 0; i < weights.count; ++i) {
        const std::int32_t handle = field.planar_handles[weights.sample[std::size_t(i)]];
        for (std::size_t face = 0; face < 6; ++face) {
            const Quadtree tree = unpacked_face(field.pool, field.pool.cubemaps[std::size_t(handle)][face]);
            const std::vector<float> texels = quadtree_texels(tree, 16);
            for (std::size_t t = 0; t < texels.size(); ++t)
                wanted[face * 256 + t] += double(weights.weight[std::size_t(i)]) * texels[t];
        }
    }
    const auto found = cubemap_texels(interpolated_visibility(field, field.planar_handles, weights), 16);
    for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(found[i], wanted[i], 1e-5);
}

TEST(VisibilityField, DefectsAreFound) {
    const auto defect_after = [](auto change) {
        VisibilityField changed = example_field();
        change(changed);
        return field_defect(changed);
    };
    EXPECT_NE(defect_after([](VisibilityField& f) { f.planar.rings = 1; }), "");
    EXPECT_NE(defect_after([](VisibilityField& f) { f.planar_handles.pop_back(); }), "");
    EXPECT_NE(defect_after([](VisibilityField& f) { f.spherical.azimuths = -3; }), "");
    EXPECT_NE(defect_after([](VisibilityField& f) { f.spherical.outer_radius = NAN; }), "");
    EXPECT_NE(defect_after([](VisibilityField& f) { f.planar.growth = 1e30f; }), "");
    EXPECT_NE(defect_after([](VisibilityField& f) { f.local_handles[3] = -1; }), "");
    EXPECT_NE(defect_after([](VisibilityField& f) { f.local_handles[3] = 1 << 30; }), "");
    EXPECT_NE(defect_after([](VisibilityField& f) { f.bounds.lower.x = NAN; }), "");
    EXPECT_NE(defect_after([](VisibilityField& f) { f.settings.face_size = 32; }), "");
    EXPECT_NE(defect_after([](VisibilityField& f) { f.pool.node_bytes = {}; }), "");
}

}  // namespace
}  // namespace haarfield
