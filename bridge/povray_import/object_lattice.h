#pragma once
/// Objects side by side, so that rays can be sent to one of them at a time. Internal.

#include "bridge/povray_import/object_frame.h"

namespace haarfield {

/// A ray in the local coordinates of an object.
struct ProbeRay {
    std::size_t surface = 0;  ///< Index of its surface.
    Vec3d start{0, 0, 0}, direction{0, 0, 1};
};

/// A point of an object's surface in its local coordinates.
struct TracedPoint {
    Vec3d point{0, 0, 0}, normal{0, 0, 0};
};

/// Objects side by side, each scaled to its grid, so that a ray meets only its own object.
class ObjectLattice {
public:
    /// requests     sorted by object.
    /// is_original  objects keep their size, except for those that are cut.
    explicit ObjectLattice(std::vector<GridRequest> requests, bool is_original = false);
    /// surfaces  of some of the requests, which are sorted by object.
    ObjectLattice(std::span<const GridRequest> requests, std::span<const ObjectSurface> surfaces,
                  bool is_original = false);

    /// Distance from a surface at which rays to it should start, in local coordinates. [cells]
    static constexpr double start_distance = 0.1;

    const GridFrame& frame(std::size_t surface) const { return frames_[surface]; }  ///< Of an object.

    /// Returns a point of an object in the lattice.
    Vec3d placed(std::size_t surface, const Vec3d& local) const { return local + places_[surface]; }

    /// Returns a query that renders a picture of the lattice.
    ///
    /// camera   a camera statement, and declarations.
    /// ambient  with the scene's ambient light.
    SceneQuery query(int width, int height, const std::string& camera, bool ambient = false) const;
    /// Returns a query that renders a colour for each ray. There is at least one ray.
    SceneQuery query(std::span<const ProbeRay> rays, bool ambient = false) const;
    /// Returns where rays first meet their objects, with the normals there. A normal of length 0: nowhere.
    ///
    /// seconds  as SceneQuery::seconds.
    /// errors   those of SceneQueries::answer.
    Result<std::vector<TracedPoint>> traced(const SceneQueries& queries, std::span<const ProbeRay> rays,
                                            double seconds, const Progress& progress) const;
    /// Returns the colours of the rays. POV-Ray's first row repeats the second.
    static std::vector<Rgb> colours(const SceneAnswer& answer, std::size_t count);

private:
    std::vector<GridRequest> requests_;
    std::vector<GridFrame> frames_;
    std::vector<Vec3d> places_;
};

}  // namespace haarfield
