#pragma once
/// Pictures next to the full one: components of the radiance of a bake, and its factors.

#include "shading/bake/radiant_mesh.h"

namespace haarfield {

/// A quantity that is computed at the vertices.
enum class RenderPass : std::uint8_t {
    diffuse,     ///< The diffuse component of the radiance. [W/(m^2 sr)]
    specular,    ///< The specular component of the radiance. [W/(m^2 sr)]
    irradiance,  ///< Of the surface, with all shadows; independent of materials and eye. [W/m^2]
    /// The cosine-weighted fraction of the hemisphere above the surface that is open, in [0, 1], in all
    /// channels: independent of the light.
    occlusion,
    /// Radiance as if each instance were alone: no other instance shadows it or sends it light.
    /// [W/(m^2 sr)]
    own_shadow,
    indirect,  ///< Radiance by indirect light. [W/(m^2 sr)]
};

/// The method by which the vertices of a bake were shaded, and by which its passes are shaded, too.
struct PassShading {
    const PointShading& shading;  ///< Must outlive render_passes.
    /// By instance, as in vertex_radiance; none: the fine meshes of the entities, by scene_radiance.
    std::span<const SampledMesh> meshes{};
    bool fitted = false;            ///< Values are fitted by fit_radiance; needs meshes.
    bool dense = false;             ///< By dense_scene_radiance; without meshes.
    std::uint32_t ray_samples = 0;  ///< If above 0: by ray_scene_radiance, with the bounces of the settings;
                                    ///< without meshes.
};

/// Computes passes of a bake.
///
/// full      its radiance, by instance and vertex.
/// returns   by pass, instance and vertex. Buried vertices have the value that
///           scene_radiance gives them. Passes that are no radiance are the diffuse component.
/// accuracy  that of scene_radiance. The light of the scene determines how exactly occlusion by other objects
///           is computed, also for `occlusion`. Passes of an instance alone are bit-identical to the bake of
///           a scene without other instances.
/// cost      one shading of all vertices per pass, but none for `diffuse`, `specular` and `indirect`. Passes
///           with each instance alone also need a ShadingGeometry of each entity, one at a time.
/// errors    interrupted.
Result<std::vector<SceneRadiance>> render_passes(const PassShading& bake,
                                                 std::span<const std::span<const Outgoing>> full,
                                                 std::span<const RenderPass> passes,
                                                 const Progress& progress = {});

}  // namespace haarfield
