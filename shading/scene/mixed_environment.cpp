#include "shading/scene/mixed_environment.h"

#include <tbb/parallel_for.h>

#include <cassert>

#include "shading/scene/turned_light.h"

namespace haarfield {

namespace {

LatLongImage mixed_image(const LatLongImage& first, const LatLongImage& second, float share) {
    const bool first_is_finer = first.pixels.size() >= second.pixels.size();
    const LatLongImage &fine = first_is_finer ? first : second, &other = first_is_finer ? second : first;
    const float fine_share = first_is_finer ? 1 - share : share, other_share = 1 - fine_share;
    const bool is_same_size = fine.width == other.width && fine.height == other.height;
    LatLongImage mixed = fine;
    tbb::parallel_for(0, fine.height, [&](int row) {
        for (int column = 0; column < fine.width; ++column) {
            const std::size_t pixel = std::size_t(row) * std::size_t(fine.width) + std::size_t(column);
            const Rgb there = is_same_size
                                  ? other.pixels[pixel]
                                  : radiance_from(other, lat_long_direction((column + 0.5) / fine.width,
                                                                            (row + 0.5) / fine.height));
            mixed.pixels[pixel] = fine.pixels[pixel] * fine_share + there * other_share;
        }
    });
    return mixed;
}

}  // namespace

Environment mixed_environment(const Environment& first, const Environment& second, float share) {
    assert(share >= 0 && share <= 1);
    if (share <= 0) return first;
    if (share >= 1) return second;
    Environment mixed(mixed_image(first.image, second.image, share));
    if (!first.backdrop.pixels.empty() || !second.backdrop.pixels.empty())
        mixed.backdrop = mixed_image(image_with_suns(first), image_with_suns(second), share);
    for (const auto& [light, of] : {std::pair(&first, 1 - share), std::pair(&second, share)})
        for (SunDisc sun : light->suns) {
            sun.irradiance *= of;
            mixed.suns.push_back(sun);
        }
    return mixed;
}

}  // namespace haarfield
