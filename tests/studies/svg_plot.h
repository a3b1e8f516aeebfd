#pragma once
/// Line plots as SVG text: what the studies show.

#include <string>
#include <utility>
#include <vector>

namespace haarfield::baseline {

/// A line with marks at its points. Points that a logarithmic axis can not show are left out.
struct PlotSeries {
    std::string name;
    std::vector<std::pair<double, double>> points;
    int colour = 0;  ///< Which of the palette's eight; series of one name share it across panels.
    bool dashed = false;
};

struct PlotAxis {
    std::string label;
    bool logarithmic = true;
    std::vector<double> ticks;  ///< Where to write numbers; empty: chosen, at powers of ten.
};

struct PlotPanel {
    std::string title;
    PlotAxis x, y;
    std::vector<PlotSeries> series;
};

/// Panels side by side, over one legend of all their series.
std::string svg_plot(const std::vector<PlotPanel>& panels);

}  // namespace haarfield::baseline
