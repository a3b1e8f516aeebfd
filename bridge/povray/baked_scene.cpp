#include "bridge/povray/baked_scene.h"

#include "bridge/povray/textured_mesh.h"
#include "fields/file/write_file.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>
#include <set>

namespace haarfield {
namespace {

/// Returns the declarations of the images on an instance's surfaces.
std::string image_declarations(const BakedInstance& instance, const TextureFiles& textures) {
    std::string text;
    std::set<const Texture*> declared;
    for (const Surface& surface : instance.surfaces)
        if (surface.texture && declared.insert(surface.texture.get()).second)
            text += textures.at(surface.texture.get()).text;
    return text;
}

/// Returns the include file of one object. The comment at its top is the object's manual.
///
/// declarations  text that precedes the mesh.
std::string include_text(const BakedInstance& instance, const std::string& declarations,
                         const std::string& mesh, std::size_t textures, const std::string& object,
                         const std::string& file_name, double assumed_gamma) {
    std::string text = fmt::format(
        "// {0}: {1}, baked to vertex colours by haarfield.\n"
        "// {2} vertices, {3} triangles, {4} textures; {9}, {6}, +y up, metres.\n"
        "//\n"
        "// Use it in your scene:\n"
        "//     #version 3.7;\n"
        "//     global_settings {{ assumed_gamma {8:.6g} adc_bailout 0 }}\n"
        "//     #include \"{0}\"\n"
        "//     object {{ {1} }}\n"
        "// Without adc_bailout 0, POV-Ray drops the dark corners of triangles. The colours are the light\n"
        "// that the object sends to the camera of the bake; your lights do not change them.\n"
        "// The object stands where it is in the baked scene. Translate, rotate and scale it freely.\n"
        "{7}"
        "// After `#declare {1}_In_Place = 1;`, the #include places the object itself instead of declaring\n"
        "// it, which needs a third less memory.\n\n"
        "#ifndef ({1}_Included)\n"
        "#declare {1}_Included = 1;\n"
        "#declare {1}_Version = version;\n"
        "#version 3.7;\n\n"
        "#declare {1}_Finish = finish {{ emission 1 ambient 0 diffuse 0 }}\n"
        "{5}"
        "#ifndef ({1}_In_Place) #declare {1} = #end\n",
        file_name, object, instance.mesh->positions.size(), instance.mesh->triangles.size(), textures,
        declarations, instance.left_handed ? "left-handed" : "right-handed",
        instance.left_handed
            ? "// Its coordinates are those of the POV-Ray file of its mesh: do not mirror it.\n"
            : "// For a left-handed camera (POV-Ray's usual one) add: scale <1, 1, -1>.\n",
        assumed_gamma,
        assumed_gamma == 1 ? "linear radiance"
                           : fmt::format("radiance to the power of 1 / {:.6g}", assumed_gamma));
    text += mesh;
    if (!is_identity(instance.placement.rotate)) text += povray_rotation(instance.placement.rotate) + "\n";
    fmt::format_to(std::back_inserter(text),
                   "scale {:.9g}\n"
                   "translate {}\n"
                   "}}\n\n"
                   "#version {}_Version;\n"
                   "#end\n",
                   instance.placement.scale, povray_vector(instance.placement.translate), object);
    return text;
}

/// Writes the include of an instance, and its atlas if it has one. Returns the number of clamped vertices.
Result<std::uint64_t> write_include(const BakedInstance& instance, const std::string& object,
                                    const std::filesystem::path& file, const TextureFiles& textures,
                                    double assumed_gamma) {
    const std::string name = file.filename().string();
    std::vector<Surface> surfaces(instance.surfaces.begin(), instance.surfaces.end());
    if (!instance.shows_reflection)
        for (Surface& surface : surfaces) surface.reflection = {};
    if (has_textures(surfaces)) {
        const TexturedMesh textured =
            textured_mesh(*instance.mesh, surfaces, instance.radiance, instance.added, textures,
                          maps_light(instance.radiance, instance.added), object, file.stem().string(),
                          instance.placement.scale);
        std::string declarations = image_declarations(instance, textures);
        if (textured.mapped) {
            declarations += textured.mapped->declarations();
            HF_TRY_DONE(textured.mapped->write(file.parent_path()));
        }
        const std::string text = include_text(instance, declarations, textured.text, textured.textures,
                                              object, name, assumed_gamma);
        HF_TRY_DONE(write_file(file, with_gamma(text, assumed_gamma)));
        return textured.clamped_vertices;
    }
    const std::filesystem::path atlas = std::filesystem::path(file).replace_extension(".exr");
    const ColouredMesh coloured =
        coloured_mesh(*instance.mesh, instance.radiance,
                      any_reflects(surfaces) ? ColourStorage::atlas : colour_storage(instance.radiance),
                      object + "_Finish", atlas.filename().string(), surfaces);
    if (!coloured.atlas.pixels.empty()) HF_TRY_DONE(write_image(coloured.atlas, atlas));
    const std::string text =
        include_text(instance, "", coloured.text, coloured.textures, object, name, assumed_gamma);
    HF_TRY_DONE(write_file(file, with_gamma(text, assumed_gamma)));
    return coloured.clamped_vertices;
}

Result<Done> check_instance(const BakedInstance& instance) {
    assert(instance.mesh);
    const std::string where = "instance " + instance.name;
    HF_TRY_DONE(check_povray_mesh(*instance.mesh, where));
    if (instance.radiance.size() != instance.mesh->positions.size())
        return Error{where, fmt::format("found {} radiance values; expected one for each of the {} vertices",
                                        instance.radiance.size(), instance.mesh->positions.size())};
    for (std::size_t i = 0; i < instance.radiance.size(); ++i)
        if (!is_finite(instance.radiance[i]))
            return Error{where, fmt::format("the radiance of vertex {} is not finite", i)};
    if (!instance.added.empty() && instance.added.size() != instance.radiance.size())
        return Error{where, fmt::format("found {} specular values; expected one for each of the {} vertices",
                                        instance.added.size(), instance.radiance.size())};
    for (std::size_t i = 0; i < instance.added.size(); ++i)
        if (!is_finite(instance.added[i]))
            return Error{where, fmt::format("the specular radiance of vertex {} is not finite", i)};
    for (const VertexValues& pass : instance.passes) {
        if (pass.values.size() != instance.mesh->positions.size())
            return Error{where, fmt::format("found {} values of {}; expected one for each of the {} vertices",
                                            pass.values.size(), pass.name, instance.mesh->positions.size())};
        for (std::size_t i = 0; i < pass.values.size(); ++i)
            if (!is_finite(pass.values[i]))
                return Error{where, fmt::format("{} of vertex {} is not finite", pass.name, i)};
    }
    if (has_textures(instance.surfaces) && instance.mesh->uvs.size() != instance.mesh->positions.size())
        return Error{where, "has a texture but no texture coordinates"};
    return check_placement(where, instance.placement);
}

}  // namespace

Result<Done> check_baked_instances(std::span<const BakedInstance> instances) {
    std::set<std::string_view> names;
    for (const BakedInstance& instance : instances) {
        HF_TRY_DONE(check_instance(instance));
        assert(std::ranges::equal(instance.passes, instances.front().passes, {}, &VertexValues::name,
                                  &VertexValues::name));
        if (!names.insert(instance.name).second)
            return Error{"instance " + instance.name, "two instances have this name; expected unique names"};
    }
    return Done{};
}

Result<BakedFiles> write_baked_scene(const std::filesystem::path& folder, const std::string& scene_name,
                                     const Camera& camera, std::span<const BakedInstance> instances,
                                     const BackgroundDescription& background) {
    if (!is_scene_name(scene_name))
        return Error{scene_name, "is not a valid scene name; expected letters, digits, _, - and ."};
    HF_TRY_DONE(check_baked_instances(instances));
    HF_TRY(const std::string camera_text, povray_camera(camera));
    HF_TRY_DONE(make_folder(folder));
    BackgroundDescription reflected = background;
    reflected.is_reflected = std::ranges::any_of(instances, [](const BakedInstance& instance) {
        return instance.shows_reflection && any_reflects(instance.surfaces);
    });
    HF_TRY(const std::string background_text, write_background(folder, scene_name, reflected));

    BakedFiles files;
    std::vector<std::string> names;
    for (const BakedInstance& instance : instances) names.push_back(instance.name);
    files.objects = povray_object_names(scene_name, names);
    const std::size_t prefix = povray_identifier(scene_name).size() + 1;
    for (const std::string& object : files.objects)
        files.includes.push_back(folder / (scene_name + "_" + object.substr(prefix) + ".inc"));

    HF_TRY(const TextureFiles textures, write_textures(folder, scene_name, textures_of(instances)));
    files.images = files_of(textures);

    std::vector<std::optional<Error>> errors(instances.size());
    std::vector<std::uint64_t> clamped(instances.size());
    tbb::parallel_for(std::size_t{0}, instances.size(), [&](std::size_t i) {
        const Result<std::uint64_t> written = write_include(instances[i], files.objects[i], files.includes[i],
                                                            textures, background.assumed_gamma);
        if (written)
            clamped[i] = *written;
        else
            errors[i] = written.error();
    });
    for (const auto& error : errors)
        if (error) return *error;
    for (std::uint64_t count : clamped) files.clamped_vertices += count;

    std::string text = fmt::format(
        "// {0}: baked by haarfield; no lights are needed.\n"
        "// povray +I{0}.pov +W{1} +H{2} +A0.0 +AM1 +R3 -J\n"
        "#version 3.7;\n"
        "global_settings {{ assumed_gamma {6:.6g} adc_bailout 0 max_trace_level 100 }}\n\n{3}\n{4}\n"
        "#ifndef ({5})\n",
        scene_name, camera.width, camera.height, camera_text, background_text, background_only,
        background.assumed_gamma);
    // The instances are placed directly: POV-Ray copies a declared object with all its textures at each use.
    for (std::size_t i = 0; i < instances.size(); ++i)
        text += fmt::format("#declare {1}_In_Place = 1;\n#include \"{0}\"\n",
                            files.includes[i].filename().string(), files.objects[i]);
    text += "#end\n";
    files.scene = folder / (scene_name + ".pov");
    HF_TRY_DONE(write_file(files.scene, text));
    return files;
}

}  // namespace haarfield
