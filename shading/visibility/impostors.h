#pragma once
/// What an object hides from afar: pictures of its silhouette, for vertices beyond the samples of its field,
/// and for those that look past it as it is turned.

#include <array>
#include <span>
#include <stop_token>

#include "fields/base/placement.h"
#include "fields/base/result.h"
#include "fields/occluder/occluder.h"

namespace haarfield {

/// Masks of an occluder's opacity, seen from directions all round it, and from two distances each.
///
/// A mask lies in the plane through the occluder's middle that faces its viewer, and is there in several
/// resolutions, down to a single cell. From a point, the mask of the nearest direction is seen, or between
/// the two distances a mixture of both, with cells about as large as a texel: so the solid angle that is
/// hidden is right at any distance, and changes with it continuously.
///
/// accuracy  under smooth light, of the irradiance of a surface that faces the occluder, relative to what it
///           is without it, RMS over places: 0.3 % between 2 and 3 radii for a box, 0.1 % for a chair; 0.13
///           and 0.05 % between 3 and 6; 0.025 % between 6 and 12; below 0.01 % from 12 on.
class Impostors {
public:
    /// face_size  of the cubemaps in which it will be seen.
    /// memory     2 MB.
    /// cost       1,152 rasterizations, on all of oneTBB's threads.
    /// errors     interrupted.
    static Result<Impostors> make(const Occluder& occluder, int face_size, const std::stop_token& stop = {});

    /// Lessens what is open by what the occluder hides.
    ///
    /// placement  of the occluder.
    /// point      in the world. From within the occluder's sphere nothing is hidden.
    /// open       visibility by texel of a cubemap, face by face and row by row. [1/255]
    /// cost       some 0.1 us, and 10 ns a texel that may be hidden.
    void hide(const Placement& placement, const Vec3f& point, std::span<std::uint8_t> open) const;

    /// From here on the masks serve. [radii]
    static constexpr float nearest = 2;

private:
    /// Where the nearer masks are seen from, and the farther. [radii]
    static constexpr std::array<float, 2> distances{nearest, 6};
    /// Of a mask: from `nearest`, the sphere round the occluder looks larger than it is. [radii]
    static constexpr float half_width = 1.16f;

    /// A mask in a resolution, with a border of cells that are empty.
    struct Level {
        int size;            ///< Cells along an edge, without the border.
        std::size_t offset;  ///< Of its first cell in the mask.
    };
    static constexpr int finest = 32;
    static constexpr auto levels = [] {
        std::array<Level, 6> made{};
        std::size_t offset = 0;
        for (std::size_t k = 0; k < made.size(); ++k) {
            made[k] = {finest >> k, offset};
            offset += std::size_t(made[k].size + 2) * std::size_t(made[k].size + 2);
        }
        return made;
    }();
    static constexpr std::size_t mask_bytes = levels.back().offset + 9;

    /// What is looked at: a level of two masks, and how they are mixed.
    struct Picture {
        const std::uint8_t *near, *far;
        float near_weight, far_weight;  ///< 1/255 at most, together.
        int size;

        float opacity(float x, float y) const;
    };

    struct Maker;

    int face_size_ = 0;
    Vec3f centre_{0, 0, 0};            ///< In the occluder's frame. [m]
    float radius_ = 0;                 ///< [m]
    std::vector<std::uint8_t> masks_;  ///< By direction and distance; opacity. [1/255]
};

}  // namespace haarfield
