#pragma once
/// A few ways to make closed shells with smooth normals: what a turner and a joiner need.
///
/// Every shell is closed, faces outwards, and has vertices of their own on both sides of a sharp edge.
/// Lengths are metres.

#include "fields/mesh/mesh.h"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace haarfield {

/// A closed surface.
struct Shell {
    std::vector<Vec3d> positions;
    std::vector<Vec3d> normals;  ///< Unit length.
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// A half outline from the bottom up: what a turner cuts, or the moulded edge of a board.
struct Profile {
    /// A point of an outline.
    struct Point {
        double radius, height;
    };
    std::vector<Point> points;

    Profile& to(double radius, double height);  ///< A straight line to there.
    /// A bulge (or a groove, if negative) from the last point to the same radius at `height`.
    Profile& bead(double bulge, double height, int steps);
    /// A straight line, swollen by `swell` in the middle.
    Profile& swelling(double radius, double height, double swell, int steps);
    /// Leaves and arrives upright.
    Profile& ease(double radius, double height, int steps);
    /// A quarter of an ellipse that leaves along the radius and arrives upright, or the other way.
    Profile& round(double radius, double height, int steps, bool leaves_upright);
};

/// Turned about the y axis. Starts and ends at radius 0.
Shell lathe(const Profile& profile, int segments);

/// A board of 2 half_x by 2 half_z with round corners. The profile's radius 0 is the outline; it goes
/// inwards with negative radii, less than the corner's; bottom and top are flat.
struct Board {
    double half_x, half_z, corner;
    int steps_x, steps_z, steps_corner;
};
Shell board(const Board& shape, const Profile& edge);  ///< Makes a board.

/// A box with edges rounded by a quarter circle in 2 * steps segments. `lines` are additional lines of
/// vertices across each axis, in ascending order and in the flat of the faces.
struct RoundedBox {
    Vec3d lower, upper;
    double radius;
    int steps;
    std::array<std::vector<double>, 3> lines{};
};
Shell rounded_box(const RoundedBox& shape);  ///< Makes a box.

/// What is cut out of a solid of right angles: by cells between planes.
struct Blocks {
    std::array<std::vector<double>, 3> lines;           ///< Across each axis, ascending: the cells' bounds.
    std::function<bool(const Vec3d& middle)> is_solid;  ///< Of a cell; none beyond the outermost lines is.
};

/// Those sides of the solid's cells that bound it and that `is_wanted`, as rectangles; all of them are a
/// closed shell.
///
/// is_wanted  of a side's middle and its outward normal.
Shell block_sides(const Blocks& blocks,
                  const std::function<bool(const Vec3d& middle, const Vec3d& normal)>& is_wanted);

/// The shell under a smooth map that keeps left and right; normals by central differences.
Shell bent(Shell shell, const std::function<Vec3d(const Vec3d&)>& map);

Shell moved(Shell shell, const Vec3d& by);  ///< The shell in another place.

/// With y along `from` to `to`, y = 0 at `from`.
Shell aligned(Shell shell, const Vec3d& from, const Vec3d& to);

/// Adds a shell of a material to a mesh.
void append(Mesh& mesh, const Shell& shell, const std::string& material);

/// A Wavefront OBJ file: positions in 1e-6 m, normals, `usemtl` by name.
std::string obj_text(const Mesh& mesh);

}  // namespace haarfield
