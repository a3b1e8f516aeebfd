#include "shading/scene/lobes.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace haarfield {
namespace {

/// Smaller values are set to zero: a half float cannot represent them next to the peak of 1.
constexpr float negligible = 1e-5f;

}  // namespace

std::vector<float> lobe_texels(float exponent, const Vec3f& direction, int size) {
    return lobe_texels(exponent, direction, size, texel_directions(size));
}

std::vector<float> lobe_texels(float exponent, const Vec3f& direction, int size,
                               std::span<const Vec3f> centres) {
    assert(exponent > 0 && exponent <= 1000 && is_face_size(size));
    std::vector<float> texels(centres.size());
    // A narrow lobe varies within a texel: averages 2 x 2 samples.
    const bool narrow = exponent * 16 > static_cast<float>(size * size);
    const auto power = [exponent](float cosine) { return std::exp(exponent * std::log(cosine)); };
    const float least = std::exp(std::log(negligible) / exponent);
    const float least_of_texel =
        std::cos(std::min(3.14f, std::acos(least) + 1.5f / static_cast<float>(size)));
    for (std::size_t i = 0; i < texels.size(); ++i) {
        const float cosine = centres[i].dot(direction);
        texels[i] = 0;
        if (!narrow) {
            if (cosine > std::max(least, 1e-6f)) texels[i] = exponent == 1 ? cosine : power(cosine);
        } else if (cosine > least_of_texel) {
            const int face = static_cast<int>(i) / (size * size), row = static_cast<int>(i) / size % size,
                      column = static_cast<int>(i) % size;
            float sum = 0;
            for (int q = 0; q < 4; ++q) {
                const float c =
                    texel_direction(face, 2 * column + q % 2, 2 * row + q / 2, 2 * size).dot(direction);
                if (c > least) sum += power(c);
            }
            texels[i] = sum / 4;
        }
    }
    return texels;
}

}  // namespace haarfield
