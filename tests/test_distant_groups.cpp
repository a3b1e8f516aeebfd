#include "shading/visibility/distant_groups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "shading/bake/renderer.h"
#include "shading/visibility/cached_visibility.h"
#include "shading/visibility/vertex_visibility.h"
#include "tests/fixtures/example_scene.h"
#include "tests/fixtures/furnished_room.h"

namespace haarfield {
namespace {

/// Rows of balls on stands, half of them rotated, on a floor.
struct Crowd {
    static constexpr int along = 7;

    ExampleScene example;
    RenderSettings settings;

    Crowd() {
        example.add_entity(square_mesh(8, 0, 16), matte(0.6f));
        const Mesh stand = joined_meshes(sphere_mesh({0, 0.5f, 0}, 0.2f, 8),
                                         box_mesh({-0.04f, 0.01f, -0.1f}, {0.04f, 0.4f, 0.1f}));
        example.add_entity(stand, matte(0.5f), 60, 120);
        example.scene.instances.push_back({0, {}});
        for (int k = 0; k < along * along; ++k)
            example.scene.instances.push_back(
                {1,
                 {{1.1f * float(k % along - along / 2), 0, 1.1f * float(k / along - along / 2)},
                  1,
                  k % 2 ? rotation_about({0, 1, 0}, 0.4 * k) : Rotation()}});
        example.scene.environment = environment(
            [](const Vec3d& d) { return 0.4 + 3 * std::exp(8 * (d.x * 0.6 + d.y * 0.7 + d.z * 0.4 - 1)); });
        settings.face_size = ExampleScene::size;
        settings.light_coefficients = 0;
        settings.exact_triangles = 0;
    }
    ShadingGeometry geometry() const { return *shading_geometry(example.scene, settings); }
    std::vector<Vec3f> points() const {
        std::mt19937 random(1);
        const auto number = [&] { return float(double(random()) * 0x1p-32); };
        std::vector<Vec3f> points;
        for (int k = 0; k < 300; ++k) {
            const float x = number(), y = number(), z = number();
            points.emplace_back(8 * x - 4, 0.8f * y, 8 * z - 4);
        }
        return points;
    }
};

TEST(DistantGroups, ContainTheInstancesThatAreNotNear) {
    const Crowd crowd;
    const ShadedScene& scene = crowd.example.scene;
    const ShadingGeometry geometry = crowd.geometry();
    DistantGroups groups(scene, geometry, 5);
    std::size_t grouped = 0, all = 0;
    for (const Vec3f& point : crowd.points()) {
        const DistantGroups::Surroundings found = groups.around(point);
        EXPECT_TRUE(std::ranges::is_sorted(found.near));
        std::vector<std::uint8_t> open(std::size_t(cubemap_faces * geometry.face_size * geometry.face_size),
                                       255);
        for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
            const ShadingGeometry::Instance& seen = geometry.instances[i];
            const float distance = (seen.middle - point).length();
            const bool is_near = std::ranges::binary_search(found.near, i);
            EXPECT_FALSE(i == 5 && is_near);
            if (i == 5 || distance >= geometry.reach * seen.radius) continue;
            EXPECT_TRUE(is_near || distance >= seen.nearer);
            if (!is_near) geometry.impostors[1]->hide(scene.instances[i].placement, point, open);
            grouped += !is_near;
            ++all;
        }
        // The solid angles agree, although the group is seen from elsewhere.
        for (std::size_t face = 0; face < cubemap_faces; ++face) {
            double sum = 0;
            const std::size_t texels = open.size() / cubemap_faces;
            for (std::size_t t = 0; t < texels; ++t) sum += open[face * texels + t];
            EXPECT_NEAR(found.distant ? double(found.distant->faces[face].mean) : 1.0,
                        sum / (255 * double(texels)), 0.02);
        }
    }
    EXPECT_GT(grouped, all / 2);
}

TEST(DistantGroups, DependOnThePointAlone) {
    const Crowd crowd;
    const ShadingGeometry geometry = crowd.geometry();
    const std::vector<Vec3f> points = crowd.points();
    DistantGroups all(crowd.example.scene, geometry, VertexVisibility::no_instance);
    for (const Vec3f& point : points) all.around(point);
    for (const Vec3f& point : points) {
        DistantGroups one(crowd.example.scene, geometry, VertexVisibility::no_instance);
        const DistantGroups::Surroundings found = all.around(point), wanted = one.around(point);
        EXPECT_TRUE(std::ranges::equal(found.near, wanted.near));
        ASSERT_EQ(found.distant != nullptr, wanted.distant != nullptr);
        if (!found.distant) continue;
        EXPECT_TRUE(std::ranges::equal(found.distant->nodes, wanted.distant->nodes,
                                       [](const WideNode<std::uint8_t>& a, const WideNode<std::uint8_t>& b) {
                                           return a.mean == b.mean && a.first_child == b.first_child &&
                                                  a.varying == b.varying;
                                       }));
    }
}

TEST(DistantGroups, RadianceIsThatOfSingleInstances) {
    const Crowd crowd;
    RenderSettings settings = crowd.settings;
    settings.occlusion = Occlusion::exact;
    const SceneColours single = total(*scene_radiance(crowd.example.scene, settings));
    settings.occlusion = Occlusion::automatic;
    settings.occlusion_error = 0;
    const SceneColours found = total(*scene_radiance(crowd.example.scene, settings));
    double largest = 0;
    for (std::size_t i = 0; i < single.size(); ++i)
        for (std::size_t v = 0; v < single[i].size(); ++v)
            largest = std::max(largest, double((found[i][v] - single[i][v]).length()));
    EXPECT_GT(largest, 0);
    EXPECT_LT(largest, 0.02);
    EXPECT_LT(furnished::relative_rmse(found, single), 0.003);
}

TEST(DistantGroups, CachedVisibilityOfACrowdIsBitIdentical) {
    const Crowd crowd;
    const ShadedScene& scene = crowd.example.scene;
    const ShadingGeometry geometry = crowd.geometry();
    const SceneLight light = scene_light(scene.environment, crowd.settings);
    const CachedVisibility kept = *CachedVisibility::make(scene, geometry, std::size_t(1) << 30);
    EXPECT_EQ(total(*scene_radiance({scene, geometry, light, crowd.settings, &kept})),
              total(*scene_radiance({scene, geometry, light, crowd.settings, nullptr})));
}

}  // namespace
}  // namespace haarfield
