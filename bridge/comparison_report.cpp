#include "bridge/comparison_report.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {
namespace {

constexpr int histogram_bins = 40;

// The pictures stand on the same dark stage in light and in dark mode, so that they look the same.
constexpr const char* style = R"(
:root { color-scheme: light dark; --ink: #1d1f23; --soft: #6a6f78; --line: #e2e4e8; --page: #fafafa;
  --card: #fff; --stage: #26282c; --mark: #b3476a; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8e9ec; --soft: #9aa0aa; --line: #34373d;
  --page: #17181b; --card: #1f2125; --stage: #101113; --mark: #e58aa6; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
main { max-width: 1080px; margin: 0 auto; padding: 40px 24px 64px; }
h1 { font-size: 28px; line-height: 1.2; font-weight: 650; letter-spacing: -0.01em; margin: 0; }
h2 { font-size: 16px; font-weight: 600; margin: 0 0 12px; }
.lead { color: var(--soft); margin: 6px 0 28px; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: 1px; margin-bottom: 28px;
  background: var(--line); border: 1px solid var(--line); border-radius: 10px; overflow: hidden; }
.tile { background: var(--card); padding: 14px 18px 12px; }
.tile b { display: block; font-size: 25px; font-weight: 600; letter-spacing: -0.01em; white-space: nowrap;
  font-variant-numeric: tabular-nums; }
.tile small { font-size: 15px; font-weight: 400; color: var(--soft); margin-left: 3px; }
.tile span, figcaption, .note { color: var(--soft); font-size: 13px; }
section { margin-bottom: 36px; }
.stage { position: relative; background: var(--stage); border-radius: 10px; overflow: hidden; line-height: 0; }
.stage img { width: 100%; height: auto; display: block; }
.swipe { --split: 50%; cursor: ew-resize; touch-action: pan-y; user-select: none; }
.swipe .first { position: absolute; inset: 0; clip-path: inset(0 calc(100% - var(--split)) 0 0); }
.swipe::after { content: ""; position: absolute; top: 0; bottom: 0; left: calc(var(--split) - 1px); width: 2px;
  background: #fff; box-shadow: 0 0 4px #0009; }
.swipe i { position: absolute; top: 12px; padding: 3px 10px; border-radius: 20px; background: #000a; color: #fff;
  font: 500 12px/1.5 system-ui, sans-serif; z-index: 1; pointer-events: none; }
.swipe i.left { left: 12px; } .swipe i.right { right: 12px; }
.bar { display: flex; flex-wrap: wrap; gap: 8px; align-items: center; margin-top: 12px; }
.bar input { flex: 1 1 200px; accent-color: var(--mark); margin: 0; }
button { font: inherit; font-size: 13px; color: inherit; background: var(--card); border: 1px solid var(--line);
  border-radius: 7px; padding: 4px 12px; cursor: pointer; }
button:hover, button:focus-visible { border-color: var(--soft); }
.two { display: grid; grid-template-columns: repeat(auto-fit, minmax(320px, 1fr)); gap: 28px; align-items: start; }
figure { margin: 0; }
figcaption { margin-top: 8px; }
.legend { height: 10px; border-radius: 5px; margin-top: 12px; }
.ends { display: flex; justify-content: space-between; color: var(--soft); font-size: 12px; margin-top: 4px;
  font-variant-numeric: tabular-nums; }
svg { width: 100%; height: auto; display: block; }
svg text { fill: var(--soft); font: 12px system-ui, "DejaVu Sans", sans-serif; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; padding: 8px 16px 8px 0; border-bottom: 1px solid var(--line); vertical-align: top; }
th { font-weight: 500; white-space: nowrap; }
td { font-variant-numeric: tabular-nums; }
td.value { white-space: nowrap; }
td.note { width: 60%; }
pre { margin: 0; padding: 14px 18px; background: var(--card); border: 1px solid var(--line); border-radius: 10px;
  overflow-x: auto; font: 13px/1.6 ui-monospace, "DejaVu Sans Mono", monospace; }
)";

// Flipping between two pictures in place shows differences that no slider does.
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

std::string escaped(const std::string& text) {
    std::string result;
    for (char c : text) switch (c) {
            case '&': result += "&amp;"; break;
            case '<': result += "&lt;"; break;
            case '>': result += "&gt;"; break;
            case '"': result += "&quot;"; break;
            default: result += c;
        }
    return result;
}

std::string base64(const std::string& bytes) {
    static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k)
            bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            text += i + k <= bytes.size() ? digits[bits >> (18 - 6 * k) & 63u] : '=';
    }
    return text;
}

Result<std::string> embedded(const Image& image, const std::string& name, const char* kind) {
    const Result<std::string> png = png_bytes(image);
    if (!png) return Error{name, png.error().what};
    return fmt::format(
        R"(<img class="{}" width="{}" height="{}" alt="{}" draggable="false" src="data:image/png;base64,{}">)",
        kind, image.width, image.height, escaped(name), base64(*png));
}

std::string css_colour(float error) {
    const auto [r, g, b] = error_colour(error);
    return fmt::format("#{:02x}{:02x}{:02x}", r, g, b);
}

/// The scale's end: a round number that hardly any pixel exceeds.
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

/// Bars in the colours of the picture beside it; a line at the mean. Heights grow with the square root of
/// the share: or the many small errors would hide the few large ones.
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
    table += row("PSNR", fmt::format("{:.2f} dB", d.psnr_db), "of sRGB values clamped to [0, 1]; 99: equal");
    table += row("Relative RMSE", fmt::format("{:.3f} %", 100 * d.relative_rmse),
                 "of linear radiance, over the root mean square of the reference");
    table += row("RMSE", fmt::format("{:.5g}", d.rmse), "of linear radiance, W/(m&sup2; sr)");
    table += row("Bias", fmt::format("{:+.2f} %", 100 * d.bias), "of the mean radiance");
    table +=
        row("SSIM", fmt::format("{:.4f}", d.ssim), "of sRGB luma, 11 &times; 11 Gaussian window; 1: equal");
    table += row("FLIP, mean", fmt::format("{:.4f}", d.flip),
                 "perceptual error at 67 pixels a degree, after Andersson et al. 2020; 0: equal");
    table += row("FLIP, 99 %", fmt::format("{:.4f}", d.flip_99),
                 "all but one pixel in a hundred are at most this");
    table += row("Pixels",
                 fmt::format("{} of {} ({:.0f} %)", d.pixels, d.mask.size(),
                             100 * static_cast<double>(d.pixels) / all),
                 "covered by both pictures; the background is left out");
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
        return Error{file.string(), "the pictures differ in size"};
    const float brightest = shown_error(difference);
    const Result<std::string> image = embedded(*report.image, report.image_name, "first");
    if (!image) return image.error();
    const Result<std::string> reference = embedded(*report.reference, report.reference_name, "second");
    if (!reference) return reference.error();
    const Result<std::string> picture =
        embedded(difference_picture(difference, width, height, brightest), "difference", "difference");
    if (!picture) return picture.error();

    const std::string first = escaped(report.image_name), second = escaped(report.reference_name);
    std::string page = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<title>{0}: {1} and {2}</title>\n<style>{3}</style>\n</head>\n<body>\n<main>\n"
        "<h1>{0}</h1>\n<p class=\"lead\">{1} compared with {2}, {4} &times; {5} pixels</p>\n",
        escaped(report.title), first, second, style, width, height);

    page += "<div class=\"tiles\">\n" + tile(fmt::format("{:.1f}", difference.psnr_db), "dB", "PSNR") +
            tile(fmt::format("{:.2f}", 100 * difference.relative_rmse), "%", "relative error") +
            tile(fmt::format("{:+.2f}", 100 * difference.bias), "%", "mean brightness") +
            tile(fmt::format("{:.4f}", difference.ssim), "", "SSIM") +
            tile(fmt::format("{:.4f}", difference.flip), "", "FLIP, mean") + "</div>\n";

    page += fmt::format(
        "<section>\n<div class=\"stage swipe\">{}{}<i class=\"left\">{}</i><i class=\"right\">{}</i></div>\n"
        "<div class=\"bar\"><button data-split=\"100\">{}</button>"
        "<input id=\"split\" type=\"range\" min=\"0\" max=\"100\" value=\"50\" step=\"0.1\" "
        "aria-label=\"how much of the first picture is shown\">"
        "<button data-split=\"0\">{}</button><button id=\"flip\">Flip</button></div>\n</section>\n",
        *reference, *image, first, second, first, second);

    page += fmt::format(
        "<section class=\"two\">\n<figure><h2>Where they differ</h2><div class=\"stage\">{}</div>\n{}"
        "<figcaption>Perceptual error (FLIP).</figcaption></figure>\n"
        "<figure><h2>How often they differ</h2>\n{}"
        "<figcaption>Share of the pixels by perceptual error; square-root "
        "scale.</figcaption></figure>\n</section>\n",
        *picture, legend(brightest), histogram(difference, brightest));

    page += "<section>\n<h2>Numbers</h2>\n" + numbers(report) + "</section>\n";
    if (!report.commands.empty()) {
        page += "<section>\n<h2>Commands</h2>\n<pre>";
        for (const std::string& command : report.commands) page += escaped(command) + "\n";
        page += "</pre>\n</section>\n";
    }
    page += fmt::format("</main>\n<script>{}</script>\n</body>\n</html>\n", script);
    return write_file(file, page);
}

}  // namespace haarfield
