#pragma once
/// Measurements that answer a question of the paper, as a table on the standard output and as a plot. All
/// take so many vertices of the shipped scene; one thread, but for that of meshes.

#include "tests/svg_plot.h"

#include <cstddef>
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

}  // namespace haarfield::baseline
