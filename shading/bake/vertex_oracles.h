#pragma once
/// The radiance of a vertex by the dense oracle, with one component replaced by an approximation of the bake.

#include "shading/bake/dense_renderer.h"
#include "shading/visibility/shading_geometry.h"

namespace haarfield {

/// Radiances of a vertex; see error_budget. [W/(m^2 sr)]
struct OracleRadiances {
    Rgb oracle{0.0f};    ///< With the bake's face size and coarse meshes.
    Rgb finer{0.0f};     ///< With more texels.
    Rgb original{0.0f};  ///< With the original meshes.
    Rgb finest{0.0f};    ///< With more texels and the original meshes.
    Rgb lighting{0.0f}, sources{0.0f}, lobes{0.0f}, visibility{0.0f}, planar{0.0f}, spherical{0.0f};
    Rgb shallow{0.0f};  ///< As lobes, with the traversal depth of the bake.
    Rgb baked{0.0f};
    Rgb distant{0.0f};
    bool has_planar = false, has_spherical = false, has_distant = false;
};

/// The data that all vertices of a scene share.
struct OracleContext {
    const ShadedScene& scene;
    const RenderSettings& settings;  ///< Of the bake.
    const ShadingGeometry& geometry;
    std::vector<Occluder> originals;          ///< By entity.
    DenseLight light, truncated, fine_light;  ///< Truncated to the bake's wavelets; with the finest texels.
    LightPyramid exact_pyramid;               ///< Of `light`.
    SceneLight baked_light;                   ///< Of the bake.

    /// originals  the original mesh of each entity: its occluder.
    OracleContext(const ShadedScene& scene, std::span<const Mesh* const> originals,
                  const RenderSettings& settings, const ShadingGeometry& geometry);
};

/// Shades vertices one at a time, for one thread.
class VertexOracles {
public:
    /// The context must outlive it.
    explicit VertexOracles(const OracleContext& context);
    ~VertexOracles();

    /// cost  about 20 ms with faces of 64 texels.
    OracleRadiances operator()(std::size_t instance, std::uint32_t vertex);

private:
    class Vertex;
    std::unique_ptr<Vertex> vertex_;
};

}  // namespace haarfield
