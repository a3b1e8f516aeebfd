#include "bridge/pictures/comparison_report.h"
#include "bridge/pictures/html_page.h"
#include "fields/file/write_file.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {
namespace {

constexpr int histogram_bins = 40;

// Flipping between the two pictures reveals differences that a slider does not.
constexpr const char* script = R"(
const swipe = document.querySelector('.swipe'), range = document.querySelector('#split');
let flipping = 0;
function split(percent) { range.value = percent; swipe.style.setProperty('--split', percent + '%'); }
function stop() { clearInterval(flipping); flipping = 0; document.querySelector('#flip').textContent = 'Flip'; }
function drag(event) {
  if (event.type === 'pointermove' && !event.buttons) return;
  stop();
  const box = swipe.getBoundingClientRect();
  split(Math.min(100, Math.max(0, 100 * (event.clientX - box.left) / box.width)));
}
swipe.addEventListener('pointerdown', drag);
swipe.addEventListener('pointermove', drag);
range.addEventListener('input', () => { stop(); split(range.value); });
document.querySelectorAll('[data-split]').forEach(b =>
  b.addEventListener('click', () => { stop(); split(b.dataset.split); }));
document.querySelector('#flip').addEventListener('click', event => {
  if (flipping) { stop(); split(50); return; }
  event.target.textContent = 'Stop';
  split(100);
  flipping = setInterval(() => split(range.value > 50 ? 0 : 100), 600);
});
)";

std::string css_colour(float error) {
    const auto [r, g, b] = error_colour(error);
    return fmt::format("#{:02x}{:02x}{:02x}", r, g, b);
}

/// Returns the end of the error scale: a round number that at most 1 % of the pixels exceed.
float shown_error(const ImageDifference& difference) {
    for (float end : {0.05f, 0.1f, 0.2f, 0.5f})
        if (difference.flip_99 <= static_cast<double>(end)) return end;
    return 1.0f;
}

std::string legend(float brightest) {
    std::string stops;
    for (int k = 0; k <= 16; ++k)
        stops += fmt::format("{}{}", k ? ", " : "", css_colour(static_cast<float>(k) / 16));
    return fmt::format(
        "<div class=\"legend\" style=\"background: linear-gradient(90deg, {})\"></div>\n"
        "<div class=\"ends\"><span>0 equal</span><span>{:.3g}</span><span>{:.3g} and above</span></div>\n",
        stops, brightest / 2, brightest);
}

/// Draws a histogram in the colours of the error picture, with a line at the mean. Bar heights grow with the
/// square root of the pixel fraction, so that few large errors remain visible among many small ones.
std::string histogram(const ImageDifference& difference, float brightest) {
    constexpr double width = 480, height = 230, left = 44, bottom = 26, top = 18;
    const std::vector<std::uint64_t> counts = error_histogram(difference, histogram_bins, brightest);
    const double all = static_cast<double>(difference.pixels);
    const double highest = static_cast<double>(*std::max_element(counts.begin(), counts.end())) / all;
    const double plot_width = width - left, plot_height = height - bottom - top;
    const double bar = plot_width / histogram_bins;
    std::string svg = fmt::format(
        "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"Histogram of the perceptual error\">\n", width,
        height);
    for (double share : {0.1, 0.5, 1.0}) {
        const double y = top + plot_height * (1 - std::sqrt(share));
        svg += fmt::format(
            "<line x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" stroke=\"var(--line)\"/>"
            "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:.2g} %</text>\n",
            left, width, y, left - 8, y + 4, 100 * highest * share);
    }
    for (int k = 0; k < histogram_bins; ++k) {
        const double share =
            std::sqrt(static_cast<double>(counts[static_cast<std::size_t>(k)]) / all / highest);
        if (share == 0) continue;
        const float middle = (static_cast<float>(k) + 0.5f) / histogram_bins;
        svg += fmt::format(
            "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" rx=\"1\" fill=\"{}\" "
            "stroke=\"var(--soft)\" stroke-width=\"0.4\"><title>{:.3g} to {:.3g}: {} pixels</title></rect>\n",
            left + k * bar + 0.5, top + plot_height * (1 - share), bar - 1, plot_height * share,
            css_colour(middle), brightest * static_cast<float>(k) / histogram_bins,
            brightest * static_cast<float>(k + 1) / histogram_bins, counts[static_cast<std::size_t>(k)]);
    }
    const double mean = left + plot_width * std::min(1.0, difference.flip / static_cast<double>(brightest));
    svg += fmt::format(
        "<line x1=\"{0}\" x2=\"{1}\" y1=\"{2}\" y2=\"{2}\" stroke=\"var(--soft)\"/>\n"
        "<line x1=\"{3:.1f}\" x2=\"{3:.1f}\" y1=\"{4}\" y2=\"{2}\" stroke=\"var(--mark)\" "
        "stroke-width=\"1.5\"/>\n"
        "<text x=\"{5:.1f}\" y=\"12\" text-anchor=\"{6}\">mean {7:.3f}</text>\n"
        "<text x=\"{0}\" y=\"{8}\">0</text><text x=\"{1}\" y=\"{8}\" text-anchor=\"end\">{9:.3g} and "
        "above</text>\n"
        "</svg>\n",
        left, width, height - bottom, mean, top - 2, mean, mean > width - 60 ? "end" : "start",
        difference.flip, height - 8, brightest);
    return svg;
}

std::string tile(const std::string& value, const char* unit, const char* name) {
    return fmt::format("<div class=\"tile\"><b>{}<small>{}</small></b><span>{}</span></div>\n", value, unit,
                       name);
}

std::string row(const std::string& name, const std::string& value, const char* note) {
    return fmt::format("<tr><th>{}</th><td class=\"value\">{}</td><td class=\"note\">{}</td></tr>\n",
                       escaped(name), escaped(value), note);
}

std::string numbers(const ComparisonReport& report) {
    const ImageDifference& d = *report.difference;
    const double all = static_cast<double>(d.mask.size());
    std::string table = "<table>\n";
    table += row("PSNR", fmt::format("{:.2f} dB", d.psnr_db),
                 "of sRGB values clamped to [0, 1]; 99: equal pictures");
    table += row("Relative RMSE", fmt::format("{:.3f} %", 100 * d.relative_rmse),
                 "of linear radiance, relative to the root mean square of the reference");
    table += row("RMSE", fmt::format("{:.5g}", d.rmse), "of linear radiance, W/(m&sup2; sr)");
    table += row("Bias", fmt::format("{:+.2f} %", 100 * d.bias), "of the mean radiance");
    table +=
        row("SSIM", fmt::format("{:.4f}", d.ssim), "of sRGB luma, 11 &times; 11 Gaussian window; 1: equal");
    table += row("FLIP, mean", fmt::format("{:.4f}", d.flip),
                 "perceptual error at 67 pixels per degree, after Andersson et al. 2020; 0: equal");
    table +=
        row("FLIP, 99 %", fmt::format("{:.4f}", d.flip_99), "99 % of the pixels have at most this error");
    table += row("Pixels",
                 fmt::format("{} of {} ({:.0f} %)", d.pixels, d.mask.size(),
                             100 * static_cast<double>(d.pixels) / all),
                 "covered by both pictures; the background is excluded");
    for (const auto& [name, value] : report.facts) table += row(name, value, "");
    return table + "</table>\n";
}

}  // namespace

Result<Done> write_comparison_report(const ComparisonReport& report, const std::filesystem::path& file) {
    assert(report.image && report.reference && report.difference);
    const ImageDifference& difference = *report.difference;
    const int width = report.image->width, height = report.image->height;
    if (report.reference->width != width || report.reference->height != height ||
        difference.mask.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
        return Error{file.string(), "the pictures have different sizes"};
    const float brightest = shown_error(difference);
    HF_TRY(const std::string image, embedded_image(*report.image, report.image_name, "first"));
    HF_TRY(const std::string reference, embedded_image(*report.reference, report.reference_name, "second"));
    HF_TRY(const std::string picture, embedded_image(difference_picture(difference, width, height, brightest),
                                                     "difference", "difference"));

    const std::string first = escaped(report.image_name), second = escaped(report.reference_name);
    std::string page =
        html_head(fmt::format("{}: {} and {}", report.title, report.image_name, report.reference_name));
    page += fmt::format("<h1>{}</h1>\n<p class=\"lead\">{} compared with {}, {} &times; {} pixels</p>\n",
                        escaped(report.title), first, second, width, height);

    page += "<div class=\"tiles\">\n" + tile(fmt::format("{:.1f}", difference.psnr_db), "dB", "PSNR") +
            tile(fmt::format("{:.2f}", 100 * difference.relative_rmse), "%", "relative error") +
            tile(fmt::format("{:+.2f}", 100 * difference.bias), "%", "mean brightness") +
            tile(fmt::format("{:.4f}", difference.ssim), "", "SSIM") +
            tile(fmt::format("{:.4f}", difference.flip), "", "FLIP, mean") + "</div>\n";

    page += fmt::format(
        "<section>\n<div class=\"stage swipe\">{}{}<i class=\"left\">{}</i><i class=\"right\">{}</i></div>\n"
        "<div class=\"bar\"><button data-split=\"100\">{}</button>"
        "<input id=\"split\" type=\"range\" min=\"0\" max=\"100\" value=\"50\" step=\"0.1\" "
        "aria-label=\"visible fraction of the first picture\">"
        "<button data-split=\"0\">{}</button><button id=\"flip\">Flip</button></div>\n</section>\n",
        reference, image, first, second, first, second);

    page += fmt::format(
        "<section class=\"two\">\n<figure><h2>Where they differ</h2><div class=\"stage\">{}</div>\n{}"
        "<figcaption>Perceptual error (FLIP).</figcaption></figure>\n"
        "<figure><h2>How often they differ</h2>\n{}"
        "<figcaption>Fraction of the pixels by perceptual error; square-root "
        "scale.</figcaption></figure>\n</section>\n",
        picture, legend(brightest), histogram(difference, brightest));

    page += "<section>\n<h2>Numbers</h2>\n" + numbers(report) + "</section>\n";
    page += commands_section(report.commands);
    page += fmt::format("</main>\n<script>{}</script>\n</body>\n</html>\n", script);
    return write_file(file, page);
}

}  // namespace haarfield
