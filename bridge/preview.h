#pragma once
/// A quick picture of shaded meshes, without POV-Ray.

#include <functional>
#include <map>
#include <memory>
#include <span>

#include "bridge/image.h"
#include "fields/mesh.h"
#include "scenes/scene.h"
#include "shading/mesh_point.h"

namespace haarfield {

/// One object. world = translate + scale * mesh. Mesh and radiance must outlive the picture.
struct PreviewInstance {
    const Mesh* mesh = nullptr;     ///< The fine one.
    Vec3f translate{0, 0, 0};       ///< [m]
    float scale = 1;                ///< > 0.
    std::span<const Rgb> radiance;  ///< One per vertex. [W/(m^2 sr)]
};

/// Radiance from a direction (of any length but zero). Called from many threads at once.
using Background = std::function<Rgb(const Vec3f& direction)>;

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
    /// cost  some 30 ms for 640 x 480 pixels on two cores; for a mesh that is new, some 0.1 s per 100,000
    ///       triangles.
    Image draw(const Camera& camera, std::span<const PreviewInstance> instances,
               const Background& background);

    /// What the centres of the camera's pixels show, row by row from the top; nothing where no object is.
    std::vector<std::optional<MeshPoint>> points(const Camera& camera,
                                                 std::span<const PreviewInstance> instances);

private:
    struct Rays;
    std::unique_ptr<Rays> rays_;
};

}  // namespace haarfield
