#pragma once
/// Prepares the meshes, occluders and fields of a scene's entities for shading.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/field/field_file.h"
#include "fields/field/field_precompute.h"
#include "scenes/scene.h"
#include "scenes/surface.h"
#include "shading/bake/renderer.h"

#include <filesystem>
#include <memory>
#include <optional>

namespace haarfield {

/// An entity with instances in the scene, in one shape, for any placements.
struct SceneEntity {
    std::string name;  ///< The entity's name; for stretched or mirrored instances followed by `~` and
                       ///< shape_name.
    PreparedMesh mesh;
    bool left_handed = false;  ///< The mesh's coordinates are those of a left-handed file.
    /// The file's vertices and faces, in that shape; present with SceneEntityOptions::original_vertices.
    std::optional<ListedMesh> listed;
    std::optional<EntityOcclusion> occlusion;  ///< Of the mesh; always present once prepared.
    VisibilityField field;
    std::vector<Surface> surfaces;    ///< By the mesh's material index.
    std::vector<Material> materials;  ///< The surfaces' materials.
    std::vector<Rgb> tints;           ///< vertex_tints of the fine mesh.
    std::filesystem::path field_file;
    bool reused = false;
    bool surroundings_reused = false;  ///< In a recomputed field: only the local samples were computed.
    std::string recomputed_because;    ///< Why an existing file was not used; empty if there was none.
    double mesh_seconds = 0, field_seconds = 0;
};

/// The prepared entities of a scene.
struct SceneEntities {
    std::vector<std::unique_ptr<SceneEntity>> entities;  ///< In the order of their first instances.
    std::vector<std::size_t> entity_of_instance;         ///< Index in `entities`, by Scene::instances.
    std::shared_ptr<const LightFilters> filters;         ///< Of Scene::filters; null: none.
    std::vector<std::string> warnings;  ///< Findings in meshes, except open edges of flat sheets.

    /// Returns the entity of instance `i` of Scene::instances.
    const SceneEntity& of_instance(std::size_t i) const { return *entities[entity_of_instance[i]]; }
};

/// The mesh of a filter.
struct FilterMesh {
    Mesh mesh;
    std::vector<Rgb> colours;  ///< Fraction of light that passes, by triangle; or one for all triangles.
};

/// Reads the mesh of a filter.
///
/// errors  those of read_mesh.
Result<FilterMesh> read_filter(const SceneFilter& filter);

/// The samples of fields that are read or computed.
enum class FieldExtent {
    none,          ///< No sample: for meshes alone, and for bakes that rasterize all objects at each point.
    surroundings,  ///< Samples around the entities.
    whole          ///< Also those at the vertices of the fine meshes.
};

/// The preparation of entities: resolution, compression and storage of fields.
struct SceneEntityOptions {
    /// A library (field_library.h), created if fields are wanted; empty: nothing is stored.
    std::filesystem::path fields_folder;
    std::int32_t face_size = 64;
    std::int32_t coefficients = FieldSettings().coefficients;
    float relative_l2_error = FieldSettings().relative_l2_error;
    FieldExtent fields = FieldExtent::whole;
    /// Fine meshes have exactly the vertices that the models' files list and triangles use, plus those of
    /// back sides. Duplicates are kept, and vertices are repeated where normals or materials differ.
    /// Entity::fine_vertices has no effect.
    bool original_vertices = false;
};

/// Reads and prepares the meshes with their materials and images. Prepared meshes are stored in the library,
/// too, if it exists or fields are wanted, and read from it by later calls. Then reads each field from the
/// library if its key matches, or computes and stores it.
///
/// Instances of one entity share mesh and field if is_same_shape holds for their shapes. Meshes are stretched
/// and mirrored as read, before subdivision and simplification, so the numbers of vertices, triangles and
/// samples apply to each shape.
///
/// Each field is stored completely as soon as it is computed: an interrupted run continues with the next one,
/// and removes temporary files of processes that were killed. If several processes need one field, one
/// computes it while the others wait. Entities with equal mesh and settings share a field, also across
/// scenes.
Result<SceneEntities> prepare_scene_entities(const Scene& scene, const SceneEntityOptions& options,
                                             const Progress& progress = {});

/// Prepares the meshes as read, neither subdivided nor simplified, and without fields: the input of a ray
/// tracer.
Result<SceneEntities> original_entities(const Scene& scene, const Progress& progress = {});

/// Returns the entities' fine meshes, by SceneEntities::entities.
std::vector<Mesh> fine_meshes(const SceneEntities& entities);

/// Returns meshes of the entities' surfaces, by SceneEntities::entities, with about `vertices` vertices over
/// all instances. Vertices are distributed in proportion to those of the fine meshes. A mesh that has more in
/// its file keeps them.
std::vector<Mesh> surface_meshes(const SceneEntities& entities, std::size_t vertices);

/// True if a surface adds specular radiance on top of its texture: Surface::has_separate_specular.
bool has_separate_specular(const SceneEntities& entities);

/// True for the materials of such surfaces; by SceneEntities::entities and material.
std::vector<std::vector<bool>> parted_materials(const SceneEntities& entities);

}  // namespace haarfield
