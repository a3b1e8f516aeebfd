#include "shading/scene/mixed_environment.h"

#include <tbb/parallel_for.h>

#include <cassert>

#include "shading/scene/turned_light.h"

namespace haarfield {

Environment mixed_environment(const Environment& first, const Environment& second, float share) {
    assert(share >= 0 && share <= 1);
    if (share <= 0) return first;
    if (share >= 1) return second;
    const bool first_is_finer = first.image.pixels.size() >= second.image.pixels.size();
    const LatLongImage &fine = first_is_finer ? first.image : second.image,
                       &other = first_is_finer ? second.image : first.image;
    const float fine_share = first_is_finer ? 1 - share : share, other_share = 1 - fine_share;
    const bool is_same_size = fine.width == other.width && fine.height == other.height;
    Environment mixed;
    mixed.image = fine;
    tbb::parallel_for(0, fine.height, [&](int row) {
        for (int column = 0; column < fine.width; ++column) {
            const std::size_t pixel = std::size_t(row) * std::size_t(fine.width) + std::size_t(column);
            const Rgb there = is_same_size
                                  ? other.pixels[pixel]
                                  : radiance_from(other, lat_long_direction((column + 0.5) / fine.width,
                                                                            (row + 0.5) / fine.height));
            mixed.image.pixels[pixel] = fine.pixels[pixel] * fine_share + there * other_share;
        }
    });
    for (const auto& [light, of] : {std::pair(&first, 1 - share), std::pair(&second, share)})
        for (SunDisc sun : light->suns) {
            sun.irradiance *= of;
            mixed.suns.push_back(sun);
        }
    return mixed;
}

}  // namespace haarfield
