#include "bridge/povray/placed_bake.h"

#include "fields/base/names.h"
#include "fields/file/write_file.h"
#include "scenes/scene_import.h"

#include <fmt/format.h>

#include <set>

namespace haarfield {
namespace {

std::string include_text(const std::string& file_name, const std::string& object, const BakedFiles& files,
                         const std::optional<Surroundings>& surroundings) {
    std::string text = fmt::format(
        "// {0}: a whole bake by haarfield as one object. Use it in {2}:\n"
        "//     global_settings {{ adc_bailout 0 }}\n"
        "//     #include \"{0}\"\n"
        "//     object {{ {1} }}\n"
        "// {3}"
        "#ifndef ({1}_Included)\n"
        "#declare {1}_Included = 1;\n"
        "#declare {1} = {4} {{\n",
        file_name, object, surroundings ? surroundings->file.filename().string() : "your scene",
        surroundings ? "It has the coordinates of that scene.\n\n"
                     : "For a left-handed camera (POV-Ray's usual one) add: scale <1, 1, -1>.\n\n",
        files.objects.size() == 1 ? "object" : "union");
    for (std::size_t i = 0; i < files.objects.size(); ++i)
        text += fmt::format(
            "#ifdef ({0}) object {{ {0} }} #else\n#declare {0}_In_Place = 1;\n#include \"{1}\"\n#end\n",
            files.objects[i], files.includes[i].filename().string());
    if (surroundings) text += matrix_into(*surroundings);
    return text + "}\n#end\n";
}

}  // namespace

std::string matrix_into(const Surroundings& surroundings) {
    // The inverse of a rotation or reflection is its transpose.
    const auto& [x, y, z] = upright_frame(surroundings.z_up, surroundings.left_handed).axes;
    const auto plain = [](double number) { return number == 0 ? 0.0 : number; };  // No -0.
    return fmt::format("matrix <{},{},{}, {},{},{}, {},{},{}, 0,0,0>\n", plain(x.x), plain(y.x), plain(z.x),
                       plain(x.y), plain(y.y), plain(z.y), plain(x.z), plain(y.z), plain(z.z));
}

Result<PlacedBake> write_placed_bake(const std::filesystem::path& folder, const std::string& scene_name,
                                     const BakedFiles& files, const Camera& camera,
                                     const std::optional<Surroundings>& surroundings) {
    assert(!files.objects.empty());
    PlacedBake placed;
    std::set<std::string> taken(files.objects.begin(), files.objects.end());
    const std::string prefix = povray_identifier(scene_name) + "_";
    placed.object = unique_name(prefix + "Baked", taken);
    placed.include = folder / (scene_name + "_" + placed.object.substr(prefix.size()) + ".inc");
    HF_TRY_DONE(write_file(placed.include, include_text(placed.include.filename().string(), placed.object,
                                                        files, surroundings)));
    if (!surroundings) return placed;

    std::error_code code;
    const std::filesystem::path whole = std::filesystem::absolute(surroundings->file).lexically_normal();
    const bool is_taken = std::filesystem::exists(folder / whole.filename(), code);
    const std::string included = is_taken ? whole.string() : whole.filename().string();
    if (included.find('"') != std::string::npos)
        return Error{whole.string(), "POV-Ray accepts no file names with quotation marks"};
    placed.scene = folder / (scene_name + "_in_place.pov");
    const std::string text = fmt::format(
        "// {0} with the baked objects of {1}.\n"
        "// povray +I{1}_in_place.pov +W{2} +H{3} +A0.3 +L<folder of {0}>\n"
        "#include \"{4}\"\n"
        "#include \"{5}\"\n"
        "global_settings {{ adc_bailout 0 }}  // otherwise POV-Ray drops the dark corners of triangles\n"
        "object {{ {6} }}\n",
        whole.filename().string(), scene_name, camera.width, camera.height, included,
        placed.include.filename().string(), placed.object);
    HF_TRY_DONE(write_file(placed.scene, text));
    return placed;
}

}  // namespace haarfield
