#pragma once
/// A scene as shading sees it: meshes with their fields, where they stand, light and eye.

#include "fields/entity_occlusion.h"
#include "fields/visibility_field.h"
#include "shading/environment.h"
#include "shading/material.h"
#include "shading/wide_tree.h"

namespace haarfield {

/// One kind of object. The pointers must outlive the rendering.
struct ShadedEntity {
    const Mesh* mesh = nullptr;                  ///< The fine mesh.
    const EntityOcclusion* occlusion = nullptr;  ///< Of the same mesh.
    const VisibilityField* field = nullptr;      ///< Of the same mesh.
    std::vector<Material> materials;             ///< By the mesh's material index.
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
    int face_size = 64;            ///< As in the fields (asserted).
    int depth = full_depth;        ///< Traversal depth, product_integral.
    float tolerance = 0;           ///< Of a vertex's radiance, for ending walks early; see vertex_radiance.
    int light_coefficients = 300;  ///< Wavelets kept a face; 0: all.
    std::uint32_t exact_triangles =
        64;  ///< Occluders of at most so many triangles are seen exactly from near.
};

}  // namespace haarfield
