#include "scenes/scene_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "fields/base/names.h"
#include "fields/mesh/mesh_reader.h"
#include "fields/mesh/model_file.h"
#include "scenes/shape.h"

namespace haarfield {
namespace {

/// Scales alike along all axes, after turning z upwards if it is so meant.
AffineMap turned_and_scaled(bool z_up, double scale) {
    AffineMap map;
    if (z_up) map.axes = {Vec3d(1, 0, 0), Vec3d(0, 0, -1), Vec3d(0, 1, 0)};
    for (Vec3d& axis : map.axes) axis *= scale;
    return map;
}

/// A name that a file may have, and POV-Ray.
std::string file_name(const std::string& name, const std::string& otherwise) {
    std::string plain = plain_name(name);
    plain.erase(0, plain.find_first_not_of("_-."));
    plain = plain.substr(0, 60);
    return plain.empty() ? otherwise : plain;
}

/// An instance that is not placed in the scene yet.
struct Placed {
    std::size_t entity;
    std::string name;
    AffineMap place;  ///< In the file's world.
};

/// What is known of an entity's mesh.
struct Extent {
    Bounds bounds;  ///< In its own frame.
    double area = 0;
};

Extent extent_of(const Mesh& mesh) {
    Extent extent{mesh_bounds(mesh), 0};
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3d p(mesh.positions[a]);
        extent.area += (Vec3d(mesh.positions[b]) - p).cross(Vec3d(mesh.positions[c]) - p).length() / 2;
    }
    return extent;
}

std::array<Vec3d, 8> corners_of(const Bounds& bounds) {
    std::array<Vec3d, 8> corners;
    for (std::size_t k = 0; k < 8; ++k)
        corners[k] = {double(k & 1 ? bounds.upper.x : bounds.lower.x),
                      double(k & 2 ? bounds.upper.y : bounds.lower.y),
                      double(k & 4 ? bounds.upper.z : bounds.lower.z)};
    return corners;
}

/// By how much a map magnifies areas, about.
double area_scale(const AffineMap& map) {
    const auto& [x, y, z] = map.axes;
    return (x.cross(y).length() + y.cross(z).length() + z.cross(x).length()) / 3;
}

class Importer {
public:
    Importer(const SceneImport& wanted, const Progress& progress) : wanted_(wanted), progress_(progress) {}

    Result<Done> add(const std::filesystem::path& path) {
        const Result<ModelFile> opened = ModelFile::open(path);
        if (!opened) return opened.error();
        const ModelFile& model = *opened;
        const std::string stem = file_name(path.stem().string(), "model");
        const ModelParts& parts = model.parts();
        const bool stands_still =
            parts.nodes.size() == parts.names.size() &&
            std::ranges::all_of(parts.nodes, [](const ModelNode& node) { return node.place == AffineMap(); });
        if (!camera_ && parts.camera) camera_ = parts.camera;
        lights_.insert(lights_.end(), parts.lights.begin(), parts.lights.end());
        if (parts.unread_lights > 0)
            warnings.push_back(fmt::format("{}: {} light_sources are no plain data; left out", path.string(),
                                           parts.unread_lights));
        if (wanted_.whole || stands_still || parts.names.size() == 1) {
            const bool is_part = parts.names.size() == 1 && !wanted_.whole && !stands_still;
            const Result<std::optional<std::size_t>> entity =
                add_entity(model, is_part ? std::optional<std::size_t>(0) : std::nullopt, stem, path);
            if (!entity) return entity.error();
            if (!*entity) return Done{};
            if (!is_part) placed_.push_back({**entity, stem, AffineMap()});
            for (const ModelNode& node : parts.nodes)
                if (is_part) placed_.push_back({**entity, file_name(node.name, stem), node.place});
            return Done{};
        }
        std::vector<std::optional<std::size_t>> entity_of_part;
        for (std::size_t part = 0; part < parts.names.size(); ++part) {
            if (progress_.stop.stop_requested()) return Error{"", interrupted};
            const Result<std::optional<std::size_t>> entity =
                add_entity(model, part, file_name(parts.names[part], stem), path);
            if (!entity) return entity.error();
            entity_of_part.push_back(*entity);
            if (progress_.report) progress_.report("parts of " + stem, part + 1, parts.names.size());
        }
        for (const ModelNode& node : parts.nodes)
            if (const auto entity = entity_of_part[node.part])
                placed_.push_back({*entity, file_name(node.name, scene.entities[*entity].name), node.place});
        return Done{};
    }

    Result<Done> place() {
        if (placed_.empty()) return Error{"", "nothing with a surface; wanted a model"};
        Bounds all;
        const AffineMap upright = turned_and_scaled(wanted_.z_up, 1);
        for (const Placed& instance : placed_)
            for (const Vec3d& corner : corners_of(extents_[instance.entity].bounds))
                all.add(Vec3f((upright * instance.place).point(corner)));
        const Vec3f size = all.upper - all.lower;
        const double longest = double(std::max({size.x, size.y, size.z}));
        const double scale = wanted_.size && longest > 0 ? *wanted_.size / longest : wanted_.unit;
        const AffineMap world = turned_and_scaled(wanted_.z_up, scale);
        double area = 0;
        std::set<std::string> taken;
        for (const Entity& entity : scene.entities) taken.insert(entity.name);
        std::map<std::string, std::size_t> count;
        for (const Placed& placed : placed_) ++count[placed.name];
        for (const Placed& placed : placed_) {
            const AffineMap place = world * placed.place;
            const Result<LinearParts> parts = linear_parts(place.rows());
            if (!parts) return Error{placed.name, "its place " + parts.error().what};
            Instance instance;
            instance.entity = placed.entity;
            // One that is called as its entity needs no name of its own.
            const bool is_own = placed.name == scene.entities[placed.entity].name;
            if (!is_own || count[placed.name] > 1) instance.name = unique_name(placed.name, taken);
            instance.placement = parts->placement;
            instance.placement.translate = Vec3f(place.origin);
            instance.shape = parts->shape;
            const double own_area = extents_[placed.entity].area * area_scale(place);
            area += own_area;
            areas_[placed.entity] += own_area;
            ++instances_[placed.entity];
            scene.instances.push_back(std::move(instance));
        }
        share_vertices(area);
        for (int axis = 0; axis < 3; ++axis) {
            bounds.lower[axis] = static_cast<float>(double(all.lower[axis]) * scale);
            bounds.upper[axis] = static_cast<float>(double(all.upper[axis]) * scale);
        }
        set_camera(world);
        for (const ModelLight& light : lights_) scene.lamps.push_back(placed_lamp(light, world, scale));
        return Done{};
    }

    Scene scene;
    Bounds bounds;  ///< Of all that is placed.
    std::vector<std::string> warnings;

private:
    /// Nothing if it has no surface, with a warning.
    Result<std::optional<std::size_t>> add_entity(const ModelFile& model, std::optional<std::size_t> part,
                                                  const std::string& name,
                                                  const std::filesystem::path& path) {
        const Result<ImportedMesh> imported = read_mesh(model, part, {});
        if (!imported && part && model.parts().names.size() > 1) {
            warnings.push_back(imported.error().message() + "; left out");
            return std::optional<std::size_t>();
        }
        if (!imported) return imported.error();
        Entity entity;
        entity.name = unique_name(name, names_);
        entity.mesh = path;
        if (part) entity.part = model.parts().names[*part];
        scene.entities.push_back(std::move(entity));
        extents_.push_back(extent_of(imported->mesh));
        areas_.push_back(0);
        instances_.push_back(0);
        return std::optional(scene.entities.size() - 1);
    }

    void share_vertices(double area) {
        constexpr std::uint32_t fewest = 500, fewest_samples = 400;
        const auto entities = static_cast<std::uint32_t>(scene.entities.size());
        for (std::size_t e = 0; e < scene.entities.size(); ++e) {
            Entity& entity = scene.entities[e];
            const double share = area > 0 ? areas_[e] / area : 1,
                         wanted = share * wanted_.vertices / std::max<std::size_t>(1, instances_[e]);
            // Round numbers read well.
            entity.fine_vertices = std::max(fewest, static_cast<std::uint32_t>(wanted / 100) * 100);
            // Fields of many entities are smaller ones.
            const std::uint32_t fields = std::max(1u, entities / 2);
            entity.planar_samples = std::max(fewest_samples, entity.planar_samples / fields);
            entity.spherical_samples = std::max(fewest_samples, entity.spherical_samples / fields);
        }
    }

    void set_camera(const AffineMap& world) {
        scene.finds_camera = !camera_;
        if (!camera_) return;
        const Vec3d position = world.point(Vec3d(camera_->position)),
                    ahead = world.direction(Vec3d(camera_->direction));
        // As far as the middle of all.
        const double distance = std::max(1e-3 * double(bounds.radius()),
                                         (Vec3d(bounds.centre()) - position).dot(ahead.normalized()));
        scene.camera.position = Vec3f(position);
        scene.camera.target = Vec3f(position + ahead.normalized() * distance);
        if (camera_->vertical_fov) scene.camera.vertical_fov = *camera_->vertical_fov;
    }

    /// In the scene: lengths are `scale` times as long.
    SceneLamp placed_lamp(const ModelLight& light, const AffineMap& world, double scale) {
        SceneLamp lamp;
        lamp.name = unique_name(file_name(light.name, "light"), lamp_names_);
        lamp.kind = std::array{LampKind::point, LampKind::spot, LampKind::cylinder,
                               LampKind::parallel}[std::size_t(light.kind)];
        lamp.position = Vec3f(world.point(Vec3d(light.position)));
        lamp.target = Vec3f(world.point(Vec3d(light.target)));
        lamp.colour = light.colour;
        lamp.radius = light.radius;
        lamp.falloff = light.falloff;
        if (light.kind == ModelLight::Kind::cylinder) {
            lamp.radius *= static_cast<float>(scale);
            lamp.falloff *= static_cast<float>(scale);
        }
        lamp.tightness = light.tightness;
        lamp.shadowless = light.shadowless;
        if (light.fade_distance > 0 && light.fade_power > 0) {
            lamp.fade_distance = light.fade_distance * static_cast<float>(scale);
            lamp.fade_power = light.fade_power;
        }
        if (light.is_physical) make_physical(light, scale, lamp);
        if (light.area) {
            const ModelLight::Area& area = *light.area;
            lamp.area = {Vec3f(world.direction(Vec3d(area.across))),
                         Vec3f(world.direction(Vec3d(area.along))),
                         area.columns,
                         area.rows,
                         area.circular,
                         area.orient,
                         area.illumination};
        }
        return lamp;
    }

    /// Intensity or irradiance, as POV-Ray's colours have it. What is lit looks the same at any scale.
    void make_physical(const ModelLight& light, double scale, Lamp& lamp) const {
        if (light.kind == ModelLight::Kind::parallel) {
            lamp.colour /= static_cast<float>(pi);
            // Before everything.
            const Vec3f ahead = (lamp.target - lamp.position).normalized();
            lamp.target = bounds.centre();
            lamp.position = lamp.target - ahead * (2 * bounds.radius());
            return;
        }
        // Much nearer than anything that is lit: 2 / (1 + (d / f)^2) is 2 f^2 / d^2 there.
        lamp.fade_distance = static_cast<float>(1e-3 * scale);
        lamp.fade_power = 2;
        lamp.colour *= static_cast<float>(scale * scale / (2 * pi * squared(lamp.fade_distance)));
    }

    const SceneImport& wanted_;
    const Progress& progress_;
    std::vector<ModelLight> lights_;  ///< Of all files.
    std::set<std::string> lamp_names_;
    std::vector<Placed> placed_;
    std::set<std::string> names_;
    std::vector<Extent> extents_;  ///< By entity, and
    std::vector<double> areas_;    ///< of all of its instances, in the world. [m^2]
    std::vector<std::size_t> instances_;
    std::optional<ModelCamera> camera_;
};

/// A square below what stands on it.
std::string floor_text(const Bounds& bounds) {
    const Vec3f size = bounds.upper - bounds.lower, middle = bounds.centre();
    const float half = 2 * std::max({size.x, size.z, 0.5f * size.y});
    std::string text;
    for (const auto& [x, z] : {std::pair(-1, -1), std::pair(-1, 1), std::pair(1, 1), std::pair(1, -1)})
        text += fmt::format("v {} {} {}\n", middle.x + float(x) * half, bounds.lower.y,
                            middle.z + float(z) * half);
    return text + "f 1 2 3\nf 1 3 4\n";
}

}  // namespace

Result<ImportedScene> scene_of_models(std::span<const std::filesystem::path> files,
                                      const std::filesystem::path& folder, const SceneImport& wanted,
                                      const Progress& progress) {
    Importer importer(wanted, progress);
    for (const std::filesystem::path& file : files)
        if (const Result<Done> added = importer.add(file); !added) return added.error();
    if (const Result<Done> placed = importer.place(); !placed) return placed.error();
    ImportedScene imported{std::move(importer.scene), {}, std::move(importer.warnings)};
    Scene& scene = imported.scene;
    if (scene.lamps.empty()) {
        scene.environment.sky = AnalyticSky();
        scene.environment.sky->turbidity = 3;
        scene.environment.sky->sun_elevation = static_cast<float>(40 * pi / 180);
        scene.environment.exposure.reset();
    }
    if (wanted.floor) {
        imported.floor_obj = floor_text(importer.bounds);
        SceneMaterial grey;
        grey.diffuse = Rgb(0.5f);
        scene.materials["floor"] = grey;
        Entity floor;
        std::set<std::string> taken;
        for (const Entity& entity : scene.entities) taken.insert(entity.name);
        floor.name = unique_name("floor", taken);
        floor.mesh = folder / "floor.obj";
        floor.material = "floor";
        floor.coarse_triangles = 0;
        scene.entities.push_back(floor);
        Instance instance;
        instance.entity = scene.entities.size() - 1;
        scene.instances.push_back(instance);
    }
    return imported;
}

}  // namespace haarfield
