#pragma once
/// Running POV-Ray: a child process without a window, watched, and stopped when asked.

#include "fields/base/progress.h"
#include "scenes/image.h"
#include "scenes/scene.h"

namespace haarfield {

/// How POV-Ray renders.
struct PovrayOptions {
    std::string program = "povray";  ///< A path, or a name to be looked up in PATH.
    int width = 640, height = 480;   ///< [pixels]
    int threads = 0;                 ///< 0: all cores.
    int antialiasing = 0;            ///< n: n x n rays a pixel, and its centre; 0: its centre alone.
    /// Only pixels that differ from a neighbour by more than this, sRGB-encoded, get the n x n rays; 0: all
    /// of them. A dome of many lights is some ten times faster with 0.05, and looks the same.
    double antialiasing_threshold = 0;
    std::vector<std::string> declarations;  ///< Each set to 1 before the scene is read.
    /// Rows of the picture that are rendered, from the first up to, but not at, the last; 0 and 0: all. The
    /// others are black. They have the same bits as in the whole picture if both are multiples of 32, or the
    /// last is the height: by blocks of so many POV-Ray decides which pixels get more rays.
    int first_row = 0, last_row = 0;
    /// A POV-Ray that tells of no progress for so long is ended. [s] It tells of its parsing and of its
    /// pixels, but at the end of a scene's parsing not until all of its meshes are in order.
    double patience = 600;
};

/// For a picture of the camera's resolution, with n x n rays where pixels differ from their neighbours.
PovrayOptions picture_options(const Camera& camera, int antialiasing);

/// One run of POV-Ray.
struct PovrayRun {
    std::string command_line;                     ///< As a person would type it.
    double parse_seconds = 0, trace_seconds = 0;  ///< Wall time, by POV-Ray's own log.
    std::vector<std::string> warnings;            ///< POV-Ray's, one line each.
};

/// Renders a scene file to a half-float EXR with alpha.
///
/// Includes and images are looked up in the scene's folder. The picture appears under its name only
/// when it is complete; nothing else stays, whatever happens.
///
/// progress  reported in pixels of the picture, by stage `POV-Ray`.
/// errors    no such program; POV-Ray's own words (parse errors with file and line) if it fails, ends by
///           a signal or leaves no picture; nothing said for longer than `patience`; interrupted: the child
///           is ended within 50 ms.
/// cost      0.5 s to start, then POV-Ray's.
Result<PovrayRun> run_povray(const std::filesystem::path& scene, const std::filesystem::path& exr,
                             const PovrayOptions& options = {}, const Progress& progress = {});

/// A picture, and the run that made it.
struct RenderedScene {
    Image image;
    PovrayRun run;
};

/// As run_povray, but into memory.
Result<RenderedScene> rendered_scene(const std::filesystem::path& scene, const PovrayOptions& options = {},
                                     const Progress& progress = {});

/// Writes `exr`, the rendered objects of a scene with their coverage, and a .png beside it of the same stem
/// that shows them before the scene's background. That takes a POV-Ray run of its own, without the objects:
/// half a second.
Result<Done> write_with_background(const Image& objects, const std::filesystem::path& scene,
                                   const std::filesystem::path& exr, const PovrayOptions& options = {},
                                   const Progress& progress = {});

/// Renders the objects of a scene that write_baked_scene wrote, and writes them with their background.
Result<RenderedScene> render_scene(const std::filesystem::path& scene, const std::filesystem::path& exr,
                                   const PovrayOptions& options = {}, const Progress& progress = {});

}  // namespace haarfield
