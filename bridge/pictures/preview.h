#pragma once
/// Renders a quick picture of shaded meshes, without POV-Ray.

#include <functional>
#include <map>
#include <memory>
#include <span>

#include "scenes/baked_instance.h"
#include "scenes/image.h"
#include "shading/bake/mesh_point.h"
#include "shading/bake/renderer.h"
#include "shading/scene/vertex_loop.h"

namespace haarfield {

/// Returns the instances of a scene, without images. The arguments must outlive the result.
///
/// radiance  by instance; empty for Preview::points, which reads no radiance.
std::vector<BakedInstance> preview_instances(const ShadedScene& scene, const SceneColours& radiance = {});

/// Returns the instances of a scene for Preview::points, with their cut-outs.
///
/// entities  those of the scene. The arguments must outlive the result.
std::vector<BakedInstance> preview_instances(const SceneEntities& entities, const ShadedScene& scene);

/// Returns the radiance from a direction of any length but zero. Called from many threads at once.
using Background = std::function<Rgb(const Vec3f& direction)>;

/// A function that is called before radiance is read, with the vertices whose radiance is read next. These
/// may include earlier ones. It returns false if the radiance is not available.
using BeforeReading = std::function<bool(const VertexMask&)>;

/// Renders instances by primary rays, with radiance interpolated over the triangles, like POV-Ray renders a
/// baked scene. Caches acceleration structures of meshes between pictures.
class Preview {
public:
    Preview();
    ~Preview();

    /// Returns a picture without coverage at the camera's resolution.
    ///
    /// Traces one ray per pixel, and eight more where neighbouring pixels differ in object or colour.
    /// Bit-identical for any number of threads.
    ///
    /// before_reading  if given, called twice on this thread between ray casting and shading: with the
    ///                 vertices that are visible at the pixels' centres, and with those that the further rays
    ///                 hit. The radiance of these vertices must be valid when the function returns; it may
    ///                 have moved in memory. The radiance of other vertices is not read. If the function
    ///                 returns false, the picture is empty.
    ///
    /// cost  about 30 ms for 640 x 480 pixels on two cores; for a new mesh, about 0.1 s per 100,000
    ///       triangles.
    Image draw(const Camera& camera, std::span<const BakedInstance> instances, const Background& background,
               const BeforeReading& before_reading = {});

    /// Returns the visible surface points at the centres of the camera's pixels, row by row from the top;
    /// none where no object is visible.
    std::vector<std::optional<MeshPoint>> points(const Camera& camera,
                                                 std::span<const BakedInstance> instances);

private:
    struct Rays;
    std::unique_ptr<Rays> rays_;
};

}  // namespace haarfield
