#include "shading/bounces/indirect_light.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "shading/bounces/gathering_directions.h"
#include "shading/bounces/lobe_rays.h"
#include "shading/bounces/row_loop.h"
#include "shading/scene/vertex_loop.h"
#include "shading/visibility/buried_fill.h"

namespace haarfield {
namespace {

Rgb between(const std::vector<Rgb>& values, const Mesh& mesh, const SurfaceHit& hit) {
    const std::array<float, 3> weights = hit.weights();
    Rgb sum(0.0f);
    for (std::size_t k = 0; k < 3; ++k) sum += values[mesh.triangles[hit.triangle][k]] * weights[k];
    return sum;
}

const Mesh& mesh_of(const ShadedScene& scene, std::size_t instance) {
    return *scene.entities[scene.instances[instance].entity].mesh;
}

/// Computes bounced_light with a transport between any elements.
template <class Transport>
Result<BouncedLight> sum_of_bounces(const Transport& transport, std::span<const Rgb> reflectance,
                                    std::span<const Rgb> direct, const BounceSettings& settings,
                                    const Progress& progress) {
    assert(reflectance.size() == direct.size());
    BouncedLight result;
    result.irradiance.assign(direct.size(), Rgb(0.0f));
    result.radiance.assign(direct.begin(), direct.end());
    std::vector<Rgb> last(direct.begin(), direct.end());
    std::vector<Rgb> arriving;
    constexpr std::size_t run = 4096;  // rows per partial sum, so that sums do not depend on threads
    struct Shares {
        double sum = 0;
        std::size_t lit = 0;
    };
    std::vector<Shares> shares((last.size() + run - 1) / run);
    double before = 1, factor = 0;
    while (result.bounces < settings.most) {
        if (progress.stop.stop_requested()) return interruption();
        arriving = transport.irradiance(last);
        // Contributions are relative to the radiance of the row, so that a dark room has the same weight as
        // the sunny street in front of it.
        tbb::parallel_for(std::size_t(0), shares.size(), [&](std::size_t r) {
            shares[r] = {};
            for (std::size_t row = r * run, end = std::min(last.size(), row + run); row < end; ++row) {
                last[row] = reflectance[row] * arriving[row];
                result.irradiance[row] += arriving[row];
                result.radiance[row] += last[row];
                const float whole = luminance(result.radiance[row]);
                if (!(whole > 0)) continue;
                shares[r].sum += double(luminance(last[row]) / whole);
                ++shares[r].lit;
            }
        });
        ++result.bounces;
        Shares all;
        for (const Shares& part : shares) {
            all.sum += part.sum;
            all.lit += part.lit;
        }
        const double added = all.lit > 0 ? all.sum / double(all.lit) : 0;
        factor = added / before;
        result.left_out = factor < 1 ? added * factor / (1 - factor) : 1;
        if (!(added > 0)) return result;
        if (factor < 1 && result.left_out <= double(settings.tolerance)) break;
        before = added;
    }
    if (result.bounces == 0 || result.bounces == settings.most) return result;
    // The further bounces have nearly the distribution of the last one.
    const float rest = static_cast<float>(factor / (1 - factor));
    for (std::size_t row = 0; row < last.size(); ++row) {
        result.irradiance[row] += arriving[row] * rest;
        result.radiance[row] += last[row] * rest;
    }
    return result;
}

}  // namespace

void fill_hidden(const ShadedScene& scene, const ShadingGeometry& geometry,
                 std::span<const std::uint8_t> hidden, SceneColours& colours) {
    const VertexRows rows(scene, geometry);
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const ShadedEntity& entity = scene.entities[scene.instances[i].entity];
        std::vector<std::uint8_t> by_vertex(rows.vertices(i).size());
        for (std::size_t k = 0; k < by_vertex.size(); ++k)
            by_vertex[rows.vertices(i)[k]] = hidden[rows.first(i) + k];
        if (by_vertex != entity.occlusion->samples().buried)
            BuriedFill(*entity.mesh, std::move(by_vertex))(colours[i]);
    }
}

std::vector<Rgb> row_reflectances(const ShadedScene& scene, const ShadingGeometry& geometry) {
    const VertexRows rows(scene, geometry);
    std::vector<Rgb> result;
    result.reserve(rows.count());
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const ShadedEntity& entity = scene.entities[scene.instances[i].entity];
        for (const std::uint32_t v : rows.vertices(i)) {
            const Rgb albedo = entity.materials[entity.mesh->vertex_materials[v]].diffuse;
            result.push_back((entity.tints.empty() ? albedo : albedo * entity.tints[v]) *
                             static_cast<float>(1 / pi));
        }
    }
    return result;
}

Result<BouncedLight> bounced_light(const LightTransport& transport, std::span<const Rgb> reflectance,
                                   std::span<const Rgb> direct, const BounceSettings& settings,
                                   const Progress& progress) {
    return sum_of_bounces(transport, reflectance, direct, settings, progress);
}

Result<BouncedLight> bounced_light(const LightTransport& transport, const CoarseTransport& coarse,
                                   std::span<const Rgb> reflectance, std::span<const Rgb> direct,
                                   const BounceSettings& settings, const Progress& progress) {
    if (settings.most < 3) return bounced_light(transport, reflectance, direct, settings, progress);
    // The first bounce is computed at all rows, since direct light may vary quickly.
    const std::vector<Rgb> first = transport.irradiance(direct);
    std::vector<Rgb> radiance(direct.size());
    for_rows(direct.size(), [&](std::size_t row) { radiance[row] = reflectance[row] * first[row]; });
    BounceSettings later = settings;
    if (later.most < any_bounces) later.most -= 2;
    HF_TRY(BouncedLight result,
           sum_of_bounces(coarse, coarse.means(reflectance), coarse.means(radiance), later, progress));
    for_rows(direct.size(), [&](std::size_t row) {
        radiance[row] += direct[row] + reflectance[row] * result.irradiance[coarse.group[row]];
    });
    result.irradiance = transport.irradiance(radiance);
    for_rows(direct.size(), [&](std::size_t row) {
        radiance[row] = direct[row] + reflectance[row] * result.irradiance[row];
    });
    result.radiance = std::move(radiance);
    result.bounces += 2;
    return result;
}

IndirectLight indirect_light(const ShadedScene& scene, const ShadingGeometry& geometry,
                             std::shared_ptr<const FineSurface> surface, const LightTransport& transport,
                             BouncedLight bounced) {
    IndirectLight result;
    result.surface = std::move(surface);
    transport.smooth(bounced.irradiance);
    store_radiance(scene, geometry, bounced.irradiance, result.irradiance);
    store_radiance(scene, geometry, bounced.radiance, result.radiance);
    fill_hidden(scene, geometry, transport.hidden(), result.irradiance);
    fill_hidden(scene, geometry, transport.hidden(), result.radiance);
    result.bounces = bounced.bounces;
    result.left_out = bounced.left_out;
    result.transport_bytes = transport.bytes();
    return result;
}

GatheredIrradiance IndirectLight::gathered_at(const ShadedScene& scene, std::size_t instance,
                                              const SurfacePoint& point, int rays) const {
    const Placement& placement = scene.instances[instance].placement;
    const Vec3f from = placement.point_to_world(point.sample);
    const Vec3f normal = placement.direction_to_world(point.normal);
    const Axes<Vec3f> axes = axes_across(normal);
    double near = 0;
    Rgb sum(0.0f);
    std::array<Vec3f, FineSurface::packet> directions;
    const std::span<const Vec3f> upright = gathering_directions(rays);
    for (std::size_t first = 0; first < upright.size(); first += directions.size()) {
        std::ranges::transform(
            upright.subspan(first, directions.size()), directions.begin(),
            [&](const Vec3f& d) { return axes.across * d.x + axes.up * d.y + normal * d.z; });
        const FineSurface::Hits hits = surface->first_hits(scene, from, directions);
        for (std::size_t k = 0; k < hits.size(); ++k) {
            if (!hits[k]) continue;
            const Rgb met = radiance_of(scene, *hits[k]);
            sum += lit ? met * share_of_direction(scene, *hits[k], directions[k], upright[first + k].z) : met;
            near += 1 / double(std::max(hits[k]->distance, 1e-12f));
        }
    }
    Rgb whole = sum * static_cast<float>(pi / rays);
    if (lit) whole += irradiance_from_bright_points(from, normal, rays);
    return {whole, static_cast<float>(near / rays)};
}

float IndirectLight::share_of_direction(const ShadedScene& scene, const SurfaceHit& hit,
                                        const Vec3f& direction, float cosine) const {
    const Mesh& mesh = mesh_of(scene, hit.instance);
    const auto& [a, b, c] = mesh.triangles[hit.triangle];
    const Vec3f across =
        (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]).normalized();
    const float slope = std::abs(
        across.dot(scene.instances[hit.instance].placement.direction_to_object(direction).normalized()));
    const float by_direction = cosine * static_cast<float>(1 / pi),
                by_point = lit->density_at(scene, radiance, hit) * hit.distance * hit.distance /
                           std::max(slope, 1e-6f);
    return by_direction / (by_direction + by_point);
}

Rgb IndirectLight::irradiance_from_bright_points(const Vec3f& from, const Vec3f& normal, int rays) const {
    const std::span<const LitSurface::BrightPoint> points = lit->points(rays);
    Rgb sum(0.0f);
    std::array<Vec3f, FineSurface::packet> ends;
    std::array<Rgb, FineSurface::packet> light;
    std::size_t count = 0;
    const auto trace = [&] {
        const std::uint16_t hidden = surface->hidden(from, std::span(ends).first(count));
        for (std::size_t k = 0; k < count; ++k)
            if ((hidden >> k & 1u) == 0) sum += light[k];
        count = 0;
    };
    for (const LitSurface::BrightPoint& point : points) {
        const Vec3f to = point.position - from;
        const float square = to.length2(), distance = std::sqrt(square), cosine = normal.dot(to) / distance,
                    slope = -point.normal.dot(to) / distance;
        if (!(cosine > 0) || !(slope > 1e-6f)) continue;
        const float by_direction = cosine * static_cast<float>(1 / pi),
                    by_point = point.density * square / slope;
        ends[count] = point.position;
        light[count] = point.radiance * (cosine / (float(rays) * (by_direction + by_point)));
        if (++count == ends.size()) trace();
    }
    trace();
    return sum;
}

Rgb IndirectLight::radiance_of(const ShadedScene& scene, const SurfaceHit& hit) const {
    if (hit.is_back) return Rgb(0.0f);
    return lit ? lit->radiance_at(scene, radiance, hit)
               : between(radiance[hit.instance], mesh_of(scene, hit.instance), hit);
}

Outgoing IndirectLight::outgoing(const ShadedScene& scene, const Vec3f& from, const VertexBrdf& brdf,
                                 const Rgb& arriving) const {
    const Rgb diffuse = brdf.diffuse * arriving;
    if (brdf.specular == Rgb(0.0f)) return {diffuse};
    Rgb sum(0.0f);
    std::array<LobeRay, FineSurface::packet> rays;
    std::array<Vec3f, FineSurface::packet> directions;
    std::size_t count = 0;
    const auto trace = [&] {
        const FineSurface::Hits hits = surface->first_hits(scene, from, std::span(directions).first(count));
        for (std::size_t k = 0; k < count; ++k)
            if (hits[k])
                sum += radiance_of(scene, *hits[k]) * (Rgb(1.0f) - brdf.metallic * rays[k].metallic) *
                       rays[k].weight;
        count = 0;
    };
    visit_lobe_rays(brdf, [&](const LobeRay& ray) {
        rays[count] = ray;
        directions[count] = ray.direction;
        if (++count == rays.size()) trace();
    });
    trace();
    return {diffuse, sum * brdf.specular};
}

}  // namespace haarfield
