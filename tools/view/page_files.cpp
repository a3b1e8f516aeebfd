#include "tools/view/page_files.h"

#include <array>
#include <fstream>
#include <iterator>
#include <map>
#include <utility>

namespace haarfield {

// Generated from the folder `page`.
extern const std::map<std::string_view, std::string_view> compiled_page_files;

std::optional<std::string> page_file(std::string_view path) {
    if (path.empty()) path = "index.html";
    const auto compiled = compiled_page_files.find(path);
    if (compiled != compiled_page_files.end()) return std::string(compiled->second);
    for (const char* module : {"build/three.module.js", "examples/jsm/controls/OrbitControls.js",
                               "examples/jsm/controls/TransformControls.js"})
        if (path == std::string("three/") + module) {
            std::ifstream file(std::string(HAARFIELD_THREE_FOLDER "/") + module, std::ios::binary);
            if (!file) return std::nullopt;
            return std::string(std::istreambuf_iterator<char>(file), {});
        }
    return std::nullopt;
}

std::string content_type(std::string_view path) {
    static constexpr std::array<std::pair<std::string_view, const char*>, 8> types{
        {{".html", "text/html; charset=utf-8"},
         {".css", "text/css; charset=utf-8"},
         {".js", "text/javascript; charset=utf-8"},
         {".svg", "image/svg+xml"},
         {".png", "image/png"},
         {".json", "application/json"},
         {".md", "text/plain; charset=utf-8"},
         {".txt", "text/plain; charset=utf-8"}}};
    if (path.empty()) return types[0].second;
    for (const auto& [ending, type] : types)
        if (path.ends_with(ending)) return type;
    return "application/octet-stream";
}

}  // namespace haarfield
