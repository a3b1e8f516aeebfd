#pragma once
/// Small scenes for tests of shading: meshes as they are, each with its own field.

#include <memory>
#include <optional>

#include "fields/field_precompute.h"
#include "shading/dense_renderer.h"
#include "tests/example_meshes.h"

namespace haarfield {

class ExampleScene {
public:
    static constexpr int size = 32;  ///< Of a cubemap's face. [texels]

    std::size_t add_entity(const Mesh& mesh, const Material& material, std::uint32_t planar = 6,
                           std::uint32_t spherical = 18) {
        return add_entity(prepared_as_is(mesh), material, planar, spherical);
    }
    std::size_t add_entity(const PreparedMesh& mesh, const Material& material, std::uint32_t planar,
                           std::uint32_t spherical) {
        parts_.push_back(std::make_unique<Part>());
        Part& part = *parts_.back();
        part.mesh = mesh;
        part.occlusion.emplace(part.mesh);
        part.field =
            *precompute_field("example", part.mesh, *part.occlusion, {size, 0, 0, planar, spherical});
        scene.entities.push_back({&part.mesh.fine, &*part.occlusion, &part.field, {material}});
        return scene.entities.size() - 1;
    }

    const PreparedMesh& mesh(std::size_t entity) const { return parts_[entity]->mesh; }

    std::vector<std::vector<Rgb>> radiance(int depth = full_depth) const {
        RenderSettings settings;
        settings.face_size = size;
        settings.depth = depth;
        return *vertex_radiance(scene, settings);
    }
    std::vector<std::vector<Rgb>> dense() const {
        RenderSettings settings;
        settings.face_size = size;
        return *dense_vertex_radiance(scene, settings);
    }

    ShadedScene scene;

private:
    struct Part {
        PreparedMesh mesh;
        std::optional<EntityOcclusion> occlusion;
        VisibilityField field;
    };
    std::vector<std::unique_ptr<Part>> parts_;
};

template <class Radiance>
LatLongImage environment(Radiance radiance, int width = 256) {
    LatLongImage image{width, width / 2, {}};
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            image.pixels.push_back(
                Rgb(float(radiance(lat_long_direction((x + 0.5) / image.width, (y + 0.5) / image.height)))));
    return image;
}

inline Material matte(float albedo) {
    Material material;
    material.diffuse = Rgb(albedo);
    return material;
}

inline Material glossy(float shininess, LobeConvention convention) {
    Material material;
    material.diffuse = Rgb(0.0f);
    material.specular = Rgb(1.0f);
    material.shininess = shininess;
    material.convention = convention;
    return material;
}

}  // namespace haarfield
