#include "shading/bounces/gathering_directions.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <numeric>
#include <vector>

#include "fields/base/spiral.h"
#include "shading/bounces/fine_surface.h"

namespace haarfield {
namespace {

constexpr std::size_t packet = FineSurface::packet;
static_assert(least_gathering_rays == int(packet));

/// Returns the directions of a spiral. They are divided into rings, each sorted by angle, so that packets are
/// about as wide as long.
std::vector<Vec3f> spiral(std::size_t rays) {
    const std::size_t packets = rays / packet;
    const auto rings = static_cast<std::size_t>(std::ceil(std::sqrt(double(packets) / 8)));
    const std::size_t ring = packet * ((packets + rings - 1) / rings);
    std::vector<std::size_t> order(rays);
    std::iota(order.begin(), order.end(), std::size_t(0));
    const auto turn = [](std::size_t k) {
        const double turns = double(k) * golden_angle / (2 * pi);
        return turns - std::floor(turns);
    };
    for (std::size_t first = 0; first < rays; first += ring)
        std::sort(order.begin() + std::ptrdiff_t(first),
                  order.begin() + std::ptrdiff_t(std::min(rays, first + ring)),
                  [&](std::size_t a, std::size_t b) { return turn(a) < turn(b); });
    std::vector<Vec3f> directions;
    for (const std::size_t k : order)
        directions.push_back(Vec3f(spiral_direction(k, std::sqrt((double(k) + 0.5) / double(rays)))));
    return directions;
}

}  // namespace

std::span<const Vec3f> gathering_directions(int rays) {
    assert(rays >= least_gathering_rays && rays <= most_gathering_rays &&
           std::has_single_bit(static_cast<unsigned>(rays)));
    static const std::vector<std::vector<Vec3f>> by_number = [] {
        std::vector<std::vector<Vec3f>> made;
        for (int number = least_gathering_rays; number <= most_gathering_rays; number *= 2)
            made.push_back(spiral(static_cast<std::size_t>(number)));
        return made;
    }();
    return by_number[static_cast<std::size_t>(std::countr_zero(static_cast<unsigned>(rays)) -
                                              std::countr_zero(unsigned(least_gathering_rays)))];
}

}  // namespace haarfield
