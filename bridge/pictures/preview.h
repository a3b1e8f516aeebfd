#pragma once
/// A quick picture of shaded meshes, without POV-Ray.

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

/// Returns the instances of a scene without images. The arguments must outlive the result.
///
/// radiance  by instance; empty: for Preview::points alone, which reads none.
std::vector<BakedInstance> preview_instances(const ShadedScene& scene, const SceneColours& radiance = {});

/// Radiance from a direction (of any length but zero). Called from many threads at once.
using Background = std::function<Rgb(const Vec3f& direction)>;

/// Told of vertices whose radiance is read next. Those of before may be among them. False: it will not be
/// there.
using BeforeReading = std::function<bool(const VertexMask&)>;

/// Draws instances as they stand, by primary rays and with the radiance interpolated over the triangles: what
/// POV-Ray makes of a baked scene. Keeps what it needs of the meshes from one picture to the next.
class Preview {
public:
    Preview();
    ~Preview();

    /// A picture without coverage, of the camera's resolution.
    ///
    /// One ray a pixel; eight more where neighbouring pixels differ, in the object or in colour.
    /// The same bits for any number of threads.
    ///
    /// before_reading  if given, called twice by this thread, between the rays and the colours: with the
    ///                 vertices that pixels' centres see, and with those that the further rays see. Only then
    ///                 must their radiance be there, and it may have moved; that of vertices that are not
    ///                 seen is not read. If it returns false the picture is empty.
    ///
    /// cost  some 30 ms for 640 x 480 pixels on two cores; for a mesh that is new, some 0.1 s per 100,000
    ///       triangles.
    Image draw(const Camera& camera, std::span<const BakedInstance> instances, const Background& background,
               const BeforeReading& before_reading = {});

    /// What the centres of the camera's pixels show, row by row from the top; nothing where no object is.
    std::vector<std::optional<MeshPoint>> points(const Camera& camera,
                                                 std::span<const BakedInstance> instances);

private:
    struct Rays;
    std::unique_ptr<Rays> rays_;
};

}  // namespace haarfield
