#pragma once
/// Textures as files that POV-Ray reads.

#include "scenes/surface.h"

#include <map>
#include <span>

namespace haarfield {

/// A texture's file, and the pigments that show it.
struct TextureFile {
    std::filesystem::path file;
    std::string pigment;  ///< What the declared pigment is called: the image,
    std::string opaque;   ///< and its colours without its alpha; the same if there is none.
    /// A pattern: 0 where the image is opaque, 1 where nothing is there; empty if it is opaque everywhere.
    std::string transmission;
    /// Declares both and PIGMENT_Function, once, however often it stands in a scene.
    std::string text;
};

/// The colours of a declared pigment times one, by PIGMENT_Function, its declared function; opaque but for
/// what a pattern lets through.
///
/// POV-Ray can not multiply an image with a colour; but it has functions of an image's channels, colour maps
/// that make them colours, and means of pigments: of the three channels' and of what is let through.
///
/// transmission  that pattern, or empty.
std::string multiplied_pigment(const std::string& pigment, const Rgb& colour,
                               const std::string& transmission = {});

/// A pigment that filters light by a declared pigment's colours times one, by PIGMENT_Function.
std::string filter_pigment(const std::string& pigment, const Rgb& colour);

/// By texture.
using TextureFiles = std::map<const Texture*, TextureFile>;

/// The textures of instances' surfaces, in their order; null where a surface has none.
template <class Instance>
std::vector<const Texture*> textures_of(std::span<const Instance> instances) {
    std::vector<const Texture*> textures;
    for (const Instance& instance : instances)
        for (const Surface& surface : instance.surfaces) textures.push_back(surface.texture.get());
    return textures;
}

std::vector<std::filesystem::path> files_of(const TextureFiles& textures);  ///< Sorted.

/// Writes each texture once, as `STEM_NAME.jpg` if it is a JPEG's own bytes, else as `STEM_NAME.png`, 8 bit
/// sRGB; numbered where two have one name.
///
/// stem    a scene's name (is_scene_name).
/// order   the textures that are wanted, in the order of their numbers; null ones are passed over.
/// errors  what the disk says.
Result<TextureFiles> write_textures(const std::filesystem::path& folder, const std::string& stem,
                                    std::span<const Texture* const> order);

}  // namespace haarfield
