#pragma once
/// A box with a post in it, over a floor, in light that casts shadows; ready to be shaded at any point.

#include "shading/lighting.h"
#include "shading/radiant_mesh.h"
#include "tests/example_scene.h"

namespace haarfield {

struct LitBox {
    ExampleScene example;
    RenderSettings settings;
    ShadingGeometry geometry;
    LightPyramid light;
    PointShading shading{example.scene, geometry, light, settings};

    LitBox()
        : example(lit_box()),
          settings(of_size()),
          geometry(*shading_geometry(example.scene, settings)),
          light(lighting_tree(example.scene.environment, settings.face_size, {}), settings.face_size) {}
    LitBox(const LitBox&) = delete;

    static constexpr std::size_t floor = 0, box = 1;  ///< Entities and instances.

    /// The floor in cells x cells squares, and the box as it is, by entity.
    std::vector<Mesh> meshes(int cells) const { return {square_mesh(4, 0, cells), example.mesh(box).fine}; }

    std::vector<RadiantMesh> radiant(int cells) const { return *mesh_radiance(shading, meshes(cells)); }

private:
    static RenderSettings of_size() {
        RenderSettings settings;
        settings.face_size = ExampleScene::size;
        settings.occlusion = Occlusion::fields;  // radiance is smooth then
        return settings;
    }
    static ExampleScene lit_box() {
        ExampleScene example;
        example.add_entity(square_mesh(4, 0, 8), matte(0.7f));
        const Mesh block = box_mesh({-0.4f, 0.1f, -0.3f}, {0.4f, 0.4f, 0.3f}, 2),
                   post = box_mesh({-0.1f, 0.3f, -0.1f}, {0.1f, 0.8f, 0.1f}, 2);
        example.add_entity(joined_meshes(block, post), matte(0.5f), 400, 300);
        example.scene.instances = {{floor, {0, 0, 0}, 1}, {box, {0.1f, 0, 0.05f}, 1.2f}};
        example.scene.environment = environment([](const Vec3d& d) {
            return 0.3 + 60 * std::pow(std::max(0.0, d.dot(Vec3d(0.4, 0.8, 0.45).normalized())), 300);
        });
        example.scene.eye = {0, 3, 5};
        return example;
    }
};

}  // namespace haarfield
