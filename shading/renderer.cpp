#include "shading/renderer.h"

#include <map>
#include <memory>

#include "fields/field_precompute.h"
#include "fields/visibility_rasterizer.h"
#include "shading/lighting.h"
#include "shading/lobes.h"
#include "shading/vertex_loop.h"

namespace haarfield {
namespace {

/// How far from an occluder's ground plane a vertex still counts as on it. [radii of the occluder]
constexpr float on_ground = 2e-3f;

/// The lobes that the materials of a scene need, by exponent.
using LobeTables = std::map<float, LobeTable>;

Result<LobeTables> needed_lobes(const ShadedScene& scene, const RenderSettings& settings,
                                const Progress& progress) {
    LobeTables tables;
    for (const ShadedEntity& entity : scene.entities)
        for (const Material& material : entity.materials)
            for (const float exponent : {1.0f, material.shininess}) {
                if (exponent != 1 && material.specular == Rgb(0.0f)) continue;
                if (tables.count(exponent)) continue;
                Result<LobeTable> table =
                    lobe_table(exponent, settings.face_size, {settings.lobe_coefficients}, progress);
                if (!table) return table.error();
                tables.emplace(exponent, std::move(*table));
            }
    return tables;
}

/// Everything that the vertices share.
struct Frame {
    const ShadedScene& scene;
    const RenderSettings& settings;
    const RgbCubemapTree light;
    const LobeTables lobes;
};

/// One thread's memory.
struct Worker {
    VisibilityRasterizer rasterizer;
    std::vector<float> visibility;
    std::vector<CubemapTree> factors;
    std::vector<const CubemapTree*> pointers;

    explicit Worker(int face_size) : rasterizer(face_size) {}
};

bool is_open(const CubemapTree& visibility) {
    for (const Quadtree& face : visibility.faces)
        if (face.scaling != 1 || !face.nodes.empty()) return false;
    return true;
}

bool is_closed(const CubemapTree& visibility) {
    for (const Quadtree& face : visibility.faces)
        if (face.scaling != 0 || !face.nodes.empty()) return false;
    return true;
}

/// What can be seen past another instance from a point of the world.
CubemapTree visibility_past(const Frame& frame, const ShadedInstance& other, const VertexView& view,
                            Worker& worker) {
    const ShadedEntity& entity = frame.scene.entities[other.entity];
    const Vec3f point = (view.point - other.translate) / other.scale;
    const Occluder& occluder = entity.occlusion->coarse();
    if (occluder.triangles.size() <= frame.settings.exact_triangles) {
        if (entity.occlusion->in_coarse()(point)) return {};
        const std::span<const std::uint8_t> open = worker.rasterizer.open_samples(occluder, point);
        worker.visibility.resize(open.size());
        for (std::size_t i = 0; i < open.size(); ++i)
            worker.visibility[i] = static_cast<float>(open[i]) / samples_per_texel;
        return visibility_tree(worker.visibility, frame.settings.face_size, {});
    }
    const VisibilityField& field = *entity.field;
    const float height = (view.position.y - other.translate.y) / other.scale - field.planar.centre.y;
    if (std::abs(height) <= on_ground * field.bounds.radius())
        return interpolated_visibility(field, field.planar_handles, field.planar.interpolation(point));
    return interpolated_visibility(field, field.spherical_handles, field.spherical.interpolation(point));
}

Rgb shaded_vertex(const Frame& frame, std::size_t instance_index, std::uint32_t vertex, Worker& worker) {
    const ShadedScene& scene = frame.scene;
    const ShadedInstance& instance = scene.instances[instance_index];
    const ShadedEntity& entity = scene.entities[instance.entity];
    const Material& material = entity.materials[entity.mesh->vertex_materials[vertex]];
    const VertexView view = vertex_view(scene, instance, vertex);

    // The first two places are kept for the lobes.
    worker.factors.assign(2, {});
    Interpolation own;
    own.sample[0] = vertex;
    own.weight[0] = 1;
    own.count = 1;
    worker.factors.push_back(interpolated_visibility(*entity.field, entity.field->local_handles, own));
    for (std::size_t other = 0; other < scene.instances.size(); ++other) {
        if (other == instance_index) continue;
        CubemapTree visibility = visibility_past(frame, scene.instances[other], view, worker);
        if (is_closed(visibility)) return Rgb(0.0f);
        if (!is_open(visibility)) worker.factors.push_back(std::move(visibility));
    }

    const auto integral = [&](CubemapTree lobe, CubemapTree* clamp) {
        worker.factors[0] = std::move(lobe);
        worker.pointers.clear();
        worker.pointers.push_back(&worker.factors[0]);
        if (clamp) {
            worker.factors[1] = std::move(*clamp);
            worker.pointers.push_back(&worker.factors[1]);
        }
        for (std::size_t i = 2; i < worker.factors.size(); ++i) worker.pointers.push_back(&worker.factors[i]);
        return product_integral(frame.light, worker.pointers, frame.settings.depth);
    };

    // material.h has both conventions.
    const float over_pi = static_cast<float>(1 / pi);
    const bool has_specular = material.specular != Rgb(0.0f);
    Rgb radiance(0.0f);
    CubemapTree cosine = interpolated_lobe(frame.lobes.at(1), view.normal);
    if (material.diffuse != Rgb(0.0f)) radiance += material.diffuse * integral(cosine, nullptr) * over_pi;
    if (has_specular && material.convention == LobeConvention::physical)
        radiance += material.specular *
                    integral(interpolated_lobe(frame.lobes.at(material.shininess), view.mirror), &cosine) *
                    ((material.shininess + 2) * 0.5f * over_pi);
    if (has_specular && material.convention == LobeConvention::povray) {
        CubemapTree above = half_space_tree(view.normal, frame.settings.face_size);
        radiance += material.specular *
                    integral(interpolated_lobe(frame.lobes.at(material.shininess), view.mirror), &above) *
                    over_pi;
    }
    return {std::max(radiance.x, 0.0f), std::max(radiance.y, 0.0f), std::max(radiance.z, 0.0f)};
}

}  // namespace

Result<std::vector<std::vector<Rgb>>> vertex_radiance(const ShadedScene& scene,
                                                      const RenderSettings& settings,
                                                      const Progress& progress) {
    Result<LobeTables> lobes = needed_lobes(scene, settings, progress);
    if (!lobes) return lobes.error();
    const Frame frame{scene, settings,
                      lighting_tree(scene.environment, settings.face_size, {settings.light_coefficients}),
                      std::move(*lobes)};
    return shaded_vertices(
        scene,
        [&frame]() -> VertexShader {
            return [&frame, worker = std::make_shared<Worker>(frame.settings.face_size)](
                       std::size_t instance, std::uint32_t vertex) {
                return shaded_vertex(frame, instance, vertex, *worker);
            };
        },
        progress);
}

}  // namespace haarfield
