#include "bridge/povray/lamp_text.h"

#include <fmt/format.h>

#include <cassert>

namespace haarfield {
namespace {

constexpr double degrees_a_radian = 180 / pi;

std::string place_text(const Vec3f& place, double scale) {
    assert(is_finite(place));
    const Vec3d at = Vec3d(place) * scale;
    return fmt::format("<{:.12g}, {:.12g}, {:.12g}>", at.x, at.y, at.z);
}

}  // namespace

std::string povray_lamp(const Lamp& lamp, double scale, const std::string& factor) {
    std::string text =
        fmt::format("light_source {{ {} rgb {}<{:.9g}, {:.9g}, {:.9g}>", place_text(lamp.position, scale),
                    factor.empty() ? "" : factor + "*", lamp.colour.x, lamp.colour.y, lamp.colour.z);
    if (lamp.kind == LampKind::spot)
        text += fmt::format(" spotlight radius {:.9g} falloff {:.9g}", double(lamp.radius) * degrees_a_radian,
                            double(lamp.falloff) * degrees_a_radian);
    if (lamp.kind == LampKind::cylinder)
        text += fmt::format(" cylinder radius {:.9g} falloff {:.9g}", double(lamp.radius) * scale,
                            double(lamp.falloff) * scale);
    if (lamp.kind == LampKind::spot || lamp.kind == LampKind::cylinder)
        text += fmt::format(" tightness {}", lamp.tightness);
    if (lamp.kind == LampKind::parallel) text += " parallel";
    if (lamp.kind != LampKind::point) text += " point_at " + place_text(lamp.target, scale);
    if (lamp.fade_distance > 0)
        text += fmt::format(" fade_distance {:.9g} fade_power {}", double(lamp.fade_distance) * scale,
                            lamp.fade_power);
    if (lamp.area) {
        text += fmt::format(" area_light {}, {}, {}, {}", place_text(lamp.area->across, scale),
                            place_text(lamp.area->along, scale), lamp.area->columns, lamp.area->rows);
        if (lamp.area->circular) text += " circular";
        if (lamp.area->orient) text += " orient";
        if (lamp.area->illumination) text += " area_illumination on";
    }
    if (lamp.shadowless) text += " shadowless";
    return text + " }";
}

}  // namespace haarfield
