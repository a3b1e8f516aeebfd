#include "bridge/pictures/budget_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "bridge/pictures/html_page.h"
#include "fields/file/write_file.h"

namespace haarfield {
namespace {

/// Plots a bar for the relative RMSE of each approximation and a whisker up to the 99th percentile, on a
/// logarithmic scale that starts at 0.01 %.
std::string plot(std::span<const BudgetEntry> entries) {
    constexpr double width = 860, left = 150, right = 20, top = 24, step = 28, least = 1e-4;
    double most = 0.1;
    for (const BudgetEntry& entry : entries) most = std::max({most, entry.relative_rmse, entry.relative_99});
    const double decades = std::ceil(std::log10(most / least));
    const double height = top + step * double(entries.size()) + 8;
    const auto at = [&](double value) {
        return left + (width - left - right) * std::clamp(std::log10(value / least) / decades, 0.0, 1.0);
    };
    std::string svg = fmt::format(
        "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"Relative error of each approximation\">\n",
        width, height);
    for (int decade = 0; decade <= int(decades); ++decade) {
        const double value = least * std::pow(10, decade);
        svg += fmt::format(
            "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\" stroke=\"var(--line)\"/>"
            "<text x=\"{0:.1f}\" y=\"14\" text-anchor=\"middle\">{3:g} %</text>\n",
            at(value), top - 4, height, 100 * value);
    }
    for (std::size_t k = 0; k < entries.size(); ++k) {
        const BudgetEntry& entry = entries[k];
        const double y = top + step * double(k), middle = y + step / 2;
        svg += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", left - 10,
                           middle + 4, escaped(entry.name));
        if (entry.relative_99 > least)
            svg += fmt::format(
                "<line x1=\"{0}\" x2=\"{1:.1f}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" stroke=\"var(--soft)\"/>\n",
                left, at(entry.relative_99), middle);
        if (entry.relative_rmse > least)
            svg += fmt::format(
                "<rect x=\"{}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{}\" rx=\"2\" "
                "fill=\"var(--mark)\"><title>{}: {:.3f} %</title></rect>\n",
                left, y + 6, at(entry.relative_rmse) - left, step - 12, escaped(entry.name),
                100 * entry.relative_rmse);
    }
    return svg + "</svg>\n";
}

std::string table(std::span<const BudgetEntry> entries) {
    std::string text =
        "<table>\n<tr><th>approximation</th><th>relative RMSE</th><th>99 %</th><th>bias</th>"
        "<th>points</th><th></th></tr>\n";
    for (const BudgetEntry& entry : entries)
        text += fmt::format(
            "<tr><th>{}</th><td>{:.3f} %</td><td>{:.2f} %</td><td>{:+.3f} %</td><td>{}</td>"
            "<td class=\"note\">{}</td></tr>\n",
            escaped(entry.name), 100 * entry.relative_rmse, 100 * entry.relative_99, 100 * entry.bias,
            entry.points, escaped(entry.meaning));
    return text + "</table>\n";
}

std::string marks(const BudgetReport& report) {
    std::string svg = fmt::format("<svg viewBox=\"0 0 {} {}\" style=\"position: absolute; inset: 0\">\n",
                                  report.preview->width, report.preview->height);
    for (const BudgetReport::Mark& mark : report.worst)
        svg += fmt::format(
            "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5\" fill=\"none\" stroke=\"#f0f\" stroke-width=\"1.5\">"
            "<title>{:.1f} %</title></circle>\n",
            mark.x, mark.y, 100 * mark.relative_error);
    return svg + "</svg>";
}

}  // namespace

Result<Done> write_budget_report(const BudgetReport& report, const std::filesystem::path& file) {
    assert(report.preview);
    HF_TRY(const std::string preview, embedded_image(*report.preview, "preview", "first-view"));
    std::string page = html_head(report.title + ": error budget");
    page += fmt::format(
        "<h1>{}</h1>\n<p class=\"lead\">Error of each approximation alone, at {} random vertices, relative "
        "to the dense oracle</p>\n<section>\n{}<p class=\"note\">Bars: RMS of the error / RMS of the "
        "radiance. Lines: 99 % of the points have a smaller "
        "error.</p>\n</section>\n<section>\n{}</section>\n",
        escaped(report.title), report.vertices, plot(report.entries), table(report.entries));
    page += fmt::format(
        "<section>\n<figure><h2>The worst vertices</h2><div class=\"stage\">{}{}</div>\n<figcaption>The "
        "measured vertices with the largest errors relative to the finest oracle, where they are visible in "
        "the preview.</figcaption></figure>\n</section>\n",
        preview, marks(report));
    if (report.oracle)
        page += fmt::format(
            "<section>\n"
            "<h2>Validation of the oracle</h2>\n"
            "<p>At {} of {} points the oracle agrees with POV-Ray's ray tracer within the ray tracer's "
            "uncertainty (99 %). Relative RMSE {:.3f} %; the ray tracer's own error, estimated from its two "
            "sets of lights: {:.3f} %; bias {:+.3f} %.</p>\n"
            "</section>\n",
            report.oracle->agreeing, report.oracle->points, 100 * report.oracle->relative_rmse,
            100 * report.oracle->reference_error, 100 * report.oracle->bias);
    page += commands_section(report.commands) + "</main>\n</body>\n</html>\n";
    return write_file(file, page);
}

}  // namespace haarfield
