#pragma once
/// The oracle of renderer.h: radiance by sums over the texels of visibility that is rasterized at each
/// vertex. It shares the texel size and the occluders, which may be coarse, with a bake.

#include "fields/rasterizer/visibility_rasterizer.h"
#include "shading/bake/renderer.h"
#include "shading/scene/vertex_loop.h"

namespace haarfield {

/// Light by texel and face: the integrand of the oracle without visibility and BRDF.
struct DenseLight {
    int face_size = 0;
    std::vector<Rgb> light;               ///< lighting.h: radiance * solid angle * size^2.
    std::vector<Vec3f> directions;        ///< Directions of the texel centres.
    std::vector<DirectionalLight> parts;  ///< All parts of concentrated light.

    /// Splits an environment by a source rule and samples it on faces of a size.
    DenseLight(const Environment& environment, int face_size, const SourceRule& rule = {});

    /// Returns the radiance of a point by one unoccluded texel.
    Components<Vec3d> radiance_from(std::size_t texel, const Material& material,
                                    const ShadingPoint& at) const;
};

/// The light and the occluders of the oracle.
struct DenseScene {
    /// The scene must outlive the result and must not change.
    DenseScene(const ShadedScene& scene, int face_size, const SourceRule& rule = {});

    const ShadedScene& scene;
    DenseLight light;
    ShadowRays rays;
    std::vector<PlacedLamp> lamps;
    EmitterTree emitters;
};

/// Shades single points of a scene as scene_radiance shades vertices, with these differences. Every occluder,
/// including the point's own entity, is rasterized at the point. Lobes are evaluated at the texels. The
/// lighting is not truncated, and every part of concentrated light has its own ray. Sums are in double. For
/// one thread; reuses its buffers.
class DenseShader {
public:
    explicit DenseShader(const DenseScene& dense);  ///< `dense` must outlive it.

    /// cost  a few milliseconds for faces of 64 texels.
    Outgoing radiance(std::size_t instance, const SurfacePoint& point);

    /// Shades the point as another one, such as one with another origin for occlusion by other instances.
    Outgoing radiance(std::size_t instance, const SurfacePoint& point, const ShadingPoint& at);

private:
    const DenseScene& dense_;
    VisibilityRasterizer rasterizer_;
    std::vector<float> visibility_;
};

/// Computes outgoing radiance by the unoccluded directional lights, in double precision.
Components<Vec3d> radiance_from_parts(std::span<const DirectionalLight> parts, const ShadowRays& rays,
                                      const Material& material, const ShadingPoint& at);

/// Computes outgoing radiance by lamps, in double precision, and by emitters, with fine_emitter_cut.
Components<Vec3d> radiance_from_near(std::span<const PlacedLamp> lamps, const EmitterTree& emitters,
                                     const ShadowRays& rays, const Material& material,
                                     const ShadingPoint& at);

/// Multiplies visibility by that around another occluder.
void multiply_by_open(std::span<float> visibility, std::span<const std::uint8_t> open_samples);

/// Returns radiance by instance and vertex, like scene_radiance.
///
/// sharing  null: this process shades all vertices.
Result<SceneRadiance> dense_scene_radiance(const ShadedScene& scene, const RenderSettings& settings,
                                           const Progress& progress = {},
                                           const PointSharing* sharing = nullptr);

}  // namespace haarfield
