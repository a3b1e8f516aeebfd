#pragma once
/// Modelling functions for turned and joined furniture: closed shells with smooth normals.
///
/// Shells face outwards and have separate vertices on both sides of a sharp edge. Lengths are in metres.

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

/// A half outline from the bottom up: the profile of a turned piece, or of a board's edge.
struct Profile {
    /// A point of the outline.
    struct Point {
        double radius, height;
    };
    std::vector<Point> points;

    Profile& to(double radius, double height);  ///< Adds a straight line.
    /// Adds a bulge (a groove if negative) from the last point to the same radius at `height`.
    Profile& bead(double bulge, double height, int steps);
    /// Adds a line that swells by `swell` in the middle.
    Profile& swelling(double radius, double height, double swell, int steps);
    /// Adds an S-curve that is vertical at both ends.
    Profile& ease(double radius, double height, int steps);
    /// Adds a quarter of an ellipse that starts horizontally and ends vertically, or the reverse if
    /// `leaves_upright`.
    Profile& round(double radius, double height, int steps, bool leaves_upright);
};

/// Rotates a profile about the y axis. The profile starts and ends at radius 0 (asserted).
Shell lathe(const Profile& profile, int segments);

/// A board of 2 half_x by 2 half_z with rounded corners and flat faces. The edge profile has radius 0 on the
/// outline and negative radii further in, of a magnitude below the corner's radius.
struct Board {
    double half_x, half_z, corner;
    int steps_x, steps_z, steps_corner;
};
Shell board(const Board& shape, const Profile& edge);  ///< Makes a board.

/// A box whose edges are rounded by quarter circles of 2 * steps segments. `lines` adds lines of vertices
/// across each axis; they are ascending and lie in the flat of the faces.
struct RoundedBox {
    Vec3d lower, upper;
    double radius;
    int steps;
    std::array<std::vector<double>, 3> lines{};
};
Shell rounded_box(const RoundedBox& shape);  ///< Makes a box.

/// A solid with right angles, composed of the cells of a grid.
struct Blocks {
    std::array<std::vector<double>, 3> lines;           ///< Planes across each axis, ascending: the cells'
                                                        ///< bounds.
    std::function<bool(const Vec3d& middle)> is_solid;  ///< Of a cell by its centre; outside the grid is
                                                        ///< empty.
};

/// Returns the boundary sides of the solid's cells that satisfy `is_wanted`, as rectangles. All sides
/// together form a closed shell.
///
/// is_wanted  takes the centre and the outward normal of a side.
Shell block_sides(const Blocks& blocks,
                  const std::function<bool(const Vec3d& middle, const Vec3d& normal)>& is_wanted);

/// Deforms a shell by a smooth map that preserves orientation. Normals follow from central differences.
Shell bent(Shell shell, const std::function<Vec3d(const Vec3d&)>& map);

Shell moved(Shell shell, const Vec3d& by);  ///< Translates a shell.

/// Moves a shell so that its y axis points from `from` to `to` and its origin is at `from`.
Shell aligned(Shell shell, const Vec3d& from, const Vec3d& to);

/// Appends a shell with a material to a mesh.
void append(Mesh& mesh, const Shell& shell, const std::string& material);

/// Returns a Wavefront OBJ file: positions rounded to 1e-6 m, normals, and `usemtl` with the material names.
std::string obj_text(const Mesh& mesh);

}  // namespace haarfield
