#include "tests/fuzz/odd_mesh.h"

#include <fmt/format.h>
#include <bit>
#include <cmath>

namespace haarfield {

std::string odd_mesh(FuzzRandom& random) {
    const auto coordinate = [&] {
        if (random_index(random, 4) == 0) return 0.5f * static_cast<float>(random_index(random, 3));
        const float value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
        return std::abs(value) <= 1e6f ? value : 1.0f;  // NaN becomes 1, too
    };
    const std::size_t points = 3 + random_index(random, 8);
    std::string text;
    for (std::size_t i = 0; i < points; ++i)
        for (int axis = 0; axis < 3; ++axis)
            text += fmt::format("{}{:.9g}{}", axis == 0 ? "v " : "", coordinate(), axis == 2 ? "\n" : " ");
    for (std::size_t i = 0; i < 2 * points; ++i) {
        text += 'f';
        for (int corner = 0; corner < 3; ++corner)
            text += fmt::format(" {}", 1 + random_index(random, points));
        text += '\n';
    }
    return text;
}

}  // namespace haarfield
