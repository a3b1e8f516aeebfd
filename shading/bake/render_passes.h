#pragma once
/// Pictures beside the full one: parts of a bake's radiance, and what it is made of.

#include "shading/bake/radiant_mesh.h"

namespace haarfield {

/// What is computed at the vertices.
enum class RenderPass : std::uint8_t {
    diffuse,     ///< Radiance without the highlights. [W/(m^2 sr)]
    specular,    ///< The highlights alone. [W/(m^2 sr)]
    irradiance,  ///< On the surface, with all shadows: independent of materials and eye. [W/m^2]
    /// The cosine-weighted share of the hemisphere above the surface that is open, in [0, 1], in all
    /// channels: independent of the light.
    occlusion,
    /// Radiance as if each instance were alone: nothing but itself shadows it, nothing sends it light.
    /// [W/(m^2 sr)]
    own_shadow,
    own_specular,  ///< The highlights of own_shadow. [W/(m^2 sr)]
    indirect,      ///< What light makes of the surface that was reflected before. [W/(m^2 sr)]
};

/// How the vertices of a bake were shaded, so that its passes are shaded alike.
struct PassShading {
    const PointShading& shading;  ///< Must outlive the passes' making.
    /// By instance, as vertex_radiance takes them; none: the entities' fine meshes, by scene_radiance.
    std::span<const SampledMesh> meshes{};
    bool fitted =
        false;           ///< Values are fitted to what lies between the vertices, fit_radiance; needs meshes.
    bool dense = false;  ///< By dense_scene_radiance; without meshes.
    std::uint32_t ray_samples = 0;  ///< If above 0: by ray_scene_radiance; without meshes.
};

/// Passes of a bake.
///
/// full      its radiance, by instance and vertex.
/// returns   by pass, instance and vertex. Where a vertex is buried, or inside another instance, it has what
///           scene_radiance would give it. `diffuse` is `full` less `specular`: they add up to it, but for
///           rounding and where a fitted or refined bake has less than its highlights.
/// accuracy  that of scene_radiance; other objects are seen as exactly as the scene's own light wants it,
///           also by `occlusion`. Passes of an instance alone have the same bits as the bake of a scene that
///           has no other instance.
/// cost      one shading of all vertices a pass, but none for `indirect`; `diffuse` and `specular` together
///           one, and none if no material has highlights. Of passes with each instance alone, besides, a
///           ShadingGeometry of each entity, one at a time.
/// errors    interrupted.
Result<std::vector<SceneRadiance>> render_passes(const PassShading& bake,
                                                 std::span<const std::span<const Rgb>> full,
                                                 std::span<const RenderPass> passes,
                                                 const Progress& progress = {});

}  // namespace haarfield
