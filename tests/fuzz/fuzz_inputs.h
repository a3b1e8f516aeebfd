#pragma once
/// Damaged and crafted files for haarfield_fuzz: the same for the same seed, on any machine.

#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

using FuzzRandom = std::mt19937_64;

/// One of 0, 1 ... count - 1; count > 0.
inline std::size_t random_index(FuzzRandom& random, std::size_t count) {
    return static_cast<std::size_t>(random() % count);
}

/// Changes bytes from `first` on, one to some ten times: bits, numbers, pieces that are cut, doubled, moved,
/// or taken from `other`; words of `dictionary`. Keeps the size if `same_size`.
void damage(std::string& bytes, FuzzRandom& random, std::string_view other,
            const std::vector<std::string_view>& dictionary, std::size_t first = 0, bool same_size = false);

/// Small, good files of a format that read_mesh takes, by the ending of the name: "obj", "ply", "stl", "off",
/// "gltf", "glb", "inc"; text and binary ones.
std::vector<std::string> example_mesh_files(std::string_view ending);

/// What readers of meshes and scenes look for, and numbers that none expects.
const std::vector<std::string_view>& mesh_words();
const std::vector<std::string_view>& scene_words();

/// Good scene files; they ask for `box.obj` and `light.exr` beside them.
std::vector<std::string> example_scene_files();

}  // namespace haarfield
