#include "scenes/scene_writer.h"

#include "scenes/povray_finish.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {
namespace {

/// Returns a basic string of TOML.
std::string toml_string(std::string_view text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\')
            result += std::string("\\") + c;
        else if (static_cast<unsigned char>(c) < 32 || c == 127)
            result += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
        else
            result += c;
    }
    return result + "\"";
}

bool is_bare(std::string_view key) {
    return !key.empty() && std::ranges::all_of(key, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
               c == '-';
    });
}

std::string key_text(std::string_view key) {
    return is_bare(key) ? std::string(key) : toml_string(key);
}

std::string list_of(const Vec3f& v) {
    return fmt::format("[{}, {}, {}]", v.x, v.y, v.z);
}

/// Returns an angle in degrees with six digits.
std::string round_degrees(float radians) {
    return fmt::format("{:.6g}", degrees(radians));
}

std::string path_text(const std::filesystem::path& path, const std::filesystem::path& folder) {
    std::error_code ignored;
    const std::filesystem::path near =
        std::filesystem::proximate(path, folder.empty() ? "." : folder, ignored);
    constexpr int most_steps_up = 3;
    const bool is_far = std::ranges::count(near, std::filesystem::path("..")) > most_steps_up;
    return toml_string(ignored || near.empty() || is_far ? std::filesystem::absolute(path, ignored).string()
                                                         : near.string());
}

std::string camera_text(const Scene& scene) {
    const Camera& camera = scene.camera;
    std::string text = "[camera]\n";
    if (!scene.finds_camera)
        text += fmt::format("position = {}\ntarget = {}\n", list_of(camera.position), list_of(camera.target));
    return text + fmt::format("vertical_fov = {}\nresolution = [{}, {}]\n\n",
                              round_degrees(camera.vertical_fov), camera.width, camera.height);
}

std::string sky_text(const AnalyticSky& sky) {
    return fmt::format(
        "sky = {{ turbidity = {}, sun_elevation = {}, sun_azimuth = {}, sun_angular_radius = {}, ground = {} "
        "}}",
        sky.turbidity, round_degrees(sky.sun_elevation), round_degrees(sky.sun_azimuth),
        round_degrees(sky.sun_angular_radius), list_of(sky.ground));
}

std::string light_text(const std::filesystem::path& image, const std::optional<AnalyticSky>& sky,
                       const std::filesystem::path& folder) {
    return sky ? sky_text(*sky) : fmt::format("image = {}", path_text(image, folder));
}

/// Returns the keys of a rotation: `rotation` if it is about +y alone, else also `rotate`.
std::string turn_text(const EnvironmentDescription& environment) {
    float rotation = environment.rotation;
    std::string rotate;
    if (const Rotation& turn = environment.turn; turn.row[1] == Vec3d(0, 1, 0)) {
        rotation += static_cast<float>(std::atan2(turn.row[0].z, turn.row[0].x));
    } else {
        rotate = fmt::format("rotate = {}\n", list_of(degrees_xyz(turn)));
    }
    // All digits, so that pixels of concentrated lights do not move.
    return (rotation != 0 ? fmt::format("rotation = {}\n", degrees(rotation)) : "") + rotate;
}

std::string environment_text(const EnvironmentDescription& environment, const std::filesystem::path& folder) {
    if (environment.is_black()) return "";
    std::string text = "[environment]\n" + light_text(environment.image, environment.sky, folder) + "\n";
    if (const std::optional<BlendedLight>& blend = environment.blend)
        text += fmt::format("blend = {{ {}, share = {} }}\n", light_text(blend->image, blend->sky, folder),
                            blend->share);
    text += turn_text(environment);
    if (!environment.lights) text += "lights = false\n";
    if (!environment.exposure)
        text += "exposure = \"auto\"\n";
    else if (*environment.exposure != 0)
        text += fmt::format("exposure = {}\n", *environment.exposure);
    return text + "\n";
}

std::string reflection_text(const Reflection& reflection) {
    if (!reflection.is_there()) return "";
    const Rgb &least = reflection.at_normal, &most = reflection.at_grazing;
    if (least == most && reflection.ior == 0 && reflection.metallic == 0 && most == Rgb(most.x))
        return fmt::format("reflection = {}\n", most.x);
    std::string text = fmt::format("reflection = {{ min = {}, max = {}", list_of(least), list_of(most));
    if (reflection.ior > 0) text += fmt::format(", ior = {}", reflection.ior);
    if (reflection.metallic > 0) text += fmt::format(", metallic = {}", reflection.metallic);
    return text + " }\n";
}

std::string material_text(const std::string& name, const SceneMaterial& material,
                          const std::filesystem::path& folder) {
    std::string text = fmt::format("[materials.{}]\n", key_text(name));
    if (const std::optional<FinishKeys> finish = finish_of(material)) {
        std::string parts;
        if (!material.image.empty()) parts += fmt::format("image = {}, ", path_text(material.image, folder));
        if (material.vertex_colours) parts += "vertex_colours = true, ";
        text += parts.empty()
                    ? fmt::format("pigment = {}\n", list_of(material.pigment))
                    : fmt::format("pigment = {{ {}colour = {} }}\n", parts, list_of(material.pigment));
        std::string keys;
        for (const auto& [key, value, matters] : *finish)
            if (matters) keys += fmt::format("{}{} = {}", keys.empty() ? "" : ", ", key, value);
        return text + fmt::format("finish = {{ {} }}\n{}\n", keys, reflection_text(material.reflection));
    }
    text += fmt::format("diffuse = {}\n", list_of(material.diffuse));
    if (material.specular != Rgb(0.0f))
        text +=
            fmt::format("specular = {}\nshininess = {}\n", list_of(material.specular), material.shininess);
    if (material.convention == LobeConvention::povray) text += "convention = \"povray\"\n";
    if (!material.image.empty()) text += fmt::format("image = {}\n", path_text(material.image, folder));
    if (material.vertex_colours) text += "vertex_colours = true\n";
    if (material.emits()) text += fmt::format("emission = {}\n", list_of(material.emission));
    if (material.ambient != Rgb(0.0f)) text += fmt::format("ambient = {}\n", list_of(material.ambient));
    return text + reflection_text(material.reflection) + "\n";
}

std::string entity_text(const Entity& entity, const std::filesystem::path& folder) {
    const Entity plain;
    std::string text =
        fmt::format("[entities.{}]\nmesh = {}\n", key_text(entity.name), path_text(entity.mesh, folder));
    if (!entity.part.empty()) text += fmt::format("part = {}\n", toml_string(entity.part));
    if (!entity.material.empty()) text += fmt::format("material = {}\n", toml_string(entity.material));
    if (!entity.materials.empty()) {
        std::string list;
        for (const auto& [part, material] : entity.materials)
            list +=
                fmt::format("{}{} = {}", list.empty() ? "" : ", ", toml_string(part), toml_string(material));
        text += fmt::format("materials = {{ {} }}\n", list);
    }
    if (entity.faces == ClosedFaces::inwards) text += "faces = \"inwards\"\n";
    const auto number = [&](const char* key, std::uint32_t Entity::*value) {
        if (entity.*value != plain.*value) text += fmt::format("{} = {}\n", key, entity.*value);
    };
    number("fine_vertices", &Entity::fine_vertices);
    number("coarse_triangles", &Entity::coarse_triangles);
    number("planar_samples", &Entity::planar_samples);
    number("spherical_samples", &Entity::spherical_samples);
    return text + "\n";
}

std::string instance_text(const Scene& scene, const Instance& instance) {
    std::string text =
        fmt::format("[[instances]]\nentity = {}\n", toml_string(scene.entities[instance.entity].name));
    if (!instance.name.empty()) text += fmt::format("name = {}\n", toml_string(instance.name));
    const Placement& placement = instance.placement;
    if (instance.shape == Shape()) {
        if (placement.translate != Vec3f(0, 0, 0))
            text += fmt::format("translate = {}\n", list_of(placement.translate));
        if (placement.scale != 1) text += fmt::format("scale = {}\n", placement.scale);
        if (!is_identity(placement.rotate))
            text += fmt::format("rotate = {}\n", list_of(degrees_xyz(placement.rotate)));
        return text + "\n";
    }
    std::string rows;
    for (int r = 0; r < 3; ++r) {
        Vec3d row;
        for (int c = 0; c < 3; ++c) {
            Vec3d axis(0, 0, 0);
            axis[c] = 1;
            row[c] = (placement.rotate(instance.shape(axis)) * double(placement.scale))[r];
        }
        rows += fmt::format("{}[{:.9g}, {:.9g}, {:.9g}, {}]", r == 0 ? "" : ",\n          ", row.x, row.y,
                            row.z, placement.translate[r]);
    }
    return text + fmt::format("matrix = [{}]\n\n", rows);
}

std::string keyframe_text(const Scene& scene, const Keyframe& keyframe) {
    std::string text = fmt::format("[[keyframes]]\ntime = {}\ninstance = {}\n", keyframe.time,
                                   toml_string(scene.instances[keyframe.instance].name));
    if (keyframe.translate) text += fmt::format("translate = {}\n", list_of(*keyframe.translate));
    if (const auto& angles = keyframe.rotate)
        text += fmt::format("rotate = {}\n",
                            list_of({degrees(angles->x), degrees(angles->y), degrees(angles->z)}));
    if (keyframe.scale) text += fmt::format("scale = {}\n", *keyframe.scale);
    return text + "\n";
}

std::string lamp_text(const Scene& scene, const SceneLamp& lamp) {
    const Lamp plain;
    const auto kind = [&] {
        switch (lamp.kind) {
            case LampKind::point: return "point";
            case LampKind::spot: return "spot";
            case LampKind::cylinder: return "cylinder";
            case LampKind::parallel: break;
        }
        return "parallel";
    }();
    std::string text = fmt::format("[[lights]]\nname = {}\nkind = \"{}\"\nposition = {}\n",
                                   toml_string(lamp.name), kind, list_of(lamp.position));
    if (lamp.kind != LampKind::point) text += fmt::format("target = {}\n", list_of(lamp.target));
    text += fmt::format("colour = {}\n", list_of(lamp.colour));
    if (lamp.fade_distance > 0) text += fmt::format("fade_distance = {}\n", lamp.fade_distance);
    if (lamp.fade_power != plain.fade_power) text += fmt::format("fade_power = {}\n", lamp.fade_power);
    if (lamp.kind == LampKind::spot)
        text += fmt::format("radius = {}\nfalloff = {}\n", round_degrees(lamp.radius),
                            round_degrees(lamp.falloff));
    if (lamp.kind == LampKind::cylinder)
        text += fmt::format("radius = {}\nfalloff = {}\n", lamp.radius, lamp.falloff);
    if (lamp.tightness != plain.tightness) text += fmt::format("tightness = {}\n", lamp.tightness);
    if (lamp.area) {
        text +=
            fmt::format("area = {{ across = {}, along = {}, samples = [{}, {}]", list_of(lamp.area->across),
                        list_of(lamp.area->along), lamp.area->columns, lamp.area->rows);
        if (lamp.area->circular) text += ", circular = true";
        if (lamp.area->orient) text += ", orient = true";
        if (lamp.area->illumination) text += ", illumination = true";
        text += " }\n";
    }
    if (lamp.shadowless) text += "shadowless = true\n";
    if (lamp.looks_like && !scene.instances[*lamp.looks_like].name.empty())
        text += fmt::format("looks_like = {}\n", toml_string(scene.instances[*lamp.looks_like].name));
    return text + "\n";
}

std::string filter_text(const SceneFilter& filter, const std::filesystem::path& folder) {
    std::string text = fmt::format("[[filters]]\nmesh = {}\ncolour = {}\n", path_text(filter.mesh, folder),
                                   list_of(filter.colour));
    if (filter.vertex_colours) text += "vertex_colours = true\n";
    if (filter.absorption != Rgb(0.0f)) text += fmt::format("absorption = {}\n", list_of(filter.absorption));
    return text + "\n";
}

std::string povray_text(const Surroundings& surroundings, const std::filesystem::path& folder) {
    std::string text = fmt::format("[povray]\nscene = {}\nup = \"{}\"\nhandedness = \"{}\"\n",
                                   path_text(surroundings.file, folder), surroundings.z_up ? "z" : "y",
                                   surroundings.left_handed ? "left" : "right");
    if (!surroundings.folder.empty())
        text += fmt::format("folder = {}\n", path_text(surroundings.folder, folder));
    return text + "\n";
}

}  // namespace

std::string scene_text(const Scene& scene, const std::filesystem::path& folder, std::string_view comments) {
    std::string text;
    while (!comments.empty()) {
        const std::size_t end = std::min(comments.find('\n'), comments.size());
        text += fmt::format("# {}\n", comments.substr(0, end));
        comments.remove_prefix(std::min(end + 1, comments.size()));
    }
    if (!text.empty()) text += "\n";
    // A scene without any light must say so.
    if (scene.environment.is_black() && scene.lamps.empty() && !scene.emits()) text += "lights = []\n\n";
    if (scene.assumed_gamma != 1) text += fmt::format("assumed_gamma = {:.6g}\n\n", scene.assumed_gamma);
    if (scene.bounces) text += fmt::format("bounces = {}\n\n", *scene.bounces);
    text += camera_text(scene);
    text += environment_text(scene.environment, folder);
    for (const auto& [name, material] : scene.materials) text += material_text(name, material, folder);
    for (const Entity& entity : scene.entities) text += entity_text(entity, folder);
    for (const Instance& instance : scene.instances) text += instance_text(scene, instance);
    for (const Keyframe& keyframe : scene.keyframes) text += keyframe_text(scene, keyframe);
    for (const SceneLamp& lamp : scene.lamps) text += lamp_text(scene, lamp);
    for (const SceneFilter& filter : scene.filters) text += filter_text(filter, folder);
    if (const std::optional<Surroundings>& surroundings = scene.surroundings)
        text += povray_text(*surroundings, folder);
    text.pop_back();
    return text;
}

}  // namespace haarfield
