#include "bridge/texture_files.h"

#include <fmt/format.h>

#include <algorithm>

#include "bridge/povray_scene.h"
#include "fields/base/names.h"
#include "fields/file/write_file.h"
#include "scenes/image.h"

namespace haarfield {
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
        // So long that a number behind it is not what povray_identifier cuts off.
        constexpr std::size_t longest = 56;
        const std::string name = unique_name(
            texture->name.empty() ? "image" : povray_identifier(texture->name).substr(0, longest), taken);
        const bool is_jpeg = !texture->jpeg.empty();
        TextureFile made;
        made.file = folder / fmt::format("{}_{}.{}", stem, name, is_jpeg ? "jpg" : "png");
        if (is_jpeg) {
            if (const Result<Done> written = write_file(made.file, texture->jpeg); !written)
                return written.error();
        } else {
            const Result<std::string> bytes =
                png_bytes(texture->texels, texture->width, texture->height, texture->has_alpha);
            if (!bytes) return Error{made.file.string(), bytes.error().what};
            if (const Result<Done> written = write_file(made.file, *bytes); !written) return written.error();
        }
        made.pigment = fmt::format("{}_Image_{}", povray_identifier(stem), povray_identifier(name));
        made.over = made.pigment + "_Over";
        const std::string image =
            fmt::format("{} \"{}\"", is_jpeg ? "jpeg" : "png", made.file.filename().string());
        if (texture->has_alpha)
            made.transmission = fmt::format("image_pattern {{ {} interpolate 2 use_alpha }}", image);
        made.text = fmt::format(
            "#ifndef ({0})\n"
            "#declare {0} = pigment {{ image_map {{ {1} interpolate 2 }} }}\n"
            "#declare {2} = pigment {{ {3} }}\n"
            "#end\n",
            made.pigment, image, made.over,
            texture->has_alpha ? made.transmission + " color_map { [0 rgb 1] [1 rgbt 1] }"
                               : std::string("rgb 1"));
        files.emplace(texture, std::move(made));
    }
    return files;
}

}  // namespace haarfield
