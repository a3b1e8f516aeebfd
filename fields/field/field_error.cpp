#include "fields/field/field_error.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "fields/rasterizer/visibility_rasterizer.h"
#include "fields/wavelets/haar_transform.h"

namespace haarfield {
namespace {

/// Squared norms over the sphere of directions.
struct SquaredNorms {
    double error = 0, occlusion = 0, open = 0;
};

/// Returns the solid angles of the texels of one face, in row-major order. [sr]
std::vector<double> solid_angles(int face_size) {
    std::vector<double> angles;
    for (int row = 0; row < face_size; ++row)
        for (int column = 0; column < face_size; ++column)
            angles.push_back(texel_solid_angle(column, row, face_size));
    return angles;
}

SquaredNorms squared_norms(const CubemapTree& found, std::span<const std::uint8_t> open,
                           std::span<const double> solid_angle, int face_size) {
    SquaredNorms norms;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const std::vector<float> visibility = quadtree_texels(found.faces[face], face_size);
        for (std::size_t i = 0; i < solid_angle.size(); ++i) {
            const double exact = double(open[face * solid_angle.size() + i]) / samples_per_texel,
                         error = double(visibility[i]) - exact;
            norms.error += error * error * solid_angle[i];
            norms.occlusion += (1 - exact) * (1 - exact) * solid_angle[i];
            norms.open += exact * exact * solid_angle[i];
        }
    }
    return norms;
}

constexpr std::size_t points_a_band = 40;

/// Returns random points, band by band: on the plane of the sampler's centre, or all around it.
template <class Sampler>
std::vector<Vec3f> random_points(const Sampler& sampler, bool on_level) {
    std::mt19937 random(1);
    const auto number = [&] { return static_cast<double>(random()) * 0x1p-32; };
    std::vector<Vec3f> points;
    for (std::size_t i = 0; i < SamplerError::bands * points_a_band; ++i) {
        const double t = (double(i / points_a_band) + number()) / SamplerError::bands,
                     azimuth = 2 * pi * number(), height = on_level ? 0 : 2 * number() - 1,
                     across = std::sqrt(1 - height * height);
        const Vec3d direction(across * std::cos(azimuth), height, across * std::sin(azimuth));
        points.push_back(sampler.centre +
                         Vec3f(direction * distance_at(t, sampler.outer_radius, sampler.growth)));
    }
    return points;
}

/// Measures the error of one sampler. lift: added to the points for the exact visibility.
template <class Sampler>
SamplerError sampler_error(const VisibilityField& field, const Sampler& sampler,
                           const std::vector<std::int32_t>& handles, const std::vector<Vec3f>& points,
                           const Vec3f& lift, const EntityOcclusion& occlusion, const std::stop_token& stop) {
    const std::vector<double> solid_angle = solid_angles(field.settings.face_size);
    std::vector<std::optional<SquaredNorms>> norms(points.size());
    tbb::enumerable_thread_specific<VisibilityRasterizer> rasterizers(field.settings.face_size);
    tbb::parallel_for(std::size_t(0), points.size(), [&](std::size_t i) {
        if (stop.stop_requested() || occlusion.in_original()(points[i] + lift)) return;
        norms[i] = squared_norms(interpolated_visibility(field, handles, sampler.interpolation(points[i])),
                                 rasterizers.local().open_samples(occlusion.coarse(), points[i] + lift),
                                 solid_angle, field.settings.face_size);
    });
    SamplerError result;
    SquaredNorms all;
    for (std::size_t band = 0; band < SamplerError::bands; ++band) {
        SquaredNorms sum;
        for (std::size_t i = band * points_a_band; i < (band + 1) * points_a_band; ++i) {
            if (!norms[i]) continue;
            sum.error += norms[i]->error;
            sum.occlusion += norms[i]->occlusion;
            sum.open += norms[i]->open;
        }
        result.band[band] =
            sum.open > 0 ? static_cast<float>(std::min(1.0, std::sqrt(sum.error / sum.open))) : 1.0f;
        all.error += sum.error;
        all.occlusion += sum.occlusion;
    }
    result.relative = all.occlusion > 0 ? static_cast<float>(std::sqrt(all.error / all.occlusion)) : 0.0f;
    return result;
}

}  // namespace

FieldError field_error(const VisibilityField& field, const EntityOcclusion& occlusion,
                       const std::stop_token& stop) {
    return {sampler_error(field, field.planar, field.planar_handles, random_points(field.planar, true),
                          planar_lift(field), occlusion, stop),
            sampler_error(field, field.spherical, field.spherical_handles,
                          random_points(field.spherical, false), Vec3f(0.0f), occlusion, stop)};
}

}  // namespace haarfield
