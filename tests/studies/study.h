#pragma once
/// Measurements, as tables on the standard output and as plots. By default, a study uses `vertices` vertices
/// of the shipped scene and one thread. The studies of meshes, occlusion and frames use all threads.

#include "tests/studies/svg_plot.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace haarfield::baseline {

/// Measures time and error of haarfield and of all baselines for the product of six functions, and of ray
/// casting with as many rays as needed for haarfield's error.
void study_baselines(std::size_t vertices);

/// Measures the table of section 3.3: how the time grows with the texels M, the kept wavelets m and the
/// functions n.
std::vector<PlotPanel> study_complexity(std::size_t vertices);

/// Measures figure 4: time and error for each depth of the traversal.
std::vector<PlotPanel> study_depth(std::size_t vertices);

struct MeshStudyOptions {
    /// Folder of the scene's visibility fields, computed if missing.
    std::string fields = "out/study/fields";
    std::string reference;    ///< A picture; empty: that of a finer uniform mesh.
    std::string environment;  ///< A lat-long image; empty: the scene's sky.
    float exposure = 0;       ///< [stops]
};

/// Measures the gain of refinement and of fitted colours: the picture's error and the time of shading for
/// each number of vertices, up to `vertices`. Meshes are uniform or refined, and colours sampled or fitted.
std::vector<PlotPanel> study_meshes(std::size_t vertices, const MeshStudyOptions& options);

/// Measures time and error of the methods for occlusion by other instances, for a scene file with an analytic
/// sky. Meshes with fewer vertices are subdivided to about `vertices`.
void study_occlusion(const std::string& file, std::size_t vertices);

/// Measures the time from a gesture to its frame in a session of `haarfield view`, with and without bounces,
/// on a scene file with an instance of an entity `chair`. Meshes are those of study_occlusion.
void study_view(const std::string& file, std::size_t vertices);

/// Measures the time of a session's frames while light, eye or a chair move, and their difference to commits
/// (RMS over all vertices), with and without bounces. The scene file must have an instance of an entity
/// `chair`.
///
/// environment  a lat-long image; empty: the scene's environment.
void study_relight(const std::string& file, std::size_t vertices, const std::string& environment);

/// Runs a session on a scene file, controlled by the standard input. Each word (light, eye or instance)
/// requests `frames` further frames of that gesture. It prints a line with the minimum wall time of a frame,
/// the minimum total time of all threads [s], and a checksum of the last frame's radiance.
/// tests/python/frame_times.py does the same in Python, alternately.
void study_session(const std::string& file, std::size_t frames);

/// Imports POV-Ray scenes and prints, for each, whether its rewritten text gives the same picture, the
/// fraction of pixels whose silhouettes differ, and the PSNR of unlit pictures. Transparent objects, which
/// remain POV-Ray's, are left out of these pictures.
///
/// detail    as PovrayImport::detail.
/// seconds   wall time after which an import is ended, > 0. [s]
/// pictures  folder that receives the pairs of unlit pictures; empty: none are written.
void study_povray(const std::vector<std::string>& files, int detail, double seconds,
                  const std::string& pictures);

/// Measures the time of the shipped scene's frames under a new light from a new view point, and of their
/// preparation. Meshes are those of study_occlusion.
void study_frame(std::size_t vertices);

/// Measures the time per vertex of many chairs on a floor of 40 m, rotated and not, compared with the shipped
/// scene.
void study_crowd(std::size_t vertices);

struct ErrorStudyOptions {
    /// Bakes to be measured: errors in per cent, `off` (the scene's vertices), `refine` (--refine 0.01).
    std::vector<std::string> targets{"off", "refine", "2", "1", "0.5"};
    std::string environment;    ///< A lat-long image; empty: the scene's environment.
    int width = 0;              ///< Of the picture; 0: the scene's. [pixels]
    std::size_t pixels = 1500;  ///< At which the truth is computed.
    /// Folder for a picture of each bake and a list of its largest errors; empty: none.
    std::filesystem::path pictures;
};

/// Measures the true error of bakes by two independent estimates of the radiance at pixels, with rays and
/// paths. Prints it next to the error that the bake reports, with vertices and processor time, cold and with
/// stored fields.
void study_error(const std::string& file, const ErrorStudyOptions& options);

/// Returns the rows of study_rivals by name.
std::vector<std::string> rival_rows();

struct RivalStudyOptions {
    std::vector<std::string> rows = rival_rows();
    std::size_t points = 2000;  ///< Vertices at which errors are measured.
    double scale = 1;           ///< Factor of the numbers of vertices and of samples of fields.
    int repeats = 2;            ///< Of each bake; the smallest processor time counts.
};

/// Measures whole bakes next to bakes by rays (ray_scene_radiance) with as many samples as the same error
/// requires. Prints a line for direct and one for all light: vertices, error, samples, and the processor and
/// wall times of both, cold (neither meshes nor fields are stored) and warm.
///
/// Errors are relative RMS errors over vertices against two independent estimates by rays and paths, to which
/// their noise does not contribute. The number of samples is interpolated between powers of four. The time of
/// rays is measured with up to 256 samples; beyond, it grows linearly.
void study_rivals(const RivalStudyOptions& options);

/// Returns the folder in which studies cache visibility fields.
inline std::filesystem::path study_fields_folder() {
    return std::filesystem::temp_directory_path() / "haarfield_study_fields";
}

}  // namespace haarfield::baseline
