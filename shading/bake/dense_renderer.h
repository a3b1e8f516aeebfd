#pragma once
/// The oracle of renderer.h: radiance by plain sums over the texels of visibility that is rasterized at each
/// vertex. What it has in common with a bake are the texels' size and the occluders, which may be coarse.

#include "fields/rasterizer/visibility_rasterizer.h"
#include "shading/bake/renderer.h"
#include "shading/scene/vertex_loop.h"

namespace haarfield {

/// Light by texel, face by face: what the oracle sums over.
struct DenseLight {
    int face_size = 0;
    std::vector<Rgb> light;         ///< lighting.h: radiance * solid angle * size^2.
    std::vector<Vec3f> directions;  ///< Of the texels' centres.

    DenseLight(const LatLongImage& environment, int face_size);  ///< The environment on faces of a size.

    /// What a texel adds to the radiance of a point that sees it.
    Vec3d radiance_from(std::size_t texel, const Material& material, const VertexView& view) const;
};

/// Shades single points of a scene, as scene_radiance shades vertices, but: every occluder, the point's own
/// entity included, is rasterized at the point; lobes are evaluated at the texels; the lighting is not
/// truncated; sums are in double. Of one thread; keeps its buffers.
class DenseShader {
public:
    /// Scene and light must outlive it.
    DenseShader(const ShadedScene& scene, const DenseLight& light);

    /// cost  some milliseconds for faces of 64 texels.
    Rgb radiance(std::size_t instance, const SurfacePoint& point);

    /// The same with a view of one's own, such as one that looks past others from another place.
    Rgb radiance(std::size_t instance, const SurfacePoint& point, const VertexView& view);

private:
    const ShadedScene& scene_;
    const DenseLight& light_;
    VisibilityRasterizer rasterizer_;
    std::vector<float> visibility_;
};

/// Multiplies visibility by what can be seen past one more occluder.
void multiply_by_open(std::span<float> visibility, std::span<const std::uint8_t> open_samples);

/// By instance and vertex, as scene_radiance.
Result<SceneRadiance> dense_scene_radiance(const ShadedScene& scene, const RenderSettings& settings,
                                           const Progress& progress = {});

}  // namespace haarfield
