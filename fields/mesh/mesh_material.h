#pragma once
/// What a mesh's file says of its materials, in the file's own terms.

#include "fields/base/vector.h"

#include <array>
#include <filesystem>
#include <memory>
#include <string>

namespace haarfield {

/// An image that a mesh's file refers to, or holds.
struct MeshImage {
    std::string name;  ///< As the file has it; empty if there is none.
    /// Where it is: beside the mesh's file or below. Empty if it was not found there, or is embedded.
    std::filesystem::path file;
    /// The embedded image: the bytes of a PNG, JPEG or other file. Null if it is in a file of its own.
    std::shared_ptr<const std::string> bytes;

    /// Whether there is something to read.
    bool is_there() const { return !file.empty() || bytes; }
    bool operator==(const MeshImage&) const = default;
};

/// What an image's alpha means.
enum class AlphaMode : std::uint8_t {
    opaque,  ///< Nothing.
    mask,    ///< Below the cutoff there is no surface.
    blend,   ///< How much of the surface there is.
};

/// One material of a mesh's file.
struct MeshMaterial {
    /// How highlights are described.
    enum class Model : std::uint8_t {
        none,       ///< By nothing: the file only names the material.
        phong,      ///< MTL's Kd, Ks and Ns.
        metallic,   ///< glTF's metallic-roughness.
        by_colour,  ///< Colours at the vertices are all there is.
    };
    Model model = Model::none;
    Rgb diffuse{0.8f, 0.8f, 0.8f};  ///< Linear; base colour of `metallic`.
    Rgb specular{0, 0, 0};          ///< Of `phong`: linear.
    float exponent = 0;             ///< Of `phong`: of the cosine to the halfway vector, Ns.
    float metallic = 0;             ///< Of `metallic`, in [0, 1].
    float roughness = 1;            ///< Of `metallic`, in [0, 1].
    Rgb emission{0, 0, 0};          ///< Radiance of its own. [W/(m^2 sr)]
    MeshImage image;                ///< Multiplies `diffuse` and `emission`, and of metals the highlights.
    /// Of `metallic`: multiplies roughness by its green and `metallic` by its blue channel, both linear.
    MeshImage surface_map;
    /// How much of the surface there is, if that is an image of its own: by its alpha, or else its luminance.
    MeshImage opacity_map;
    AlphaMode alpha = AlphaMode::opaque;
    float alpha_cutoff = 0.5f;  ///< Of AlphaMode::mask.
};

}  // namespace haarfield
