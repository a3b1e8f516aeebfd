#pragma once
/// A scene as shading sees it: meshes with their fields, where they stand, light and eye.

#include "fields/base/placement.h"
#include "fields/field/entity_occlusion.h"
#include "fields/field/visibility_field.h"
#include "shading/scene/emitter.h"
#include "shading/scene/lamp.h"
#include "shading/scene/light_sources.h"
#include "shading/scene/material.h"
#include "shading/walk/wide_tree.h"

#include <span>

namespace haarfield {

/// One kind of object. The pointers must outlive the rendering.
struct ShadedEntity {
    const Mesh* mesh = nullptr;                  ///< The fine mesh.
    const EntityOcclusion* occlusion = nullptr;  ///< Of the same mesh.
    const VisibilityField* field = nullptr;      ///< Of the same mesh.
    std::vector<Material> materials;             ///< By the mesh's material index.
    /// What images and colours multiply the diffuse term with, by vertex, as far as light that bounces is
    /// concerned; none: white.
    std::span<const Rgb> tints{};
    std::vector<Emitter> emitters{};  ///< What of it glows, in its own frame.
};

/// One object of the scene.
struct ShadedInstance {
    std::size_t entity = 0;
    Placement placement;

    bool operator==(const ShadedInstance&) const = default;
};

/// All that shading needs to know of a scene.
struct ShadedScene {
    std::vector<ShadedEntity> entities;
    std::vector<ShadedInstance> instances;
    Environment environment;  ///< Clean and turned.
    Vec3f eye{0, 0, 0};       ///< Where the highlights are seen from.
    std::vector<Lamp> lamps{};
};

/// How a vertex sees past other instances. Those of few triangles (RenderSettings::exact_triangles) are seen
/// exactly from near, whatever is chosen, and so are those that are turned. Beyond the samplers of their
/// fields all of them are seen by pictures of their silhouettes (impostors.h), as far as
/// RenderSettings::reach.
enum class Occlusion {
    fields,  ///< Interpolated between samples of the instance's field: fast, and wrong close to the instance.
    exact,   ///< Rasterized at the vertex.
    /// Rasterized as far out as the error of radiance is above a tolerance: the field's own estimate of its
    /// error, times the unevenness of the light that is not concentrated.
    automatic,
};

/// How light is followed from surface to surface; see indirect_light.h.
struct BounceSettings {
    int most = 0;              ///< Bounces; 0: direct light alone.
    float tolerance = 0.001f;  ///< Of a vertex's radiance, by those that are left out.
    int directions = 32;       ///< In which a vertex looks, at least; a power of two.
};
/// So many that the tolerance decides.
inline constexpr int any_bounces = 1000;

/// How exactly a scene is shaded.
struct RenderSettings {
    int face_size = 64;             ///< As in the fields (asserted).
    int depth = full_depth;         ///< Traversal depth, product_integral.
    int light_coefficients = 1000;  ///< Wavelets kept a face; 0: all.
    SourceRule sources;             ///< What of the light is concentrated, and served by rays.
    Occlusion occlusion = Occlusion::automatic;
    float occlusion_error = 0.1f;  ///< Tolerance of `automatic`, for SamplerError::band times unevenness().
    /// Occluders of at most so many triangles are seen exactly from near.
    std::uint32_t exact_triangles = 64;
    /// How far objects cast shadows: radii of the object from its middle. What is cut off is at most
    /// 1 / reach^2 of the irradiance an object, that of a ball straight above; shadows of concentrated light
    /// end nowhere.
    float reach = 20;
    BounceSettings bounces;
    /// For KeptVisibility, where a scene is shaded again and again.
    std::size_t kept_bytes = std::size_t(1) << 30;
};

}  // namespace haarfield
