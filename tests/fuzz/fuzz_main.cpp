// haarfield_fuzz: feeds damaged and crafted files to the readers of fields, meshes, scenes, plans and
// messages.
//
// Each file must be read or rejected within 5 s of processor time (a whole model 30 s, a POV-Ray scene 60 s
// besides POV-Ray itself) and 1 GiB, without a crash. A modified field must be rejected or unchanged, and a
// field with correct hashes must be safe to use.
// A mesh of arbitrary numbers must bake to finite radiance. Whole models must bake likewise, or be rejected.
// Files are read in a child process, so that a crash is counted, the file is saved, and the next file is
// read. With --apart, files of third-party formats are read by a reader process, as in the program. Crashes
// of that process are counted, but are not failures. Without it, a process without sandbox that reads many
// files parses fields (batch_reader.h).

#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <new>

#include "fields/base/sanitizers.h"
#include "fields/field/field_grids.h"
#include "fields/model/assimp_content.h"
#include "fields/model/model_file.h"
#include "fields/preparation/mesh_preparation.h"
#include "fields/vdb/vdb_file.h"
#include "scenes/image.h"
#include "scenes/image_reader.h"
#include "scenes/scene_reader.h"
#include "scenes/surface.h"
#include "tests/fixtures/baked_mesh.h"
#include "tests/fixtures/example_textures.h"
#include "tests/fixtures/test_folder.h"
#include "tests/fuzz/field_subjects.h"
#include "tests/fuzz/fuzz_inputs.h"
#include "tests/fuzz/image_seeds.h"
#include "tests/fuzz/import_subject.h"
#include "tests/fuzz/json_subjects.h"
#include "tests/fuzz/odd_mesh.h"
#include "tests/fuzz/povray_subject.h"
#include "tests/fuzz/structured_changes.h"

#include <fmt/format.h>

// Without AddressSanitizer, nothing calls this.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
    return "max_allocation_size_mb=1024:hard_rss_limit_mb=1536:quarantine_size_mb=64:detect_leaks=0:"
           "allocator_may_return_null=1";
}

namespace haarfield {
namespace {

using std::filesystem::path;

constexpr std::size_t files_per_process = 1000;  // so that memory leaks of libraries do not accumulate

/// Returns a defect of a mesh's materials, images or colours; empty if there is none.
std::string wrong_appearance(const ImportedMesh& read) {
    const std::size_t vertices = read.mesh.positions.size(), materials = read.mesh.material_names.size();
    if (read.materials.size() != materials || read.mapped.size() != materials ||
        read.coloured.size() != materials)
        return "materials without a description";
    if ((!read.mesh.uvs.empty() && read.mesh.uvs.size() != vertices) ||
        (!read.mesh.colours.empty() && read.mesh.colours.size() != vertices))
        return "vertices without uvs or colours";
    for (const Vec2f& uv : read.mesh.uvs)
        if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) return "a uv that is not finite";
    for (const Rgb& colour : read.mesh.colours)
        if (!is_finite(colour)) return "a colour that is not finite";
    for (const MeshMaterial& described : read.materials) {
        const Surface surface = surface_of(described);
        const Material& material = surface.material;
        for (const Rgb& colour : {material.diffuse, material.specular, surface.emission})
            for (int c = 0; c < 3; ++c)
                if (!(colour[c] >= 0 && colour[c] <= 1e12f)) return "a colour out of its range";
        if (!(material.shininess >= 1 && material.shininess <= 1000) ||
            !(material.roughness >= 0.0005f && material.roughness <= 1))
            return "a highlight out of its range";
        if (!described.image.bytes) continue;
        const Result<Texture> texture =
            read_texture({described.image, {}, described.alpha, described.alpha_cutoff});
        if (!texture && texture.error().what.empty()) return "an image was refused without a reason";
    }
    return {};
}

/// Files of text or bytes, damaged with words of their own format.
class DamagedFiles : public Subject {
public:
    DamagedFiles(std::vector<std::string> files, const std::vector<std::string_view>& words, FileKind kind)
        : files_(std::move(files)), words_(words), kind_(kind) {}
    std::string input(FuzzRandom& random) override {
        std::string bytes = files_[random_index(random, files_.size())];
        // Half of them are changed by structure, which reaches deeper into the reader than changes to bytes.
        if (random_index(random, 2)) {
            const bool is_text = bytes.find('\0') == std::string::npos;
            change_structure(bytes, random, kind_ == FileKind::text && !is_text ? FileKind::binary : kind_);
        } else {
            damage(bytes, random, files_[random_index(random, files_.size())], words_);
        }
        return bytes;
    }

private:
    std::vector<std::string> files_;
    const std::vector<std::string_view>& words_;
    FileKind kind_;
};

class DamagedImages : public DamagedFiles {
public:
    explicit DamagedImages(const std::string& format)
        : DamagedFiles(format == "png"
                           ? std::vector{*png_bytes(random_texture(5, 4).texels, 5, 4, false),
                                         *png_bytes(random_texture(3, 7, true).texels, 3, 7, true)}
                           : example_image_files(format),
                       mesh_words(), format == "png" ? FileKind::png : FileKind::binary),
          format_(format) {}
    std::string file_name() const override { return "image." + format_; }
    std::string objection(const path& file, Outcome& outcome) override {
        const auto embedded = std::make_shared<const std::string>(text_of(file));
        const Result<Texture> texture =
            read_texture({MeshImage{"image", {}, embedded}, {}, AlphaMode::blend});
        if (!texture) return outcome.refused(texture.error());
        outcome.accepted = true;
        if (texture->width < 1 || texture->height < 1 ||
            texture->texels.size() != std::size_t(texture->width) * std::size_t(texture->height))
            return "an image without texels";
        if (!is_finite(texture->colour_at({0.3f, -7.6f}))) return "a colour that is not finite";
        return {};
    }

private:
    std::string format_;
};

/// Valid meshes of unusual numbers, which are baked.
class OddShapes : public Subject {
public:
    std::string file_name() const override { return "shape.obj"; }
    std::string input(FuzzRandom& random) override { return odd_mesh(random); }
    std::string objection(const path& file, Outcome& outcome) override {
        const BakedMesh baked = baked_mesh(file, file.parent_path() / "fields");
        std::filesystem::remove_all(file.parent_path() / "fields");
        if (!baked.refused.empty())
            return baked.refused.find("shape.obj") == std::string::npos ? "refused: " + baked.refused : "";
        outcome.accepted = true;
        if (!baked.defect.empty()) return baked.defect;
        return baked.not_finite > 0 ? "radiance that is not finite" : "";
    }
};

/// Checks a list of vertices and faces: increasing numbers, valid faces, and every vertex of the mesh that
/// was read from the same file.
std::string wrong_list(const ListedMesh& listed, const Mesh& read) {
    if (listed.numbers.size() != listed.positions.size()) return "listed vertices without a number";
    if (std::ranges::adjacent_find(listed.numbers, std::greater_equal()) != listed.numbers.end())
        return "numbers that do not grow";
    std::uint64_t corners = 0;
    for (const std::uint32_t count : listed.face_corners) corners += count;
    if (corners != listed.corners.size()) return "listed faces without their corners";
    for (const std::uint32_t corner : listed.corners)
        if (corner >= listed.positions.size()) return "a listed corner without a vertex";
    for (const std::int32_t number : read.original_vertices)
        if (number != not_original && !std::ranges::binary_search(listed.numbers, number))
            return "a vertex that the file does not list";
    return {};
}

class DamagedMeshes : public DamagedFiles {
public:
    explicit DamagedMeshes(std::string ending)
        : DamagedFiles(example_mesh_files(ending), mesh_words(),
                       ending == "glb" ? FileKind::glb : FileKind::text),
          ending_(std::move(ending)) {}
    std::string file_name() const override { return "mesh." + ending_; }
    std::string objection(const path& file, Outcome& outcome) override {
        const Result<ModelFile> model = ModelFile::open(file);
        if (!model) return outcome.refused(model.error());
        for (std::size_t part = 0; part < model->parts().names.size(); ++part)
            if (const Result<ImportedMesh> read = read_mesh(*model, part, {.appearance = true}); !read)
                if (read.error().what.empty()) return "a part was refused without a reason";
        Result<ImportedMesh> mesh = read_mesh(*model, {}, {.appearance = true});
        if (!mesh) return outcome.refused(mesh.error());
        outcome.accepted = true;
        if (const std::string wrong = wrong_appearance(*mesh); !wrong.empty()) return wrong;
        if (const Result<ListedMesh> listed = model->listed(); !listed) {
            if (listed.error().what.empty()) return "a list was refused without a reason";
        } else if (const std::string wrong = wrong_list(*listed, mesh->mesh); !wrong.empty()) {
            return wrong;
        }
        for (const auto& triangle : mesh->mesh.triangles)
            for (const std::uint32_t corner : triangle)
                if (corner >= mesh->mesh.positions.size() || !is_finite(mesh->mesh.positions[corner]))
                    return "a corner without a position";
        const Result<PreparedMesh> prepared = prepare_mesh(*std::move(mesh), {60, 20});
        return !prepared && prepared.error().what.empty() ? "refused without a reason" : "";
    }

private:
    std::string ending_;
};

class DamagedScenes : public DamagedFiles {
public:
    DamagedScenes() : DamagedFiles(example_scene_files(), scene_words(), FileKind::text) {}
    std::string file_name() const override { return "scene.toml"; }
    std::string objection(const path& file, Outcome& outcome) override {
        const Result<Scene> scene = read_scene(file);
        if (!scene) return scene.error().where.empty() ? "refused without a place" : "";
        outcome.accepted = true;
        for (const Instance& instance : scene->instances)
            if (instance.entity >= scene->entities.size())
                return "an instance without an entity";
            else if (!(instance.placement.scale > 0) || !is_same_shape(instance.shape, instance.shape))
                return "an instance without a place";
        return {};
    }
};

/// The kinds in turn. Shapes and whole models take a second each. Images are left to a reader process,
/// because OpenImageIO allocates as much memory as damaged files state.
constexpr std::array<std::string_view, 14> here_names{"obj",  "ply",     "stl",   "off",   "gltf",
                                                      "glb",  "obj",     "scene", "ply",   "inc",
                                                      "plan", "message", "field", "forged"};
constexpr std::array<std::string_view, 17> apart_names{"field", "forged", "obj",  "stl", "gltf", "glb",
                                                       "png",   "jpeg",   "tiff", "exr", "hdr",  "webp",
                                                       "bmp",   "targa",  "gltf", "glb", "obj"};

std::span<const std::string_view> names_of(bool apart) {
    return apart ? std::span<const std::string_view>(apart_names) : here_names;
}

std::unique_ptr<Subject> subject(std::string_view name) {
    if (name == "field") return damaged_fields();
    if (name == "forged") return forged_fields();
    if (name == "scene") return std::make_unique<DamagedScenes>();
    if (name == "shape") return std::make_unique<OddShapes>();
    if (name == "plan") return damaged_plans();
    if (name == "message") return damaged_messages();
    if (name == "import") return damaged_models();
    if (name == "povray") return damaged_povray_scenes();
    if (name == "png" || !example_image_files(name).empty())
        return std::make_unique<DamagedImages>(std::string(name));
    return std::make_unique<DamagedMeshes>(std::string(name));
}

std::string_view subject_name(std::uint64_t index, const std::string& only, bool apart) {
    const std::span<const std::string_view> names = names_of(apart);
    return only.empty() ? names[index % names.size()] : std::string_view(only);
}

/// Data shared between parent and child.
struct Board {
    volatile std::uint64_t next;       ///< The file that is being read, or will be next.
    volatile std::uint64_t accepted;   ///< Files that were accepted.
    volatile std::uint64_t contained;  ///< Files that crashed their reader.
    volatile bool objected;
};

void limit_memory() {
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    if (is_address_sanitized) return;  // __asan_default_options limits the memory
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t limit = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + (rlim_t(1) << 30);
    const rlimit memory{limit, limit};
    setrlimit(RLIMIT_AS, &memory);
    // Readers that catch bad_alloc would hide the failure.
    std::set_new_handler([] {
        static constexpr std::string_view message = "more than 1 GiB requested\n";
        [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message.data(), message.size());
        abort();
    });
}

/// Ends the process after this many seconds of processor time or wall time; 0: never.
void limit_time(unsigned processor, unsigned clock) {
    const itimerval limit{{0, 0}, {static_cast<time_t>(processor), 0}};
    setitimer(ITIMER_PROF, &limit, nullptr);
    alarm(clock);
}

/// Reads files from board.next to `last`, then ends the process.
[[noreturn]] void read_files(Board& board, std::uint64_t last, std::uint64_t seed, const std::string& only,
                             bool apart, const path& folder) {
    std::map<std::string, std::unique_ptr<Subject>, std::less<>> subjects;
    write_text(folder / "box.obj", "");  // scenes refer to it
    write_text(folder / "light.exr", "");
    if (apart) {
        static const std::array tasks{model_reader_task(), image_reader_task(), field_reader_task(),
                                      vdb_reader_task()};
        unsetenv("HAARFIELD_READER");
        if (const Result<Done> forked = fork_reader_process(tasks); !forked) {
            fmt::print(stderr, "{}\n", forked.error().what);
            abort();
        }
    } else {
        setenv("HAARFIELD_READER", "", 1);
        allow_unsandboxed_readers();
        read_images_in_this_process();
        read_fields_in_batches();
    }
    limit_memory();
    while (board.next < last) {
        FuzzRandom random(seed * 0x9e3779b97f4a7c15 + board.next);
        const std::string_view name = subject_name(board.next, only, apart);
        std::unique_ptr<Subject>& known = subjects[std::string(name)];
        if (!known) known = subject(name);
        Subject& current = *known;
        const path file = folder / current.file_name();
        std::filesystem::remove(file);  // overwriting waits for the disk on some systems
        write_text(file, current.input(random));
        Outcome outcome;
        limit_time(current.seconds(), current.clock_seconds());
        const std::string objection = current.objection(file, outcome);
        limit_time(0, 0);
        if (outcome.accepted) board.accepted = board.accepted + 1;
        if (outcome.contained) board.contained = board.contained + 1;
        if (!objection.empty()) {
            fmt::print(stderr, "file {}: {}\n", std::uint64_t(board.next), objection);
            board.objected = true;
            _exit(1);
        }
        board.next = board.next + 1;
    }
    _exit(0);
}

struct Options {
    std::uint64_t files = 1000, first = 0, seed = 1;
    std::string only, keep;
    bool apart = false, each = false;
};

int run(const Options& options) {
    void* const memory =
        mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return 1;
    Board& board = *new (memory) Board{options.first, 0, 0, false};
    const TestFolder folder;
    const std::uint64_t last = options.first + options.files;
    std::uint64_t failures = 0;
    while (board.next < last) {
        const std::uint64_t end = std::min(last, board.next + files_per_process);
        const pid_t child = fork();
        if (child == 0) read_files(board, end, options.seed, options.only, options.apart, folder.path());
        int status = 0;
        waitpid(child, &status, 0);
        if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && board.next == end) continue;
        ++failures;
        const std::string_view name = subject_name(board.next, options.only, options.apart);
        const std::string what =
            board.objected                                       ? "objection"
            : WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF ? "longer than its seconds"
            : WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM ? "waits for its wall time"
            : WIFSIGNALED(status)                                ? fmt::format("signal {}", WTERMSIG(status))
                                  : fmt::format("exit code {}", WEXITSTATUS(status));
        fmt::print("file {} ({}): {}\n", std::uint64_t(board.next), name, what);
        if (!options.keep.empty())
            for (const auto& file : std::filesystem::directory_iterator(folder.path()))
                if (const std::string own = file.path().filename();
                    file.is_regular_file() && own != "box.obj" && own != "light.exr")
                    std::filesystem::copy_file(
                        file.path(),
                        path(options.keep) / fmt::format("{}-{}", std::uint64_t(board.next), own),
                        std::filesystem::copy_options::overwrite_existing);
        board.objected = false;
        board.next = board.next + 1;
    }
    if (options.each)
        fmt::print("| {} | {} | {} | {} | {} | {} |\n", options.only,
                   options.apart ? "a reader process" : "this process", options.files,
                   std::uint64_t(board.accepted), std::uint64_t(board.contained), failures);
    else
        fmt::print("{} files, {} of them accepted, {} failures, {} crashed or exhausted their reader\n",
                   options.files, std::uint64_t(board.accepted), failures, std::uint64_t(board.contained));
    std::fflush(stdout);
    return failures == 0 ? 0 : 1;
}

/// Reads the given number of files of each kind.
int run_each(Options options) {
    int code = 0;
    fmt::print(
        "| kind | read in | files | accepted | crashed or exhausted their reader | failures "
        "|\n|---|---|---|---|---|---|\n");
    const auto all = names_of(options.apart);
    const std::set<std::string_view> names(all.begin(), all.end());
    for (const std::string_view name : names) {
        options.only = name;
        code = std::max(code, run(options));
    }
    return code;
}

}  // namespace
}  // namespace haarfield

int main(int argument_count, char** arguments) {
    CLI::App program{"Feeds damaged and crafted files to haarfield's readers", "haarfield_fuzz"};
    haarfield::Options options;
    program.add_option("--files", options.files, "How many")->capture_default_str();
    program.add_option("--first", options.first, "Index of the first")->capture_default_str();
    program.add_option("--seed", options.seed, "Other files")->capture_default_str();
    program.add_option("--only", options.only,
                       "One kind: field, forged, scene, obj, ply, stl, off, gltf, glb, inc, shape, plan, "
                       "message, import, povray, "
                       "png, jpeg, tiff, exr, hdr, webp, bmp, targa");
    program.add_flag("--apart", options.apart, "Formats of libraries are read by a reader process");
    program.add_flag("--each", options.each, "So many of each kind, with a row of a table for each");
    program.add_option("--keep", options.keep, "Folder for the files that failed")
        ->check(CLI::ExistingDirectory);
    CLI11_PARSE(program, argument_count, arguments);
    return options.each && options.only.empty() ? haarfield::run_each(options) : haarfield::run(options);
}
