#include "bridge/baked_scene.h"

#include "bridge/image.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>
#include <set>
#include <unordered_map>

namespace haarfield {
namespace {

constexpr float largest_radiance = 65000;  // POV-Ray keeps colours as floats, but its EXR holds halves

struct ColourHash {
    std::size_t operator()(const std::array<float, 3>& c) const {
        std::size_t hash = 0;
        for (float channel : c) hash = (hash ^ std::bit_cast<std::uint32_t>(channel)) * 0x9e3779b97f4a7c15u;
        return hash ^ (hash >> 29);
    }
};

/// The colours of an instance, each once, in the order of their first vertex.
struct Palette {
    std::vector<std::array<float, 3>> colours;
    std::vector<std::uint32_t> of_vertex;
    std::uint64_t clamped = 0;
};

Palette palette(std::span<const Rgb> radiance) {
    Palette result;
    result.of_vertex.reserve(radiance.size());
    std::unordered_map<std::array<float, 3>, std::uint32_t, ColourHash> number;
    for (const Rgb& value : radiance) {
        std::array<float, 3> colour;
        for (int c = 0; c < 3; ++c) colour[c] = std::clamp(value[c], 0.0f, largest_radiance) + 0.0f;
        if (Rgb(colour[0], colour[1], colour[2]) != value) ++result.clamped;
        const auto [entry, is_new] =
            number.emplace(colour, static_cast<std::uint32_t>(result.colours.size()));
        if (is_new) result.colours.push_back(colour);
        result.of_vertex.push_back(entry->second);
    }
    return result;
}

/// The include file of one object. The usage comment stands first: it is the manual.
std::string include_text(const BakedInstance& instance, const Palette& colours, const std::string& object,
                         const std::string& file_name) {
    const Mesh& mesh = *instance.mesh;
    const double magnified = small_triangle_scale(mesh);
    const std::array<Vec3d, 3> rotation = interpolation_rotation(mesh);
    std::vector<Vec3f> positions;
    for (const Vec3f& p : mesh.positions)
        positions.emplace_back(
            Vec3d(rotation[0].dot(Vec3d(p)), rotation[1].dot(Vec3d(p)), rotation[2].dot(Vec3d(p))) +
            Vec3d(0.0));
    std::string text;
    text.reserve(64 * (mesh.positions.size() + mesh.triangles.size() + colours.colours.size()));
    auto out = std::back_inserter(text);
    fmt::format_to(
        out,
        "// {0}: {1}, baked to vertex colours by haarfield.\n"
        "// {2} vertices, {3} triangles, {4} colours; linear radiance, right-handed, +y up, metres.\n"
        "//\n"
        "// In a scene of your own:\n"
        "//     #version 3.7;\n"
        "//     global_settings {{ assumed_gamma 1 adc_bailout 0 }}\n"
        "//     #include \"{0}\"\n"
        "//     object {{ {1} }}\n"
        "// Without adc_bailout 0, POV-Ray drops the dark corners of triangles. The colours are the\n"
        "// light that the object sends to the camera it was baked for: your lights do not change\n"
        "// them. It has its place in the baked scene; translate, rotate and scale it as you like.\n"
        "// For a left-handed camera (POV-Ray's usual one) add: scale <1, 1, -1>\n\n"
        "#ifndef ({1}_Included)\n"
        "#declare {1}_Included = 1;\n"
        "#declare {1}_Version = version;\n"
        "#version 3.7;\n\n"
        "#declare {1}_Finish = finish {{ emission 1 ambient 0 diffuse 0 }}\n"
        "#declare {1} = mesh2 {{\n",
        file_name, object, mesh.positions.size(), mesh.triangles.size(), colours.colours.size());
    append_povray_vectors(text, "vertex_vectors", positions, static_cast<float>(magnified));
    fmt::format_to(out, "texture_list {{ {}", colours.colours.size());
    for (const auto& c : colours.colours)
        fmt::format_to(out, ",\ntexture{{pigment{{rgb<{:.6g},{:.6g},{:.6g}>}}finish{{{}_Finish}}}}", c[0],
                       c[1], c[2], object);
    fmt::format_to(out, " }}\nface_indices {{ {}", mesh.triangles.size());
    // Three textures a face, or one: with two, POV-Ray 3.7 crashes.
    for (const auto& triangle : mesh.triangles) {
        const auto& [a, b, c] = triangle;
        fmt::format_to(out, ",\n<{},{},{}>,{}", a, b, c, colours.of_vertex[a]);
        if (!is_sliver(mesh, triangle, magnified))
            fmt::format_to(out, ",{},{}", colours.of_vertex[b], colours.of_vertex[c]);
    }
    // The vertices are magnified and turned so that POV-Ray's interpolation is exact.
    fmt::format_to(
        out,
        " }}\n"
        "matrix <{:.17g},{:.17g},{:.17g}, {:.17g},{:.17g},{:.17g}, {:.17g},{:.17g},{:.17g}, 0,0,0>\n"
        "scale {:.17g}\n"
        "translate {}\n"
        "}}\n\n"
        "#version {}_Version;\n"
        "#end\n",
        rotation[0].x, rotation[0].y, rotation[0].z, rotation[1].x, rotation[1].y, rotation[1].z,
        rotation[2].x, rotation[2].y, rotation[2].z, static_cast<double>(instance.scale) / magnified,
        povray_vector(instance.translate), object);
    return text;
}

Result<Done> check_instance(const BakedInstance& instance) {
    assert(instance.mesh);
    const std::string where = "instance " + instance.name;
    if (Result<Done> good = check_povray_mesh(*instance.mesh, where); !good) return good.error();
    if (instance.radiance.size() != instance.mesh->positions.size())
        return Error{where, fmt::format("{} radiance values for {} vertices", instance.radiance.size(),
                                        instance.mesh->positions.size())};
    for (std::size_t i = 0; i < instance.radiance.size(); ++i)
        if (!is_finite(instance.radiance[i]))
            return Error{where, fmt::format("the radiance of vertex {} is not finite", i)};
    return check_placement(where, instance.translate, instance.scale);
}

}  // namespace

Result<Done> check_baked_instances(std::span<const BakedInstance> instances) {
    std::set<std::string_view> names;
    for (const BakedInstance& instance : instances) {
        if (Result<Done> good = check_instance(instance); !good) return good.error();
        if (!names.insert(instance.name).second)
            return Error{"instance " + instance.name, "there are two of this name"};
    }
    return Done{};
}

Result<BakedFiles> write_baked_scene(const std::filesystem::path& folder, const std::string& scene_name,
                                     const Camera& camera, std::span<const BakedInstance> instances,
                                     const BackgroundDescription& background) {
    if (!is_scene_name(scene_name))
        return Error{scene_name, "is no scene name; wanted letters, digits, _, - and ."};
    if (Result<Done> good = check_baked_instances(instances); !good) return good.error();
    const Result<std::string> camera_text = povray_camera(camera);
    if (!camera_text) return camera_text.error();
    if (Result<Done> made = make_folder(folder); !made) return made.error();
    const Result<std::string> background_text = write_background(folder, scene_name, background);
    if (!background_text) return background_text.error();

    BakedFiles files;
    std::vector<std::string> names;
    for (const BakedInstance& instance : instances) names.push_back(instance.name);
    files.objects = povray_object_names(scene_name, names);
    const std::size_t prefix = povray_identifier(scene_name).size() + 1;
    for (const std::string& object : files.objects)
        files.includes.push_back(folder / (scene_name + "_" + object.substr(prefix) + ".inc"));

    std::vector<std::optional<Error>> errors(instances.size());
    std::vector<std::uint64_t> clamped(instances.size());
    tbb::parallel_for(std::size_t{0}, instances.size(), [&](std::size_t i) {
        const Palette colours = palette(instances[i].radiance);
        clamped[i] = colours.clamped;
        const std::string text =
            include_text(instances[i], colours, files.objects[i], files.includes[i].filename().string());
        if (Result<Done> written = write_file(files.includes[i], text); !written) errors[i] = written.error();
    });
    for (const auto& error : errors)
        if (error) return *error;
    for (std::uint64_t count : clamped) files.clamped_vertices += count;

    std::string text = fmt::format(
        "// {0}: baked by haarfield; no lights are needed.\n"
        "// povray +I{0}.pov +W{1} +H{2} +A0.0 +AM1 +R3 -J\n"
        "#version 3.7;\n"
        "global_settings {{ assumed_gamma 1 adc_bailout 0 }}\n\n{3}\n{4}\n"
        "#ifndef ({5})\n",
        scene_name, camera.width, camera.height, *camera_text, *background_text, background_alone);
    // POV-Ray copies an object with all its textures where it is used: the declared one is dropped at once.
    for (std::size_t i = 0; i < instances.size(); ++i)
        text += fmt::format("#include \"{0}\"\nobject {{ {1} }}\n#undef {1}\n",
                            files.includes[i].filename().string(), files.objects[i]);
    text += "#end\n";
    files.scene = folder / (scene_name + ".pov");
    if (Result<Done> written = write_file(files.scene, text); !written) return written.error();
    return files;
}

}  // namespace haarfield
