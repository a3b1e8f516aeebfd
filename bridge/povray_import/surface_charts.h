#pragma once
/// Planar charts of surfaces, side by side in one image.

#include "fields/base/vector.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace haarfield {

/// A surface to be divided into charts.
struct UnchartedSurface {
    std::span<const Vec3f> positions;
    std::span<const std::array<std::uint32_t, 3>> triangles;
    /// Wanted side of a texel by triangle, in the unit of the positions. > 0, and at least 1e-7 of the
    /// surface's size.
    std::vector<float> texels;
};

/// A surface with image coordinates. Vertices at the borders of charts occur once for each chart.
struct ChartedSurface {
    std::vector<std::uint32_t> originals;                 ///< By vertex: the vertex of the surface.
    std::vector<Vec2f> uvs;                               ///< By vertex, in [0, 1]; v points up.
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< In the order of the surface's triangles.
};

/// A chart's rectangle in the image, with its border. [texels]
struct ChartRectangle {
    int left = 0, top = 0, width = 0, height = 0;
    std::uint32_t surface = 0;   ///< Index of the chart's surface.
    std::uint32_t triangle = 0;  ///< One of its triangles.
};

/// Charts of some surfaces.
struct SurfaceCharts {
    int width = 0, height = 0;               ///< Of the image. [texels]
    std::vector<ChartedSurface> surfaces;    ///< As the surfaces.
    std::vector<ChartRectangle> rectangles;  ///< Disjoint.
    std::vector<std::uint8_t> covered;  ///< By texel, rows from the top: 1 if its centre is on a surface.
};

/// Divides surfaces into connected charts, and arranges these in an image.
///
/// The triangles of a chart face the same side of a cube, onto which they are projected, so that texels are
/// stretched by a factor of at most the square root of 3. Sizes of texels are rounded down to a power of two
/// times a common unit. Charts do not overlap, and have a border of two texels.
///
/// most  number of texels on the surfaces. If the wanted texels are more, all become larger.
/// cost  0.1 us per texel and 1 us per triangle.
SurfaceCharts surface_charts(std::span<const UnchartedSurface> surfaces, double most);

}  // namespace haarfield
