#include "shading/bake/source_light.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace haarfield {
namespace {

/// Calls `act` with each receiver and each light that it faces and that is not occluded from it.
template <class Act>
void for_each_lit(const ShadowRays& rays, std::span<const DirectionalLight> lights,
                  std::span<const ShadingPoint> receivers, const Act& act) {
    for (std::size_t first = 0; first < receivers.size(); first += ShadowRays::packet) {
        const ReceiverPacket packet(
            receivers.subspan(first, std::min(ShadowRays::packet, receivers.size() - first)));
        for (const DirectionalLight& light : lights) {
            const std::uint16_t lit = packet.lit(rays, light.direction);
            for (std::size_t i = 0; i < packet.size(); ++i)
                if (lit >> i & 1u) act(first + i, light);
        }
    }
}

}  // namespace

ReceiverPacket::ReceiverPacket(std::span<const ShadingPoint> receivers) : receivers_(receivers) {
    assert(receivers.size() <= ShadowRays::packet);
    for (std::size_t i = 0; i < receivers.size(); ++i) from_[i] = receivers[i].from;
}

std::uint16_t ReceiverPacket::lit(const ShadowRays& rays, const Vec3f& towards_light, std::uint16_t wanted,
                                  std::size_t without) const {
    std::uint16_t faces = 0;
    for (std::size_t i = 0; i < receivers_.size(); ++i)
        faces = static_cast<std::uint16_t>(faces | unsigned(receivers_[i].brdf.normal.dot(towards_light) > 0)
                                                       << i);
    faces &= wanted;
    const std::span<const Vec3f> from = std::span(from_).first(receivers_.size());
    return static_cast<std::uint16_t>(faces & ~rays.blocked(from, faces, towards_light, without));
}

void add_source_light(const ShadowRays& rays, std::span<const DirectionalLight> lights,
                      std::span<const ShadingPoint> receivers, std::span<Outgoing> radiance) {
    assert(receivers.size() == radiance.size());
    for_each_lit(rays, lights, receivers, [&](std::size_t i, const DirectionalLight& light) {
        radiance[i] += reflectance(receivers[i].brdf, light.direction) * light.irradiance;
    });
}

void add_lit_parts(const ShadowRays& rays, std::span<const DirectionalLight> lights,
                   std::span<const ShadingPoint> receivers, std::span<VisibleLights> parts) {
    assert(receivers.size() == parts.size());
    for_each_lit(rays, lights, receivers, [&](std::size_t i, const DirectionalLight& light) {
        parts[i].direction += light.direction * luminance(light.irradiance);
        parts[i].irradiance += light.irradiance;
        parts[i].by_cosine += light.irradiance * receivers[i].brdf.normal.dot(light.direction);
    });
}

}  // namespace haarfield
