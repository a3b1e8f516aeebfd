#pragma once
/// Where visibility is sampled around an entity, and how it is interpolated between the samples.
///
/// Spacing grows with distance: ring or shell i of n lies at the distance
///     outer_radius * (exp(growth t) - 1) / (exp(growth) - 1),  t = i / (n - 1);
/// the first one is the centre itself. (Sun and Mukherjee 2006, section 6.1; the exponential law is
/// ours: near the object it halves the interpolation error of a uniform spacing.)

#include "fields/base/vector.h"

#include <array>
#include <cstdint>

namespace haarfield {

/// The law: the distance at t in [0, 1], and the t of a distance; beyond the outer radius t is greater
/// than 1.
double distance_at(double t, double outer_radius, double growth);
double radial_position(double distance, double outer_radius, double growth);  ///< The inverse of distance_at.

/// Samples and weights of one lookup: at most eight, weights in [0, 1].
struct Interpolation {
    std::array<std::uint32_t, 8> sample{};
    std::array<float, 8> weight{};
    int count = 0;
    float open = 0.0f;  ///< Weight of "nothing in the way". All weights, with this, add up to 1.
};

/// Concentric circles on the plane y = centre.y. Sample index = ring * angles + angle;
/// angle j is at the azimuth 2 pi j / angles, measured from +x towards +z.
struct PlanarSampler {
    Vec3f centre{0, 0, 0};  ///< Projection of the box's centre on the lowest plane of the box. [m]
    std::int32_t rings = 0, angles = 0;
    float outer_radius = 0;  ///< [m]
    float growth = 3;

    /// Of all circles.
    std::uint32_t sample_count() const { return static_cast<std::uint32_t>(rings * angles); }
    Vec3f sample_position(std::uint32_t sample) const;  ///< Where a sample stands. [m]

    /// Bilinear, with wrap-around in angle. Beyond outer_radius the samples of the last ring weigh less by
    /// the square of the distance, as what the entity hides does; it looks too large and too faint there.
    Interpolation interpolation(const Vec3f& position) const;
};

/// Concentric spheres. Sample index = (shell * polar + row) * azimuths + azimuth; row k is at the
/// polar angle pi k / (polar - 1) from +y: the first and last rows are the poles, where all azimuths
/// coincide. Azimuths as above. Lookup is trilinear, and beyond outer_radius as PlanarSampler's.
struct SphericalSampler {
    Vec3f centre{0, 0, 0};  ///< Centre of the bounding box. [m]
    std::int32_t shells = 0, polar = 0, azimuths = 0;
    float outer_radius = 0;  ///< [m]
    float growth = 3;

    /// Of all spheres.
    std::uint32_t sample_count() const { return static_cast<std::uint32_t>(shells * polar * azimuths); }
    Vec3f sample_position(std::uint32_t sample) const;         ///< Where a sample stands. [m]
    Interpolation interpolation(const Vec3f& position) const;  ///< The samples round a position.
};

/// Samplers with about the wanted number of samples (never more, at least 2 rings x 3 angles or
/// 2 x 3 x 3), of about equal spacing in each direction near the object.
PlanarSampler planar_sampler(const Vec3f& ground_centre, float radius, std::uint32_t samples);
/// See planar_sampler.
SphericalSampler spherical_sampler(const Vec3f& centre, float radius, std::uint32_t samples);

}  // namespace haarfield
