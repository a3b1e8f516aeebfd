#include "shading/bake/lamp_light.h"

#include <algorithm>
#include <cassert>

namespace haarfield {
namespace {

constexpr std::size_t packet = ShadowRays::packet;

/// Returns the light of a lamp as if it were at one of its positions.
LampLight light_from(const PlacedLamp& placed, const LampPlace& place, const Vec3d& direction,
                     const Vec3d& point) {
    Lamp moved = placed.lamp;
    moved.position = Vec3f(lamp_place(placed.lamp, place, direction));
    moved.target += moved.position - placed.lamp.position;
    return lamp_light(moved, point);
}

/// Returns the radiance of a point without shadows, for light of colour 1. `response` is BRDF times cosine by
/// direction.
template <class Number, class Response>
auto unshadowed(const PlacedLamp& placed, const LampLight& light, const Vec3d& point,
                const Response& response) {
    if (!placed.lamp.area || !placed.lamp.area->illumination)
        return response(light.direction) * static_cast<Number>(light.share);
    decltype(response(light.direction)) sum;
    for (const LampPlace& place : placed.places) {
        const LampLight here = light_from(placed, place, light.direction, point);
        if (here.share > 0) sum += response(here.direction) * static_cast<Number>(here.share);
    }
    return sum / static_cast<Number>(placed.places.size());
}

/// Returns the end of the shadow ray for one of a lamp's positions.
Vec3f ray_end(const PlacedLamp& placed, const LampPlace& place, const LampLight& light, const Vec3f& from) {
    if (placed.lamp.kind == LampKind::cylinder || placed.lamp.kind == LampKind::parallel)
        return Vec3f(Vec3d(from) + light.direction * light.distance);
    return Vec3f(lamp_place(placed.lamp, place, light.direction));
}

std::size_t instance_left_out(const Lamp& lamp) {
    return lamp.looks_like.value_or(ShadowRays::no_instance);
}

bool can_be_shadowed(const Lamp& lamp, const LampLight& light) {
    return !lamp.shadowless && light.distance > 0;
}

/// Adds the light of a lamp to up to 16 receivers.
void add_to_packet(const ShadowRays& rays, const PlacedLamp& placed, std::span<const ShadingPoint> receivers,
                   std::span<const Vec3f> from, std::span<Outgoing> radiance) {
    const Lamp& lamp = placed.lamp;
    const Rgb irradiance = lamp.colour * static_cast<float>(pi);
    std::array<LampLight, packet> light;
    std::array<Outgoing, packet> whole;
    std::uint16_t lit = 0;
    for (std::size_t i = 0; i < receivers.size(); ++i) {
        const Vec3d point(receivers[i].position);
        light[i] = lamp_light(lamp, point);
        if (!(light[i].share > 0)) continue;
        whole[i] = unshadowed<float>(placed, light[i], point,
                                     [&](const Vec3d& direction) {
                                         return reflectance(receivers[i].brdf, Vec3f(direction));
                                     }) *
                   irradiance;
        if (lamp.shadowless) whole[i].specular = Rgb(0.0f);
        if (whole[i] != Outgoing()) lit = static_cast<std::uint16_t>(lit | 1u << i);
    }
    std::uint16_t shadowed = 0;
    std::array<Rgb, packet> visibility;
    visibility.fill(Rgb(1.0f));
    for (std::size_t i = 0; i < receivers.size(); ++i)
        if ((lit >> i & 1u) && can_be_shadowed(lamp, light[i])) {
            shadowed = static_cast<std::uint16_t>(shadowed | 1u << i);
            visibility[i] = Rgb(0.0f);
        }
    if (shadowed != 0) {
        std::array<Vec3f, packet> ends;
        for (const LampPlace& place : placed.places) {
            for (std::size_t i = 0; i < receivers.size(); ++i)
                if (shadowed >> i & 1u) ends[i] = ray_end(placed, place, light[i], from[i]);
            const std::uint16_t blocked = rays.blocked_from(
                from, shadowed, std::span(ends).first(receivers.size()), instance_left_out(lamp));
            for (std::size_t i = 0; i < receivers.size(); ++i)
                if ((shadowed >> i & 1u) && !(blocked >> i & 1u))
                    visibility[i] += rays.transmitted(from[i], ends[i]) * static_cast<float>(place.weight);
        }
    }
    for (std::size_t i = 0; i < receivers.size(); ++i)
        if (lit >> i & 1u) radiance[i] += whole[i] * visibility[i];
}

}  // namespace

void add_lamp_light(const ShadowRays& rays, std::span<const PlacedLamp> lamps,
                    std::span<const ShadingPoint> receivers, std::span<Outgoing> radiance) {
    assert(receivers.size() == radiance.size());
    if (lamps.empty()) return;
    std::array<Vec3f, packet> from;
    for (std::size_t first = 0; first < receivers.size(); first += packet) {
        const std::size_t count = std::min(packet, receivers.size() - first);
        const std::span<const ShadingPoint> here = receivers.subspan(first, count);
        for (std::size_t i = 0; i < count; ++i) from[i] = here[i].from;
        for (const PlacedLamp& lamp : lamps)
            add_to_packet(rays, lamp, here, std::span(from).first(count), radiance.subspan(first, count));
    }
}

Components<Vec3d> radiance_from_lamps(std::span<const PlacedLamp> lamps, const ShadowRays& rays,
                                      const Material& material, const ShadingPoint& at) {
    Components<Vec3d> radiance;
    const Vec3d point(at.position), normal(at.brdf.normal), mirror(at.brdf.mirror);
    for (const PlacedLamp& placed : lamps) {
        const Lamp& lamp = placed.lamp;
        const LampLight light = lamp_light(lamp, point);
        if (!(light.share > 0)) continue;
        Components<Vec3d> whole =
            unshadowed<double>(
                placed, light, point,
                [&](const Vec3d& direction) { return reflectance(material, normal, mirror, direction); }) *
            Vec3d(lamp.colour) * pi;
        if (lamp.shadowless) whole.specular = Vec3d(0.0);
        if (whole == Components<Vec3d>()) continue;
        const bool is_shadowed = can_be_shadowed(lamp, light);
        Vec3d visibility(is_shadowed ? 0.0 : 1.0);
        if (is_shadowed)
            for (const LampPlace& place : placed.places) {
                const Vec3f end = ray_end(placed, place, light, at.from);
                if (!rays.is_blocked_from(at.from, end, instance_left_out(lamp)))
                    visibility += Vec3d(rays.transmitted(at.from, end)) * place.weight;
            }
        radiance += whole * visibility;
    }
    return radiance;
}

}  // namespace haarfield
