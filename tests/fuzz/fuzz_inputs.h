#pragma once
/// Damaged and crafted files for haarfield_fuzz, determined by the seed on all machines.

#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

using FuzzRandom = std::mt19937_64;

/// Returns one of 0, 1 ... count - 1; count > 0.
inline std::size_t random_index(FuzzRandom& random, std::size_t count) {
    return static_cast<std::size_t>(random() % count);
}

/// Applies one to about ten changes to the bytes from `first` on: bits, numbers, and pieces that are removed,
/// duplicated, moved, or copied from `other` or `dictionary`. Preserves the size if `same_size`.
void damage(std::string& bytes, FuzzRandom& random, std::string_view other,
            const std::vector<std::string_view>& dictionary, std::size_t first = 0, bool same_size = false);

/// Returns small valid files of a format of read_mesh, by file extension: "obj", "ply", "stl", "off", "gltf",
/// "glb", "inc"; as text and binary.
std::vector<std::string> example_mesh_files(std::string_view ending);

/// Words that readers of meshes and scenes search for, and unusual numbers.
const std::vector<std::string_view>& mesh_words();
const std::vector<std::string_view>& scene_words();

/// Returns valid scene files. They refer to `box.obj` and `light.exr` in the same directory.
std::vector<std::string> example_scene_files();

}  // namespace haarfield
