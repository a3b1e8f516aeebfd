#include "bridge/povray/reference_filters.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>

#include "bridge/povray/povray_scene.h"
#include "fields/file/write_file.h"
#include "scenes/scene_entities.h"

namespace haarfield {
namespace {

/// Returns an interior that absorbs light: POV-Ray's exponential attenuation.
std::string interior_text(const Rgb& absorption, double world_scale) {
    const float most = std::max({absorption.x, absorption.y, absorption.z});
    if (!(most > 0)) return {};
    const Rgb colour = Rgb(1.0f) - absorption / most;
    return fmt::format("interior {{ fade_distance {:.9g} fade_power 1001 fade_color rgb {} }}\n",
                       world_scale / double(most), povray_vector(colour));
}

std::string mesh_text(const FilterMesh& filter) {
    std::map<std::array<float, 3>, std::size_t> textures;
    std::vector<std::size_t> texture_of;
    for (std::size_t t = 0; t < filter.mesh.triangles.size(); ++t) {
        const Rgb& colour = filter.colours[filter.colours.size() > 1 ? t : 0];
        texture_of.push_back(
            textures.emplace(std::array{colour.x, colour.y, colour.z}, textures.size()).first->second);
    }
    std::vector<std::string> texts(textures.size());
    for (const auto& [colour, index] : textures)
        texts[index] = fmt::format(
            "texture {{ pigment {{ rgbf <{:.7g},{:.7g},{:.7g},1> }} finish {{ ambient 0 emission 0 diffuse 0 "
            "}} "
            "}}",
            colour[0], colour[1], colour[2]);
    std::string text = "mesh2 {\n";
    append_povray_vectors(text, "vertex_vectors", filter.mesh.positions);
    fmt::format_to(std::back_inserter(text), "texture_list {{ {},\n{} }}\nface_indices {{ {}", texts.size(),
                   fmt::join(texts, ",\n"), filter.mesh.triangles.size());
    for (std::size_t t = 0; t < texture_of.size(); ++t) {
        const auto& [a, b, c] = filter.mesh.triangles[t];
        fmt::format_to(std::back_inserter(text), ",\n<{},{},{}>,{}", a, b, c, texture_of[t]);
    }
    return text + " }\n";
}

}  // namespace

Result<std::string> write_reference_filters(const std::filesystem::path& folder, const std::string& name,
                                            std::span<const SceneFilter> filters, double world_scale,
                                            std::vector<std::filesystem::path>& includes) {
    std::string statements;
    for (std::size_t k = 0; k < filters.size(); ++k) {
        HF_TRY(const FilterMesh filter, read_filter(filters[k]));
        HF_TRY_DONE(check_povray_mesh(filter.mesh, filters[k].mesh.string()));
        const std::string object = fmt::format("{}_Filter_{}", povray_identifier(name), k);
        const std::string text = fmt::format(
            "// A filter of light: {} triangles; metres.\n#ifndef ({}_Included)\n#declare {}_Included = 1;\n"
            "#declare {} =\n{}{}}}\n#end\n",
            filter.mesh.triangles.size(), object, object, object, mesh_text(filter),
            interior_text(filters[k].absorption, world_scale));
        includes.push_back(folder / fmt::format("{}_filter_{}.inc", name, k));
        HF_TRY_DONE(write_file(includes.back(), text));
        statements += fmt::format("#include \"{}\"\nobject {{ {} no_image no_reflection scale {:.17g} }}\n",
                                  includes.back().filename().string(), object, world_scale);
    }
    return statements;
}

}  // namespace haarfield
