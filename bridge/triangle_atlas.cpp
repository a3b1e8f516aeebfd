#include "bridge/triangle_atlas.h"

#include <fmt/format.h>

#include <cassert>
#include <cmath>

namespace haarfield {

TriangleAtlas::TriangleAtlas(std::size_t triangles)
    : triangles_(triangles),
      columns_(static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(triangles))))),
      rows_((triangles + columns_ - 1) / columns_) {
    assert(triangles > 0);
}

void TriangleAtlas::append_uvs(std::string& text, std::size_t triangle) const {
    const std::size_t left = x(triangle), top = y(triangle);
    // The middles of three texels of the square.
    fmt::format_to(std::back_inserter(text), ",\n<{0}.5,{1}.5>,<{2}.5,{1}.5>,<{0}.5,{3}.5>", left, top,
                   left + 1, top + 1);
}

std::string TriangleAtlas::pigment(const std::string& image) const {
    return fmt::format("pigment {{ image_map {{ {} interpolate 2 }} scale <{}, {}, 1> scale <1, -1, 1> }}",
                       image, width(), height());
}

}  // namespace haarfield
