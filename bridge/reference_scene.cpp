#include "bridge/reference_scene.h"

#include "fields/file/write_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace haarfield {
namespace {

constexpr double wanted_radius = 64;      // POV-Ray units: far above its shadow tolerance, 1e-3
constexpr double largest_distance = 1e6;  // POV-Ray units: below its limit for rays, 1e7
constexpr float dimmest_tint = 1e-4f;     // of a highlight's strongest channel

bool is_grey(const Rgb& colour) {
    return colour.x == colour.y && colour.y == colour.z;
}

/// What pigment is to be multiplied with to give the diffuse albedo.
float diffuse_share(const Material& material) {
    float share = 0;
    for (int c = 0; c < 3; ++c)
        if (material.pigment[c] > 0) share = std::max(share, material.diffuse[c] / material.pigment[c]);
    return share;
}

/// A material as a POV-Ray texture.
///
/// POV-Ray's highlight has the colour of the light, or of the pigment if it is metallic. To give it another,
/// it lies under a layer that shines by nothing itself and lets the tint through; what is diffuse below that
/// layer is divided by the tint. A channel without highlight keeps 1e-4 of the strongest one, so that the
/// division is defined.
std::string texture_text(const Material& material) {
    const bool physical = material.convention == LobeConvention::physical, grey = is_grey(material.specular);
    const float strongest = std::max({material.specular.x, material.specular.y, material.specular.z});
    const float phong = strongest * (physical ? 0.5f * (material.shininess + 2) : material.phong),
                blinn = physical ? 0 : strongest * material.blinn,
                metallic = physical ? 0 : material.metallic;
    Rgb tint(1, 1, 1), pigment = metallic > 0 ? material.pigment : material.diffuse;
    if (!grey)
        for (int c = 0; c < 3; ++c) {
            tint[c] = std::max(material.specular[c] / strongest, dimmest_tint);
            pigment[c] /= tint[c];
        }
    std::string text =
        fmt::format("texture {{ pigment {{ rgb {} }} finish {{ ambient 0 emission 0 diffuse {}",
                    povray_vector(pigment), metallic > 0 ? diffuse_share(material) : 1);
    if (phong > 0) text += fmt::format(" phong {} phong_size {}", phong, material.shininess);
    if (blinn > 0) text += fmt::format(" specular {} roughness {}", blinn, material.roughness);
    if (metallic > 0) text += fmt::format(" metallic {}", metallic);
    text += " } }";
    if (!grey)
        text += fmt::format(
            "\n  texture {{ pigment {{ rgbf <{}, {}, {}, 1> }} finish {{ ambient 0 emission 0 diffuse 0 }} "
            "}}",
            tint.x, tint.y, tint.z);
    return text;
}

/// Whether POV-Ray can show a metallic material: its pigment gives both diffuse and highlights their colour.
bool has_metals_colours(const Material& material) {
    if (!is_grey(material.specular)) return false;
    const Rgb diffuse = material.pigment * diffuse_share(material);
    for (int c = 0; c < 3; ++c)
        if (!(std::abs(diffuse[c] - material.diffuse[c]) <= 1e-5f)) return false;
    return true;
}

Result<Done> check_materials(const ReferenceInstance& instance, const std::string& where) {
    for (std::size_t k = 0; k < instance.materials.size(); ++k) {
        const Material& material = instance.materials[k];
        const auto refused = [&](const char* what, float value, const char* wanted) {
            return Error{where, fmt::format("material {} has {} {}; wanted {}", k, what, value, wanted)};
        };
        const auto in = [](float value, double lowest, double highest) {  // refuses NaN too
            return value >= lowest && value <= highest;
        };
        for (int c = 0; c < 3; ++c) {
            if (!in(material.diffuse[c], 0, largest_distance))
                return refused("diffuse", material.diffuse[c], "0 or more");
            if (!in(material.specular[c], 0, largest_distance))
                return refused("specular", material.specular[c], "0 or more");
            if (!in(material.pigment[c], 0, 1)) return refused("pigment", material.pigment[c], "[0, 1]");
        }
        if (!in(material.shininess, 1e-6, 1e6)) return refused("shininess", material.shininess, "above 0");
        if (!in(material.phong, 0, 1e6)) return refused("phong", material.phong, "0 or more");
        if (!in(material.blinn, 0, 1e6)) return refused("blinn", material.blinn, "0 or more");
        if (!in(material.roughness, 1e-6, 1e6)) return refused("roughness", material.roughness, "above 0");
        if (!in(material.metallic, 0, 1)) return refused("metallic", material.metallic, "[0, 1]");
        if (material.metallic > 0 && !has_metals_colours(material))
            return Error{
                where,
                fmt::format("material {} is metallic; wanted white highlights and a diffuse colour that "
                            "is a multiple of the pigment",
                            k)};
    }
    for (std::uint16_t index : instance.mesh->vertex_materials)
        if (index >= instance.materials.size())
            return Error{where,
                         fmt::format("the mesh uses material {} of {}", index, instance.materials.size())};
    return Done{};
}

Result<Done> check_instances(std::span<const ReferenceInstance> instances) {
    std::set<std::string_view> names;
    for (const ReferenceInstance& instance : instances) {
        assert(instance.mesh);
        const std::string where = "instance " + instance.name;
        if (Result<Done> good = check_povray_mesh(*instance.mesh, where); !good) return good.error();
        if (instance.mesh->normals.size() != instance.mesh->positions.size() ||
            instance.mesh->vertex_materials.size() != instance.mesh->positions.size())
            return Error{where, "normals or materials are missing for some vertices"};
        for (std::size_t i = 0; i < instance.mesh->normals.size(); ++i)
            if (!is_finite(instance.mesh->normals[i]))
                return Error{where, fmt::format("the normal of vertex {} is not finite", i)};
        if (Result<Done> good = check_materials(instance, where); !good) return good.error();
        if (Result<Done> good = check_placement(where, instance.placement); !good) return good.error();
        if (!names.insert(instance.name).second) return Error{where, "there are two of this name"};
    }
    return Done{};
}

std::string mesh_text(const ReferenceInstance& instance, const std::string& object) {
    const Mesh& mesh = *instance.mesh;
    const double magnified = small_triangle_scale(mesh);
    std::string text;
    auto out = std::back_inserter(text);
    fmt::format_to(out,
                   "// For the ray tracer: {0} vertices, {1} triangles; metres.\n"
                   "#ifndef ({2}_Included)\n#declare {2}_Included = 1;\n"
                   "#declare {2}_Version = version;\n#version 3.7;\n\n",
                   mesh.positions.size(), mesh.triangles.size(), object);
    for (std::size_t k = 0; k < instance.materials.size(); ++k)
        fmt::format_to(out, "#declare {}_Material_{} =\n  {}\n", object, k,
                       texture_text(instance.materials[k]));
    fmt::format_to(out, "#declare {} = mesh2 {{\n", object);
    append_povray_vectors(text, "vertex_vectors", mesh.positions, static_cast<float>(magnified));
    append_povray_vectors(text, "normal_vectors", mesh.normals);
    fmt::format_to(out, "texture_list {{ {}", instance.materials.size());
    for (std::size_t k = 0; k < instance.materials.size(); ++k)
        fmt::format_to(out, ", texture {{ {}_Material_{} }}", object, k);
    fmt::format_to(out, " }}\nface_indices {{ {}", mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles)  // the corners of a triangle agree in material
        fmt::format_to(out, ",\n<{},{},{}>,{}", a, b, c, mesh.vertex_materials[a]);
    fmt::format_to(out, " }}\nscale {:.17g}\n}}\n\n#version {}_Version;\n#end\n", 1 / magnified, object);
    return text;
}

/// A power of two by which the world is magnified, so that the median object has wanted_radius or
/// somewhat more, and everything is near enough for POV-Ray's rays.
double chosen_world_scale(std::span<const ReferenceInstance> instances, const Camera& camera,
                          double& extent) {
    std::vector<double> radii;
    extent = Vec3d(camera.position).length();
    for (const ReferenceInstance& instance : instances) {
        const Bounds bounds = mesh_bounds(*instance.mesh);
        const double radius = double(instance.placement.scale) * bounds.radius();
        const Vec3d centre = instance.placement.point_to_world(Vec3d(bounds.centre()));
        radii.push_back(radius);
        extent = std::max(extent, centre.length() + radius);
    }
    if (radii.empty()) return 1;
    std::nth_element(radii.begin(), radii.begin() + radii.size() / 2, radii.end());
    const double median = radii[radii.size() / 2];
    double exponent = median > 0 ? std::ceil(std::log2(wanted_radius / median)) : 0;
    if (extent > 0) exponent = std::min(exponent, std::floor(std::log2(largest_distance / extent)));
    return std::exp2(std::clamp(exponent, -40.0, 40.0));
}

void add_warnings(std::vector<std::string>& warnings, std::span<const ReferenceInstance> instances) {
    std::set<std::string> said;
    for (const ReferenceInstance& instance : instances)
        for (const Material& material : instance.materials)
            if (material.convention == LobeConvention::physical && luminance(material.specular) > 0)
                said.insert(fmt::format(
                    "POV-Ray has no cosine on highlights: the physical one of shininess {} is written as "
                    "phong {} "
                    "and will be too bright at grazing light",
                    material.shininess, luminance(material.specular) * 0.5f * (material.shininess + 2)));
    warnings.assign(said.begin(), said.end());
}

}  // namespace

Result<ReferenceFiles> write_reference_scene(const std::filesystem::path& folder,
                                             const std::string& scene_name, const Camera& camera,
                                             std::span<const ReferenceInstance> instances,
                                             const Environment& environment, int lights) {
    assert(lights >= 16);
    if (!is_scene_name(scene_name))
        return Error{scene_name, "is no scene name; wanted letters, digits, _, - and ."};
    if (Result<Done> good = check_instances(instances); !good) return good.error();

    ReferenceFiles files;
    double extent = 0;
    files.world_scale = chosen_world_scale(instances, camera, extent);
    const Result<std::string> camera_text = povray_camera(camera, files.world_scale);
    if (!camera_text) return camera_text.error();
    if (Result<Done> made = make_folder(folder); !made) return made.error();
    const LatLongImage background = image_with_suns(environment);
    const Result<std::string> background_text = write_background(folder, scene_name, {&background});
    if (!background_text) return background_text.error();
    add_warnings(files.warnings, instances);

    std::string text = fmt::format(
        "// {0}: the reference for haarfield's baked scene, lit by a dome of parallel lights.\n"
        "// povray +I{0}.pov +W{1} +H{2} +A0.0 +AM1 +R3 -J\n"
        "// One metre is {3} units: POV-Ray's shadows ignore what is nearer than 1e-3 units.\n"
        "#version 3.7;\n"
        "global_settings {{ assumed_gamma 1 adc_bailout 0 }}\n"
        "#ifdef ({7})\n"
        "// The background's light alone: one bounce, as fine as POV-Ray can.\n"
        "global_settings {{ radiosity {{ recursion_limit 1 brightness 1 gray_threshold 0 normal on\n"
        "  pretrace_start 0.08 pretrace_end 0.01 count 1600 error_bound 0.1 nearest_count 10\n"
        "  minimum_reuse 0.004 }} }}\n"
        "#end\n\n{4}\n{5}\n"
        "#ifndef ({6})\n",
        scene_name, camera.width, camera.height, files.world_scale, *camera_text, *background_text,
        background_alone, by_radiosity);

    using Shared = std::pair<const Mesh*, const Material*>;
    std::map<Shared, std::size_t> mesh_number;
    std::string objects;
    for (const ReferenceInstance& instance : instances) {
        const auto [entry, is_new] =
            mesh_number.emplace(Shared{instance.mesh, instance.materials.data()}, mesh_number.size());
        const std::string object = fmt::format("{}_Mesh_{}", povray_identifier(scene_name), entry->second);
        if (is_new) {
            files.includes.push_back(folder / fmt::format("{}_mesh_{}.inc", scene_name, entry->second));
            if (Result<Done> written = write_file(files.includes.back(), mesh_text(instance, object));
                !written)
                return written.error();
            text += fmt::format("#include \"{}\"\n", files.includes.back().filename().string());
        }
        const Vec3d translate = Vec3d(instance.placement.translate) * files.world_scale;
        const Rotation& rotate = instance.placement.rotate;
        const std::string turned = is_identity(rotate) ? "" : " " + povray_rotation(rotate);
        objects +=
            fmt::format("object {{ {}{} scale {:.17g} translate <{:.12g}, {:.12g}, {:.12g}> }}  // {}\n",
                        object, turned, instance.placement.scale * files.world_scale, translate.x,
                        translate.y, translate.z, povray_identifier(instance.name));
    }
    text += "\n" + objects + "\n";

    const double distance = std::max(1e4, 8 * extent * files.world_scale);  // outside of everything
    text += fmt::format(
        "// Two sets of lights, each of which is the whole environment: alone, one is twice as bright.\n"
        "#declare Share = 0.5;\n#ifdef ({0}) #declare Share = 1; #end\n#ifdef ({1}) #declare Share = 1; "
        "#end\n",
        first_lights_alone, second_lights_alone);
    for (const auto& [switched_off_by, cut_share] :
         {std::pair(second_lights_alone, 0.5), std::pair(first_lights_alone, 0.4)}) {
        text += fmt::format("#ifndef ({})\n", switched_off_by);
        for (const DirectionalLight& light :
             light_dome(environment, {.lights = lights / 2, .cut_share = cut_share})) {
            const Vec3d place = Vec3d(light.direction) * distance;
            const Rgb colour = light.irradiance * static_cast<float>(1 / pi);
            text += fmt::format(
                "light_source {{ <{:.9g},{:.9g},{:.9g}> rgb Share*<{:.7g},{:.7g},{:.7g}> parallel point_at 0 "
                "}}\n",
                place.x, place.y, place.z, colour.x, colour.y, colour.z);
            ++files.lights;
        }
        text += "#end\n";
    }
    text += "#end\n";
    files.scene = folder / (scene_name + ".pov");
    if (Result<Done> written = write_file(files.scene, text); !written) return written.error();
    return files;
}

}  // namespace haarfield
