#include "shading/bounces/cosine_directions.h"

namespace haarfield {
namespace {

constexpr float unit = 1.0f / (1 << 24);  // a float has 24 significant bits

}  // namespace

std::array<std::uint32_t, 2> sobol_digits(std::uint32_t index) {
    // Bit k of the index flips the digits of direction number k. In the first dimension this is digit k + 1
    // only. In the second dimension these are the coefficients of (1 + x)^k modulo 2, row k of Pascal's
    // triangle.
    std::uint32_t x = 0, y = 0;
    for (std::uint32_t first = 1u << 31, second = 1u << 31; index != 0;
         index >>= 1, first >>= 1, second ^= second >> 1)
        if (index & 1u) {
            x ^= first;
            y ^= second;
        }
    return {x, y};
}

Vec2f sobol_point(std::uint32_t index) {
    const auto [x, y] = sobol_digits(index);
    return Vec2f(float(x >> 8) * unit, float(y >> 8) * unit);
}

Vec3f cosine_direction(const Vec2f& point, const Vec3f& normal, const Axes<Vec3f>& axes) {
    const float a = 2 * point.x - 1, b = 2 * point.y - 1;
    float radius = 0, angle = 0;
    constexpr float quarter = static_cast<float>(pi / 4);
    if (std::abs(a) > std::abs(b)) {
        radius = a;
        angle = quarter * (b / a);
    } else if (b != 0) {
        radius = b;
        angle = 2 * quarter - quarter * (a / b);
    }
    const float height = std::sqrt(std::max(0.0f, 1 - radius * radius));
    return axes.across * (radius * std::cos(angle)) + axes.up * (radius * std::sin(angle)) + normal * height;
}

Vec3f power_direction(const Vec2f& point, float exponent, const Vec3f& axis, const Axes<Vec3f>& axes) {
    const float cosine = std::pow(1 - point.x, 1 / (exponent + 1)),
                sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine)),
                angle = static_cast<float>(2 * pi) * point.y;
    return axes.across * (sine * std::cos(angle)) + axes.up * (sine * std::sin(angle)) + axis * cosine;
}

}  // namespace haarfield
