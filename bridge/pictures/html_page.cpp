#include "bridge/pictures/html_page.h"

#include <fmt/format.h>

namespace haarfield {
namespace {

// The pictures have the same dark background in light and dark mode, so that they look the same.
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

}  // namespace

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

Result<std::string> embedded_image(const Image& image, const std::string& name, const char* kind) {
    const Result<std::string> png = png_bytes(image);
    if (!png) return Error{name, png.error().what};
    return fmt::format(
        R"(<img class="{}" width="{}" height="{}" alt="{}" draggable="false" src="data:image/png;base64,{}">)",
        kind, image.width, image.height, escaped(name), base64(*png));
}

std::string html_head(const std::string& title) {
    return fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n<main>\n",
        escaped(title), style);
}

std::string commands_section(const std::vector<std::string>& commands) {
    if (commands.empty()) return {};
    std::string section = "<section>\n<h2>Commands</h2>\n<pre>";
    for (const std::string& command : commands) section += escaped(command) + "\n";
    return section + "</pre>\n</section>\n";
}

}  // namespace haarfield
