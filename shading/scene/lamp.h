#pragma once
/// Lamps: light from places in the scene, shed as POV-Ray's light sources shed it.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fields/base/vector.h"

namespace haarfield {

/// How a lamp's rays run.
enum class LampKind : std::uint8_t {
    point,     ///< From its place in all directions.
    spot,      ///< The same, within a cone about the axis from its place to its target.
    cylinder,  ///< Along that axis, within a cylinder about it; only ahead of its place.
    parallel,  ///< Along that axis, everywhere; what stands behind its place casts no shadow.
};

/// A grid of places from which the light comes as far as shadows go.
struct LampArea {
    Vec3f across{1, 0, 0}, along{0, 0, 1};  ///< Edges of the grid, whose middle is the lamp's place. [m]
    std::uint32_t columns = 4, rows = 4;    ///< Places; 1 to 1024 each.
    bool circular = false;                  ///< The grid is bent into an ellipse.
    bool orient = false;                    ///< Its edges turn to face the point that is lit.
    /// Points are lit from all places, not from the middle alone: by the mean light of all of them times the
    /// mean of their visibilities.
    bool illumination = false;

    bool operator==(const LampArea&) const = default;
};

/// One lamp.
struct Lamp {
    LampKind kind = LampKind::point;
    Vec3f position{0, 0, 0};  ///< [m]
    Vec3f target{0, -1, 0};   ///< What it points at; another place. Of all kinds but point. [m]
    /// Outgoing radiance of a white matt surface that faces it, near the axis, where nothing fades: the
    /// irradiance there over pi. >= 0. [W/(m^2 sr)]
    Rgb colour{1, 1, 1};
    /// Light falls off as 2 / (1 + (d / fade_distance)^fade_power), d the distance, or the depth along the
    /// axis where rays are parallel. 0: it does not. [m]
    float fade_distance = 0;
    float fade_power = 2;  ///< 0 to 100.
    /// Where light begins and ends to fade away from the axis: half angles of the cone [rad], or radii of the
    /// cylinder [m]. falloff >= radius >= 0.
    float radius = 0.5235988f, falloff = 0.7853982f;
    float tightness = 0;           ///< How fast it does so between: POV-Ray's exponent. 0 to 100.
    std::optional<LampArea> area;  ///< Of point and spot only.
    bool shadowless = false;       ///< Nothing casts a shadow; makes no highlights then, as in POV-Ray.
    /// An instance of the scene that shows what the lamp looks like: it casts no shadow of this lamp.
    std::optional<std::size_t> looks_like;

    bool operator==(const Lamp&) const = default;
};

/// What comes from a lamp at a point.
struct LampLight {
    Vec3d direction;      ///< Towards the light; unit length.
    double distance = 0;  ///< To where a shadow ray ends; 0: nothing shadows the point. [m]
    double share = 0;     ///< Irradiance on a surface that faces it / (pi colour). 0: none.
};

/// The light of a lamp at a point, if nothing stands between; of an area, that of its middle.
///
/// accuracy  against POV-Ray's pictures: 1e-5.
/// source    POV-Ray 3.7's light_source.
LampLight lamp_light(const Lamp& lamp, const Vec3d& point);

/// One of an area's places, in units of its edges.
struct LampPlace {
    double across, along;  ///< From the middle.
    double weight;         ///< Of its visibility; all of them add up to 1.
};

/// An area's places; of a lamp without one, the middle.
///
/// source  POV-Ray's recursion from the corners inwards, as deep as it goes: the places of 2^k have equal
///         weights, and those of 2^k + 1 have half of it at the ends.
std::vector<LampPlace> lamp_places(const std::optional<LampArea>& area);

/// A lamp with its places.
struct PlacedLamp {
    Lamp lamp;
    std::vector<LampPlace> places;
};
std::vector<PlacedLamp> placed_lamps(std::span<const Lamp> lamps);  ///< Those that are not black.

/// A place in the world, as a point sees it.
///
/// direction  from the point to the lamp's middle; of LampArea::orient. Unit length.
Vec3d lamp_place(const Lamp& lamp, const LampPlace& place, const Vec3d& direction);

}  // namespace haarfield
