#pragma once
/// The outline of the opaque area of an image, as triangles in the image. Implemented with CGAL.

#include "fields/base/vector.h"

#include <array>
#include <cstdint>
#include <vector>

namespace haarfield {

/// The opacity of an image. It repeats in both directions, and is bilinear between texel centres.
struct OpacityMap {
    int width = 0, height = 0;          ///< [texels]; 0: no map, opaque everywhere.
    std::vector<std::uint8_t> opacity;  ///< In row-major order from the top; 255 is opaque.

    bool has_holes() const;  ///< True if a texel is less than half opaque.
};

/// The opaque part of a tile: a square of side 1, whose repetitions fill the plane.
struct OpaqueTile {
    Imath::V2d corner{0, 0};          ///< The tile's upper left corner: the centre of the first texel.
    std::vector<Imath::V2d> corners;  ///< x right and y down, both in [0, 1] across the image.
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Consistently oriented, without overlap.
};

/// Returns triangles that cover an image where it is at least half opaque.
///
/// map        must not be empty. Larger maps than 2^20 texels are averaged down to at most that.
/// tolerance  the outline is simplified by this distance. Islands and holes smaller than its square are
///            removed; the topology of all others is preserved. At least 0.25. [texels]
/// accuracy   the tolerance. Between texel centres, the outline is straight, whereas that of bilinear opacity
///            is a hyperbola.
/// cost       a few microseconds per texel of the outline.
/// source     outlines by marching squares; Dyken, Daehlen and Sevaldrud 2009, simultaneous curve
///            simplification.
OpaqueTile opaque_tile(const OpacityMap& map, double tolerance);

}  // namespace haarfield
