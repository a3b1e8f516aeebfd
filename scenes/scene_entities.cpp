#include "scenes/scene_entities.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>

#include "fields/base/names.h"
#include "fields/field/field_library.h"
#include "fields/field/mesh_library.h"
#include "fields/file/claim.h"
#include "fields/file/write_file.h"
#include "fields/mesh/mesh_subdivision.h"
#include "fields/mesh/mesh_topology.h"
#include "fields/mesh/shared_vertices.h"
#include "fields/preparation/crossed_vertices.h"
#include "fields/preparation/thin_sheets.h"
#include "scenes/entity_field.h"
#include "scenes/entity_surfaces.h"
#include "scenes/files_in_memory.h"
#include "scenes/model_warnings.h"
#include "shading/visibility/light_filters.h"

namespace haarfield {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// An entity in one shape.
struct Variant {
    std::size_t entity;  // Index in Scene::entities.
    Shape shape;
};

/// Tests whether a mesh is planar to 1e-5 of its size, as floors and walls are.
bool is_flat(const Mesh& mesh) {
    Vec3d normal(0, 0, 0);
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3d from(mesh.positions[a]);
        const Vec3d area = (Vec3d(mesh.positions[b]) - from).cross(Vec3d(mesh.positions[c]) - from);
        normal += area.dot(normal) < 0 ? -area : area;
    }
    normal.normalize();
    const double thickness = 1e-5 * double(mesh_bounds(mesh).radius());
    return std::ranges::all_of(mesh.positions, [&](const Vec3f& position) {
        return std::abs((Vec3d(position) - Vec3d(mesh.positions[0])).dot(normal)) <= thickness;
    });
}

/// Returns findings that deserve a warning: not the open edges and back sides of planar meshes.
MeshFindings notable_findings(const PreparedMesh& mesh) {
    MeshFindings findings = mesh.findings;
    if (is_flat(mesh.original)) findings.boundary_edges = findings.backs = findings.parted_vertices = 0;
    return findings;
}

/// Caches model files from which several parts or shapes are needed, so that each is read once. Keeps only
/// the last of all other files.
class ModelShelf {
public:
    explicit ModelShelf(const Scene& scene) : scene_(scene) {
        for (const Entity& entity : scene.entities)
            if (!entity.part.empty()) shared_.insert(entity.mesh);
        for (const Instance& instance : scene.instances)
            if (instance.shape != Shape()) shared_.insert(scene.entities[instance.entity].mesh);
    }

    /// Returns a model file. The pointer is valid until the next call.
    Result<const ModelFile*> file(const std::filesystem::path& path) {
        if (const auto given = mesh_in_memory(scene_, path)) return given.get();
        const auto known = models_.find(path);
        if (known != models_.end()) return &known->second;
        HF_TRY(ModelFile opened, ModelFile::open(path));
        if (!shared_.contains(path)) return &last_.emplace(std::move(opened));
        return &models_.emplace(path, std::move(opened)).first->second;
    }

private:
    const Scene& scene_;
    std::set<std::filesystem::path> shared_;
    std::map<std::filesystem::path, ModelFile> models_;
    std::optional<ModelFile> last_;
};

/// Returns the part that an entity names; none for the whole file.
Result<std::optional<std::size_t>> part_of(const ModelFile& model, const Entity& entity) {
    if (entity.part.empty()) return std::optional<std::size_t>();
    const std::vector<std::string>& names = model.parts().names;
    const auto found = std::ranges::find(names, entity.part);
    if (found != names.end()) return std::optional(static_cast<std::size_t>(found - names.begin()));
    constexpr std::size_t most_listed = 20;
    return Error{model.file().string(),
                 fmt::format("found no part \"{}\", which entity {} names; expected one of {}", entity.part,
                             entity.name, quoted_list(names, most_listed))};
}

/// Prepares an entity's mesh and occluders, or finds the mesh in the library.
Result<Done> prepare_or_find_mesh(ImportedMesh imported, const MeshPreparation& wanted,
                                  const std::filesystem::path& file, const SceneEntityOptions& options,
                                  const Progress& progress, SceneEntity& entity) {
    constexpr std::size_t fewest_stored = 1000;  // triangles of the fine mesh; others are prepared in 10 ms
    const std::filesystem::path& folder = options.fields_folder;
    std::error_code unknown;
    const bool has_library = !folder.empty() && std::filesystem::is_directory(folder, unknown);
    const ContentHash key = has_library ? preparation_key(imported, wanted) : ContentHash();
    if (has_library)
        if (std::optional<LibraryMesh> found = find_library_mesh(folder, key)) {
            entity.mesh = std::move(found->mesh);
            entity.occlusion.emplace(entity.mesh, std::move(found->occlusion));
            return Done{};
        }
    Result<PreparedMesh> prepared = prepare_mesh(std::move(imported), wanted, progress);
    if (!prepared) return Error{file.string(), prepared.error().message()};
    entity.mesh = std::move(*prepared);
    entity.occlusion.emplace(entity.mesh);
    if (has_library && entity.mesh.fine.triangles.size() >= fewest_stored &&
        !add_library_mesh(folder, entity.name, key, entity.mesh, *entity.occlusion, progress) &&
        progress.stop.stop_requested())
        return interruption();
    return Done{};  // Where the library cannot be written, the next command prepares the mesh again.
}

/// Reads and prepares the mesh and its surfaces.
Result<Done> take_mesh(const Scene& scene, const Entity& description, const Shape& shape,
                       const SceneEntityOptions& options, ModelShelf& models, TextureShelf& shelf,
                       ModelWarnings& warnings, const Progress& progress, SceneEntity& entity) {
    const bool originals = options.original_vertices;
    HF_TRY(const ModelFile* model, models.file(description.mesh));
    HF_TRY(const std::optional<std::size_t> part, part_of(*model, description));
    HF_TRY(ImportedMesh imported,
           read_mesh(*model, part, {.appearance = true, .originals = originals, .faces = description.faces}));
    if (originals) {
        HF_TRY(ListedMesh listed, model->listed(part));
        entity.listed = shaped_listing(std::move(listed), shape);
    }
    HF_TRY(std::vector<Surface> surfaces, entity_surfaces(scene, description, imported, shelf, warnings));
    if (uses_file_materials(description, imported)) warnings.add_unused(description.mesh, model->unused());
    DistinctAttributes wanted;
    wanted.originals = originals;
    MeshPreparation preparation{originals ? 0 : description.fine_vertices, description.coarse_triangles};
    for (const Surface& surface : surfaces) {
        wanted.uvs.push_back(surface.texture != nullptr);
        wanted.colours.push_back(surface.coloured);
        preparation.opacity.push_back(surface.texture ? opacity_map(*surface.texture) : OpacityMap());
    }
    preparation.split_crossed = !originals;
    preparation.faces = description.faces;
    const bool is_less = wanted.uvs != imported.mapped || wanted.colours != imported.coloured;
    if (is_less) imported.mesh = with_shared_vertices(imported.mesh, wanted);
    if (shape != Shape()) {
        imported.mesh = shaped_mesh(std::move(imported.mesh), shape);
        leave_out_bad_triangles(imported.mesh, imported.findings);  // Rounding can make triangles
                                                                    // degenerate.
    }
    HF_TRY_DONE(
        prepare_or_find_mesh(std::move(imported), preparation, description.mesh, options, progress, entity));
    entity.left_handed = model->is_left_handed() && !mirrors(shape);
    if (entity.left_handed) warnings.add_left_handed(description.mesh);
    warnings.add_findings(description.mesh, description.part, notable_findings(entity.mesh));
    entity.surfaces = std::move(surfaces);
    entity.materials = materials_of(entity.surfaces);
    return Done{};
}

Result<Done> find_or_make_field(SceneEntity& entity, const FieldSettings& settings,
                                const SceneEntityOptions& options, const Progress& progress) {
    const bool is_whole = options.fields == FieldExtent::whole;
    const auto make = [&](const PrecomputedSamples& known) {
        return is_whole
                   ? precompute_field(entity.name, entity.mesh, *entity.occlusion, settings, progress, known)
                   : precompute_surroundings(entity.name, entity.mesh, *entity.occlusion, settings, progress,
                                             known);
    };
    if (options.fields_folder.empty()) {
        HF_TRY(entity.field, make({}));
        return Done{};
    }
    HF_TRY(LibraryField found, library_field(options.fields_folder, entity.name,
                                             is_whole ? field_keys(entity.mesh, settings)
                                                      : surroundings_keys(entity.mesh, settings),
                                             make, progress));
    if (found.field.local_handles.size() != (is_whole ? entity.mesh.fine.positions.size() : 0))
        return Error{found.file.string(), "found a field of another mesh; expected the mesh of its key"};
    entity.field = std::move(found.field);
    entity.field_file = std::move(found.file);
    entity.reused = found.reused;
    entity.surroundings_reused = found.surroundings_reused;
    entity.recomputed_because = std::move(found.recomputed_because);
    return Done{};
}

/// Reads the meshes of a scene's filters.
Result<std::shared_ptr<const LightFilters>> light_filters(const Scene& scene) {
    if (scene.filters.empty()) return std::shared_ptr<const LightFilters>();
    auto filters = std::make_shared<LightFilters>();
    for (const SceneFilter& filter : scene.filters) {
        HF_TRY(FilterMesh read, read_filter(filter));
        filters->add(read.mesh.positions, read.mesh.triangles, std::move(read.colours), filter.absorption);
    }
    filters->commit();
    return std::shared_ptr<const LightFilters>(std::move(filters));
}

}  // namespace

Result<FilterMesh> read_filter(const SceneFilter& filter) {
    MeshReaderOptions options;
    options.appearance = filter.vertex_colours;
    HF_TRY(ImportedMesh imported, read_mesh(filter.mesh, options));
    FilterMesh result{std::move(imported.mesh), {filter.colour}};
    const std::vector<Rgb>& vertices = result.mesh.colours;
    if (!filter.vertex_colours || vertices.empty()) return result;
    result.colours.assign(result.mesh.triangles.size(), filter.colour);
    for (std::size_t t = 0; t < result.colours.size(); ++t) {
        const auto& [a, b, c] = result.mesh.triangles[t];
        const Rgb mean = (vertices[a] + vertices[b] + vertices[c]) / 3.0f;
        for (int k = 0; k < 3; ++k) result.colours[t][k] *= std::clamp(mean[k], 0.0f, 1.0f);
    }
    return result;
}

FieldSettings entity_field_settings(const Entity& description, const EntityOcclusion& occlusion,
                                    const SceneEntityOptions& options) {
    FieldSettings settings;
    settings.face_size = options.face_size;
    settings.coefficients = options.coefficients;
    settings.relative_l2_error = options.relative_l2_error;
    // Exactly rasterized entities need no samples in space; 0 gives the minimum number.
    const bool is_exact = occlusion.coarse().triangles().size() <= RenderSettings().exact_triangles;
    settings.planar_samples = is_exact ? 0 : description.planar_samples;
    settings.spherical_samples = is_exact ? 0 : description.spherical_samples;
    return settings;
}

Result<SceneEntities> prepare_scene_entities(const Scene& scene, const SceneEntityOptions& options,
                                             const Progress& progress) {
    SceneEntities result;
    if (options.fields != FieldExtent::none && !options.fields_folder.empty()) {
        HF_TRY_DONE(make_folder(options.fields_folder));
        remove_abandoned_claims(options.fields_folder);
    }
    std::vector<Variant> known;  // By result.entities.
    ModelWarnings warnings;
    TextureShelf shelf;
    ModelShelf models(scene);
    for (const Instance& instance : scene.instances) {
        const auto same = std::ranges::find_if(known, [&instance](const Variant& variant) {
            return variant.entity == instance.entity && is_same_shape(variant.shape, instance.shape);
        });
        result.entity_of_instance.push_back(static_cast<std::size_t>(same - known.begin()));
        if (same != known.end()) continue;
        known.push_back({instance.entity, instance.shape});
        if (progress.stop.stop_requested()) return interruption();

        const Entity& description = scene.entities[instance.entity];
        auto entity = std::make_unique<SceneEntity>();
        entity->name = description.name;
        if (instance.shape != Shape()) entity->name += fmt::format("~{}", shape_name(instance.shape));
        if (progress.report) progress.report("mesh of " + entity->name, 0, 1);
        const Clock::time_point mesh_start = Clock::now();
        HF_TRY_DONE(take_mesh(scene, description, instance.shape, options, models, shelf, warnings, progress,
                              *entity));
        entity->tints = vertex_tints(entity->mesh.fine, entity->surfaces);
        entity->mesh_seconds = seconds_since(mesh_start);
        if (progress.report) progress.report("mesh of " + entity->name, 1, 1);
        const FieldSettings settings = entity_field_settings(description, *entity->occlusion, options);
        if (options.fields == FieldExtent::none) {
            entity->field = empty_field(entity->name, entity->mesh, settings);
        } else {
            const Clock::time_point field_start = Clock::now();
            HF_TRY_DONE(find_or_make_field(*entity, settings, options, progress));
            entity->field_seconds = seconds_since(field_start);
        }
        result.entities.push_back(std::move(entity));
    }
    HF_TRY(result.filters, light_filters(scene));
    result.warnings = warnings.lines();
    return result;
}

Result<SceneEntities> original_entities(const Scene& scene, const Progress& progress) {
    Scene plain = scene;
    for (Entity& entity : plain.entities) {
        entity.fine_vertices = 0;
        entity.coarse_triangles = 0;
    }
    SceneEntityOptions wanted;
    wanted.fields = FieldExtent::none;
    return prepare_scene_entities(plain, wanted, progress);
}

std::vector<Mesh> fine_meshes(const SceneEntities& entities) {
    std::vector<Mesh> meshes;
    for (const auto& entity : entities.entities) meshes.push_back(entity->mesh.fine);
    return meshes;
}

std::vector<Mesh> surface_meshes(const SceneEntities& entities, std::size_t vertices) {
    double fine_vertices = 0;
    for (const std::size_t entity : entities.entity_of_instance)
        fine_vertices += static_cast<double>(entities.entities[entity]->mesh.fine.positions.size());
    std::vector<Mesh> meshes;
    for (const auto& entity : entities.entities) {
        const double share = static_cast<double>(entity->mesh.fine.positions.size()) / fine_vertices;
        meshes.push_back(subdivided(visible_surface(entity->mesh),
                                    static_cast<std::uint32_t>(share * static_cast<double>(vertices))));
        if (entity->mesh.findings.open_components > 0)
            split_crossed_vertices(meshes.back(), entity->mesh.original);
        part_thin_sheets(meshes.back(), entity->mesh.original);
    }
    return meshes;
}

bool has_separate_specular(const SceneEntities& entities) {
    return std::ranges::any_of(entities.entities, [](const auto& entity) {
        return std::ranges::any_of(entity->surfaces, &Surface::has_separate_specular);
    });
}

std::vector<std::vector<bool>> parted_materials(const SceneEntities& entities) {
    std::vector<std::vector<bool>> parted;
    for (const auto& entity : entities.entities) {
        parted.emplace_back();
        for (const Surface& surface : entity->surfaces)
            parted.back().push_back(surface.has_separate_specular());
    }
    return parted;
}

}  // namespace haarfield
