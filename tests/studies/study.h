#pragma once
/// Measurements, as a table on the standard output and as a plot. Unless said otherwise they take so many
/// vertices of the shipped scene; one thread, but for those of meshes, occlusion and frames.

#include "tests/studies/svg_plot.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace haarfield::baseline {

/// Time and error of haarfield and everything that it is measured against, for the product of six functions;
/// and of ray casting, with as many rays as make it as exact as haarfield.
void study_baselines(std::size_t vertices);

/// The table of section 3.3: how the time grows with the texels M, the kept wavelets m and the functions n.
std::vector<PlotPanel> study_complexity(std::size_t vertices);

/// Figure 4: time and error against the depth of the traversal.
std::vector<PlotPanel> study_depth(std::size_t vertices);

struct MeshStudyOptions {
    std::string fields = "out/study/fields";  ///< Folder of the scene's visibility fields; made if missing.
    std::string reference;                    ///< A picture; empty: that of a finer even mesh.
    std::string environment;                  ///< A lat-long image; empty: the scene's sky.
    float exposure = 0;                       ///< [stops]
};

/// What refinement and fitted colours gain: the picture's error and the time of shading against the vertices,
/// for meshes that are even or refined, with colours sampled or fitted; of up to so many vertices.
std::vector<PlotPanel> study_meshes(std::size_t vertices, const MeshStudyOptions& options);

/// Time and error of the ways to see past other instances, for a scene file with an analytic sky. The meshes
/// are subdivided to about so many vertices, if they do not have more.
void study_occlusion(const std::string& file, std::size_t vertices);

/// Time from a gesture to its frame in a session of `haarfield view` on a scene file with an instance of an
/// entity `chair`, with and without bounces; meshes as for study_occlusion.
void study_view(const std::string& file, std::size_t vertices);

/// Time of a session's frames while light, eye or a chair move, and their difference to commits (RMS of all
/// vertices), with and without bounces, on a scene file with an instance of an entity `chair`.
///
/// environment  a lat-long image; empty: the scene's own light.
void study_relight(const std::string& file, std::size_t vertices, const std::string& environment);

/// Frames of a session on a scene file, driven by the standard input: each word there, light, eye or
/// instance, is a gesture of so many frames more, and makes a line of the least time of one, the least time
/// of all its threads [s], and a sum of the bits of the radiance after the last. tests/python/frame_times.py
/// does the same in Python, in turn.
void study_session(const std::string& file, std::size_t frames);

/// Time of the shipped scene's frames under a new light from a new place, and of what is prepared for them;
/// meshes as for study_occlusion.
void study_frame(std::size_t vertices);

/// Time per vertex of many chairs on a floor of 40 m, turned and not, against the shipped scene.
void study_crowd(std::size_t vertices);

/// Where studies keep visibility fields, for the next time.
inline std::filesystem::path study_fields_folder() {
    return std::filesystem::temp_directory_path() / "haarfield_study_fields";
}

}  // namespace haarfield::baseline
