#pragma once
/// Questions to POV-Ray about a scene: sandboxed runs of a rewritten scene.

#include "bridge/povray_import/wrapped_scene.h"
#include "fields/base/progress.h"
#include "fields/base/vector.h"

#include <memory>
#include <optional>
#include <span>

namespace haarfield {

/// Where and how POV-Ray runs.
struct QueryOptions {
    std::string program = "povray";  ///< A path, or a name to be looked up in PATH.
    int threads = 0;                 ///< 0: all cores.
    WrapOptions wrap{};
    double seconds = 300;                           ///< Wall time of one run. [s]
    std::uint64_t memory = std::uint64_t{4} << 30;  ///< Address space of POV-Ray. [bytes]
    bool sandboxed = true;                          ///< False: POV-Ray can do what this process can.
};

/// The relation between the numbers of a scene and the light that POV-Ray displays for them.
struct SceneGamma {
    double exponent = 1;     ///< Light is the number to this power: assumed_gamma.
    bool is_legacy = false;  ///< A scene without assumed_gamma before version 3.7: numbers are sRGB-encoded.

    double light(double number) const;  ///< Linear light of a number.
    double number(double light) const;  ///< The inverse.
};

/// Surfaces emit this share of their pigment in queries of pigments, since pictures end at 1 and pigments do
/// not. POV-Ray knows the share as HF_E, which is 1 in other queries.
inline constexpr double pigment_emission = 0.25;

/// One question: what POV-Ray evaluates before, after and around the scene's text.
struct SceneQuery {
    bool survey = false, lights = false, sky = false, camera = false, settings = true, extras = false,
         pigments = false;  ///< The switches of WrappedScene. Pixels are pigments up to 1 / pigment_emission.
    std::string put;        ///< Body of HF_Put(HF_I), before it increases HF_N. May be empty.
    std::string prelude;    ///< Further text before the scene.
    std::string suffix;     ///< Text behind the scene.
    int width = 1, height = 1;  ///< Of the picture. [pixels]
    bool in_numbers = false;    ///< The picture is in the numbers of the scene instead of linear light.
    bool is_linear = false;     ///< The picture is linear, else decoded from what POV-Ray displays.
    std::vector<std::string> arguments{};  ///< Further arguments of POV-Ray.
    /// Ends POV-Ray when it needs more processor time for one object. POV-Ray announces each object by
    /// `#debug "HF_OBJECT k\n"`. [s] 0: no limit.
    double object_seconds = 0;
    double seconds = 0;  ///< Wall time, if it is shorter than QueryOptions::seconds. [s] 0: no such limit.
};

/// The result of a run.
struct SceneAnswer {
    std::vector<Rgb> pixels;                 ///< Linear, rows from the top; empty if POV-Ray was ended.
    std::optional<std::size_t> slow_object;  ///< The object at which POV-Ray was ended.
};

/// A rewritten scene in a scratch folder, where POV-Ray runs.
///
/// POV-Ray runs in bubblewrap if that works here, else under Landlock. It can read its own installation, the
/// scene's folder, and folders of WrapOptions::library. It can write only to the scratch folder and has no
/// network. Memory, processor time and the size of files are limited. The destructor removes the scratch
/// folder.
class SceneQueries {
public:
    /// Rewrites a scene.
    ///
    /// errors  those of wrapped_scene; no scratch folder can be created; no sandbox is available.
    static Result<SceneQueries> create(const std::filesystem::path& scene, const QueryOptions& options);

    SceneQueries(SceneQueries&&) = default;  ///< Takes ownership.
    SceneQueries& operator=(SceneQueries&&) = delete;
    ~SceneQueries();

    const WrappedScene& scene() const { return scene_; }                ///< The rewritten scene.
    const SceneGamma& gamma() const { return gamma_; }                  ///< Linear before measure_gamma.
    const std::filesystem::path& file() const { return file_; }         ///< The file of the scene.
    const std::filesystem::path& scratch() const { return *scratch_; }  ///< The folder in which POV-Ray runs.

    /// Measures the scene's gamma.
    ///
    /// errors  as answer.
    /// cost    a run of POV-Ray if the scene's text mentions another assumed_gamma than 1.
    Result<Done> measure_gamma(const Progress& progress = {});

    /// Runs POV-Ray.
    ///
    /// errors  the program does not exist; POV-Ray's messages if it fails; the time limit; interrupted.
    /// cost    half a second, and the time in which POV-Ray parses the scene.
    Result<SceneAnswer> answer(const SceneQuery& query, const Progress& progress = {}) const;

    /// Runs POV-Ray for each query, up to four at a time, since each waits for half a second. Files that they
    /// write besides pictures are lost.
    ///
    /// returns  an answer for each query.
    /// errors   as answer; the first query's whose run fails.
    Result<std::vector<SceneAnswer>> answers(std::span<const SceneQuery> queries,
                                             const Progress& progress = {}) const;

    /// Renders the file itself, with the size and the arguments of a query.
    ///
    /// errors  as answer.
    Result<SceneAnswer> original(const SceneQuery& query, const Progress& progress = {}) const;

    /// Runs POV-Ray, and renders an OpenEXR file instead of a picture in memory.
    ///
    /// returns  the file, in the scratch folder.
    Result<std::filesystem::path> rendered_exr(const SceneQuery& query, const Progress& progress = {}) const;

    /// Writes a query as files that POV-Ray can render without this program: the main one, and its includes,
    /// whose names begin with `hf_`. POV-Ray needs the scene's folder as +L.
    Result<Done> write_files(const SceneQuery& query, const std::filesystem::path& main) const;

    /// Returns the lines of a file that POV-Ray wrote into the scratch folder.
    ///
    /// errors  no such file; more than 1 GiB.
    Result<std::string> written(const std::string& name) const;

private:
    SceneQueries() = default;
    Result<SceneAnswer> picture(const SceneQuery& query, const std::filesystem::path& folder,
                                const std::string& input, const Progress& progress) const;
    Result<SceneAnswer> run(const SceneQuery& query, const std::filesystem::path& folder,
                            const std::string& input, const std::string& format,
                            const Progress& progress) const;
    std::string input_of(const SceneQuery& query) const;

    std::filesystem::path file_;
    QueryOptions options_;
    WrappedScene scene_;
    std::shared_ptr<const std::filesystem::path> scratch_;
    SceneGamma gamma_;
    bool uses_frames_ = false;
};

/// Renders a scene as it is in POV-Ray's sandbox, and writes the picture as a PNG file.
///
/// folders    the only folders that POV-Ray can read besides its installation. Includes and images are looked
///            up there.
/// arguments  further arguments, such as the size.
/// errors     those of SceneQueries::answer; the picture cannot be written.
Result<Done> render_sandboxed(const std::filesystem::path& scene,
                              const std::vector<std::filesystem::path>& folders,
                              const std::filesystem::path& png, std::vector<std::string> arguments,
                              const QueryOptions& options, const Progress& progress = {});

/// True if bubblewrap can run programs here. Tried once per process.
bool bubblewrap_works();

}  // namespace haarfield
