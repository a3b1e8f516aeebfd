#include "fields/field/samplers.h"

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

/// Returns the sum of the samples' weights.
double total_weight(double radius, double outer_radius) {
    return radius > outer_radius ? outer_radius * outer_radius / (radius * radius) : 1;
}

/// A position between two adjacent samples along one axis.
struct Bracket {
    std::uint32_t lower, upper;
    double fraction;
};

Bracket clamped_bracket(double index, int count) {
    const double clamped = std::clamp(index, 0.0, double(count - 1));
    const auto lower = std::min(static_cast<std::uint32_t>(clamped), static_cast<std::uint32_t>(count - 2));
    return {lower, lower + 1, clamped - lower};
}

Bracket wrapped_bracket(double azimuth, int count) {
    double index = azimuth / (2 * pi) * count;
    if (index < 0) index += count;
    auto lower = static_cast<std::uint32_t>(index);
    const double fraction = std::clamp(index - lower, 0.0, 1.0);
    lower %= static_cast<std::uint32_t>(count);
    return {lower, (lower + 1) % static_cast<std::uint32_t>(count), fraction};
}

/// Adds a sample unless its weight is zero.
void add_sample(Interpolation& interpolation, std::uint32_t sample, double weight) {
    if (!(weight > 0)) return;
    const auto slot = static_cast<std::size_t>(interpolation.count++);
    interpolation.sample[slot] = sample;
    interpolation.weight[slot] = static_cast<float>(weight);
}

}  // namespace

double distance_at(double t, double outer_radius, double growth) {
    return outer_radius * std::expm1(growth * t) / std::expm1(growth);
}

double radial_position(double distance, double outer_radius, double growth) {
    return std::log1p(distance / outer_radius * std::expm1(growth)) / growth;
}

Vec3f PlanarSampler::sample_position(std::uint32_t sample) const {
    const auto ring = sample / static_cast<std::uint32_t>(angles),
               angle = sample % static_cast<std::uint32_t>(angles);
    const double radius = distance_at(double(ring) / (rings - 1), outer_radius, growth);
    const double azimuth = 2 * pi * angle / angles;
    return centre + Vec3f(static_cast<float>(radius * std::cos(azimuth)), 0.0f,
                          static_cast<float>(radius * std::sin(azimuth)));
}

Interpolation PlanarSampler::interpolation(const Vec3f& position) const {
    const double x = double(position.x) - centre.x, z = double(position.z) - centre.z;
    const double radius = std::hypot(x, z);
    const double weight = total_weight(radius, outer_radius);
    Interpolation result;
    result.open = static_cast<float>(1 - weight);
    const Bracket ring = clamped_bracket(radial_position(radius, outer_radius, growth) * (rings - 1), rings);
    const Bracket angle = wrapped_bracket(std::atan2(z, x), angles);
    const auto columns = static_cast<std::uint32_t>(angles);
    add_sample(result, ring.lower * columns + angle.lower,
               weight * (1 - ring.fraction) * (1 - angle.fraction));
    add_sample(result, ring.lower * columns + angle.upper, weight * (1 - ring.fraction) * angle.fraction);
    add_sample(result, ring.upper * columns + angle.lower, weight * ring.fraction * (1 - angle.fraction));
    add_sample(result, ring.upper * columns + angle.upper, weight * ring.fraction * angle.fraction);
    return result;
}

Vec3f SphericalSampler::sample_position(std::uint32_t sample) const {
    const auto columns = static_cast<std::uint32_t>(azimuths), rows = static_cast<std::uint32_t>(polar);
    const auto azimuth_index = sample % columns, row = sample / columns % rows,
               shell = sample / columns / rows;
    const double radius = distance_at(double(shell) / (shells - 1), outer_radius, growth);
    const double inclination = pi * row / (polar - 1), azimuth = 2 * pi * azimuth_index / azimuths;
    // At the poles the sine is exactly zero, so that all azimuths coincide and share one cubemap.
    const double across = row == 0 || row + 1 == rows ? 0 : radius * std::sin(inclination);
    return centre + Vec3f(static_cast<float>(across * std::cos(azimuth)),
                          static_cast<float>(radius * std::cos(inclination)),
                          static_cast<float>(across * std::sin(azimuth)));
}

Interpolation SphericalSampler::interpolation(const Vec3f& position) const {
    const Vec3d offset = Vec3d(position) - Vec3d(centre);
    const double radius = offset.length();
    const double weight = total_weight(radius, outer_radius);
    Interpolation result;
    result.open = static_cast<float>(1 - weight);
    const double inclination = std::atan2(std::hypot(offset.x, offset.z), offset.y);
    const Bracket shell =
        clamped_bracket(radial_position(radius, outer_radius, growth) * (shells - 1), shells);
    const Bracket row = clamped_bracket(inclination / pi * (polar - 1), polar);
    const Bracket azimuth = wrapped_bracket(std::atan2(offset.z, offset.x), azimuths);
    for (unsigned corner = 0; corner < 8; ++corner) {
        const std::uint32_t s = corner & 4u ? shell.upper : shell.lower;
        const std::uint32_t r = corner & 2u ? row.upper : row.lower;
        const std::uint32_t a = corner & 1u ? azimuth.upper : azimuth.lower;
        add_sample(result,
                   (s * static_cast<std::uint32_t>(polar) + r) * static_cast<std::uint32_t>(azimuths) + a,
                   weight * (corner & 4u ? shell.fraction : 1 - shell.fraction) *
                       (corner & 2u ? row.fraction : 1 - row.fraction) *
                       (corner & 1u ? azimuth.fraction : 1 - azimuth.fraction));
    }
    return result;
}

PlanarSampler planar_sampler(const Vec3f& ground_centre, float radius, std::uint32_t samples) {
    PlanarSampler sampler;
    sampler.centre = ground_centre;
    sampler.outer_radius = 6 * radius;
    // Near the object, the spacing along a ring is then about that between rings.
    sampler.rings = std::max(2, static_cast<int>(std::sqrt(samples / 2.0)));
    sampler.angles = std::max(3, static_cast<int>(samples / static_cast<std::uint32_t>(sampler.rings)));
    return sampler;
}

SphericalSampler spherical_sampler(const Vec3f& centre, float radius, std::uint32_t samples) {
    SphericalSampler sampler;
    sampler.centre = centre;
    sampler.outer_radius = 6 * radius;
    // Azimuths : rows : shells = 2 : 1 : 1.25.
    const double rows = std::cbrt(samples / 2.5);
    sampler.polar = std::max(3, static_cast<int>(rows));
    sampler.azimuths = std::max(3, 2 * sampler.polar);
    sampler.shells =
        std::max(2, static_cast<int>(samples / static_cast<std::uint32_t>(sampler.polar * sampler.azimuths)));
    return sampler;
}

}  // namespace haarfield
