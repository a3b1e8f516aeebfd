#include "bridge/povray/triangle_atlas.h"

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

std::array<Vec2f, 3> TriangleAtlas::uvs(std::size_t triangle) const {
    // The centres of three texels of the square.
    const Vec2f first(static_cast<float>(x(triangle)) + 0.5f, static_cast<float>(y(triangle)) + 0.5f);
    return {first, first + Vec2f(1, 0), first + Vec2f(0, 1)};
}

std::string TriangleAtlas::pigment(const std::string& image) const {
    return fmt::format("pigment {{ image_map {{ {} interpolate 2 }} scale <{}, {}, 1> scale <1, -1, 1> }}",
                       image, width(), height());
}

}  // namespace haarfield
