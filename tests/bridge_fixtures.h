#pragma once
/// Small scenes and a folder of one's own, for the tests of the bridge.

#include "bridge/povray_scene.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/example_meshes.h"

namespace haarfield {

/// An empty folder, removed with what is in it.
class TestFolder {
public:
    TestFolder() {
        std::string pattern = (std::filesystem::temp_directory_path() / "haarfield-test-XXXXXX").string();
        if (!::mkdtemp(pattern.data())) std::abort();
        path_ = pattern;
    }
    ~TestFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TestFolder(const TestFolder&) = delete;
    TestFolder& operator=(const TestFolder&) = delete;

    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    const std::filesystem::path& path() const { return path_; }

    /// Names of all files below, sorted.
    std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(path_))
            names.push_back(std::filesystem::relative(entry.path(), path_).string());
        std::sort(names.begin(), names.end());
        return names;
    }

private:
    std::filesystem::path path_;
};

inline std::string text_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::stringstream text;
    text << stream.rdbuf();
    return text.str();
}

inline LatLongImage constant_environment(int height, const Rgb& radiance) {
    LatLongImage image{2 * height, height, {}};
    image.pixels.assign(static_cast<std::size_t>(2 * height * height), radiance);
    return image;
}

/// A camera at (0, 0, distance) that looks at the origin: a square of half edge 1 fills the picture.
inline Camera frontal_camera(float distance, int size) {
    Camera camera;
    camera.position = Vec3f(0, 0, distance);
    camera.target = Vec3f(0, 0, 0);
    camera.vertical_fov = 2 * std::atan(1 / distance);
    camera.width = camera.height = size;
    return camera;
}

}  // namespace haarfield
