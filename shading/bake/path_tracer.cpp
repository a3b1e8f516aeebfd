#include "shading/bake/path_tracer.h"

#include <algorithm>

#include "shading/bake/lamp_light.h"
#include "shading/bake/shadow_batch.h"
#include "shading/bounces/cosine_directions.h"
#include "shading/bounces/lobe_rays.h"

namespace haarfield {
namespace {

constexpr std::size_t packet = FineSurface::packet;
constexpr std::uint32_t batch_paths = 1024;  ///< Paths that advance together.
constexpr std::uint32_t lobe_share = 4;      ///< Paths of the diffuse component for each of a lobe.
constexpr float over_pi = static_cast<float>(1 / pi);

}  // namespace

PathTracer::PathVertex PathTracer::path_vertex(const SurfaceHit& hit, const Vec3f& position) const {
    const ShadedInstance& instance = rays_.scene.instances[hit.instance];
    const ShadedEntity& entity = rays_.scene.entities[instance.entity];
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
    return {position + instance.placement.direction_to_world(outwards) * offsets_[hit.instance],
            instance.placement.direction_to_world(normal.normalized()), reflectance * over_pi};
}

PathTracer::PathTracer(const RayScene& rays, const FineSurface& surface) : rays_(rays), surface_(surface) {
    for (const ShadedInstance& instance : rays.scene.instances)
        offsets_.push_back(surface_offset * instance.placement.scale *
                           rays.scene.entities[instance.entity].occlusion->coarse().bounds().radius());
}

/// The paths of one point.
class PathTracer::PathBatch {
public:
    PathBatch(const PathTracer& tracer, const PathSamples& samples, std::span<Rgb> radiance)
        : tracer_(tracer),
          rays_(tracer.rays_),
          samples_(samples),
          radiance_(radiance),
          shadows_(tracer.rays_.rays, Add{radiance}) {}

    void operator()(const Vec3f& from, std::span<const PathStart> starts, int bounces) {
        for (std::uint32_t i = 0; i < starts.size(); ++i)
            paths_.push_back({from, starts[i].direction, Rgb(1.0f), 0, i, starts[i].path});
        for (int reflection = 0; !paths_.empty(); ++reflection) {
            find_vertices(reflection, reflection < bounces);
            add_lamps();
            paths_.clear();
            for (const Met& met : met_) {
                const ReflectionSample sample =
                    samples_.reflection(met.path.number, std::uint32_t(reflection));
                add_sampled_light(met, sample);
                reflect(met, sample);
            }
            shadows_.trace();
        }
    }

private:
    /// A ray of a path.
    struct Path {
        Vec3f from, direction;
        Rgb carried;           ///< Factor of the radiance along the ray.
        float density;         ///< Of the direction. [1/sr]
        std::uint32_t start;   ///< Index in the result.
        std::uint32_t number;  ///< In the samples.
    };

    /// A surface that a path has met.
    struct Met {
        Path path;
        PathVertex at;
    };

    /// The light of an unblocked shadow ray.
    struct Light {
        std::uint32_t start;
        Rgb radiance;
    };
    struct Add {
        std::span<Rgb> radiance;
        void operator()(const Light& light) const { radiance[light.start] += light.radiance; }
    };

    /// Finds the surfaces that paths meet. Paths that leave the scene get the light from there.
    ///
    /// continues  false: surfaces end the paths.
    void find_vertices(int reflection, bool continues) {
        met_.clear();
        std::array<Vec3f, packet> directions;
        FineSurface::Hits hits;
        for (std::size_t first = 0; first < paths_.size(); first += packet) {
            const std::size_t count = std::min(packet, paths_.size() - first);
            if (reflection == 0) {
                for (std::size_t i = 0; i < count; ++i) directions[i] = paths_[first + i].direction;
                hits = tracer_.surface_.first_hits(rays_.scene, paths_[first].from,
                                                   std::span(directions).first(count));
            } else {
                for (std::size_t i = 0; i < count; ++i)
                    hits[i] = tracer_.surface_.first_hit(rays_.scene, paths_[first + i].from,
                                                         paths_[first + i].direction);
            }
            for (std::size_t i = 0; i < count; ++i) {
                const Path& path = paths_[first + i];
                const std::optional<SurfaceHit>& hit = hits[i];
                // The light that the first rays find is direct.
                if (!hit && reflection > 0) add_distant_light(path);
                if (hit && !hit->is_back && continues)
                    met_.push_back(
                        {path, tracer_.path_vertex(*hit, path.from + path.direction * hit->distance)});
            }
        }
    }

    void add_distant_light(const Path& path) {
        if (rays_.environment.is_black()) return;
        Rgb radiance;
        double density = 0;
        rays_.environment.look_up(path.direction, radiance, density);
        radiance_[path.start] += path.carried * radiance * (path.density / (path.density + float(density)));
    }

    void add_lamps() {
        if (rays_.lamps.empty()) return;
        for (std::size_t first = 0; first < met_.size(); first += packet) {
            const std::size_t count = std::min(packet, met_.size() - first);
            std::array<ShadingPoint, packet> receivers;
            std::array<Outgoing, packet> light;
            for (std::size_t i = 0; i < count; ++i) {
                const PathVertex& at = met_[first + i].at;
                receivers[i].from = receivers[i].position = at.from;
                receivers[i].brdf.normal = receivers[i].brdf.mirror = at.normal;
                receivers[i].brdf.diffuse = at.reflectance;
            }
            add_lamp_light(rays_.rays, rays_.lamps, std::span(receivers).first(count),
                           std::span(light).first(count));
            for (std::size_t i = 0; i < count; ++i) {
                const Path& path = met_[first + i].path;
                radiance_[path.start] += path.carried * light[i].diffuse;
            }
        }
    }

    /// Adds a shadow ray towards light that was sampled at a surface.
    void add_light(const Met& met, const LightSample& light) {
        const float cosine = met.at.normal.dot(light.direction);
        if (!(cosine > 0)) return;
        const double densities = light.density + (light.is_disc ? 0.0 : double(cosine * over_pi));
        shadows_.add(met.at.from, light.direction, light.distance,
                     {met.path.start, met.path.carried * met.at.reflectance * light.radiance *
                                          float(double(cosine) / densities)});
    }

    void add_sampled_light(const Met& met, const ReflectionSample& sample) {
        if (!rays_.environment.is_black()) add_light(met, sample.environment);
        if (!rays_.emitters.is_black())
            if (const auto light = rays_.emitters.sample(met.at.from, sample.emitter)) add_light(met, *light);
    }

    /// Continues a path, or ends it by Russian roulette.
    void reflect(const Met& met, const ReflectionSample& sample) {
        Path path = met.path;
        path.carried *= met.at.reflectance * static_cast<float>(pi);
        const float chance = std::min(1.0f, std::max({path.carried.x, path.carried.y, path.carried.z}));
        if (!(sample.roulette < double(chance))) return;
        path.carried /= chance;
        path.from = met.at.from;
        path.direction =
            cosine_direction(as_place(sample.direction), met.at.normal, axes_across(met.at.normal));
        const float cosine = met.at.normal.dot(path.direction);
        if (!(cosine > 0)) return;
        path.density = cosine * over_pi;
        paths_.push_back(path);
        if (rays_.emitters.is_black()) return;
        if (const std::optional<LightSample> light = rays_.emitters.look_up(path.from, path.direction))
            shadows_.add(
                path.from, path.direction, light->distance,
                {path.start, path.carried * light->radiance *
                                 float(double(path.density) / (double(path.density) + light->density))});
    }

    const PathTracer& tracer_;
    const RayScene& rays_;
    const PathSamples& samples_;
    std::span<Rgb> radiance_;
    ShadowBatch<Light, Add> shadows_;
    std::vector<Path> paths_;
    std::vector<Met> met_;
};

void PathTracer::trace(const Vec3f& from, std::span<const PathStart> starts, const PathSamples& samples,
                       int bounces, std::span<Rgb> radiance) const {
    std::ranges::fill(radiance, Rgb(0.0f));
    PathBatch(*this, samples, radiance)(from, starts, bounces);
}

PathTracer::Estimate PathTracer::indirect_irradiance(const Vec3f& from, const Vec3f& normal, double certainty,
                                                     std::uint32_t most, std::uint32_t seed) const {
    const Axes<Vec3f> axes = axes_across(normal);
    Vec3d sum(0.0), squares(0.0);
    Estimate result;
    std::vector<PathStart> starts;
    std::vector<Rgb> radiance;
    for (std::uint32_t first = 0; first < most; first += batch_paths) {
        const PathSamples samples(rays_.environment, std::min(batch_paths, most - first),
                                  mixed_seed(seed, first));
        starts.clear();
        for (std::uint32_t k = 0; k < samples.paths(); ++k)
            starts.push_back({cosine_direction(as_place(samples.first(k)), normal, axes), k});
        radiance.resize(starts.size());
        trace(from, starts, samples, any_bounces, radiance);
        for (const Rgb& each : radiance) {
            const Vec3d found(each * static_cast<float>(pi));
            sum += found;
            squares += found * found;
        }
        const std::uint32_t paths = first + samples.paths();
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
                                       std::uint32_t seed, int bounces) const {
    Components<Vec3d> sum;
    for (std::uint32_t first = 0; first < paths; first += batch_paths) {
        const PathSamples samples(rays_.environment, std::min(batch_paths, paths - first),
                                  mixed_seed(seed, first));
        sum += Components<Vec3d>(indirect_radiance(from, brdf, samples, bounces)) * double(samples.paths());
    }
    return Outgoing(sum / double(paths));
}

Outgoing PathTracer::indirect_radiance(const Vec3f& from, const VertexBrdf& brdf, const PathSamples& samples,
                                       int bounces) const {
    Outgoing result;
    std::vector<PathStart> starts;
    std::vector<Rgb> weights, radiance;
    if (brdf.diffuse != Rgb(0.0f)) {
        const Axes<Vec3f> axes = axes_across(brdf.normal);
        for (std::uint32_t k = 0; k < samples.paths(); ++k)
            starts.push_back({cosine_direction(as_place(samples.first(k)), brdf.normal, axes), k});
        radiance.resize(starts.size());
        trace(from, starts, samples, bounces, radiance);
        Vec3d sum(0.0);
        for (const Rgb& each : radiance) sum += Vec3d(each);
        result.diffuse = brdf.diffuse * Rgb(sum * (pi / samples.paths()));
    }
    if (!brdf.has_specular()) return result;
    starts.clear();
    visit_lobe_rays(
        brdf, std::max(1u, samples.paths() / lobe_share),
        [&](std::uint32_t k) {
            return as_place(samples.first(std::min(k * lobe_share + lobe_share / 2, samples.paths() - 1)));
        },
        [&](std::uint32_t k, const LobeRay& ray) {
            starts.push_back({ray.direction.normalized(), k});
            weights.push_back((Rgb(1.0f) - brdf.metallic * ray.metallic) * ray.weight);
        });
    radiance.resize(starts.size());
    trace(from, starts, samples, bounces, radiance);
    Vec3d sum(0.0);
    for (std::size_t k = 0; k < radiance.size(); ++k) sum += Vec3d(radiance[k] * weights[k]);
    result.specular = Rgb(sum) * brdf.specular;
    return result;
}

}  // namespace haarfield
