#pragma once
/// Emissive surfaces as light: triangles that emit light, divided into patches as finely as the lit point
/// requires.
///
/// Emitters are sampled by area, with one shadow ray per patch. The emission of a vertex itself is not part
/// of its baked radiance, so that gathering baked radiance for further bounces counts no light twice.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fields/base/vector.h"

namespace haarfield {

/// A triangle that emits the same radiance in all directions of its front side.
struct Emitter {
    std::array<Vec3f, 3> corners;  ///< Counter-clockwise, seen from the emitting side. [m]
    Rgb radiance{0, 0, 0};         ///< >= 0. [W/(m^2 sr)]

    bool operator==(const Emitter&) const = default;
};

/// A hierarchy of a scene's emitters in the world. Emitters that are far from a point are evaluated as one.
struct EmitterTree {
    /// A set of triangles.
    struct Node {
        Vec3f centre;        ///< Centroid, weighted by area and radiance. [m]
        Vec3f place;         ///< On the surface: the centroid of the triangle nearest to `centre`. [m]
        float radius = 0;    ///< Of a sphere around `centre` that contains the triangles. [m]
        Vec3f facing;        ///< Mean normal, weighted likewise; its length is below 1 if normals differ.
        float cone = 0;      ///< Sine of the largest angle between a normal and `facing`; 1 for 90 degrees
                             ///< and more.
        Rgb power{0, 0, 0};  ///< Sum of radiance times area. [W/sr]
        std::uint32_t first = 0, count = 0;  ///< Range in `triangles`.
        std::uint32_t second_child = 0;      ///< Index; the first child follows its parent. 0: a single
                                             ///< triangle.
    };
    std::vector<Node> nodes;  ///< The root comes first; empty if nothing emits light.
    std::vector<Emitter> triangles;

    bool empty() const { return nodes.empty(); }  ///< True if nothing emits light.
};

/// Builds the hierarchy. Black emitters and those without area are left out.
///
/// cost  O(n log n), 1 us per triangle.
EmitterTree emitter_tree(std::vector<Emitter> emitters);

/// The limits of the division of emitters into patches.
struct EmitterCut {
    float size = 0.05f;       ///< Largest ratio of a patch's radius to its distance.
    float share = 1.0f / 64;  ///< Largest fraction of all power per patch, unless the patch appears as a
                              ///< point.
    std::size_t most = 256;   ///< Largest number of patches. If more are needed, or more than four times as
                              ///< many triangle splits, `size` grows, up to 0.5.
};

/// A patch as seen from a point.
struct EmitterPatch {
    Vec3f place;              ///< A point of the patch, where a shadow ray ends. [m]
    Vec3f direction;          ///< Towards its centroid; unit length.
    Rgb irradiance{0, 0, 0};  ///< Unoccluded irradiance at the point. [W/m^2]
    Rgb facing{0, 0, 0};      ///< Unoccluded irradiance on a surface that faces the patch. [W/m^2]
    float spread = 0;         ///< Variance of its directions along one axis. [rad^2]
};

/// Finds the patches above the horizon of a surface element.
///
/// patches   overwritten. May exceed EmitterCut::most only if that many small triangles are nearby.
/// accuracy  relative error of the unoccluded irradiance of a triangle: 1e-5 for nearby triangles (Lambert's
///           formula, at any distance), size^2 / 2 for triangles treated as points.
/// cost      10 ns per visited node, 100 ns per nearby triangle.
/// source    Lambert 1760, the irradiance from a polygon; Walter and others 2005, Lightcuts, the tree.
void find_patches(const EmitterTree& tree, const Vec3f& point, const Vec3f& normal, const EmitterCut& cut,
                  std::vector<EmitterPatch>& patches);

/// Returns the irradiance of a surface element by the fraction of a triangle of radiance 1 above its horizon.
double triangle_irradiance(const std::array<Vec3d, 3>& corners, const Vec3d& point, const Vec3d& normal);

}  // namespace haarfield
