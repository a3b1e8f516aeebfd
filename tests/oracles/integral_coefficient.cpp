#include "tests/oracles/integral_coefficient.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "fields/wavelets/quadtree.h"

namespace haarfield {

double integral_coefficient(std::span<const HaarBasisFunction> functions) {
    assert(!functions.empty());
    const HaarBasisFunction& finest = *std::max_element(
        functions.begin(), functions.end(),
        [](const HaarBasisFunction& a, const HaarBasisFunction& b) { return a.level < b.level; });

    int levels = 0;
    double sign = 1;
    std::array<int, 3> finest_wavelets{};  // number of wavelets of each kind
    for (const HaarBasisFunction& function : functions) {
        assert(function.level >= 0 && function.level < 32);
        levels += function.level;
        const int up = finest.level - function.level;
        if (finest.x >> up != function.x || finest.y >> up != function.y) return 0;
        if (function.kind == HaarBasisFunction::Kind::scaling) continue;
        const std::size_t wavelet = static_cast<std::size_t>(function.kind) - 1;
        if (up == 0) {
            ++finest_wavelets[wavelet];
        } else {
            const unsigned quadrant = 2 * (finest.y >> (up - 1) & 1u) + (finest.x >> (up - 1) & 1u);
            sign *= double(wavelet_sign[wavelet][quadrant]);
        }
    }
    // Signs of equal wavelets cancel in pairs, and along_x * along_y = diagonal. The remaining product on the
    // finest square is constant only if all three kinds remain, or none.
    const bool parity = finest_wavelets[0] % 2 != 0;
    if ((finest_wavelets[1] % 2 != 0) != parity || (finest_wavelets[2] % 2 != 0) != parity) return 0;
    return std::ldexp(sign, levels - 2 * finest.level);
}

}  // namespace haarfield
