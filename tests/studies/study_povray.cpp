#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <filesystem>
#include <map>
#include <mutex>
#include <thread>

#include "bridge/pictures/preview.h"
#include "bridge/povray_import/imported_scene.h"
#include "fields/base/srgb.h"
#include "fields/model/mesh_reader.h"
#include "scenes/image.h"
#include "scenes/scene_camera.h"
#include "scenes/texture.h"
#include "tests/studies/study.h"

namespace haarfield::baseline {
namespace {

constexpr int width = 160;
constexpr int finer = 3;  // Rays of a pixel in each direction, in pictures that are compared.

/// The result for one file.
struct FileResult {
    std::string reason;      ///< Of the first failure; empty: none.
    bool evaluated = false;  ///< The rewritten scene's picture equals the original's.
    bool imported = false;   ///< At least one object.
    bool has_camera = false;
    std::size_t objects = 0, meshes = 0, transparent = 0, failed = 0;
    double silhouettes = 1;  ///< Fraction of pixels that differ.
    double psnr = 0;         ///< Of unlit pictures, where both show an object. [dB]
    double seconds = 0;
};

/// Returns the last words of an error without numbers and names, to count equal reasons.
std::string short_reason(const std::string& what) {
    std::string text = what.substr(0, 100);
    if (const std::size_t at = what.find("Parse Error: "); at != std::string::npos)
        text = what.substr(at, 80);
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

double clock_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Requests a stop after a time, unless it is destroyed before.
class TimeLimit {
public:
    explicit TimeLimit(double seconds)
        : thread_([this, seconds](const std::stop_token& ended) {
              std::unique_lock lock(mutex_);
              const bool is_over = !changed_.wait_for(lock, ended, std::chrono::duration<double>(seconds),
                                                      [&] { return ended.stop_requested(); });
              if (is_over) source_.request_stop();
          }) {}

    std::stop_token token() const { return source_.get_token(); }

private:
    std::stop_source source_;
    std::mutex mutex_;
    std::condition_variable_any changed_;
    std::jthread thread_;
};

/// Compares the wrapped scene with the file itself, which is wrapped with all objects in one include.
Result<bool> is_evaluated(const std::filesystem::path& file, const QueryOptions& options) {
    HF_TRY(const SceneQueries queries, SceneQueries::create(file, options));
    SceneQuery query;
    query.width = 64;
    query.height = 48;
    query.arguments = {"+Q1"};
    query.lights = query.sky = query.camera = query.extras = true;
    query.put = "object{HF_A[HF_N]}";
    HF_TRY(const SceneAnswer wrapped, queries.answer(query));
    HF_TRY(const SceneAnswer original, queries.original(query));
    for (std::size_t i = 0; i < wrapped.pixels.size(); ++i)
        for (int c = 0; c < 3; ++c)
            if (std::abs(srgb_encoded(wrapped.pixels[i][c]) - srgb_encoded(original.pixels[i][c])) >
                8.0f / 255)
                return false;
    return true;
}

/// Returns the original's objects before a background, unlit and antialiased.
Result<std::vector<Rgb>> unlit_picture(const SceneQueries& queries, const std::vector<std::size_t>& hidden,
                                       const Camera& camera, const char* background) {
    SceneQuery query;
    query.camera = query.pigments = true;
    query.width = width;
    query.height = width * camera.height / camera.width;
    query.arguments = {"+A0.0", "+AM1", fmt::format("+R{}", finer), "-J"};
    std::vector<int> is_hidden(hidden.empty() ? 1 : *std::ranges::max_element(hidden) + 1, 0);
    for (const std::size_t object : hidden) is_hidden[object] = 1;
    query.prelude = fmt::format("#declare HF_RN={};\n#declare HF_RA=array[{}]{{{}}}\n", is_hidden.size(),
                                is_hidden.size(), fmt::join(is_hidden, ","));
    query.put =
        "#local HF_H=0; #if(HF_N<HF_RN) #local HF_H=HF_RA[HF_N]; #end #if(HF_H=0) object{HF_A[HF_N]} #end";
    query.suffix = fmt::format(
        "\n#version 3.7;\nglobal_settings{{adc_bailout 0}}\nbackground{{rgb {}*HF_E}}\n", background);
    HF_TRY(SceneAnswer answer, queries.answer(query));
    return std::move(answer.pixels);
}

/// Returns the mean of each square of `finer` pixels.
std::vector<Rgb> reduced(const Image& image) {
    const int columns = image.width / finer, rows = image.height / finer;
    std::vector<Rgb> pixels(std::size_t(columns) * std::size_t(rows), Rgb(0.0f));
    for (int y = 0; y < rows * finer; ++y)
        for (int x = 0; x < columns * finer; ++x)
            pixels[std::size_t(y / finer * columns + x / finer)] +=
                image.pixels[std::size_t(y * image.width + x)] / float(finer * finer);
    return pixels;
}

/// Writes the original, the import and the absolute differences side by side.
Result<Done> write_pair(const std::vector<Rgb>& original, const std::vector<Rgb>& import,
                        const std::filesystem::path& png) {
    const std::size_t rows = original.size() / std::size_t(width);
    Image pair{3 * width, static_cast<int>(rows), {}, {}};
    for (std::size_t row = 0; row < rows; ++row)
        for (int part = 0; part < 3; ++part)
            for (std::size_t p = row * std::size_t(width); p < (row + 1) * std::size_t(width); ++p) {
                Rgb pixel = part == 0 ? original[p] : import[p];
                if (part == 2)
                    for (int c = 0; c < 3; ++c)
                        pixel[c] =
                            srgb_decoded(std::abs(srgb_encoded(original[p][c]) - srgb_encoded(import[p][c])));
                pair.pixels.push_back(pixel);
            }
    return write_image(pair, png);
}

Result<Done> compare(const std::filesystem::path& file, const QueryOptions& options,
                     const ImportedPovrayScene& imported, const std::filesystem::path& pictures,
                     FileResult& result) {
    const Scene& scene = imported.scene;
    if (scene.finds_camera) return Error{"", "no perspective camera"};
    HF_TRY(SceneQueries queries, SceneQueries::create(file, options));
    HF_TRY_DONE(queries.measure_gamma({}));
    // Transparent objects remain POV-Ray's, and look as they do in the file.
    std::vector<std::size_t> hidden = imported.distant_objects;
    hidden.insert(hidden.end(), imported.live_objects.begin(), imported.live_objects.end());
    HF_TRY(const std::vector<Rgb> dark, unlit_picture(queries, hidden, scene.camera, "<0,0,0>"));
    HF_TRY(const std::vector<Rgb> bright, unlit_picture(queries, hidden, scene.camera, "<1,1,1>"));
    std::vector<ImportedMesh> meshes;
    for (const Entity& entity : scene.entities) {
        MeshReaderOptions with_colours;
        with_colours.appearance = true;
        HF_TRY(ImportedMesh mesh, read_mesh(entity.mesh, with_colours));
        meshes.push_back(std::move(mesh));
    }
    // Pigments are vertex colours, or images.
    std::map<std::filesystem::path, std::shared_ptr<const Texture>> images;
    std::vector<std::vector<Surface>> surfaces;
    for (const Entity& entity : scene.entities) {
        std::vector<Surface>& surface = surfaces.emplace_back(1);
        const std::filesystem::path& image = scene.materials.at(entity.material).image;
        if (image.empty()) continue;
        if (!images.contains(image)) {
            TextureSource source;
            source.image.file = image;
            HF_TRY(Texture texture, read_texture(source));
            images[image] = std::make_shared<const Texture>(std::move(texture));
        }
        surface[0].texture = images[image];
    }
    std::vector<std::vector<Rgb>> colours;
    for (std::size_t e = 0; e < meshes.size(); ++e) {
        const Mesh& mesh = meshes[e].mesh;
        colours.push_back(mesh.uvs.empty() ? mesh.colours
                                           : std::vector<Rgb>(mesh.positions.size(), Rgb(1.0f)));
        for (Rgb& colour : colours.back()) colour *= scene.materials.at(scene.entities[e].material).pigment;
    }
    for (std::vector<Rgb>& each : colours)
        for (Rgb& colour : each)
            for (int c = 0; c < 3; ++c) colour[c] = std::pow(colour[c], scene.assumed_gamma);
    std::vector<BakedInstance> instances;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const std::size_t entity = scene.instances[i].entity;
        const Mesh& mesh = meshes[entity].mesh;
        instances.push_back({fmt::format("i{}", i),
                             &mesh,
                             scene.instances[i].placement,
                             colours[entity],
                             {},
                             surfaces[entity]});
    }
    Camera camera = scene.camera;
    camera.width = finer * width;
    camera.height = finer * (width * scene.camera.height / scene.camera.width);
    Preview preview;
    const std::vector<Rgb> on_dark =
        reduced(preview.draw(camera, instances, [](const Vec3f&) { return Rgb(0.0f); }));
    const std::vector<Rgb> on_bright =
        reduced(preview.draw(camera, instances, [](const Vec3f&) { return Rgb(1.0f); }));
    if (!pictures.empty())
        HF_TRY_DONE(write_pair(
            dark, on_dark,
            pictures / (file.parent_path().filename().string() + "_" + file.stem().string() + ".png")));
    double differing = 0, error = 0, compared = 0;
    for (std::size_t p = 0; p < dark.size(); ++p) {
        const Rgb through = bright[p] - dark[p], own = on_bright[p] - on_dark[p];
        const bool is_object = through.x + through.y + through.z < 1.5f,
                   is_mesh = own.x + own.y + own.z < 1.5f;
        differing += is_object != is_mesh;
        if (!is_object || !is_mesh) continue;
        for (int c = 0; c < 3; ++c) {
            const double difference = double(srgb_encoded(dark[p][c]) - srgb_encoded(on_dark[p][c]));
            error += difference * difference / 3;
        }
        compared += 1;
    }
    result.silhouettes = differing / static_cast<double>(dark.size());
    result.psnr = compared > 0 ? std::min(99.0, -10 * std::log10(std::max(1e-12, error / compared))) : 0;
    return Done{};
}

FileResult result_of(const std::filesystem::path& file, const std::filesystem::path& folder, int detail,
                     double seconds, const std::filesystem::path& pictures) {
    FileResult result;
    QueryOptions options;
    options.seconds = 200;
    const double start = clock_seconds();
    const Result<bool> evaluated = is_evaluated(file, options);
    result.evaluated = evaluated && *evaluated;
    if (!evaluated) result.reason = "evaluated: " + short_reason(evaluated.error().what);
    PovrayImport wanted;
    wanted.queries = options;
    wanted.detail = detail;
    wanted.object_seconds = 40;
    wanted.with_environment = false;
    const TimeLimit limit(seconds);
    Progress progress;
    progress.stop = limit.token();
    const Result<ImportedPovrayScene> imported =
        imported_povray_scene(file, folder, "scene", wanted, progress);
    if (imported) {
        result.imported = imported->surfaces > 0;
        result.has_camera = !imported->scene.finds_camera;
        result.objects = imported->objects;
        result.meshes = imported->surfaces;
        result.transparent = imported->transparent;
        result.failed = imported->failed;
        const Result<Done> compared = compare(file, options, *imported, pictures, result);
        if (!compared && result.reason.empty())
            result.reason = "compared: " + short_reason(compared.error().what);
    } else if (result.reason.empty()) {
        result.reason = "imported: " + short_reason(imported.error().what);
    }
    result.seconds = clock_seconds() - start;
    return result;
}

}  // namespace

void study_povray(const std::vector<std::string>& files, int detail, double seconds,
                  const std::string& pictures) {
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / fmt::format("haarfield_study_povray_{}", ::getpid());
    std::map<std::string, int> reasons;
    double evaluated = 0, geometry = 0, some = 0, colours = 0;
    fmt::print("{:>4} {:>5} {:>5} {:>6} {:>6} {:>8} {:>6} {:>6}  {}\n", "eval", "objs", "mesh", "transp",
               "failed", "silh. %", "dB", "s", "file");
    for (const std::string& file : files) {
        std::error_code ignored;
        std::filesystem::remove_all(folder, ignored);
        const FileResult result = result_of(file, folder, detail, seconds, pictures);
        evaluated += result.evaluated;
        some += result.imported && result.has_camera;
        geometry += result.imported && result.has_camera && result.transparent == 0 && result.failed == 0 &&
                    result.silhouettes <= 0.02;
        colours += result.imported && result.psnr >= 30;
        if (!result.reason.empty()) ++reasons[result.reason];
        fmt::print("{:>4} {:>5} {:>5} {:>6} {:>6} {:>8.2f} {:>6.1f} {:>6.1f}  {}  {}\n",
                   result.evaluated ? 1 : 0, result.objects, result.meshes, result.transparent, result.failed,
                   100 * result.silhouettes, result.psnr, result.seconds, file, result.reason);
        std::fflush(stdout);
    }
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
    const double percent = 100 / static_cast<double>(std::max<std::size_t>(1, files.size()));
    fmt::print(
        "\nevaluated {:.1f} %; geometry {:.1f} %, an object and the camera {:.1f} %; colours {:.1f} %\n",
        evaluated * percent, geometry * percent, some * percent, colours * percent);
    for (const auto& [reason, number] : reasons) fmt::print("{:>4}  {}\n", number, reason);
}

}  // namespace haarfield::baseline
