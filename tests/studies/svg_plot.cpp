#include "tests/studies/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace haarfield::baseline {
namespace {

// Palette of Okabe and Ito 2008, suitable for colour-blind readers.
constexpr std::array<const char*, 8> palette{"#000000", "#0072b2", "#d55e00", "#009e73",
                                             "#cc79a7", "#e69f00", "#56b4e9", "#777777"};

constexpr double panel_width = 300, panel_height = 260;  // of the plot area
constexpr double left_margin = 62, top_margin = 34, bottom_margin = 52, gap = 26;
constexpr double legend_row = 20, legend_column = 245;

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text)
        result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
    return result;
}

std::string text(double x, double y, const char* anchor, const std::string& content, const char* more = "") {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y, anchor, more,
                       escaped(content));
}

std::string line(double x1, double y1, double x2, double y2, const char* colour) {
    return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"/>\n", x1,
                       y1, x2, y2, colour);
}

/// Maps values to the unit interval.
struct Scale {
    bool logarithmic;
    double lower, upper;
    std::vector<double> ticks;

    Scale(const PlotAxis& axis, std::vector<double> values)
        : logarithmic(axis.logarithmic), ticks(axis.ticks) {
        values.insert(values.end(), ticks.begin(), ticks.end());
        if (logarithmic) std::erase_if(values, [](double value) { return !(value > 0); });
        lower = *std::min_element(values.begin(), values.end());
        upper = *std::max_element(values.begin(), values.end());
        if (ticks.empty()) {
            lower = std::pow(10, std::floor(std::log10(lower)));
            upper = std::pow(10, std::ceil(std::log10(upper)));
            for (double tick = lower; tick < upper * 1.01; tick *= 10) ticks.push_back(tick);
        }
        // Marks at the ends must not overlap the frame.
        const double margin = 0.04;
        const double from = mapped(lower), to = mapped(upper);
        first_ = from - margin * (to - from);
        range_ = (to - from) * (1 + 2 * margin);
    }

    bool shows(double value) const { return std::isfinite(value) && (!logarithmic || value > 0); }
    double operator()(double value) const { return (mapped(value) - first_) / range_; }

private:
    double mapped(double value) const { return logarithmic ? std::log10(value) : value; }
    double first_ = 0, range_ = 1;
};

/// Powers of ten from 10,000 on use exponents.
std::string tick_text(double value) {
    const double power = std::log10(value);
    if (value < 1e4 || power != std::floor(power)) return fmt::format("{:.6g}", value);
    constexpr std::array<const char*, 10> superscript{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    std::string exponent;
    for (const char digit : fmt::format("{:.0f}", power)) exponent += superscript[std::size_t(digit - '0')];
    return "10" + exponent;
}

std::string mark(double x, double y, const PlotSeries& series) {
    return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"{}\"/>\n", x, y,
                       series.dashed ? "white" : palette[std::size_t(series.colour)]);
}

std::string stroke(const PlotSeries& series) {
    return fmt::format("stroke=\"{}\" stroke-width=\"1.6\"{}", palette[std::size_t(series.colour)],
                       series.dashed ? " stroke-dasharray=\"5 3\"" : "");
}

std::string panel_svg(const PlotPanel& panel, double left) {
    std::vector<double> xs, ys;
    for (const PlotSeries& series : panel.series)
        for (const auto& [x, y] : series.points) {
            xs.push_back(x);
            ys.push_back(y);
        }
    const Scale x_scale(panel.x, xs), y_scale(panel.y, ys);
    const auto at_x = [&](double value) { return left + panel_width * x_scale(value); };
    const auto at_y = [&](double value) { return top_margin + panel_height * (1 - y_scale(value)); };
    const double bottom = top_margin + panel_height, right = left + panel_width;

    std::string svg =
        text(left + panel_width / 2, top_margin - 12, "middle", panel.title, " font-weight=\"bold\"");
    for (const double tick : y_scale.ticks) {
        svg += line(left, at_y(tick), right, at_y(tick), "#dddddd");
        svg += text(left - 6, at_y(tick) + 4, "end", tick_text(tick));
    }
    for (const double tick : x_scale.ticks) {
        svg += line(at_x(tick), top_margin, at_x(tick), bottom, "#dddddd");
        svg += text(at_x(tick), bottom + 17, "middle", tick_text(tick));
    }
    svg += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#666666\"/>\n",
        left, top_margin, panel_width, panel_height);
    svg += text(left + panel_width / 2, bottom + 38, "middle", panel.x.label);
    const double label_x = left - 46, label_y = top_margin + panel_height / 2;
    svg += text(label_x, label_y, "middle", panel.y.label,
                fmt::format(" transform=\"rotate(-90 {:.1f} {:.1f})\"", label_x, label_y).c_str());
    for (const PlotSeries& series : panel.series) {
        std::string places, marks;
        for (const auto& [x, y] : series.points) {
            if (!x_scale.shows(x) || !y_scale.shows(y)) continue;
            places += fmt::format("{:.1f},{:.1f} ", at_x(x), at_y(y));
            marks += mark(at_x(x), at_y(y), series);
        }
        svg +=
            fmt::format("<polyline points=\"{}\" fill=\"none\" {}/>\n<g {}>{}</g>\n", places, stroke(series),
                        fmt::format("stroke=\"{}\"", palette[std::size_t(series.colour)]), marks);
    }
    return svg;
}

}  // namespace

std::string svg_plot(const std::vector<PlotPanel>& panels) {
    std::vector<const PlotSeries*> named;
    for (const PlotPanel& panel : panels)
        for (const PlotSeries& series : panel.series)
            if (std::none_of(named.begin(), named.end(),
                             [&](const auto* n) { return n->name == series.name; }))
                named.push_back(&series);

    const double width = static_cast<double>(panels.size()) * (left_margin + panel_width + gap);
    const auto columns =
        std::max<std::size_t>(1, static_cast<std::size_t>((width - left_margin) / legend_column));
    const std::size_t rows = (named.size() + columns - 1) / columns;
    const double legend_top = top_margin + panel_height + bottom_margin;
    const double height = legend_top + legend_row * static_cast<double>(rows) + 8;

    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 "
        "{0:.0f} {1:.0f}\" "
        "font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\">\n"
        "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        width, height);
    double left = left_margin;
    for (const PlotPanel& panel : panels) {
        svg += panel_svg(panel, left);
        left += panel_width + gap + left_margin;
    }
    for (std::size_t i = 0; i < named.size(); ++i) {
        const double x = left_margin + legend_column * static_cast<double>(i % columns);
        const double y = legend_top + 10 + legend_row * static_cast<double>(i / columns);
        svg += fmt::format("<line x1=\"{0:.1f}\" y1=\"{2:.1f}\" x2=\"{1:.1f}\" y2=\"{2:.1f}\" {3}/>\n", x,
                           x + 26, y, stroke(*named[i]));
        svg += text(x + 33, y + 4, "start", named[i]->name);
    }
    return svg + "</svg>\n";
}

}  // namespace haarfield::baseline
