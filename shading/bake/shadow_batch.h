#pragma once
/// Shadow rays that wait for a full packet.

#include <array>
#include <utility>

#include "shading/bake/environment_sampler.h"
#include "shading/visibility/shadow_rays.h"

namespace haarfield {

/// Traces shadow rays in packets, and uses what belongs to those that nothing blocks.
///
/// Content  what a ray carries; default-constructible.
/// Use      called as (const Content&) for each unblocked ray, in the order of addition.
template <class Content, class Use>
class ShadowBatch {
public:
    /// The rays must outlive it.
    ShadowBatch(const ShadowRays& rays, Use use) : rays_(rays), use_(std::move(use)) {}

    /// Adds a ray.
    ///
    /// distance  to the light, or far_away.
    void add(const Vec3f& from, const Vec3f& direction, float distance, const Content& content) {
        constexpr float horizon = 1e6f;  // larger than any scene [m]
        from_[size_] = from;
        ends_[size_] = from + direction * std::min(distance, horizon);
        contents_[size_] = content;
        if (++size_ == ShadowRays::packet) trace();
    }

    /// Traces the rays that still wait.
    void trace() {
        const auto wanted = static_cast<std::uint16_t>((1u << size_) - 1);
        const std::uint16_t blocked =
            rays_.blocked_from(std::span(from_).first(size_), wanted, std::span(ends_).first(size_));
        for (std::size_t i = 0; i < size_; ++i)
            if (!(blocked >> i & 1u)) use_(contents_[i]);
        size_ = 0;
    }

private:
    const ShadowRays& rays_;
    Use use_;
    std::array<Vec3f, ShadowRays::packet> from_, ends_;
    std::array<Content, ShadowRays::packet> contents_;
    std::size_t size_ = 0;
};

}  // namespace haarfield
