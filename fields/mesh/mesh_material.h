#pragma once
/// Materials of a mesh, in the terms of its file.

#include "fields/base/vector.h"

#include <array>
#include <filesystem>
#include <memory>
#include <string>

namespace haarfield {

/// An image that a mesh's file refers to or embeds.
struct MeshImage {
    std::string name;  ///< As in the file; empty if there is none.
    /// Path in the directory of the mesh's file or below. Empty if the image was not found there, or is
    /// embedded.
    std::filesystem::path file;
    /// The embedded image: the bytes of a PNG, JPEG or other file. Null if it is a separate file.
    std::shared_ptr<const std::string> bytes;

    /// True if the image can be read.
    bool is_there() const { return !file.empty() || bytes; }
    bool operator==(const MeshImage&) const = default;  ///< Compares embedded images by address.
};

/// The meaning of an image's alpha.
enum class AlphaMode : std::uint8_t {
    opaque,  ///< Ignored.
    mask,    ///< Below the cutoff, there is no surface.
    blend,   ///< Coverage of the surface.
};

/// A material of a mesh's file.
struct MeshMaterial {
    /// The specular model.
    enum class Model : std::uint8_t {
        none,       ///< None: the file only names the material.
        phong,      ///< MTL's Kd, Ks and Ns.
        metallic,   ///< glTF's metallic-roughness.
        by_colour,  ///< None: there are only vertex colours.
    };
    Model model = Model::none;
    Rgb diffuse{0.8f, 0.8f, 0.8f};  ///< Linear; base colour of `metallic`.
    Rgb specular{0, 0, 0};          ///< Linear, for `phong`.
    float exponent = 0;             ///< Ns: exponent of the cosine to the halfway vector, for `phong`.
    float metallic = 0;             ///< For `metallic`, in [0, 1].
    float roughness = 1;            ///< For `metallic`, in [0, 1].
    Rgb emission{0, 0, 0};          ///< Emitted radiance. [W/(m^2 sr)]
    MeshImage image;                ///< Multiplies `diffuse`, `emission` and the specular colour of metals.
    /// For `metallic`: multiplies roughness by its green and `metallic` by its blue channel, both linear.
    MeshImage surface_map;
    /// Coverage of the surface in a separate image: its alpha, or its luminance if it has no alpha.
    MeshImage opacity_map;
    AlphaMode alpha = AlphaMode::opaque;
    float alpha_cutoff = 0.5f;  ///< For AlphaMode::mask.
};

}  // namespace haarfield
