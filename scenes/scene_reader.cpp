#include "scenes/scene_reader.h"

#include "scenes/files_in_memory.h"
#include "scenes/lamp_reader.h"
#include "scenes/povray_finish.h"
#include "scenes/scene_tables.h"
#include "shading/scene/shaded_scene.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {

namespace {

constexpr Range turns{-3600, 3600};  // [degrees]

// Reads an angle: the key is in degrees, the value in radians.
void take_angle(TomlTable& table, std::string_view key, float& angle, const Range& degrees) {
    float taken = 0;
    table.take(key, taken, degrees);
    if (table.has(key)) angle = radians(taken);
}

// Reads the camera. Returns true if the table places it.
bool take_camera(TomlTable table, Camera& camera) {
    const bool is_placed = table.has("position") || table.has("target");
    if (is_placed) {
        table.require("position");
        table.require("target");
    }
    table.take("position", camera.position, coordinates);
    table.take("target", camera.target, coordinates);
    take_angle(table, "vertical_fov", camera.vertical_fov, {0.01, 179, false, false});
    std::array<std::uint32_t, 2> resolution{static_cast<std::uint32_t>(camera.width),
                                            static_cast<std::uint32_t>(camera.height)};
    table.take("resolution", resolution, {1, 16384});
    camera.width = static_cast<int>(resolution[0]);
    camera.height = static_cast<int>(resolution[1]);
    if (is_placed && !((camera.target - camera.position).length() > 1e-6f))
        table.refuse("target", "camera.target equals camera.position; expected another point");
    table.finish();
    return is_placed;
}

AnalyticSky parsed_sky(TomlTable table) {
    AnalyticSky sky;
    table.take("turbidity", sky.turbidity, {2, 10});
    take_angle(table, "sun_elevation", sky.sun_elevation, {0, 90});
    take_angle(table, "sun_azimuth", sky.sun_azimuth, turns);
    take_angle(table, "sun_angular_radius", sky.sun_angular_radius, {0, 5.7, true, false});
    table.take("ground", sky.ground, albedos);
    table.finish();
    return sky;
}

// Reads a light, which has either an image or a sky.
void take_light(TomlTable& table, const std::filesystem::path& folder, std::filesystem::path& image,
                std::optional<AnalyticSky>& sky) {
    table.take("image", image, folder);
    if (const toml::table* described = table.take_table("sky"))
        sky = parsed_sky(TomlTable(*described, table.name() + ".sky", table.file()));
    if (table.has("image") == table.has("sky"))
        table.refuse(table.has("sky") ? "sky" : "",
                     fmt::format("{} has {}; expected exactly one", table.name(),
                                 table.has("sky") ? "both image and sky" : "neither image nor sky"));
}

BlendedLight parsed_blend(TomlTable table, const std::filesystem::path& folder) {
    BlendedLight blend;
    take_light(table, folder, blend.image, blend.sky);
    table.require("share");
    table.take("share", blend.share, {0, 1});
    table.finish();
    return blend;
}

void take_environment(TomlTable table, const std::filesystem::path& folder,
                      EnvironmentDescription& environment) {
    take_light(table, folder, environment.image, environment.sky);
    if (const toml::table* blend = table.take_table("blend"))
        environment.blend = parsed_blend(TomlTable(*blend, "environment.blend", table.file()), folder);
    take_angle(table, "rotation", environment.rotation, turns);
    Vec3f degrees(0, 0, 0);
    table.take("rotate", degrees, turns);
    if (table.has("rotate")) environment.turn = rotation_of_degrees(degrees);
    table.take("exposure", environment.exposure, {-60, 60}, "auto");
    table.take("lights", environment.lights);
    table.finish();
}

// Reads the POV-Ray scene in which the objects stand.
Surroundings parsed_surroundings(TomlTable table, const std::filesystem::path& folder) {
    Surroundings surroundings;
    table.require("scene");
    table.take("scene", surroundings.file, folder);
    const auto take_word = [&table](std::string_view key, std::string_view first, std::string_view second) {
        std::string word(first);
        table.take(key, word);
        if (word != first && word != second)
            table.refuse(
                key, fmt::format("povray.{} is \"{}\"; expected \"{}\" or \"{}\"", key, word, first, second));
        return word == first;
    };
    surroundings.z_up = !take_word("up", "y", "z");
    surroundings.left_handed = take_word("handedness", "left", "right");
    std::string other;
    table.take("folder", other);
    if (!other.empty()) {
        surroundings.folder = (folder / other).lexically_normal();
        std::error_code failure;
        if (!std::filesystem::is_directory(surroundings.folder, failure))
            table.refuse("folder", fmt::format("povray.folder is {}: there is no such folder",
                                               surroundings.folder.string()));
    }
    table.finish();
    return surroundings;
}

SceneFilter parsed_filter(TomlTable table, const std::filesystem::path& folder) {
    SceneFilter filter;
    table.require("mesh");
    table.take("mesh", filter.mesh, folder);
    table.take("colour", filter.colour, {0, 1});
    table.take("vertex_colours", filter.vertex_colours);
    table.take("absorption", filter.absorption, {0, 1e6});
    table.finish();
    return filter;
}

// Reads a POV-Ray finish, with POV-Ray's defaults.
void take_finish(TomlTable finish, SceneMaterial& material) {
    take_povray_finish(finish, material);
    float brilliance = 1;
    finish.take("brilliance", brilliance, {0, 1000});
    if (brilliance != 1)
        finish.refuse("brilliance", fmt::format("{}.brilliance is {}; expected 1, the only supported value",
                                                finish.name(), brilliance));
    finish.finish();
}

// Reads a colour, or an image and a colour that multiplies it.
void take_pigment(TomlTable& table, const std::filesystem::path& folder, SceneMaterial& material) {
    const toml::node* pigment = table.table().get("pigment");
    if (pigment == nullptr || !pigment->is_table()) {
        table.take("pigment", material.pigment, pigments);
        return;
    }
    TomlTable parts(*table.take_table("pigment"), table.name() + ".pigment", table.file());
    parts.take("vertex_colours", material.vertex_colours);
    if (!material.vertex_colours) parts.require("image");
    parts.take("image", material.image, folder);
    parts.take("colour", material.pigment, pigments);
    parts.finish();
}

// Reads a reflection: a number, or a table.
void take_reflection(TomlTable& table, Reflection& reflection) {
    const toml::node* node = table.table().get("reflection");
    if (node == nullptr) return;
    if (!node->is_table()) {
        float fraction = 0;
        table.take("reflection", fraction, albedos);
        reflection.at_normal = reflection.at_grazing = Rgb(fraction);
        return;
    }
    TomlTable parts(*table.take_table("reflection"), table.name() + ".reflection", table.file());
    parts.require("max");
    parts.take("max", reflection.at_grazing, albedos);
    parts.take("min", reflection.at_normal, albedos);
    parts.take("ior", reflection.ior, {1, 10, true});
    parts.take("metallic", reflection.metallic, {0, 1});
    if (!parts.has("min") && !parts.has("ior")) reflection.at_normal = reflection.at_grazing;
    parts.finish();
}

SceneMaterial parsed_material(TomlTable table, const std::filesystem::path& folder) {
    SceneMaterial material;
    take_reflection(table, material.reflection);
    if (table.has("pigment") || table.has("finish")) {
        for (const char* key :
             {"diffuse", "specular", "shininess", "convention", "image", "vertex_colours", "emission"})
            if (table.has(key))
                table.refuse(key,
                             fmt::format("{}.{} conflicts with pigment and finish; expected either these, or "
                                         "diffuse, specular, shininess, convention, image and emission",
                                         table.name(), key));
        material.convention = LobeConvention::povray;
        table.require("pigment");
        take_pigment(table, folder, material);
        const toml::table plain;
        const toml::table* const finish = table.take_table("finish");
        take_finish(TomlTable(finish ? *finish : plain, table.name() + ".finish", table.file()), material);
        const auto most = [](const Rgb& colour) { return std::max({colour.x, colour.y, colour.z}); };
        constexpr float rounding = 1e-5f;
        if (most(material.diffuse) > 1 + rounding)
            table.refuse("pigment",
                         fmt::format("{}: pigment times finish.diffuse is {:.4g}; expected at most 1",
                                     table.name(), most(material.diffuse)));
        for (int c = 0; c < 3; ++c) material.diffuse[c] = std::min(material.diffuse[c], 1.0f);
        if (material.metallic > 0 && most(material.pigment) > 1)
            table.refuse("pigment", fmt::format("{}: the pigment of a metallic finish is {:.4g}; expected at "
                                                "most 1",
                                                table.name(), most(material.pigment)));
        table.finish();
        return material;
    }
    table.take("diffuse", material.diffuse, albedos);
    table.take("specular", material.specular, albedos);
    table.take("shininess", material.shininess, shininesses);
    table.take("image", material.image, folder);
    table.take("vertex_colours", material.vertex_colours);
    table.take("emission", material.emission, emissions);
    table.take("ambient", material.ambient, emissions);
    std::string convention = "physical";
    table.take("convention", convention);
    if (convention == "povray")
        material.convention = LobeConvention::povray;
    else if (convention != "physical")
        table.refuse("convention", fmt::format("{}.convention is \"{}\"; expected \"physical\" or \"povray\"",
                                               table.name(), convention));
    table.finish();
    return material;
}

// Tests whether a name is valid in file names: entities and instances name files of fields and of POV-Ray.
bool is_file_name(std::string_view name) {
    return !name.empty() && name.size() <= 100 && name.front() != '.' && name.front() != '-' &&
           std::ranges::none_of(
               name, [](char c) { return c == '/' || c == '\\' || c == 127 || (c >= 0 && c < 32); });
}

Entity parsed_entity(TomlTable table, const std::string& name, const std::filesystem::path& folder,
                     const std::map<std::string, SceneMaterial>& materials) {
    Entity entity;
    entity.name = name;
    const auto take_material = [&materials](TomlTable& from, std::string_view key, std::string& material) {
        from.take(key, material);
        if (from.has(key) && !materials.contains(material))
            from.refuse(
                key, fmt::format("{}.{} is \"{}\"; there is no such material", from.name(), key, material));
    };
    table.require("mesh");
    table.take("mesh", entity.mesh, folder);
    table.take("part", entity.part);
    take_material(table, "material", entity.material);
    if (const toml::table* by_name = table.take_table("materials")) {
        TomlTable parts(*by_name, table.name() + ".materials", table.file());
        for (const auto& [part, value] : *by_name)
            take_material(parts, part.str(), entity.materials[std::string(part.str())]);
    }
    std::string faces = "outwards";
    table.take("faces", faces);
    if (faces == "inwards")
        entity.faces = ClosedFaces::inwards;
    else if (faces != "outwards")
        table.refuse("faces", fmt::format("{}.faces is \"{}\"; expected \"outwards\" or \"inwards\"",
                                          table.name(), faces));
    table.take("fine_vertices", entity.fine_vertices, {1, 20e6});
    table.take("coarse_triangles", entity.coarse_triangles, {0, 20e6});
    table.take("planar_samples", entity.planar_samples, {1, 10e6});
    table.take("spherical_samples", entity.spherical_samples, {1, 10e6});
    table.finish();
    return entity;
}

// Reads a placement: either a matrix; or a scale, then a rotation, then a translation.
void take_place(TomlTable& table, Instance& instance) {
    std::array<std::array<double, 4>, 3> matrix{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    Vec3d scale(1, 1, 1);
    Vec3f translate(0, 0, 0), degrees(0, 0, 0);
    table.take_matrix("matrix", matrix, coordinates);
    table.take("translate", translate, coordinates);
    table.take_factors("scale", scale, {least_stretch, most_stretch});
    table.take("rotate", degrees, turns);
    const bool is_matrix = table.has("matrix");
    for (const char* key : {"translate", "scale", "rotate"})
        if (is_matrix && table.has(key))
            table.refuse(key,
                         fmt::format("{}.{} conflicts with matrix; expected either a matrix, or translate, "
                                     "scale and rotate",
                                     table.name(), key));

    std::array<Vec3d, 3> linear{Vec3d(scale.x, 0, 0), Vec3d(0, scale.y, 0), Vec3d(0, 0, scale.z)};
    if (is_matrix)
        for (std::size_t i = 0; i < 3; ++i) {
            linear[i] = {matrix[i][0], matrix[i][1], matrix[i][2]};
            translate[int(i)] = static_cast<float>(matrix[i][3]);
        }
    const Result<PlacedShape> parts = placed_shape(linear);
    if (!parts) {
        const char* key = is_matrix ? "matrix" : "scale";
        return table.refuse(key, fmt::format("{}.{} {}", table.name(), key, parts.error().what));
    }
    instance.placement = parts->placement;
    instance.placement.translate = translate;
    // Two negative factors are a rotation by 180 degrees, applied before `rotate`.
    const Rotation rotate = rotation_of_degrees(degrees);
    instance.placement.rotate =
        is_identity(parts->placement.rotate) ? rotate : rotate * parts->placement.rotate;
    instance.shape = parts->shape;
}

// Reads an instance. Its name is empty if the file gives none.
Instance parsed_instance(TomlTable table, const std::vector<Entity>& entities,
                         const std::vector<Instance>& before) {
    Instance instance;
    table.require("entity");
    std::string entity_name;
    table.take("entity", entity_name);
    const auto entity = std::ranges::find(entities, entity_name, &Entity::name);
    if (entity != entities.end())
        instance.entity = static_cast<std::size_t>(entity - entities.begin());
    else if (table.has("entity"))
        table.refuse("entity",
                     fmt::format("{}.entity is \"{}\"; there is no such entity", table.name(), entity_name));
    table.take("name", instance.name);
    if (table.has("name") && !is_file_name(instance.name))
        table.refuse("name", fmt::format("{}.name is \"{}\"; expected a valid file name", table.name(),
                                         instance.name));
    const auto same = std::ranges::find(before, instance.name, &Instance::name);
    if (table.has("name") && same != before.end())
        table.refuse(
            "name",
            fmt::format("{}.name is \"{}\", which is the name of instances[{}]; expected a unique name",
                        table.name(), instance.name, same - before.begin()));
    take_place(table, instance);
    table.finish();
    return instance;
}

// Names the unnamed instances: `chair` if it is the only one, else chair_1, chair_2 and so on, skipping names
// of other instances and entities. A named instance uses up its number, so that the numbers of the others do
// not change.
void name_instances(Scene& scene) {
    std::vector<std::size_t> count(scene.entities.size(), 0), numbered(scene.entities.size(), 0);
    std::set<std::string> taken;
    for (const Instance& instance : scene.instances) {
        ++count[instance.entity];
        taken.insert(instance.name);
    }
    const std::set<std::string> given = taken;
    for (const Entity& entity : scene.entities) taken.insert(entity.name);
    for (Instance& instance : scene.instances) {
        const std::string& entity = scene.entities[instance.entity].name;
        std::size_t& number = numbered[instance.entity];
        if (!instance.name.empty()) {
            ++number;
        } else if (count[instance.entity] == 1 && !given.contains(entity)) {
            instance.name = entity;
        } else {
            do instance.name = fmt::format("{}_{}", entity, ++number);
            while (!taken.insert(instance.name).second);
        }
    }
}

// Reads a keyframe of an instance; all instances have names.
Keyframe parsed_keyframe(TomlTable table, const Scene& scene) {
    Keyframe keyframe;
    std::string name;
    table.require("time");
    table.require("instance");
    table.take("time", keyframe.time, {0, 1e6});
    table.take("instance", name);
    const auto instance = std::ranges::find(scene.instances, name, &Instance::name);
    if (instance != scene.instances.end())
        keyframe.instance = static_cast<std::size_t>(instance - scene.instances.begin());
    else if (table.has("instance"))
        table.refuse("instance",
                     fmt::format("{}.instance is \"{}\"; there is no such instance", table.name(), name));
    Vec3f translate(0, 0, 0), degrees(0, 0, 0);
    table.take("translate", translate, coordinates);
    table.take("rotate", degrees, turns);
    if (table.has("translate")) keyframe.translate = translate;
    if (table.has("rotate"))
        keyframe.rotate = Vec3f(radians(degrees.x), radians(degrees.y), radians(degrees.z));
    float scale = 1;
    table.take("scale", scale, {least_stretch, most_stretch});
    if (table.has("scale")) keyframe.scale = scale;
    const float stretch = instance == scene.instances.end() ? 1 : scale * instance->placement.scale;
    if (!(stretch >= static_cast<float>(least_stretch) && stretch <= static_cast<float>(most_stretch)))
        table.refuse("scale", fmt::format("{}.scale is {}, which times the scale of {} is {:.3g}; "
                                          "expected {:g} to {:g}",
                                          table.name(), scale, name, stretch, least_stretch, most_stretch));
    if (!keyframe.translate && !keyframe.rotate && !keyframe.scale)
        table.refuse("", fmt::format("{} has none of translate, rotate and scale; expected at least one",
                                     table.name()));
    for (const Keyframe& before : scene.keyframes)
        if (before.instance == keyframe.instance && !(keyframe.time > before.time))
            table.refuse(
                "time",
                fmt::format("{}.time is {}; expected more than {}, the time of the previous keyframe of {}",
                            table.name(), keyframe.time, before.time, name));
    table.finish();
    return keyframe;
}

// Returns the tables of an array such as [[instances]].
std::vector<TomlTable> tables_of(const toml::array& list, const std::string& name, TomlFile& file) {
    std::vector<TomlTable> tables;
    for (std::size_t i = 0; i < list.size(); ++i) {
        const toml::table* table = list.get(i)->as_table();
        if (table != nullptr)
            tables.emplace_back(*table, fmt::format("{}[{}]", name, i), file);
        else
            file.refuse(list.get(i)->source(),
                        fmt::format("{0}[{1}] is not a table; expected [[{0}]]", name, i));
    }
    return tables;
}

// Returns the members of a table of tables in the order of the file; toml++ sorts them by name.
std::vector<std::pair<std::string, const toml::table*>> parts_in_order(const toml::table& table,
                                                                       const std::string& name,
                                                                       TomlFile& file) {
    struct Part {
        toml::source_position position;
        std::string name;
        const toml::table* table;
    };
    std::vector<Part> parts;
    for (const auto& [key, value] : table) {
        if (const toml::table* part = value.as_table())
            parts.push_back({key.source().begin, std::string(key.str()), part});
        else
            file.refuse(value.source(), fmt::format("{}.{} is not a table; expected [{}.{}]", name, key.str(),
                                                    name, key.str()));
    }
    std::ranges::sort(parts, [](const Part& a, const Part& b) { return a.position < b.position; });
    std::vector<std::pair<std::string, const toml::table*>> result;
    for (Part& part : parts) result.emplace_back(std::move(part.name), part.table);
    return result;
}

}  // namespace

Result<Scene> read_scene(const std::filesystem::path& path) {
    HF_TRY(const toml::table parsed, read_toml(path));
    return scene_of_tables(parsed, {path.string(), path.stem().string(), path.parent_path(), nullptr});
}

Result<Scene> scene_of_tables(const toml::table& tables, const TablesOrigin& origin) {
    Scene scene;
    scene.name = origin.scene_name;
    scene.given = origin.given;
    const std::filesystem::path& folder = origin.folder;
    std::set<std::string> given_names;
    if (origin.given) given_names = names_of(*origin.given);
    TomlFile file{origin.where, std::nullopt, &given_names};
    TomlTable root(tables, "", file);
    for (const char* key : {"entities", "instances"}) root.require(key);

    root.take("assumed_gamma", scene.assumed_gamma, {0.1, 10});
    std::uint32_t bounces = 0;
    root.take("bounces", bounces, {0, any_bounces});
    if (root.has("bounces")) scene.bounces = static_cast<int>(bounces);
    scene.finds_camera = true;
    if (const toml::table* camera = root.take_table("camera"))
        scene.finds_camera = !take_camera(TomlTable(*camera, "camera", file), scene.camera);
    if (const toml::table* environment = root.take_table("environment"))
        take_environment(TomlTable(*environment, "environment", file), folder, scene.environment);
    if (const toml::table* materials = root.take_table("materials"))
        for (const auto& [name, material] : parts_in_order(*materials, "materials", file))
            scene.materials[name] = parsed_material(TomlTable(*material, "materials." + name, file), folder);
    // Something must emit light.
    if (!root.has("lights") && !scene.emits()) {
        root.require("environment");
        if (!scene.environment.lights)
            root.refuse("environment",
                        "environment.lights is false; expected true, or [[lights]] or emissive materials");
    }
    if (const toml::table* entities = root.take_table("entities"))
        for (const auto& [name, entity] : parts_in_order(*entities, "entities", file)) {
            if (!is_file_name(name))
                file.refuse(entity->source(), "found an invalid entity name; expected a valid file name");
            scene.entities.push_back(
                parsed_entity(TomlTable(*entity, "entities." + name, file), name, folder, scene.materials));
        }
    if (const toml::array* instances = root.take_array("instances")) {
        if (instances->empty()) root.refuse("instances", "instances is empty; expected at least one");
        for (TomlTable& instance : tables_of(*instances, "instances", file))
            scene.instances.push_back(parsed_instance(std::move(instance), scene.entities, scene.instances));
    }
    if (const toml::table* povray = root.take_table("povray"))
        scene.surroundings = parsed_surroundings(TomlTable(*povray, "povray", file), folder);
    const toml::array* lamps = root.take_array("lights");
    const toml::array* filters = root.take_array("filters");
    const toml::array* keyframes = root.take_array("keyframes");
    root.finish();
    if (file.error) return *file.error;
    name_instances(scene);
    if (lamps != nullptr)
        for (TomlTable& lamp : tables_of(*lamps, "lights", file))
            scene.lamps.push_back(parsed_lamp(std::move(lamp), scene.instances, scene.lamps));
    if (filters != nullptr)
        for (TomlTable& filter : tables_of(*filters, "filters", file))
            scene.filters.push_back(parsed_filter(std::move(filter), folder));
    if (keyframes != nullptr)
        for (TomlTable& keyframe : tables_of(*keyframes, "keyframes", file)) {
            if (keyframe.has("light"))
                scene.lamp_keyframes.push_back(
                    parsed_lamp_keyframe(std::move(keyframe), scene.lamps, scene.lamp_keyframes));
            else
                scene.keyframes.push_back(parsed_keyframe(std::move(keyframe), scene));
        }
    if (file.error) return *file.error;
    return scene;
}

}  // namespace haarfield
