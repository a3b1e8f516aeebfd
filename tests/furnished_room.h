#pragma once
/// A furnished room for tests and benchmarks of radiance transfer.

#include "shading/lighting.h"
#include "shading/radiance_transfer.h"
#include "shading/renderer.h"
#include "tests/example_scene.h"

namespace haarfield::furnished {

inline RenderSettings settings() {
    RenderSettings result;
    result.face_size = ExampleScene::size;
    result.occlusion = Occlusion::fields;  // as frames see what moves
    return result;
}

/// A bright sky with a sun, turned about +y. [rad]
inline LatLongImage sky(double turn) {
    const Vec3d sun = Vec3d(std::sin(turn), 0.8, std::cos(turn)).normalized();
    LatLongImage image =
        environment([&](const Vec3d& d) { return 0.5 + d.y * 0.3 + 6 * std::exp(20 * (d.dot(sun) - 1)); });
    for (Rgb& pixel : image.pixels) pixel *= Rgb(1, 0.8f, 0.5f);
    return image;
}

/// A floor, two blocks that are looked up in their field, and two balls; all of them rough and glossy.
class Room : public ExampleScene {
public:
    Room() {
        PreparedMesh floor_mesh = prepared_as_is(square_mesh(5, 0, 10));
        floor_mesh.coarse = square_mesh(5, 0);
        Material lacquer = glossy(30, LobeConvention::povray);
        lacquer.diffuse = Rgb(0.4f, 0.2f, 0.1f);
        lacquer.specular = Rgb(0.3f, 0.3f, 0.2f);
        Material metal = glossy(15, LobeConvention::physical);
        metal.specular = Rgb(0.6f);
        Material brass = lacquer;
        brass.specular = Rgb(1.0f);
        brass.phong = 0.1f;
        brass.blinn = 0.3f;
        brass.metallic = 0.8f;
        brass.pigment = Rgb(0.8f, 0.4f, 0.2f);
        const auto floor = add_entity(floor_mesh, matte(0.6f), 6, 18);
        block = add_entity(box_mesh({-0.4f, 0, -0.4f}, {0.4f, 0.8f, 0.4f}, 4), lacquer, 800, 1200);
        const auto ball = add_entity(sphere_mesh({0, 0.4f, 0}, 0.4f, 10), metal, 500, 800);
        const auto brass_ball = add_entity(sphere_mesh({0, 0.3f, 0}, 0.3f, 8), brass, 500, 800);
        scene.instances = {{floor, {0, 0, 0}, 1},
                           {block, {-0.6f, 0, 0}, 1},
                           {ball, {0.5f, 0, 0.4f}, 1},
                           {block, {0.6f, 0, -0.9f}, 0.7f},
                           {brass_ball, {0.2f, 0, 1.3f}, 1}};
        scene.environment = sky(0.4);
        scene.eye = {2, 2, 3};
    }
    RgbCubemapTree light() const {
        return lighting_tree(scene.environment, size, {settings().light_coefficients});
    }
    const ShadingGeometry& geometry() const {
        if (!geometry_) geometry_ = std::move(*shading_geometry(scene, settings()));
        return *geometry_;
    }
    VertexRadiance full() const { return *vertex_radiance(scene, settings()); }

    std::size_t block;

private:
    mutable std::optional<ShadingGeometry> geometry_;
};

inline double relative_rmse(const VertexRadiance& found, const VertexRadiance& wanted) {
    double error = 0, norm = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i)
        for (std::size_t v = 0; v < wanted[i].size(); ++v) {
            const Vec3f difference = found.at(i).at(v) - wanted[i][v];
            error += double(difference.dot(difference));
            norm += double(wanted[i][v].dot(wanted[i][v]));
        }
    return std::sqrt(error / norm);
}

}  // namespace haarfield::furnished
