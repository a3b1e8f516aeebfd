#pragma once
/// The points of a scene that its camera shows, for judging the lamps that stand for emitters.

#include "fields/mesh/first_surface.h"
#include "scenes/scene.h"
#include "shading/scene/emitter.h"
#include "shading/scene/lamp.h"

#include <array>
#include <span>
#include <vector>

namespace haarfield {

/// A point of a surface that the camera shows.
struct LitPoint {
    Vec3f position;       ///< [m]
    Vec3f normal;         ///< Unit length, on the camera's side.
    Rgb albedo{0, 0, 0};  ///< Of the diffuse term.
};

/// Objects in the world, as rays meet them.
struct WorldSurface {
    Mesh mesh;                ///< Triangles, positions and normals in the world.
    std::vector<Rgb> albedo;  ///< By its vertices.

    /// Adds an object whose mesh has normals.
    ///
    /// albedo  by the mesh's vertices.
    void add(const Mesh& object, const Placement& placement, std::span<const Rgb> object_albedo);
};

/// The visible points of a camera's picture, on a coarse grid, and what lies between them and lamps.
class LitPoints {
public:
    /// cost  one ray for each of at most 3,072 points.
    LitPoints(const Camera& camera, const WorldSurface& world);

    std::span<const LitPoint> points() const { return points_; }

    /// True if nothing lies between a point and a place. [m]
    bool sees(const LitPoint& point, const Vec3f& place) const;

private:
    FirstSurface surface_;
    std::vector<LitPoint> points_;
};

/// Two sets of lamps, each of which stands for all emitters, and the points that they light.
struct LampSets {
    LitPoints lit;
    std::vector<Emitter> emitters;
    std::array<std::vector<Lamp>, 2> lamps;  ///< With the colours of a scene that one set lights alone.
};

/// Computes the error of the diffuse radiance of the points that both sets have in common: the root of the
/// mean product of their errors, over points and channels. Half the difference of the sets lacks this error.
///
/// returns   0 if the errors of the sets cancel.
/// accuracy  where a point is partly in shadow the visibility of up to 256 patches counts as exact.
/// cost      a shadow ray for each lamp and point.
double common_lamp_error(const LampSets& sets);

}  // namespace haarfield
