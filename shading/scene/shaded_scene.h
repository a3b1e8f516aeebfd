#pragma once
/// A scene as the input of shading: meshes with their fields, placements, light and eye.

#include "fields/base/placement.h"
#include "fields/field/entity_occlusion.h"
#include "fields/field/visibility_field.h"
#include "shading/scene/emitter.h"
#include "shading/scene/lamp.h"
#include "shading/scene/light_sources.h"
#include "shading/scene/material.h"
#include "shading/walk/wide_tree.h"

#include <memory>
#include <span>

namespace haarfield {

class LightFilters;

/// A kind of object. The pointers must outlive the rendering.
struct ShadedEntity {
    const Mesh* mesh = nullptr;                  ///< The fine mesh.
    const EntityOcclusion* occlusion = nullptr;  ///< Of the same mesh.
    const VisibilityField* field = nullptr;      ///< Of the same mesh.
    std::vector<Material> materials;             ///< By the mesh's material index.
    /// Factors on diffuse reflection by images and vertex colours, by vertex, for indirect light; empty:
    /// white.
    std::span<const Rgb> tints{};
    std::vector<Emitter> emitters{};  ///< Its emitters, in its own frame.
};

/// An object of the scene.
struct ShadedInstance {
    std::size_t entity = 0;
    Placement placement;

    bool operator==(const ShadedInstance&) const = default;
};

/// The input of shading.
struct ShadedScene {
    std::vector<ShadedEntity> entities;
    std::vector<ShadedInstance> instances;
    Environment environment;  ///< Cleaned and rotated.
    Vec3f eye{0, 0, 0};       ///< Viewpoint of specular reflection.
    std::vector<Lamp> lamps{};
    std::shared_ptr<const LightFilters> filters{};  ///< Of the lamps' light; null: none.
};

/// The representation of occlusion by other instances. Instances of few triangles
/// (RenderSettings::exact_triangles) and rotated instances are always exact from nearby. Beyond the samplers
/// of their fields, all instances are represented by silhouettes (impostors.h), up to RenderSettings::reach.
enum class Occlusion {
    fields,  ///< Interpolated between samples of the instance's field: fast, inaccurate close to the
             ///< instance.
    exact,   ///< Rasterized at the vertex.
    /// Rasterized within the distance where the error of radiance exceeds a tolerance. The error is the
    /// field's estimate times the unevenness of the smooth light.
    automatic,
};

/// Settings of indirect light; see indirect_light.h.
struct BounceSettings {
    int most = 0;              ///< Number of bounces; 0: direct light only.
    float tolerance = 0.001f;  ///< Of a vertex's radiance, for the omitted bounces.
    int directions = 32;       ///< Directions sampled per vertex, at least; a power of two.
};
/// A number of bounces that leaves the end to the tolerance.
inline constexpr int any_bounces = 1000;

/// The accuracy settings of shading.
struct RenderSettings {
    int face_size = 64;             ///< As in the fields (asserted).
    int depth = full_depth;         ///< Traversal depth of product_integral.
    int light_coefficients = 1000;  ///< Wavelets stored per face; 0: all.
    SourceRule sources;             ///< Separates concentrated light, which shadow rays evaluate.
    Occlusion occlusion = Occlusion::automatic;
    float occlusion_error = 0.1f;  ///< Tolerance of `automatic`, for SamplerError::band times unevenness().
    /// Occluders of at most this number of triangles are exact from nearby.
    std::uint32_t exact_triangles = 64;
    /// Range of shadows, in radii of the object from its centre. The truncation changes irradiance by at most
    /// 1 / reach^2 per object, for a sphere straight above. Shadows of concentrated light have no limit.
    float reach = 20;
    BounceSettings bounces;
    /// Memory of CachedVisibility, for scenes that are shaded repeatedly.
    std::size_t kept_bytes = std::size_t(1) << 30;
};

}  // namespace haarfield
