#pragma once
/// Positions of visibility samples around an entity, and interpolation between them.
///
/// The spacing increases with distance: ring or shell i of n is at the distance
///     outer_radius * (exp(growth t) - 1) / (exp(growth) - 1),  t = i / (n - 1);
/// the first one is the centre itself. (Sun and Mukherjee 2006, section 6.1. The exponential law is ours:
/// near the object it halves the interpolation error of a uniform spacing.)

#include "fields/base/vector.h"

#include <array>
#include <cstdint>

namespace haarfield {

/// Returns the distance at t in [0, 1].
double distance_at(double t, double outer_radius, double growth);
/// The inverse of distance_at; greater than 1 beyond the outer radius.
double radial_position(double distance, double outer_radius, double growth);

/// Samples and weights of one lookup: at most eight, with weights in [0, 1].
struct Interpolation {
    std::array<std::uint32_t, 8> sample{};
    std::array<float, 8> weight{};
    int count = 0;
    float open = 0.0f;  ///< Weight of full visibility. All weights, including this one, sum to 1.
};

/// Concentric circles on the plane y = centre.y. Sample index = ring * angles + angle. Angle j is at the
/// azimuth 2 pi j / angles, measured from +x towards +z.
struct PlanarSampler {
    Vec3f centre{0, 0, 0};  ///< Projection of the box's centre onto the bottom plane of the box. [m]
    std::int32_t rings = 0, angles = 0;
    float outer_radius = 0;  ///< [m]
    float growth = 3;

    /// The number of samples on all circles.
    std::uint32_t sample_count() const { return static_cast<std::uint32_t>(rings * angles); }
    Vec3f sample_position(std::uint32_t sample) const;  ///< Returns a sample's position. [m]

    /// Interpolates bilinearly, with wrap-around in angle. Beyond outer_radius, the weights of the last ring
    /// decrease with the square of the distance, like the solid angle that the entity occludes. There, the
    /// occlusion is too large and too faint.
    Interpolation interpolation(const Vec3f& position) const;
};

/// Concentric spheres. Sample index = (shell * polar + row) * azimuths + azimuth. Row k is at the polar angle
/// pi k / (polar - 1) from +y. The first and last rows are the poles, where all azimuths coincide. Azimuths
/// are those of PlanarSampler.
struct SphericalSampler {
    Vec3f centre{0, 0, 0};  ///< Centre of the bounding box. [m]
    std::int32_t shells = 0, polar = 0, azimuths = 0;
    float outer_radius = 0;  ///< [m]
    float growth = 3;

    /// The number of samples on all spheres.
    std::uint32_t sample_count() const { return static_cast<std::uint32_t>(shells * polar * azimuths); }
    Vec3f sample_position(std::uint32_t sample) const;  ///< Returns a sample's position. [m]
    /// Interpolates trilinearly; beyond outer_radius as PlanarSampler.
    Interpolation interpolation(const Vec3f& position) const;
};

/// Return samplers with about `samples` samples, with similar spacing in each direction near the object:
/// never more than `samples`, but at least 2 rings x 3 angles or 2 x 3 x 3.
PlanarSampler planar_sampler(const Vec3f& ground_centre, float radius, std::uint32_t samples);
/// See planar_sampler.
SphericalSampler spherical_sampler(const Vec3f& centre, float radius, std::uint32_t samples);

}  // namespace haarfield
