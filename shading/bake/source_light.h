#pragma once
/// Radiance of points by concentrated sources: shadow rays and the BRDF for each of their directions.

#include "shading/scene/light_sources.h"
#include "shading/scene/vertex_loop.h"
#include "shading/visibility/shadow_rays.h"

namespace haarfield {

/// At most sixteen neighbouring receivers, for rays to one light at a time.
class ReceiverPacket {
public:
    /// receivers  must outlive it.
    explicit ReceiverPacket(std::span<const ShadingPoint> receivers);

    std::size_t size() const { return receivers_.size(); }  ///< Number of receivers.
    /// Returns a receiver.
    const ShadingPoint& operator[](std::size_t i) const { return receivers_[i]; }

    /// Tests which receivers face a light and are not occluded from it: bit i for receiver i.
    ///
    /// wanted   bit i: test receiver i; other bits of the result are 0.
    /// without  as in ShadowRays::blocked.
    std::uint16_t lit(const ShadowRays& rays, const Vec3f& towards_light, std::uint16_t wanted = 0xffff,
                      std::size_t without = ShadowRays::no_instance) const;

private:
    std::span<const ShadingPoint> receivers_;
    std::array<Vec3f, ShadowRays::packet> from_;
};

/// Adds the light of unoccluded sources to the outgoing radiance of each receiver.
///
/// receivers  neighbours in space next to each other.
/// radiance   by receiver. [W/(m^2 sr)]
/// cost       50 to 100 ns per light that a receiver faces.
void add_source_light(const ShadowRays& rays, std::span<const DirectionalLight> lights,
                      std::span<const ShadingPoint> receivers, std::span<Outgoing> radiance);

/// The visible fraction of some lights at a receiver.
struct VisibleLights {
    Vec3f direction{0.0f};  ///< Mean, by luminance; not normalised.
    Rgb irradiance{0.0f};   ///< Of visible lights, on a surface that faces each. [W/m^2]
    Rgb by_cosine{0.0f};    ///< Of visible lights, on the receiver's surface. [W/m^2]
};

/// Adds visible lights, without the BRDF, to `parts`; one per receiver.
void add_lit_parts(const ShadowRays& rays, std::span<const DirectionalLight> lights,
                   std::span<const ShadingPoint> receivers, std::span<VisibleLights> parts);

}  // namespace haarfield
