#include "scenes/scene_entities.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <map>
#include <tuple>

#include "fields/mesh_reader.h"

namespace haarfield {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// v turned about x, then y, then z. [rad]
Vec3f rotated(const Vec3f& v, const Vec3f& angles) {
    Vec3d r(v);
    const Vec3d c(std::cos(double(angles.x)), std::cos(double(angles.y)), std::cos(double(angles.z)));
    const Vec3d s(std::sin(double(angles.x)), std::sin(double(angles.y)), std::sin(double(angles.z)));
    r = {r.x, c.x * r.y - s.x * r.z, s.x * r.y + c.x * r.z};
    r = {c.y * r.x + s.y * r.z, r.y, c.y * r.z - s.y * r.x};
    r = {c.z * r.x - s.z * r.y, s.z * r.x + c.z * r.y, r.z};
    return Vec3f(r);
}

void rotate_mesh(Mesh& mesh, const Vec3f& angles) {
    for (Vec3f& position : mesh.positions) position = rotated(position, angles);
    for (Vec3f& normal : mesh.normals) normal = rotated(normal, angles).normalized();
}

/// The entity's name, with its rotation in whole hundredths of a degree where there is one; fit for a file.
std::string posed_name(const std::string& name, const Vec3f& rotate) {
    if (rotate == Vec3f(0.0f)) return name;
    const auto degrees = [](float angle) { return std::round(angle * 18000 / pi) / 100; };
    return fmt::format("{}-r{}_{}_{}", name, degrees(rotate.x), degrees(rotate.y), degrees(rotate.z));
}

std::vector<Material> mesh_materials(const Scene& scene, const Entity& entity, const Mesh& mesh) {
    std::vector<Material> materials;
    for (const std::string& name : mesh.material_names) {
        const auto mapped = entity.materials.find(name);
        materials.push_back(
            scene.materials.at(mapped != entity.materials.end() ? mapped->second : entity.material));
    }
    return materials;
}

/// Reads the field if the file is there, may be used, and has the key.
bool reuse_field(SceneEntity& entity, const ContentHash& key, Unsealed unsealed) {
    std::error_code ignored;
    if (!std::filesystem::exists(entity.field_file, ignored)) return false;
    Result<VisibilityField> field = read_field(entity.field_file, unsealed);
    if (!field)
        entity.remade_because = field.error().message();
    else if (!(field->key == key))
        entity.remade_because =
            fmt::format("{}: made from another mesh or with other settings", entity.field_file.string());
    else if (field->local_handles.size() != entity.mesh.fine.positions.size())
        entity.remade_because = fmt::format("{}: not of this mesh", entity.field_file.string());
    else {
        entity.field = *std::move(field);
        entity.reused = true;
        entity.remade_because.clear();
    }
    return entity.reused;
}

Result<Done> find_or_make_field(SceneEntity& entity, const FieldSettings& settings, Unsealed unsealed,
                                const Progress& progress) {
    const ContentHash key = field_key(entity.mesh, settings);
    if (reuse_field(entity, key, unsealed)) return Done{};
    // Held while the field is made: who wants the same one waits for it, and a folder where nothing can be
    // written is noticed before the work.
    Result<TemporaryFile> temporary = TemporaryFile::beside(entity.field_file, progress);
    if (!temporary) return temporary.error();
    if (reuse_field(entity, key, unsealed)) return Done{};  // another process made it meanwhile
    Result<VisibilityField> field =
        precompute_field(entity.name, entity.mesh, *entity.occlusion, settings, progress);
    if (!field) return field.error();
    entity.field = *std::move(field);
    return write_field(entity.field, *temporary);
}

}  // namespace

Result<SceneEntities> prepare_scene_entities(const Scene& scene, const SceneEntityOptions& options,
                                             const Progress& progress) {
    SceneEntities result;
    if (options.fields) {
        std::error_code failure;
        std::filesystem::create_directories(options.fields_folder, failure);
        if (failure)
            return Error{options.fields_folder.string(), "can not make the folder: " + failure.message()};
        remove_abandoned_files(options.fields_folder);
    }
    using Pose = std::tuple<std::size_t, float, float, float>;
    std::map<Pose, std::size_t> known;
    for (const Instance& instance : scene.instances) {
        const Vec3f& rotate = instance.rotate;
        const auto [entry, is_new] =
            known.emplace(Pose{instance.entity, rotate.x, rotate.y, rotate.z}, result.entities.size());
        result.entity_of_instance.push_back(entry->second);
        if (!is_new) continue;
        if (progress.stop.stop_requested()) return Error{"", interrupted};

        const Entity& description = scene.entities[instance.entity];
        auto entity = std::make_unique<SceneEntity>();
        entity->name = posed_name(description.name, rotate);
        entity->entity = instance.entity;
        if (progress.report) progress.report("mesh of " + entity->name, 0, 1);
        const Clock::time_point mesh_start = Clock::now();
        Result<ImportedMesh> imported = read_mesh(description.mesh);
        if (!imported) return imported.error();
        rotate_mesh(imported->mesh, rotate);
        Result<PreparedMesh> prepared = prepare_mesh(
            std::move(*imported), {description.fine_vertices, description.coarse_triangles}, progress);
        if (!prepared) return Error{description.mesh.string(), prepared.error().message()};
        entity->mesh = std::move(*prepared);
        entity->occlusion.emplace(entity->mesh);
        entity->materials = mesh_materials(scene, description, entity->mesh.fine);
        entity->mesh_seconds = seconds_since(mesh_start);
        if (progress.report) progress.report("mesh of " + entity->name, 1, 1);
        if (const std::string findings = entity->mesh.findings.summary();
            !findings.empty() && rotate == Vec3f(0.0f))
            result.warnings.push_back(fmt::format("{}: {}", description.mesh.string(), findings));

        if (options.fields) {
            const Clock::time_point field_start = Clock::now();
            entity->field_file = options.fields_folder / (entity->name + ".vdb");
            FieldSettings settings;
            settings.face_size = options.face_size;
            settings.coefficients = options.coefficients;
            settings.relative_l2_error = options.relative_l2_error;
            // What is rasterized at the vertex itself needs no samples around it, beyond the fewest there can
            // be.
            const bool is_exact =
                entity->occlusion->coarse().triangles.size() <= RenderSettings().exact_triangles;
            settings.planar_samples = is_exact ? 0 : description.planar_samples;
            settings.spherical_samples = is_exact ? 0 : description.spherical_samples;
            const Result<Done> done = find_or_make_field(*entity, settings, options.unsealed, progress);
            if (!done) return done.error();
            entity->field_seconds = seconds_since(field_start);
        }
        result.entities.push_back(std::move(entity));
    }
    return result;
}

ShadedScene shaded_scene(const Scene& scene, const SceneEntities& entities, LatLongImage environment) {
    ShadedScene shaded;
    for (const auto& entity : entities.entities)
        shaded.entities.push_back(
            {&entity->mesh.fine, &*entity->occlusion, &entity->field, entity->materials});
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        shaded.instances.push_back(
            {entities.entity_of_instance[i], scene.instances[i].translate, scene.instances[i].scale});
    shaded.environment = std::move(environment);
    shaded.eye = scene.camera.position;
    return shaded;
}

}  // namespace haarfield
