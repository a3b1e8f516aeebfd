#pragma once
/// Runs POV-Ray as a child process without a window, with progress and interruption.

#include "fields/base/progress.h"
#include "scenes/image.h"
#include "scenes/scene.h"

namespace haarfield {

/// POV-Ray's render settings.
struct PovrayOptions {
    std::string program = "povray";  ///< A path, or a name to be looked up in PATH.
    int width = 640, height = 480;   ///< [pixels]
    int threads = 0;                 ///< 0: all cores.
    int antialiasing = 0;            ///< n: n x n rays per pixel, and one at its centre; 0: its centre alone.
    /// Only pixels that differ from a neighbour by more than this threshold (sRGB-encoded) get the n x n
    /// rays; 0: all pixels. With a dome of many lights, 0.05 is about ten times faster and looks the same.
    double antialiasing_threshold = 0;
    std::vector<std::string> declarations;  ///< Each is set to 1 before the scene is parsed.
    /// The rows to render, from first_row up to but excluding last_row; 0 and 0: all. The other rows are
    /// black. The rendered rows are bit-identical to those of the whole picture if both numbers are multiples
    /// of 32, or if last_row is the height: POV-Ray decides by blocks of 32 rows which pixels get more rays.
    int first_row = 0, last_row = 0;
    /// POV-Ray is ended if it reports no progress for this time. It reports parsing and pixels, but nothing
    /// while it builds the hierarchies of meshes at the end of parsing. [s]
    double patience = 600;
};

/// Returns options for a picture of the camera's resolution with n x n rays where pixels differ from their
/// neighbours.
PovrayOptions picture_options(const Camera& camera, int antialiasing);

/// One run of POV-Ray.
struct PovrayRun {
    std::string command_line;                     ///< The command line in shell syntax.
    double parse_seconds = 0, trace_seconds = 0;  ///< Wall times from POV-Ray's log.
    std::vector<std::string> warnings;            ///< POV-Ray's warnings, one line each.
};

/// Renders a scene file to a half-float EXR with alpha.
///
/// POV-Ray looks up includes and images in the scene's folder. The picture appears under its name only when
/// it is complete. No other file remains, even after an error.
///
/// progress  reported in pixels, as stage `POV-Ray`.
/// errors    the program does not exist; POV-Ray's messages (parse errors with file and line) if it fails, is
///           ended by a signal or writes no picture; no output for longer than `patience`; interrupted: the
///           child is ended within 50 ms.
/// cost      0.5 s to start, then POV-Ray's.
Result<PovrayRun> run_povray(const std::filesystem::path& scene, const std::filesystem::path& exr,
                             const PovrayOptions& options = {}, const Progress& progress = {});

/// A picture and the run that rendered it.
struct RenderedScene {
    Image image;
    PovrayRun run;
};

/// Renders like run_povray, but into memory.
Result<RenderedScene> rendered_scene(const std::filesystem::path& scene, const PovrayOptions& options = {},
                                     const Progress& progress = {});

/// Writes `exr`, the rendered objects of a scene with their coverage, and a .png of the same stem next to it,
/// with the objects over the scene's background. The background takes a separate POV-Ray run without the
/// objects: half a second.
Result<Done> write_with_background(const Image& objects, const std::filesystem::path& scene,
                                   const std::filesystem::path& exr, const PovrayOptions& options = {},
                                   const Progress& progress = {});

/// Renders the objects of a scene by write_baked_scene, and writes them with their background.
Result<RenderedScene> render_scene(const std::filesystem::path& scene, const std::filesystem::path& exr,
                                   const PovrayOptions& options = {}, const Progress& progress = {});

}  // namespace haarfield
