#pragma once
/// Measurements that answer a question of the paper, as a table on the standard output and as a plot. All
/// take so many vertices of the shipped scene, and one thread.

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

}  // namespace haarfield::baseline
