#include "tools/model_info.h"

#include <fmt/format.h>

#include <algorithm>

#include "fields/model/mesh_reader.h"
#include "fields/model/model_file.h"
#include "fields/preparation/mesh_preparation.h"
#include "scenes/texture.h"

namespace haarfield {
namespace {

/// A guess of the upward axis, and its reason.
struct UpAxis {
    char axis;
    std::string because;
};

UpAxis up_axis(const std::filesystem::path& file, const Bounds& bounds) {
    const std::string ending = lower_ending(file);
    if (ending == ".glb" || ending == ".gltf") return {'y', "as glTF specifies"};
    const float near = 0.01f * bounds.radius();
    const bool on_y = std::abs(bounds.lower.y) < near, on_z = std::abs(bounds.lower.z) < near;
    if (on_y != on_z) return {on_y ? 'y' : 'z', fmt::format("the model stands on {} = 0", on_y ? 'y' : 'z')};
    if (ending == ".stl") return {'z', "a guess, as in most STL files"};
    return {'y', "a guess"};
}

const char* model_name(MeshMaterial::Model model) {
    switch (model) {
        case MeshMaterial::Model::none: return "name only";
        case MeshMaterial::Model::phong: return "phong";
        case MeshMaterial::Model::metallic: return "metallic-roughness";
        case MeshMaterial::Model::by_colour: return "vertex colours";
    }
    return "";
}

nlohmann::ordered_json vector_json(const Vec3f& v) {
    return {v.x, v.y, v.z};
}

nlohmann::ordered_json image_json(const MeshImage& image) {
    nlohmann::ordered_json json{{"name", image.name}, {"found", image.is_there()}};
    if (!image.is_there()) return json;
    const Result<Texture> texture = read_texture({image, {}, AlphaMode::blend});
    if (!texture) {
        json["error"] = texture.error().message();
        return json;
    }
    json["width"] = texture->width;
    json["height"] = texture->height;
    json["alpha"] = texture->has_alpha;
    return json;
}

nlohmann::ordered_json material_json(const ImportedMesh& imported, std::size_t number) {
    const MeshMaterial& material = imported.materials[number];
    nlohmann::ordered_json json{{"name", imported.mesh.material_names[number]},
                                {"described_by", model_name(material.model)},
                                {"texture_coordinates", bool(imported.mapped[number])},
                                {"vertex_colours", bool(imported.coloured[number])}};
    if (material.model == MeshMaterial::Model::none) return json;
    json["diffuse"] = vector_json(material.diffuse);
    if (material.model == MeshMaterial::Model::phong) {
        json["specular"] = vector_json(material.specular);
        json["exponent"] = material.exponent;
    }
    if (material.model == MeshMaterial::Model::metallic) {
        json["metallic"] = material.metallic;
        json["roughness"] = material.roughness;
    }
    if (material.emission != Rgb(0.0f)) json["emission"] = vector_json(material.emission);
    if (!material.image.name.empty()) json["image"] = image_json(material.image);
    if (!material.opacity_map.name.empty()) json["opacity_map"] = image_json(material.opacity_map);
    return json;
}

std::string image_text(const nlohmann::ordered_json& image) {
    const std::string name = image["name"];
    if (!image["found"]) return fmt::format("{} (not found next to the model)", name);
    if (image.contains("error")) return fmt::format("{} (cannot be read)", name);
    return fmt::format("{} ({} x {}{})", name, image["width"].get<int>(), image["height"].get<int>(),
                       image["alpha"].get<bool>() ? ", with alpha" : "");
}

void print_material(const nlohmann::ordered_json& material, const CommandContext& context) {
    const std::string name = material["name"], described = material["described_by"];
    std::string text = fmt::format("  {:<24} {}", name.empty() ? "(no name)" : name, described);
    if (material.contains("diffuse"))
        text += fmt::format(", diffuse {:.2g} {:.2g} {:.2g}", material["diffuse"][0].get<float>(),
                            material["diffuse"][1].get<float>(), material["diffuse"][2].get<float>());
    if (material.contains("exponent"))
        text += fmt::format(", specular {:.2g}, exponent {:.3g}", material["specular"][0].get<float>(),
                            material["exponent"].get<float>());
    if (material.contains("metallic"))
        text += fmt::format(", metallic {:.2g}, roughness {:.2g}", material["metallic"].get<float>(),
                            material["roughness"].get<float>());
    if (material.contains("emission")) text += ", emits light";
    if (material["vertex_colours"].get<bool>()) text += ", vertex colours";
    for (const char* key : {"image", "opacity_map"})
        if (material.contains(key)) text += ", " + image_text(material[key]);
    context.print("{}\n", text);
}

}  // namespace

Result<ExitCode> print_model(const std::filesystem::path& file, bool json, CommandContext& context) {
    HF_TRY(const ModelFile model, ModelFile::open(file));
    HF_TRY(ImportedMesh imported, read_mesh(model, {}, {.appearance = true}));
    nlohmann::ordered_json report;
    const ModelParts& parts = model.parts();
    const Bounds bounds = mesh_bounds(imported.mesh);
    report["vertices"] = imported.mesh.positions.size();
    report["triangles"] = imported.mesh.triangles.size();
    report["bounds"] = {{"lower", vector_json(bounds.lower)}, {"upper", vector_json(bounds.upper)}};
    const UpAxis up = up_axis(file, bounds);
    report["up"] = {{"axis", std::string(1, up.axis)}, {"because", up.because}};
    report["parts"] = nlohmann::ordered_json::array();
    for (std::size_t part = 0; part < parts.names.size(); ++part) {
        const auto places = std::ranges::count(parts.nodes, part, &ModelNode::part);
        report["parts"].push_back({{"name", parts.names[part]}, {"places", places}});
    }
    report["camera"] = parts.camera.has_value();
    report["materials"] = nlohmann::ordered_json::array();
    for (std::size_t m = 0; m < imported.materials.size(); ++m)
        report["materials"].push_back(material_json(imported, m));
    report["not_used"] = imported.unused;
    const Result<PreparedMesh> prepared = prepare_mesh(std::move(imported), {}, context.progress);
    if (!prepared) return Error{file.string(), prepared.error().message()};
    const MeshFindings& findings = prepared->findings;
    report["findings"] = findings.summary();
    report["open_edges"] = findings.boundary_edges;
    report["pieces"] = findings.components;
    report["sheet_triangles"] = findings.backs;
    report["self_intersecting"] = findings.self_intersecting;
    context.report["model"] = report;
    if (json) {
        print(stdout, "{}\n", report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
        return ExitCode::done;
    }
    const Vec3f size = bounds.upper - bounds.lower;
    context.print("model       {} vertices, {} triangles in {} pieces\n",
                  report["vertices"].get<std::size_t>(), report["triangles"].get<std::size_t>(),
                  findings.components);
    context.print("size        {:.3g} x {:.3g} x {:.3g}, from ({:.3g}, {:.3g}, {:.3g})\n", size.x, size.y,
                  size.z, bounds.lower.x, bounds.lower.y, bounds.lower.z);
    context.print("up          {}, {}\n", up.axis, up.because);
    constexpr std::size_t most = 30;
    context.print("parts       {}, placed {} times{}\n", parts.names.size(), parts.nodes.size(),
                  parts.camera ? "; a camera" : "");
    for (std::size_t part = 0; part < std::min(most, parts.names.size()); ++part) {
        const auto places = report["parts"][part]["places"].get<std::size_t>();
        context.print("  {}{}\n", parts.names[part].empty() ? "(no name)" : parts.names[part],
                      places > 1 ? fmt::format(", {} times", places) : "");
    }
    if (parts.names.size() > most) context.print("  and {} more\n", parts.names.size() - most);
    context.print("materials   {}\n", report["materials"].size());
    for (std::size_t m = 0; m < std::min(most, report["materials"].size()); ++m)
        print_material(report["materials"][m], context);
    if (report["materials"].size() > most)
        context.print("  and {} more\n", report["materials"].size() - most);
    std::string unused;
    for (const auto& [what, count] : report["not_used"].items())
        unused += fmt::format("{}{} of {}", unused.empty() ? "" : ", ", what, count.get<std::size_t>());
    if (!unused.empty()) context.print("not used    {}\n", unused);
    context.print("mesh        {}\n", findings.summary().empty() ? "no problems" : findings.summary());
    return ExitCode::done;
}

}  // namespace haarfield
