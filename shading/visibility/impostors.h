#pragma once
/// Impostors: masks of an object's silhouette. They replace the object for vertices beyond the samples of its
/// field, and for all distant vertices if the object is rotated or one of many.

#include <array>
#include <span>
#include <stop_token>

#include "fields/base/placement.h"
#include "fields/base/result.h"
#include "fields/occluder/occluder.h"

namespace haarfield {

/// Masks of an occluder's opacity from directions all around it, at two distances each.
///
/// A mask lies in the plane through the occluder's centre that faces the viewer, and exists in several
/// resolutions down to a single cell. A lookup uses the masks of the nearest direction, interpolated between
/// the two distances, in the resolution whose cells are about as large as a texel. The occluded solid angle
/// is therefore correct at any distance and changes continuously with it.
///
/// accuracy  error of the irradiance of a surface that faces the occluder, relative to the unoccluded
///           irradiance under smooth light, RMS over places: 0.3 % between 2 and 3 radii for a box, 0.1 % for
///           a chair; 0.13 and 0.05 % between 3 and 6; 0.025 % between 6 and 12; below 0.01 % from 12 on.
class Impostors {
public:
    /// Makes the masks.
    ///
    /// face_size  texels along an edge of the cubemaps to be multiplied.
    /// memory     2 MB.
    /// cost       1,152 rasterizations, in parallel on oneTBB.
    /// errors     interrupted.
    static Result<Impostors> make(const Occluder& occluder, int face_size, const std::stop_token& stop = {});

    /// Multiplies visibility by the transparency of the occluder's mask.
    ///
    /// placement  of the occluder.
    /// point      the viewer, in the world. Inside the occluder's sphere nothing is occluded.
    /// open       visibility by texel of a cubemap, by face and row. [1/255]
    /// cost       O(texels that the occluder's part of the mask may cover): 0.2 us for a chair in a grid of
    ///            100, in the mean.
    void hide(const Placement& placement, const Vec3f& point, std::span<std::uint8_t> open) const;

    /// Smallest distance at which masks are used. [radii]
    static constexpr float nearest = 2;

private:
    /// Viewing distances of the nearer and the farther masks. [radii]
    static constexpr std::array<float, 2> distances{nearest, 6};
    /// Half the width of a mask: at `nearest`, the outline of the sphere extends beyond its radius. [radii]
    static constexpr float half_width = 1.16f;

    /// One resolution of a mask, with a border of empty cells.
    struct Level {
        int size;            ///< Cells along an edge, without the border.
        std::size_t offset;  ///< Offset of its first cell in the mask.
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
    /// The bytes of all masks of one direction.
    static constexpr std::size_t mask_bytes = distances.size() * (levels.back().offset + 9);

    /// The cells of the finest masks of a direction that are not empty: [left, right) and [bottom, top).
    struct Extent {
        std::uint8_t left = finest, right = 0, bottom = finest, top = 0;
    };

    struct Maker;

    Extent extent_of(std::size_t direction) const;

    int face_size_ = 0;
    Vec3f centre_{0, 0, 0};            ///< Of the occluder, in its own frame. [m]
    float radius_ = 0;                 ///< [m]
    std::vector<Extent> extents_;      ///< By direction.
    std::vector<std::uint8_t> masks_;  ///< Opacity by direction, cell and distance. [1/255]
};

}  // namespace haarfield
