#include "shading/bake/path_tracer.h"

#include "shading/bake/lamp_light.h"
#include "shading/bake/scrambled_sobol.h"
#include "shading/bounces/cosine_directions.h"
#include "shading/bounces/lobe_rays.h"

namespace haarfield {

PathTracer::PathVertex PathTracer::path_vertex(const ShadedScene& scene, const SurfaceHit& hit,
                                               const Vec3f& position) {
    const ShadedInstance& instance = scene.instances[hit.instance];
    const ShadedEntity& entity = scene.entities[instance.entity];
    const Mesh& mesh = *entity.mesh;
    const std::array<std::uint32_t, 3>& corners = mesh.triangles[hit.triangle];
    const std::array<float, 3> weights = hit.weights();
    Vec3f normal(0.0f);
    Rgb reflectance(0.0f);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = corners[k];
        const Rgb albedo = entity.materials[mesh.vertex_materials[v]].diffuse;
        normal += mesh.normals[v] * weights[k];
        reflectance += (entity.tints.empty() ? albedo : albedo * entity.tints[v]) * weights[k];
    }
    const Vec3f outwards = (mesh.positions[corners[1]] - mesh.positions[corners[0]])
                               .cross(mesh.positions[corners[2]] - mesh.positions[corners[0]])
                               .normalized();
    const float offset =
        surface_offset * instance.placement.scale * entity.occlusion->coarse().bounds().radius();
    return {position + instance.placement.direction_to_world(outwards) * offset,
            instance.placement.direction_to_world(normal.normalized()),
            reflectance * static_cast<float>(1 / pi)};
}

PathTracer::PathTracer(const ShadedScene& scene, const FineSurface& surface, const ShadowRays& rays,
                       const SourceRule& sources)
    : scene_(scene),
      surface_(surface),
      rays_(rays),
      lamps_(placed_lamps(scene.lamps)),
      emitters_(scene_emitters(scene).triangles) {
    SplitLight split = split_light(scene.environment, sources);
    smooth_ = std::move(split.smooth);
    sources_ = SourceChoice(split.sources);
}

Rgb PathTracer::light_of_lamps(const PathVertex& at) const {
    Outgoing radiance;
    ShadingPoint receiver;
    receiver.from = receiver.position = at.from;
    receiver.brdf.normal = receiver.brdf.mirror = at.normal;
    receiver.brdf.diffuse = at.reflectance;
    add_lamp_light(rays_, lamps_, {&receiver, 1}, {&radiance, 1});
    return radiance.diffuse;
}

Rgb PathTracer::light_of_sources(const PathVertex& at, Numbers& number) const {
    if (sources_.empty()) return Rgb(0.0f);
    const std::optional<SourceChoice::Chosen> chosen = sources_.choose(double(number()));
    const float cosine = chosen ? at.normal.dot(chosen->light.direction) : 0.0f;
    if (!(cosine > 0) || rays_.is_blocked(at.from, chosen->light.direction)) return Rgb(0.0f);
    return at.reflectance * chosen->light.irradiance * (cosine / float(chosen->chance));
}

bool PathTracer::is_blocked(const Vec3f& from, const LightSample& light) const {
    return rays_.is_blocked_from(from, from + light.direction * light.distance);
}

Rgb PathTracer::light_of_emitters(const PathVertex& at, Numbers& number) const {
    if (emitters_.is_black()) return Rgb(0.0f);
    const double x = double(number());
    const std::optional<LightSample> light = emitters_.sample(at.from, {x, double(number())});
    const float cosine = light ? at.normal.dot(light->direction) : 0.0f;
    if (!(cosine > 0) || is_blocked(at.from, *light)) return Rgb(0.0f);
    return at.reflectance * light->radiance * float(double(cosine) / (light->density + double(cosine) / pi));
}

Rgb PathTracer::radiance_by_direction(const PathVertex& at, const Vec3f& direction) const {
    if (emitters_.is_black()) return Rgb(0.0f);
    const float cosine = at.normal.dot(direction);
    const std::optional<LightSample> light = emitters_.look_up(at.from, direction);
    if (!(cosine > 0) || !light || is_blocked(at.from, *light)) return Rgb(0.0f);
    const double density = double(cosine) / pi;
    return light->radiance * float(density / (density + light->density));
}

Rgb PathTracer::radiance_along(const Vec3f& from, const Vec3f& first_direction, Numbers& number) const {
    Rgb found(0.0f), carried(1.0f);
    PathVertex at{from, first_direction, Rgb(0.0f)};
    Vec3f direction = first_direction;
    for (bool is_first = true;; is_first = false) {
        const std::optional<SurfaceHit> hit = surface_.first_hit(scene_, at.from, direction);
        if (!hit) {
            if (!is_first) found += carried * radiance_from(smooth_, Vec3d(direction));
            break;
        }
        if (hit->is_back) break;
        at = path_vertex(scene_, *hit, at.from + direction * hit->distance);
        found +=
            carried * (light_of_lamps(at) + light_of_sources(at, number) + light_of_emitters(at, number));
        carried *= at.reflectance * static_cast<float>(pi);
        const float chance = std::min(1.0f, std::max({carried.x, carried.y, carried.z}));
        if (!(number() < chance)) break;
        carried /= chance;
        const float x = number();
        direction = cosine_direction(Vec2f(x, number()), at.normal, axes_across(at.normal));
        found += carried * radiance_by_direction(at, direction);
    }
    return found;
}

PathTracer::Estimate PathTracer::indirect_irradiance(const Vec3f& from, const Vec3f& normal, double certainty,
                                                     std::uint32_t most, std::uint32_t seed) const {
    constexpr std::uint32_t batch = 1024;
    Numbers number(seed);
    // First directions are stratified, which matters most for the first bounce. The shift makes different
    // seeds independent.
    const float shift_x = number(), shift_y = number();
    const Axes<Vec3f> axes = axes_across(normal);
    Vec3d sum(0.0), squares(0.0);
    Estimate result;
    for (std::uint32_t path = 0; path < most; ++path) {
        const Vec2f stratum = sobol_point(path);
        const float x = stratum.x + shift_x + number() / batch, y = stratum.y + shift_y + number() / batch;
        const Vec2f place(std::min(x - std::floor(x), 0.99999994f), std::min(y - std::floor(y), 0.99999994f));
        const Vec3d found(radiance_along(from, cosine_direction(place, normal, axes), number) *
                          static_cast<float>(pi));
        sum += found;
        squares += found * found;
        const std::uint32_t paths = path + 1;
        if (paths % batch != 0 && paths != most) continue;
        for (int c = 0; c < 3; ++c) {
            const double mean = sum[c] / paths, variance = std::max(0.0, squares[c] / paths - mean * mean);
            result.irradiance[c] = static_cast<float>(mean);
            result.deviation[c] = static_cast<float>(std::sqrt(variance / paths));
        }
        if (double(luminance(result.deviation)) <= certainty * double(luminance(result.irradiance))) break;
    }
    return result;
}

Outgoing PathTracer::indirect_radiance(const Vec3f& from, const VertexBrdf& brdf, std::uint32_t paths,
                                       std::uint32_t seed) const {
    Outgoing radiance;
    if (brdf.diffuse != Rgb(0.0f))
        radiance.diffuse =
            brdf.diffuse * indirect_irradiance(from, brdf.normal, 0, paths, mixed_seed(seed, 0)).irradiance;
    if (!brdf.has_specular()) return radiance;
    Numbers number(mixed_seed(seed, 1));
    Rgb sum(0.0f);
    visit_lobe_rays(brdf, [&](const LobeRay& ray) {
        const Rgb tint = Rgb(1.0f) - brdf.metallic * ray.metallic;
        sum += radiance_along(from, ray.direction, number) * tint * ray.weight;
    });
    radiance.specular = sum * brdf.specular;
    return radiance;
}

}  // namespace haarfield
