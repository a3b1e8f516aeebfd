#pragma once
/// Emissive surfaces as lamps: meshes that glow, cut into patches as fine as the point that they light needs.
///
/// Their light is served here, by area, with a shadow ray for each patch. What vertices themselves send out
/// as emission is not in their baked radiance: who gathers that for further bounces counts nothing twice.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fields/base/vector.h"

namespace haarfield {

/// A triangle that sends out the same radiance in all directions of one side.
struct Emitter {
    std::array<Vec3f, 3> corners;  ///< Counter-clockwise, seen from where it shines. [m]
    Rgb radiance{0, 0, 0};         ///< >= 0. [W/(m^2 sr)]

    bool operator==(const Emitter&) const = default;
};

/// A scene's emitters in the world, so that those which are far from a point can be taken together.
struct EmitterTree {
    /// Some of the triangles.
    struct Node {
        Vec3f centre;        ///< Of their area, weighted with the radiance. [m]
        Vec3f place;         ///< On the surface: the middle of the triangle nearest to it. [m]
        float radius = 0;    ///< Of a sphere about it that holds them. [m]
        Vec3f facing;        ///< Mean normal, weighted in the same way: the shorter, the less they agree.
        float cone = 0;      ///< Sine of the greatest angle between their normals and it; 1: or beyond.
        Rgb power{0, 0, 0};  ///< Radiance times area, summed. [W/sr]
        std::uint32_t first = 0, count = 0;  ///< In `triangles`.
        std::uint32_t second_child = 0;      ///< The first one follows its parent; 0: a single triangle.
    };
    std::vector<Node> nodes;  ///< The first is the root; none if nothing shines.
    std::vector<Emitter> triangles;

    bool empty() const { return nodes.empty(); }
};

/// Emitters in the world; those that are black or have no area are left out.
///
/// cost  O(n log n), 1 us a triangle.
EmitterTree emitter_tree(std::vector<Emitter> emitters);

/// How finely emitters are cut.
struct EmitterCut {
    float size = 0.05f;       ///< Radius of a patch over its distance, at most.
    float share = 1.0f / 64;  ///< Of all power that a patch may have, unless it looks like a point.
    std::size_t most = 256;   ///< Patches; where that is too few, or needs more than four times as many
                              ///< triangles split, `size` grows, up to 0.5.
};

/// A patch as a point sees it.
struct EmitterPatch {
    Vec3f place;              ///< Of one of its points, where a shadow ray ends. [m]
    Vec3f direction;          ///< Towards its middle; unit length.
    Rgb irradiance{0, 0, 0};  ///< At the point, if nothing is in the way. [W/m^2]
    Rgb facing{0, 0, 0};      ///< The same on a surface that faces the patch. [W/m^2]
    float spread = 0;         ///< Variance of its directions along one axis. [rad^2]
};

/// The patches that a surface element sees above its horizon.
///
/// patches   overwritten. More than EmitterCut::most only where so many small triangles are near.
/// accuracy  of the irradiance of triangles, where nothing is in the way: 1e-5 where they are near (Lambert's
///           formula, at any distance), size^2 / 2 where they are taken as points.
/// cost      10 ns a node on the way, 100 ns a near triangle.
/// source    Lambert 1760, the irradiance from a polygon; Walter and others 2005, Lightcuts, the tree.
void find_patches(const EmitterTree& tree, const Vec3f& point, const Vec3f& normal, const EmitterCut& cut,
                  std::vector<EmitterPatch>& patches);

/// Irradiance from a triangle of radiance 1 on a surface element; of what lies above its horizon.
double triangle_irradiance(const std::array<Vec3d, 3>& corners, const Vec3d& point, const Vec3d& normal);

}  // namespace haarfield
