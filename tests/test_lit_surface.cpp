#include "shading/bounces/lit_surface.h"

#include <gtest/gtest.h>

#include "shading/bake/bounced_radiance.h"
#include "shading/bounces/gathering_directions.h"
#include "tests/fixtures/example_scene.h"

namespace haarfield {
namespace {

constexpr float wall = 0.02f;  ///< Radiance of dark surfaces. [W/(m^2 sr)]

/// A room without furniture, 2 m wide.
Mesh room_mesh(int segments) {
    Mesh mesh = box_mesh({-1, -1, -1}, {1, 1, 1}, segments);
    for (Vec3f& normal : mesh.normals) normal = -normal;
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    return mesh;
}

/// A dark room with a bright patch in the middle of its ceiling.
struct Room : ExampleScene {
    explicit Room(int segments) {
        const Mesh mesh = room_mesh(segments);
        scene.instances.push_back({add_entity(mesh, matte(0.5f)), {}});
        std::vector<Rgb>& values = shown.emplace_back(mesh.positions.size(), Rgb(wall));
        for (std::size_t v = 0; v < values.size(); ++v) {
            const Vec3f& p = mesh.positions[v];
            if (p.y > 0.99f && std::abs(p.x) < 0.15f && std::abs(p.z) < 0.15f)
                values[v] = Rgb(1.0f, 2.0f, 3.0f);
        }
        detail.places.emplace_back(mesh.triangles.size(), -1);
    }
    const Mesh& mesh() const { return *scene.entities[0].mesh; }
    double area(std::size_t triangle) const {
        const auto& [a, b, c] = mesh().triangles[triangle];
        const auto& at = mesh().positions;
        return 0.5 * double((at[b] - at[a]).cross(at[c] - at[a]).length());
    }
    /// Divides a triangle, with the same difference in all cells.
    void divide(std::size_t triangle, const Rgb& difference) {
        detail.places[0][triangle] = std::int32_t(detail.differences.size() / DirectDetail::cells);
        detail.differences.insert(detail.differences.end(), DirectDetail::cells, difference);
    }
    IndirectLight indirect(bool is_lit) const {
        IndirectLight light;
        light.surface = std::make_shared<const FineSurface>(scene);
        light.radiance = shown;
        if (is_lit) light.lit = std::make_shared<const LitSurface>(scene, shown, detail);
        return light;
    }

    SceneColours shown;
    DirectDetail detail;
};

TEST(LitSurface, CellsAreEqualPartsOfTheirTriangle) {
    double sum = 0;
    for (std::size_t cell = 0; cell < DirectDetail::cells; ++cell) {
        const auto [first, u, v] = DirectDetail::centre(cell);
        EXPECT_NEAR(first + u + v, 1, 1e-6f);
        EXPECT_EQ(DirectDetail::cell_at(u, v), cell);
        const std::array<Vec2f, 3> at = DirectDetail::corners(cell);
        const Vec2f along = at[1] - at[0], across = at[2] - at[0];
        const double area = 0.5 * std::abs(double(along.x * across.y - along.y * across.x));
        EXPECT_NEAR(area * DirectDetail::cells, 0.5, 1e-5);
        sum += area;
    }
    EXPECT_NEAR(sum, 0.5, 1e-5);
    for (const auto& [u, v] : {std::pair(0.0f, 0.0f), {1.0f, 0.0f}, {0.0f, 1.0f}, {0.5f, 0.5f}})
        EXPECT_LT(DirectDetail::cell_at(u, v), DirectDetail::cells);
}

TEST(LitSurface, DensityHasTheIntegralOne) {
    Room room(8);
    room.divide(3, Rgb(4.0f));
    const LitSurface surface(room.scene, room.shown, room.detail);
    double sum = 0;
    for (std::uint32_t t = 0; t < room.mesh().triangles.size(); ++t)
        for (std::size_t cell = 0; cell < DirectDetail::cells; ++cell) {
            const auto [first, u, v] = DirectDetail::centre(cell);
            sum += double(surface.density_at(room.scene, room.shown, {0, t, u, v})) * room.area(t) /
                   double(DirectDetail::cells);
        }
    EXPECT_NEAR(sum, 1, 1e-4);
    EXPECT_NEAR(surface.radiance_at(room.scene, room.shown, {0, 3, 0.3f, 0.3f}).x, 4 + wall, 1e-5);
}

TEST(LitSurface, BrightPointsAreDistributedByLight) {
    Room room(16);
    const LitSurface surface(room.scene, room.shown, room.detail);
    double bright = 0, whole = 0;
    for (std::uint32_t t = 0; t < room.mesh().triangles.size(); ++t) {
        Rgb mean(0.0f);
        for (const std::uint32_t v : room.mesh().triangles[t]) mean += room.shown[0][v] / 3.0f;
        const double light = double(luminance(mean)) * room.area(t);
        whole += light;
        if (mean.x > 2 * wall) bright += light;
    }
    for (const int number : {16, 256, 4096}) {
        int found = 0;
        for (const LitSurface::BrightPoint& point : surface.points(number)) {
            found += point.position.y > 0.99f && std::abs(point.position.x) < 0.26f &&
                     std::abs(point.position.z) < 0.26f;
            EXPECT_NEAR(point.normal.length(), 1, 1e-5f);
            EXPECT_LT(point.normal.dot(point.position), 0);
        }
        EXPECT_EQ(surface.points(number).size(), std::size_t(number));
        EXPECT_NEAR(found, number * bright / whole, 2 + 0.003 * number);
    }
}

TEST(LitSurface, BlackRoomsHaveNoPoints) {
    Room room(2);
    room.shown[0].assign(room.shown[0].size(), Rgb(0.0f));
    const IndirectLight light = room.indirect(true);
    EXPECT_TRUE(light.lit->points(64).empty());
    EXPECT_EQ(light.gathered_at(room.scene, 0, surface_point(room.scene.entities[0], 0), 64).irradiance,
              Rgb(0.0f));
}

TEST(LitSurface, FewRaysGatherFromABrightPatch) {
    const Room room(16);
    const IndirectLight plain = room.indirect(false), lit = room.indirect(true);
    const ShadedEntity& entity = room.scene.entities[0];
    double worst = 0, worst_plain = 0;
    for (std::uint32_t v = 0; v < room.mesh().positions.size(); v += 13) {
        const SurfacePoint point = surface_point(entity, v);
        const auto gathered = [&](const IndirectLight& light, int rays) {
            return double(light.gathered_at(room.scene, 0, point, rays).irradiance.y);
        };
        const double wanted = gathered(lit, most_gathering_rays);
        EXPECT_NEAR(gathered(plain, most_gathering_rays) / wanted, 1, 0.1) << v;
        worst = std::max(worst, std::abs(gathered(lit, 256) / wanted - 1));
        worst_plain = std::max(worst_plain, std::abs(gathered(plain, 256) / wanted - 1));
    }
    EXPECT_LT(worst, 0.05);
    EXPECT_LT(worst, 0.5 * worst_plain);
}

TEST(LitSurface, AveragesKeepTheLight) {
    Room room(6);
    for (const std::size_t t : {0u, 7u, 20u}) room.divide(t, Rgb(float(t) + 1));
    const auto light = [&](const SceneColours& values) {
        double sum = 0;
        for (std::size_t t = 0; t < room.mesh().triangles.size(); ++t)
            for (const std::uint32_t v : room.mesh().triangles[t])
                sum += double(values[0][v].x) * room.area(t) / 3;
        return sum;
    };
    SceneColours averaged = room.shown;
    average_detail(room.scene, room.detail, averaged);
    EXPECT_NEAR(light(averaged) - light(room.shown), room.area(0) + 8 * room.area(7) + 21 * room.area(20),
                1e-3);
}

TEST(LitSurface, UnevenTrianglesAreThoseWithTheMostLight) {
    Room room(16);
    const std::vector<InstanceTriangle> found = uneven_triangles(room.scene, room.shown, 1e-5, 1000);
    std::size_t wanted = 0;
    for (const auto& [a, b, c] : room.mesh().triangles)
        wanted += room.shown[0][a] != room.shown[0][b] || room.shown[0][a] != room.shown[0][c];
    EXPECT_EQ(found.size(), wanted);
    EXPECT_GT(wanted, 0u);
    EXPECT_EQ(uneven_triangles(room.scene, room.shown, 1e-5, 3).size(), 3u);
    EXPECT_TRUE(uneven_triangles(room.scene, room.shown, 1, 1000).empty());
}

TEST(LitSurface, FocusedLightHasShadowEdgesInsideTriangles) {
    // The shadow of a black box on a coarse floor has the same light as on a fine one, also if vertices of
    // the floor are inside the box.
    const auto floor_light = [](float bottom, int segments, bool focused) {
        ExampleScene example;
        example.scene.instances.push_back({example.add_entity(square_mesh(2, 0, segments), matte(0.5f)), {}});
        example.scene.instances.push_back(
            {example.add_entity(box_mesh({-0.4f, bottom, -0.3f}, {0.7f, 0.5f, 0.6f}), matte(0)), {}});
        example.scene.environment = environment(
            [](const Vec3d& d) { return d.dot(Vec3d(0.3, 0.9, 0.1).normalized()) > 0.99 ? 100.0 : 0.1; });
        RenderSettings settings;
        settings.face_size = ExampleScene::size;
        settings.bounces.most = any_bounces;
        const ShadingGeometry geometry = *shading_geometry(example.scene, settings);
        const SceneLight light = scene_light(example.scene.environment, settings);
        const PointShading direct{example.scene, geometry, light, settings};
        const SceneRadiance radiance = *scene_radiance(direct);
        const IndirectLight indirect =
            focused
                ? *focused_indirect_light(direct, radiance, *bounce_rays(example.scene, geometry, settings))
                : *scene_indirect_light(direct, radiance);
        const Mesh& mesh = *example.scene.entities[0].mesh;
        double sum = 0;
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
            for (std::size_t cell = 0; cell < DirectDetail::cells; ++cell) {
                const std::array<float, 3> w = DirectDetail::centre(cell);
                Vec3f at(0.0f);
                for (std::size_t c = 0; c < 3; ++c) at += mesh.positions[mesh.triangles[t][c]] * w[c];
                if (at.x > -0.4f && at.x < 0.7f && at.z > -0.3f && at.z < 0.6f && bottom < 0) continue;
                Rgb value(0.0f);
                for (std::size_t c = 0; c < 3; ++c)
                    value += indirect.radiance[0][mesh.triangles[t][c]] * w[c];
                if (focused)
                    value = indirect.lit->radiance_at(example.scene, indirect.radiance, {0, t, w[1], w[2]});
                sum += double(value.y) / double(DirectDetail::cells * mesh.triangles.size());
            }
        return sum;
    };
    for (const float bottom : {0.3f, -0.1f}) {
        const double wanted = floor_light(bottom, 64, false);
        for (const int segments : {4, 10})
            EXPECT_NEAR(floor_light(bottom, segments, true) / wanted, 1, 0.03) << segments << ' ' << bottom;
        EXPECT_GT(std::abs(floor_light(bottom, 4, false) / wanted - 1), 0.05) << bottom;
    }
}

}  // namespace
}  // namespace haarfield
