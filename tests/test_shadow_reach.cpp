#include <gtest/gtest.h>

#include <algorithm>

#include "fields/model/mesh_reader.h"
#include "shading/bake/renderer.h"
#include "shading/scene/sky.h"
#include "tests/fixtures/example_scene.h"

namespace haarfield {
namespace {

constexpr int angles = 13;

/// Returns a floor around the origin, made of rings of vertices.
Mesh floor_of_rings(std::span<const float> distances) {
    Mesh mesh;
    const int rings = static_cast<int>(distances.size());
    for (int ring = 0; ring < rings; ++ring)
        for (int angle = 0; angle < angles; ++angle) {
            // No two rings have vertices at the same angles.
            const double azimuth = 2 * pi * (angle + 0.381966 * ring) / angles;
            mesh.positions.push_back(
                Vec3f(Vec3d(std::cos(azimuth), 0, std::sin(azimuth)) * double(distances[std::size_t(ring)])));
            mesh.normals.push_back({0, 1, 0});
        }
    const auto vertex = [&](int ring, int angle) {
        return static_cast<std::uint32_t>(ring * angles + angle % angles);
    };
    for (int ring = 0; ring + 1 < rings; ++ring)
        for (int angle = 0; angle < angles; ++angle) {
            mesh.triangles.push_back({vertex(ring, angle), vertex(ring, angle + 1), vertex(ring + 1, angle)});
            mesh.triangles.push_back(
                {vertex(ring, angle + 1), vertex(ring + 1, angle + 1), vertex(ring + 1, angle)});
        }
    mesh.vertex_materials.assign(mesh.positions.size(), 0);
    mesh.material_names = {""};
    return mesh;
}

/// Returns distances with constant steps from 0.05 to 50, and with constant ratios from 1 to 50.
std::vector<float> distances() {
    std::vector<float> made;
    constexpr int count = 100;
    for (int k = 0; k < count; ++k) {
        const float share = float(k) / (count - 1);
        made.push_back(0.05f + 49.9f * share);
        made.push_back(std::pow(50.0f, share));
    }
    std::ranges::sort(made);
    return made;
}

/// An object on a floor that extends to 50 of its radii, under a clear sky.
class FarFloor {
public:
    explicit FarFloor(const Mesh& object) {
        const float radius = bounds_of(object.positions).radius();
        std::vector<float> rings = distances();
        for (float& distance : rings) distance *= radius;
        PreparedMesh floor = prepared_as_is(floor_of_rings(rings));
        floor.coarse = square_mesh(120 * radius, 0);
        example_.scene.instances = {{example_.add_entity(floor, matte(0.7f), 6, 18), {}},
                                    {example_.add_entity(object, matte(0.5f), 2000, 3000), {}}};
        example_.scene.eye = {0, 10, 20};
    }

    /// Expects the bake to be within a hundredth of the dense sum over exact visibility at all but a few of
    /// the floor's vertices, except those below the object.
    void expect_right(float elevation, float azimuth, double few = 1e-3) {
        AnalyticSky sky;
        sky.sun_elevation = elevation * float(pi) / 180;
        sky.sun_azimuth = azimuth * float(pi) / 180;
        example_.scene.environment = sky_environment(sky, 256);
        const std::vector<Rgb> found = example_.radiance()[0], wanted = example_.dense()[0];
        std::size_t seen = 0, wrong = 0;
        double worst = 0;
        float at = 0;
        for (std::size_t v = 0; v < wanted.size(); ++v) {
            const auto right = double(luminance(wanted[v]));
            if (!(right > 0)) continue;
            const double error = std::abs(double(luminance(found[v])) / right - 1);
            ++seen;
            wrong += error > 0.01;
            if (error <= worst) continue;
            worst = error;
            at = example_.mesh(0).fine.positions[v].length();
        }
        EXPECT_LE(double(wrong), few * double(seen)) << elevation << ", " << azimuth << " degrees: " << wrong
                                                     << ", the worst by " << worst << " at " << at << " m";
    }

private:
    ExampleScene example_;
};

TEST(ShadowReach, OfACubeEndsNowhere) {
    FarFloor scene(box_mesh({-1, 0, -1}, {1, 2, 1}));
    for (const float azimuth : {0.0f, 17.0f, 45.0f, 121.0f, 260.0f}) scene.expect_right(5, azimuth);
}

TEST(ShadowReach, OfAChairHasNoSeams) {
    Mesh chair = read_mesh(HAARFIELD_SOURCE_DIR "/scenes/meshes/chair.obj")->mesh;
    std::ranges::fill(chair.vertex_materials, std::uint16_t(0));
    FarFloor scene(chair);
    // The sun's few directions are visible in the penumbrae of the chair's slats.
    for (const float elevation : {5.0f, 10.0f, 15.0f}) scene.expect_right(elevation, 30, 2e-3);
}

}  // namespace
}  // namespace haarfield
