#pragma once
/// Line plots as SVG text, for the studies.

#include <string>
#include <utility>
#include <vector>

namespace haarfield::baseline {

/// A line with marks at its points. Points that a logarithmic axis cannot show are omitted.
struct PlotSeries {
    std::string name;
    std::vector<std::pair<double, double>> points;
    int colour = 0;  ///< Index in the palette of eight colours. Series of one name share it across panels.
    bool dashed = false;
};

struct PlotAxis {
    std::string label;
    bool logarithmic = true;
    std::vector<double> ticks;  ///< Positions of labels; empty: chosen automatically, at powers of ten.
};

struct PlotPanel {
    std::string title;
    PlotAxis x, y;
    std::vector<PlotSeries> series;
};

/// Returns panels side by side, above one legend of all their series.
std::string svg_plot(const std::vector<PlotPanel>& panels);

}  // namespace haarfield::baseline
