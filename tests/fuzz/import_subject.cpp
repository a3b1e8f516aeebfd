#include "tests/fuzz/import_subject.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <sstream>

#include "tests/fixtures/example_textures.h"
#include "tests/fixtures/test_folder.h"
#include "tests/fuzz/image_seeds.h"
#include "tests/fuzz/import_room.h"
#include "tests/fuzz/structured_changes.h"
#include "tools/command.h"

namespace haarfield {
namespace {

using std::filesystem::path;

struct NamedFile {
    std::string name, bytes;
};

/// All files of a model; the main file is first.
using Model = std::vector<NamedFile>;

void replace_all(std::string& text, std::string_view from, std::string_view to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
        text.replace(at, from.size(), to);
}

/// Returns a tetrahedron of two materials, one of which has an image of this name.
Model obj_model(const NamedFile& image) {
    return {{"thing.obj",
             "mtllib thing.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl wood\n"
             "f 1/1 3/3 2/2\nf 1/1 2/2 4/3\nusemtl leaf\nf 2/1 3/2 4/3\nf 1/1 4/2 3/3\n"},
            {"thing.mtl", "newmtl wood\nKd 0.8 0.5 0.2\nKs 0.2 0.2 0.2\nNs 60\nillum 2\nmap_Kd " +
                              image.name + "\n\nnewmtl leaf\nKd 1 1 1\nKe 0.5 0 0\nd 0.5\nmap_Kd " +
                              image.name + "\nmap_d " + image.name + "\n"},
            image};
}

/// Returns a model with its buffer and its image in separate files.
Model gltf_model(const NamedFile& image) {
    std::string json = example_mesh_files("gltf").front();
    const auto put = [&](std::string_view begin, const std::string& name) {
        const std::size_t at = json.find(begin);
        json.replace(at, json.find('"', at) - at, name);
    };
    put("data:image", image.name);
    put("data:application", "thing.bin");
    std::string buffer;
    for (const float x : {0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f})
        buffer.append(reinterpret_cast<const char*>(&x), sizeof x);
    return {{"thing.gltf", json}, {"thing.bin", buffer}, image};
}

Model mesh2_model(const NamedFile& image) {
    return {
        {"thing.inc",
         "mesh2 { vertex_vectors { 4 <0,0,0> <1,0,0> <0,1,0> <0,0,1> } uv_vectors { 3 <0,0> <1,0> <0,1> }\n"
         "texture_list { 1 texture { pigment { image_map { " +
             path(image.name).extension().string().substr(1) + " \"" + image.name +
             "\" } } finish { diffuse 0.7 phong 0.2 phong_size 40 } } }\n"
             "face_indices { 4 <0,2,1>,0 <0,1,3>,0 <1,2,3>,0 <2,0,3>,0 }\n"
             "uv_indices { 4 <0,1,2> <0,1,2> <1,2,0> <2,0,1> } uv_mapping }\n"},
        image};
}

Model coloured_ply() {
    return {{"thing.ply",
             "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
             "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
             "property list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n"
             "0 1 0 0 0 255\n3 0 1 2\n"}};
}

std::vector<Model> whole_models() {
    std::vector<NamedFile> images{{"wood.png", *png_bytes(random_texture(5, 4).texels, 5, 4, false)},
                                  {"wood.png", *png_bytes(random_texture(3, 7, true).texels, 3, 7, true)}};
    for (const char* format : {"jpeg", "tiff", "bmp", "webp", "hdr", "exr", "targa"})
        images.push_back({format == std::string_view("targa") ? "wood.tga" : std::string("wood.") + format,
                          example_image_files(format).front()});
    std::vector<Model> models{coloured_ply()};
    for (const NamedFile& image : images) {
        models.push_back(obj_model(image));
        models.push_back(gltf_model(image));
        models.push_back(mesh2_model(image));
    }
    for (const char* ending : {"ply", "gltf", "glb", "inc", "stl", "off"})
        for (const std::string& bytes : example_mesh_files(ending))
            models.push_back({{std::string("thing.") + ending, bytes}});
    return models;
}

FileKind kind_of(const std::string& name) {
    const std::string ending = path(name).extension();
    if (ending == ".glb") return FileKind::glb;
    if (ending == ".png") return FileKind::png;
    return std::ranges::count(std::array{".obj", ".mtl", ".gltf", ".inc", ".ply", ".off", ".stl"}, ending)
               ? FileKind::text
               : FileKind::binary;
}

/// A placeholder for the folder of the model.
constexpr std::string_view here = "@HERE@";

/// Makes a model refer to files outside of its folder.
void refer_elsewhere(Model& model, FuzzRandom& random) {
    constexpr std::array ways{
        "../outside/{}",   "@HERE@/../outside/{}", "file:../outside/{}",      "..\\outside\\{}",
        "./../outside/{}", "%2e%2e/outside/{}",    "models/../../outside/{}", "file://@HERE@/../outside/{}"};
    if (model.size() < 2) return;
    const std::string& name = model[1 + random_index(random, model.size() - 1)].name;
    const std::string elsewhere = fmt::format(fmt::runtime(ways[random_index(random, ways.size())]), name);
    for (NamedFile& file : model)
        if (kind_of(file.name) == FileKind::text) replace_all(file.bytes, name, elsewhere);
}

void damage_model(Model& model, FuzzRandom& random) {
    do {
        NamedFile& file = model[random_index(random, model.size())];
        const FileKind kind = kind_of(file.name);
        const bool is_text = file.bytes.find('\0') == std::string::npos;
        if (random_index(random, 2))
            change_structure(file.bytes, random,
                             kind == FileKind::text && !is_text ? FileKind::binary : kind);
        else
            damage(file.bytes, random, std::string(model.front().bytes), mesh_words());
    } while (random_index(random, 3) == 0);
}

Result<ExitCode> run(Command (*make)(CLI::App&), std::vector<std::string> arguments) {
    CLI::App program;
    const Command command = make(program);
    std::ranges::reverse(arguments);
    program.parse(std::move(arguments));
    CommandContext context;
    context.threads = 1;
    context.quiet = true;
    context.message = [](const std::string&) {};
    return command.run(context);
}

/// Returns a defect of a rejection; empty if there is none.
std::string wrong_refusal(const Error& error) {
    if (error.what.empty() || error.where.empty()) return "refused without a reason or a place";
    return error.what.find("is not finite") != std::string::npos && error.where.find("instance") == 0
               ? "baked to what is not finite: " + error.message()
               : "";
}

/// Returns a defect of a table of baked vertices; empty if there is none.
std::string wrong_table(const path& file) {
    std::ifstream table(file);
    std::string line;
    if (!std::getline(table, line)) return "nothing was baked";
    while (std::getline(table, line))
        for (const char* odd : {",nan", ",-nan", ",inf", ",-inf"})
            if (line.find(odd) != std::string::npos) return "a vertex that is not finite: " + line;
    return "";
}

class DamagedModels : public Subject {
public:
    DamagedModels() : models_(whole_models()) {}
    std::string file_name() const override { return "model"; }
    unsigned seconds() const override { return 30; }
    std::string input(FuzzRandom& random) override {
        Model model = models_[random_index(random, models_.size())];
        if (random_index(random, 8) == 0) refer_elsewhere(model, random);
        if (random_index(random, 8)) damage_model(model, random);
        std::string bytes;
        for (const NamedFile& file : model)
            bytes += fmt::format("{} {}\n", file.name, file.bytes.size()) + file.bytes;
        return bytes;
    }
    std::string objection(const path& file, Outcome& outcome) override {
        const ImportRoom room(file.parent_path() / "room");
        std::istringstream bundle(text_of(file));
        std::string first, name;
        for (std::size_t size = 0; bundle >> name >> size;) {
            std::string bytes(size, '\0');
            bundle.get();
            bundle.read(bytes.data(), static_cast<std::streamsize>(size));
            if (first.empty()) first = name;
            replace_all(bytes, here, room.models().string());
            write_text(room.models() / name, bytes);
            write_text(room.outside() / name, bytes);
        }
        return room.objection(
            [&] { return imported_and_baked(room.models() / first, room.output(), outcome); });
    }

private:
    static std::string imported_and_baked(const path& model, const path& output, Outcome& outcome) {
        const Result<ExitCode> imported =
            run(import_command, {"import", model, "-o", output, "--vertices", "1000"});
        const path scene = output / "thing.toml";
        if (!imported) {
            if (std::filesystem::exists(scene)) return "refused, and a scene was written";
            outcome.refused(imported.error());
            return wrong_refusal(imported.error());
        }
        const Result<ExitCode> baked =
            run(bake_command, {"bake", scene, "-o", output, "--face-size", "16", "--bounces", "1",
                               "--no-render", "--format", "csv"});
        if (!baked) {
            if (std::filesystem::exists(output / "thing.pov")) return "refused, and half of it was written";
            outcome.refused(baked.error());
            return wrong_refusal(baked.error());
        }
        outcome.accepted = true;
        if (!std::filesystem::exists(output / "thing.pov")) return "baked, and no scene was written";
        return wrong_table(output / "thing.csv");
    }

    std::vector<Model> models_;
};

}  // namespace

std::unique_ptr<Subject> damaged_models() {
    return std::make_unique<DamagedModels>();
}

}  // namespace haarfield
