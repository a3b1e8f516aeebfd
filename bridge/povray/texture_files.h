#pragma once
/// Writes textures as files that POV-Ray reads.

#include "scenes/surface.h"

#include <map>
#include <span>

namespace haarfield {

/// A texture's file and the pigments that display it.
struct TextureFile {
    std::filesystem::path file;
    std::string pigment;  ///< Name of the declared pigment with the image.
    std::string opaque;   ///< Name of the pigment without the image's alpha; the same if there is none.
    /// A pattern: 0 where the image is opaque, 1 where it is transparent. Empty if the image is opaque
    /// everywhere.
    std::string transmission;
    /// Declares both pigments and PIGMENT_Function. The declarations are guarded and may be repeated in a
    /// scene.
    std::string text;
};

/// Returns a pigment with the colours of a declared pigment times `colour`. It uses PIGMENT_Function, the
/// pigment's declared function. The result is opaque unless a pattern makes it transparent.
///
/// POV-Ray cannot multiply an image by a colour. It has functions of an image's channels, colour maps that
/// turn them into colours, and averages of pigments: here of the three channels and of the transparency.
///
/// transmission  the pattern of transparency, or empty.
std::string multiplied_pigment(const std::string& pigment, const Rgb& colour,
                               const std::string& transmission = {});

/// Returns a pigment that filters light by a declared pigment's colours times `colour`, with
/// PIGMENT_Function.
std::string filter_pigment(const std::string& pigment, const Rgb& colour);

/// Texture files, by texture.
using TextureFiles = std::map<const Texture*, TextureFile>;

/// Returns the textures of the instances' surfaces in order, with null for surfaces without one.
template <class Instance>
std::vector<const Texture*> textures_of(std::span<const Instance> instances) {
    std::vector<const Texture*> textures;
    for (const Instance& instance : instances)
        for (const Surface& surface : instance.surfaces) textures.push_back(surface.texture.get());
    return textures;
}

std::vector<std::filesystem::path> files_of(const TextureFiles& textures);  ///< Sorted.

/// Writes each texture once: as `STEM_NAME.jpg` if its JPEG file is available, otherwise as `STEM_NAME.png`,
/// 8 bit sRGB. Equal names are numbered.
///
/// stem    a scene's name (is_scene_name).
/// order   the textures in the order of their numbers; null entries are skipped.
/// errors  I/O errors.
Result<TextureFiles> write_textures(const std::filesystem::path& folder, const std::string& stem,
                                    std::span<const Texture* const> order);

}  // namespace haarfield
