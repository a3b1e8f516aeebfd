#include "bridge/povray_import/triangle_text.h"

#include <fmt/format.h>

#include <iterator>

namespace haarfield {

void TriangleText::add(const std::array<Vec3d, 3>& corners) {
    for (const Vec3d& p : corners)
        fmt::format_to(std::back_inserter(vertices_), ",<{:.9g},{:.9g},{:.9g}>", p.x, p.y, p.z);
    const std::size_t first = 3 * count_++;
    fmt::format_to(std::back_inserter(faces_), ",<{},{},{}>", first, first + 1, first + 2);
    vertices_ += '\n';
    faces_ += '\n';
}

std::string TriangleText::mesh2() const {
    return fmt::format("mesh2{{vertex_vectors{{{}{}}}face_indices{{{}{}}}", 3 * count_, vertices_, count_,
                       faces_);
}

}  // namespace haarfield
