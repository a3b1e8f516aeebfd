#include "shading/bake/lamp_light.h"

#include <algorithm>
#include <cassert>

namespace haarfield {
namespace {

constexpr std::size_t packet = ShadowRays::packet;

/// The light of a lamp, as if it stood in one of its places.
LampLight light_from(const PlacedLamp& placed, const LampPlace& place, const Vec3d& direction,
                     const Vec3d& point) {
    Lamp moved = placed.lamp;
    moved.position = Vec3f(lamp_place(placed.lamp, place, direction));
    moved.target += moved.position - placed.lamp.position;
    return lamp_light(moved, point);
}

/// What reaches a point if nothing is in the way, per colour. `response` is BRDF times cosine by direction.
template <class Colour, class Response>
Colour unshadowed(const PlacedLamp& placed, const LampLight& light, const Vec3d& point,
                  const Response& response) {
    if (!placed.lamp.area || !placed.lamp.area->illumination)
        return response(light.direction) * static_cast<decltype(Colour().x)>(light.share);
    Colour sum(0);
    for (const LampPlace& place : placed.places) {
        const LampLight here = light_from(placed, place, light.direction, point);
        if (here.share > 0) sum += response(here.direction) * static_cast<decltype(Colour().x)>(here.share);
    }
    return sum / static_cast<decltype(Colour().x)>(placed.places.size());
}

/// Where the shadow ray of one of a lamp's places ends.
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

/// Up to 16 receivers under one lamp.
void add_to_packet(const ShadowRays& rays, const PlacedLamp& placed,
                   std::span<const SourceReceiver> receivers, std::span<const Vec3f> from,
                   std::span<Rgb> radiance, std::span<Rgb> diffuse) {
    const Lamp& lamp = placed.lamp;
    const Rgb irradiance = lamp.colour * static_cast<float>(pi);
    std::array<LampLight, packet> light;
    std::array<Rgb, packet> whole, whole_diffuse;
    std::uint16_t lit = 0;
    for (std::size_t i = 0; i < receivers.size(); ++i) {
        const Vec3d point(receivers[i].position);
        light[i] = lamp_light(lamp, point);
        const VertexBrdf& brdf = receivers[i].brdf;
        const auto dull = [&](const Vec3d& direction) {
            return brdf.diffuse * std::max(brdf.normal.dot(Vec3f(direction)), 0.0f);
        };
        const auto response = [&](const Vec3d& direction) { return reflectance(brdf, Vec3f(direction)); };
        whole[i] = whole_diffuse[i] = Rgb(0.0f);
        if (!(light[i].share > 0)) continue;
        const bool is_dull = lamp.shadowless || brdf.specular == Rgb(0.0f);
        if (is_dull || !diffuse.empty())
            whole_diffuse[i] = unshadowed<Rgb>(placed, light[i], point, dull) * irradiance;
        whole[i] =
            is_dull ? whole_diffuse[i] : unshadowed<Rgb>(placed, light[i], point, response) * irradiance;
        if (whole[i] != Rgb(0.0f)) lit = static_cast<std::uint16_t>(lit | 1u << i);
    }
    std::uint16_t shadowed = 0;
    std::array<float, packet> visibility;
    visibility.fill(1);
    for (std::size_t i = 0; i < receivers.size(); ++i)
        if ((lit >> i & 1u) && can_be_shadowed(lamp, light[i])) {
            shadowed = static_cast<std::uint16_t>(shadowed | 1u << i);
            visibility[i] = 0;
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
                    visibility[i] += static_cast<float>(place.weight);
        }
    }
    for (std::size_t i = 0; i < receivers.size(); ++i)
        if (lit >> i & 1u) {
            radiance[i] += whole[i] * visibility[i];
            if (!diffuse.empty()) diffuse[i] += whole_diffuse[i] * visibility[i];
        }
}

}  // namespace

void add_lamp_light(const ShadowRays& rays, std::span<const PlacedLamp> lamps,
                    std::span<const SourceReceiver> receivers, std::span<Rgb> radiance,
                    std::span<Rgb> diffuse) {
    assert(receivers.size() == radiance.size());
    assert(diffuse.empty() || diffuse.size() == radiance.size());
    if (lamps.empty()) return;
    std::array<Vec3f, packet> from;
    for (std::size_t first = 0; first < receivers.size(); first += packet) {
        const std::size_t count = std::min(packet, receivers.size() - first);
        const std::span<const SourceReceiver> here = receivers.subspan(first, count);
        for (std::size_t i = 0; i < count; ++i) from[i] = here[i].from;
        for (const PlacedLamp& lamp : lamps)
            add_to_packet(rays, lamp, here, std::span(from).first(count), radiance.subspan(first, count),
                          diffuse.empty() ? diffuse : diffuse.subspan(first, count));
    }
}

Vec3d radiance_from_lamps(std::span<const PlacedLamp> lamps, const ShadowRays& rays, const Vec3f& from,
                          const Material& material, const VertexView& view) {
    Vec3d radiance(0.0);
    const Vec3d point(view.position), normal(view.normal);
    for (const PlacedLamp& placed : lamps) {
        const Lamp& lamp = placed.lamp;
        const LampLight light = lamp_light(lamp, point);
        if (!(light.share > 0)) continue;
        const auto response = [&](const Vec3d& direction) {
            if (!lamp.shadowless) return reflectance(material, normal, Vec3d(view.mirror), direction);
            return Vec3d(material.diffuse) * (std::max(normal.dot(direction), 0.0) / pi);
        };
        const Vec3d whole = unshadowed<Vec3d>(placed, light, point, response) * Vec3d(lamp.colour) * pi;
        if (whole == Vec3d(0.0)) continue;
        const bool is_shadowed = can_be_shadowed(lamp, light);
        double visibility = is_shadowed ? 0 : 1;
        if (is_shadowed)
            for (const LampPlace& place : placed.places)
                if (!rays.is_blocked_from(from, ray_end(placed, place, light, from), instance_left_out(lamp)))
                    visibility += place.weight;
        radiance += whole * visibility;
    }
    return radiance;
}

}  // namespace haarfield
