#include "bridge/povray/texture_files.h"

#include <fmt/format.h>

#include <algorithm>

#include "bridge/povray/povray_scene.h"
#include "fields/base/names.h"
#include "fields/file/write_file.h"
#include "scenes/image.h"

namespace haarfield {

namespace {

/// Returns the entries of a pigment_map whose average is a declared pigment's colours times `colour`.
///
/// entries  number of entries in the whole map.
/// filter   filter value of the colours.
std::string channel_entries(const std::string& pigment, const Rgb& colour, int entries, int filter) {
    std::string text;
    for (int c = 0; c < 3; ++c) {
        Rgb channel(0.0f);
        channel[c] = float(entries) * colour[c];
        text += fmt::format(
            " [1 function {{ {}_Function(x, y, z).{} }} color_map {{ [0 rgbf <0, 0, 0, {}>] "
            "[1 rgbf <{}, {}, {}, {}>] }}]",
            pigment, std::array{"red", "green", "blue"}[std::size_t(c)], filter, channel.x, channel.y,
            channel.z, filter);
    }
    return text;
}

}  // namespace

std::string filter_pigment(const std::string& pigment, const Rgb& colour) {
    return "average pigment_map {" + channel_entries(pigment, colour, 3, 1) + " }";
}

std::string multiplied_pigment(const std::string& pigment, const Rgb& colour,
                               const std::string& transmission) {
    const int pigments = transmission.empty() ? 3 : 4;
    std::string text = "average pigment_map {" + channel_entries(pigment, colour, pigments, 0);
    if (pigments == 4)
        text += fmt::format(" [1 {} color_map {{ [0 rgb 0] [1 rgbt <0, 0, 0, 4>] }}]", transmission);
    return text + " }";
}

std::vector<std::filesystem::path> files_of(const TextureFiles& textures) {
    std::vector<std::filesystem::path> files;
    for (const auto& [texture, file] : textures) files.push_back(file.file);
    std::ranges::sort(files);
    return files;
}

Result<TextureFiles> write_textures(const std::filesystem::path& folder, const std::string& stem,
                                    std::span<const Texture* const> order) {
    TextureFiles files;
    std::set<std::string> taken;
    for (const Texture* texture : order) {
        if (!texture || files.contains(texture)) continue;
        // Leaves space for a number before povray_identifier's limit.
        constexpr std::size_t longest = 56;
        const std::string name = unique_name(
            texture->name.empty() ? "image" : povray_identifier(texture->name).substr(0, longest), taken);
        const bool is_jpeg = !texture->jpeg.empty();
        TextureFile made;
        made.file = folder / fmt::format("{}_{}.{}", stem, name, is_jpeg ? "jpg" : "png");
        if (is_jpeg) {
            HF_TRY_DONE(write_file(made.file, texture->jpeg));
        } else {
            const Result<std::string> bytes =
                png_bytes(texture->texels, texture->width, texture->height, texture->has_alpha);
            if (!bytes) return Error{made.file.string(), bytes.error().what};
            HF_TRY_DONE(write_file(made.file, *bytes));
        }
        made.pigment = fmt::format("{}_Image_{}", povray_identifier(stem), povray_identifier(name));
        const std::string image =
            fmt::format("{} \"{}\"", is_jpeg ? "jpeg" : "png", made.file.filename().string());
        made.opaque = made.pigment;
        made.text = fmt::format(
            "#ifndef ({0})\n#declare {0} = pigment {{ image_map {{ {1} interpolate 2 }} }}\n"
            "#declare {0}_Function = function {{ pigment {{ {0} }} }}\n",
            made.pigment, image);
        if (texture->has_alpha) {
            made.transmission = fmt::format("image_pattern {{ {} interpolate 2 use_alpha }}", image);
            made.opaque += "_Opaque";
            made.text += fmt::format("#declare {} = pigment {{ {} }}\n", made.opaque,
                                     multiplied_pigment(made.pigment, Rgb(1.0f)));
        }
        made.text += "#end\n";
        files.emplace(texture, std::move(made));
    }
    return files;
}

}  // namespace haarfield
