#pragma once
/// Where an image is opaque, as triangles in the image. CGAL's work.

#include "fields/base/vector.h"

#include <array>
#include <cstdint>
#include <vector>

namespace haarfield {

/// How opaque an image is. It repeats in both directions, and is bilinear between the texels' middles.
struct OpacityMap {
    int width = 0, height = 0;          ///< [texels]; 0: there is no map, all is opaque.
    std::vector<std::uint8_t> opacity;  ///< Row by row from the top; 255 is opaque.

    bool has_holes() const;  ///< Whether a texel is less than half opaque.
};

/// The opaque part of an image's tile: of a square of side 1 which the image, repeated, fills the plane with.
struct OpaqueTile {
    Imath::V2d corner{0, 0};          ///< The tile's upper left one: the middle of the first texel.
    std::vector<Imath::V2d> corners;  ///< x right and y down, both in [0, 1] across the image.
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Of one sense; they do not overlap.
};

/// Triangles that cover an image where it is at least half opaque.
///
/// map        there is one; of more than 2^20 texels an average of so many or less is taken.
/// tolerance  the outline is simplified by as much, and islands and holes of less than its square are left
///            out; no part of what is left changes its connections. From 0.25 on. [texels]
/// accuracy   the tolerance; and between the lines of the texels' middles the outline is straight where that
///            of bilinear opacity is a hyperbola.
/// cost       some microseconds per texel of the outline.
/// source     outlines by marching squares; Dyken, Daehlen and Sevaldrud 2009, simultaneous curve
///            simplification.
OpaqueTile opaque_tile(const OpacityMap& map, double tolerance);

}  // namespace haarfield
