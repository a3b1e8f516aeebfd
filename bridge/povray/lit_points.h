#pragma once
/// The visible points of a scene, used to judge the lamps that represent emitters.

#include "fields/mesh/first_surface.h"
#include "scenes/scene.h"
#include "shading/scene/emitter.h"
#include "shading/scene/lamp.h"

#include <array>
#include <span>
#include <vector>

namespace haarfield {

/// A visible point of a surface.
struct LitPoint {
    Vec3f position;       ///< [m]
    Vec3f normal;         ///< Unit length, on the camera's side.
    Rgb albedo{0, 0, 0};  ///< Of the diffuse term.
};

/// All objects in world coordinates, for ray casting.
struct WorldSurface {
    Mesh mesh;                ///< Triangles, positions and normals in the world.
    std::vector<Rgb> albedo;  ///< Albedo of the diffuse term, by vertex.

    /// Adds an object whose mesh has normals.
    ///
    /// albedo  by the mesh's vertices.
    void add(const Mesh& object, const Placement& placement, std::span<const Rgb> object_albedo);
};

/// The visible points of a camera's picture, on a coarse grid, and the surfaces that occlude lamps from them.
class LitPoints {
public:
    /// cost  one ray for each of at most 3,072 points.
    LitPoints(const Camera& camera, const WorldSurface& world);

    std::span<const LitPoint> points() const { return points_; }  ///< By the rows of the grid.

    /// True if no surface lies between a point and a place. [m]
    bool sees(const LitPoint& point, const Vec3f& place) const;

private:
    FirstSurface surface_;
    std::vector<LitPoint> points_;
};

/// Two sets of lamps, each of which stands for all emitters, and the points that they light.
struct LampSets {
    LitPoints lit;
    std::vector<Emitter> emitters;
    std::array<std::vector<Lamp>, 2> lamps;  ///< The colours are those of a scene lit by one set alone.
};

/// Returns the error of the points' diffuse radiance that both sets have in common: the root of the mean
/// product of their errors, over points and channels. Half the difference of the sets does not include this
/// error.
///
/// returns   0 if the mean product is negative.
/// accuracy  in partial shadow, the visibility of up to 256 patches is assumed to be exact.
/// cost      a shadow ray for each lamp and point.
double common_lamp_error(const LampSets& sets);

}  // namespace haarfield
