#include "tests/studies/svg_plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>

namespace haarfield::baseline {
namespace {

std::vector<std::pair<double, double>> polyline_points(const std::string& svg) {
    std::smatch line;
    EXPECT_TRUE(std::regex_search(svg, line, std::regex("<polyline points=\"([^\"]*)\"")));
    const std::string text = line[1];
    const std::regex point("([0-9.]+),([0-9.]+)");
    std::vector<std::pair<double, double>> points;
    for (std::sregex_iterator found(text.begin(), text.end(), point), end; found != end; ++found)
        points.emplace_back(std::stod((*found)[1]), std::stod((*found)[2]));
    return points;
}

TEST(SvgPlot, LogarithmicAxesMakePowersStraightAndPassOverZero) {
    const PlotPanel panel{
        "A & B", {"x", true, {}}, {"y", true, {}}, {{"cubic", {{1, 2}, {10, 2e3}, {50, 0}, {100, 2e6}}}}};
    const std::string svg = svg_plot({panel});
    const auto points = polyline_points(svg);
    ASSERT_EQ(points.size(), 3u);
    EXPECT_NEAR(points[1].first - points[0].first, points[2].first - points[1].first, 0.11);
    EXPECT_NEAR(points[1].second - points[0].second, points[2].second - points[1].second, 0.11);
    EXPECT_LT(points[2].second, points[0].second);  // smaller y is higher
    EXPECT_NE(svg.find("A &amp; B"), std::string::npos);
    EXPECT_NE(svg.find(">cubic<"), std::string::npos);
    EXPECT_NE(svg.find(">10⁷<"), std::string::npos);
}

TEST(SvgPlot, LinearAxesKeepDistances) {
    const PlotPanel panel{
        "", {"x", false, {0, 4}}, {"y", false, {-1, 1}}, {{"line", {{0, -1}, {1, 0}, {4, 1}}}}};
    const auto points = polyline_points(svg_plot({panel}));
    ASSERT_EQ(points.size(), 3u);
    EXPECT_NEAR(4 * (points[1].first - points[0].first), points[2].first - points[0].first, 0.3);
    EXPECT_NEAR(points[0].second - points[1].second, points[1].second - points[2].second, 0.11);
}

}  // namespace
}  // namespace haarfield::baseline
