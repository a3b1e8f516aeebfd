#pragma once
/// Lamps: local lights that emit light as POV-Ray's light sources do.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fields/base/vector.h"

namespace haarfield {

/// The directions of a lamp's rays.
enum class LampKind : std::uint8_t {
    point,     ///< From the lamp's position in all directions.
    spot,      ///< From the lamp's position, within a cone about the axis to its target.
    cylinder,  ///< Along the axis, within a cylinder about it; only in front of the position.
    parallel,  ///< Along the axis, everywhere; objects behind the position cast no shadow.
};

/// A grid of positions from which shadow rays start.
struct LampArea {
    Vec3f across{1, 0, 0}, along{0, 0, 1};  ///< Edges of the grid, whose centre is the lamp's position. [m]
    std::uint32_t columns = 4, rows = 4;    ///< Positions; 1 to 1024 each.
    bool circular = false;                  ///< Bends the grid into an ellipse.
    bool orient = false;                    ///< Rotates the grid to face the lit point.
    /// Lights points from all positions, not from the centre alone: by the mean light of all positions times
    /// the mean of their visibilities.
    bool illumination = false;

    bool operator==(const LampArea&) const = default;
};

/// A lamp.
struct Lamp {
    LampKind kind = LampKind::point;
    Vec3f position{0, 0, 0};  ///< [m]
    Vec3f target{0, -1, 0};   ///< Point on the axis, different from the position. Of all kinds except point.
                              ///< [m]
    /// Outgoing radiance of a white diffuse surface that faces the lamp, near the axis and without fading:
    /// the irradiance there over pi. >= 0. [W/(m^2 sr)]
    Rgb colour{1, 1, 1};
    /// Light fades as 2 / (1 + (d / fade_distance)^fade_power). d is the distance, or the depth along the
    /// axis for cylinder and parallel. 0: no fading. [m]
    float fade_distance = 0;
    float fade_power = 2;  ///< 0 to 100.
    /// Range of the falloff away from the axis: half angles of the cone [rad], or radii of the cylinder [m].
    /// falloff >= radius >= 0.
    float radius = 0.5235988f, falloff = 0.7853982f;
    float tightness = 0;           ///< POV-Ray's exponent of the falloff. 0 to 100.
    std::optional<LampArea> area;  ///< For point and spot only.
    bool shadowless = false;       ///< Nothing casts a shadow of the lamp; it has no specular light, as in
                                   ///< POV-Ray.
    /// An instance that shows the lamp's shape: it casts no shadow of this lamp.
    std::optional<std::size_t> looks_like;

    bool operator==(const Lamp&) const = default;
};

/// The light of a lamp at a point.
struct LampLight {
    Vec3d direction;      ///< Towards the light; unit length.
    double distance = 0;  ///< To the end of a shadow ray; 0: nothing occludes the point. [m]
    double share = 0;     ///< Irradiance on a surface that faces the light / (pi colour). 0: none.
};

/// Returns the unoccluded light of a lamp at a point; for an area, the light of its centre.
///
/// accuracy  1e-5 against pictures by POV-Ray.
/// source    POV-Ray 3.7's light_source.
LampLight lamp_light(const Lamp& lamp, const Vec3d& point);

/// One position of an area, in units of its edges.
struct LampPlace {
    double across, along;  ///< From the centre.
    double weight;         ///< Of its visibility; the weights add up to 1.
};

/// Returns the positions of an area; the centre for a lamp without one.
///
/// source  POV-Ray's recursion from the corners inwards, at full depth: 2^k positions have equal weights; of
///         2^k + 1, the two at the ends have half the weight of the others.
std::vector<LampPlace> lamp_places(const std::optional<LampArea>& area);

/// A lamp with the positions of its area.
struct PlacedLamp {
    Lamp lamp;
    std::vector<LampPlace> places;
};
std::vector<PlacedLamp> placed_lamps(std::span<const Lamp> lamps);  ///< Leaves out black lamps.

/// Returns a position of an area in the world.
///
/// direction  from the point to the lamp's centre, for LampArea::orient. Unit length.
Vec3d lamp_place(const Lamp& lamp, const LampPlace& place, const Vec3d& direction);

}  // namespace haarfield
