#pragma once
/// Radiance at the vertices of a scene: one product integral per vertex and lobe.

#include "fields/occluder.h"
#include "fields/progress.h"
#include "fields/result.h"
#include "fields/visibility_field.h"
#include "shading/environment.h"
#include "shading/material.h"
#include "shading/product_integral.h"

namespace haarfield {

/// One kind of object. The pointers must outlive the rendering.
struct ShadedEntity {
    const Mesh* mesh = nullptr;              ///< The fine mesh.
    const Occluder* occluder = nullptr;      ///< Of the coarse mesh.
    const VisibilityField* field = nullptr;  ///< Of the same mesh.
    std::vector<Material> materials;         ///< By the mesh's material index.
};

/// world = translate + scale * entity.
struct ShadedInstance {
    std::size_t entity = 0;
    Vec3f translate{0, 0, 0};
    float scale = 1;  ///< > 0.
};

struct ShadedScene {
    std::vector<ShadedEntity> entities;
    std::vector<ShadedInstance> instances;
    LatLongImage environment;  ///< Clean and turned.
    Vec3f eye{0, 0, 0};        ///< Where the highlights are seen from.
};

struct RenderSettings {
    int face_size = 64;             ///< As in the fields (asserted).
    int depth = full_depth;         ///< Traversal depth, product_integral.
    int light_coefficients = 300;   ///< Wavelets kept a face; 0: all.
    int lobe_coefficients = 70;     ///< The same for the BRDF lobes.
    std::uint32_t exact_triangles = 64;  ///< Occluders of at most so many triangles are rasterized at the vertex.
};

/// Outgoing radiance towards the eye, by instance and vertex of its fine mesh. [W/(m^2 sr)]
///
/// Vertices that face away from the eye get the radiance that they would show at grazing view: the
/// highlight's mirror direction is taken with the view vector's component into the surface removed.
/// Buried vertices (VisibilityField::buried_vertices) take the mean of their nearest unburied neighbours.
/// Uses all of oneTBB's threads; the result does not depend on their number. errors: interrupted.
Result<std::vector<std::vector<Rgb>>> vertex_radiance(const ShadedScene& scene, const RenderSettings& settings,
                                                      const Progress& progress = {});

}  // namespace haarfield
