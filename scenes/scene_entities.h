#pragma once
/// From a scene's description to everything that shading needs: meshes, occluders, fields.

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

/// An entity of which a scene has instances, in one shape, however these are placed.
struct SceneEntity {
    std::string name;  ///< The entity's; of instances that are stretched or mirrored with `~` and shape_name.
    PreparedMesh mesh;
    bool left_handed = false;  ///< Coordinates of the mesh, which are those of a left-handed file.
    /// Its file's vertices and faces, in that shape: if SceneEntityOptions::original_vertices.
    std::optional<ListedMesh> listed;
    std::optional<EntityOcclusion> occlusion;  ///< Of the mesh; always there once prepared.
    VisibilityField field;
    std::vector<Surface> surfaces;    ///< By the mesh's material index,
    std::vector<Material> materials;  ///< and their materials.
    std::vector<Rgb> tints;           ///< vertex_tints of the fine mesh.
    std::filesystem::path field_file;
    bool reused = false;
    bool surroundings_reused = false;  ///< Of a field that is made: only its local samples were.
    std::string remade_because;        ///< Why a file that was there was not used; empty if none was there.
    double mesh_seconds = 0, field_seconds = 0;
};

/// A scene's entities, prepared.
struct SceneEntities {
    std::vector<std::unique_ptr<SceneEntity>> entities;  ///< In the order of the first instances.
    std::vector<std::size_t> entity_of_instance;         ///< Index in `entities`, by Scene::instances.
    std::vector<std::string> warnings;  ///< Of what was found in meshes; not that flat sheets are open.

    /// The entity of instance `i` of Scene::instances.
    const SceneEntity& of_instance(std::size_t i) const { return *entities[entity_of_instance[i]]; }
};

/// How fields are made, and where they are kept.
struct SceneEntityOptions {
    /// A library (field_library.h), made if missing; empty: fields are not kept in files.
    std::filesystem::path fields_folder;
    std::int32_t face_size = 64;
    std::int32_t coefficients = FieldSettings().coefficients;
    float relative_l2_error = FieldSettings().relative_l2_error;
    bool fields = true;  ///< false: meshes only.
    /// Whether fine meshes have the vertices that the models' files list, and no others but those of backs:
    /// all that triangles use, also where several are alike, each as often as normals and materials part
    /// there. Entity::fine_vertices is without effect then.
    bool original_vertices = false;
    Unsealed unsealed = Unsealed::refused;  ///< Files without a seal.
};

/// Reads and prepares the meshes with their materials and images, then makes each field, or reads it from the
/// folder if its key fits.
///
/// Instances of one entity share mesh and field if is_same_shape holds for the shape of the first of them.
/// Meshes are stretched and mirrored as they were read, before they are subdivided and simplified, so that
/// numbers of vertices, triangles and samples are of every shape.
///
/// Each field is in the folder, whole, as soon as it is made: a run that was killed goes on where it was, and
/// removes what the killed one left half-written. Of several processes that want the same field one makes it
/// while the others wait. Entities with the same mesh and settings share one, also those of other scenes.
Result<SceneEntities> prepare_scene_entities(const Scene& scene, const SceneEntityOptions& options,
                                             const Progress& progress = {});

/// The meshes as they were read, neither subdivided nor simplified, and without fields: what a ray tracer is
/// given.
Result<SceneEntities> original_entities(const Scene& scene, const Progress& progress = {});

/// The entities' fine meshes, by SceneEntities::entities.
std::vector<Mesh> fine_meshes(const SceneEntities& entities);

/// Meshes of the entities' surfaces, by SceneEntities::entities, with so many vertices in all instances
/// together, shared out as those of the fine meshes are. A mesh that has more in its file keeps them.
std::vector<Mesh> surface_meshes(const SceneEntities& entities, std::size_t vertices);

/// True if a surface adds specular radiance on top of its texture: Surface::parts_highlights.
bool parts_highlights(const SceneEntities& entities);

/// True for the materials of such surfaces; by SceneEntities::entities and material.
std::vector<std::vector<bool>> parted_materials(const SceneEntities& entities);

}  // namespace haarfield
