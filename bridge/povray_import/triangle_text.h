#pragma once
/// Unconnected triangles as text for POV-Ray. Internal.

#include "fields/base/vector.h"

#include <array>
#include <string>

namespace haarfield {

/// The text of a `mesh2` of unconnected triangles, in the order in which they were added.
///
/// POV-Ray parses a `mesh` of n triangles in a time proportional to n^2, because it compares vertices:
/// 200,000 triangles take 49 s as `mesh` and 3 s as `mesh2`.
class TriangleText {
public:
    /// Coordinates have nine significant digits.
    void add(const std::array<Vec3d, 3>& corners);

    /// Returns the statement without its last brace, so that a texture can follow.
    std::string mesh2() const;

private:
    std::string vertices_, faces_;
    std::size_t count_ = 0;
};

}  // namespace haarfield
