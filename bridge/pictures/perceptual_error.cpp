#include "bridge/pictures/perceptual_error.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>

namespace haarfield {
namespace {

/// One channel of a picture, row by row.
using Plane = std::vector<double>;

/// An odd number of weights around a pixel.
using Kernel = std::vector<double>;

enum class Border { repeat, zero };

/// Returns the plane filtered by `across` along its rows and by `down` along its columns.
Plane filtered(const Plane& plane, int width, int height, const Kernel& across, const Kernel& down,
               Border border = Border::repeat) {
    const auto line = [border](const double* begin, std::ptrdiff_t stride, int length, int at,
                               const Kernel& kernel) {
        const int radius = static_cast<int>(kernel.size()) / 2;
        double sum = 0;
        for (int k = -radius; k <= radius; ++k) {
            if (border == Border::zero && (at + k < 0 || at + k >= length)) continue;
            sum += kernel[k + radius] * begin[stride * std::clamp(at + k, 0, length - 1)];
        }
        return sum;
    };
    Plane rows(plane.size()), result(plane.size());
    tbb::parallel_for(0, height, [&](int y) {
        const std::size_t first = static_cast<std::size_t>(y) * width;
        for (int x = 0; x < width; ++x) rows[first + x] = line(&plane[first], 1, width, x, across);
    });
    tbb::parallel_for(0, height, [&](int y) {
        for (int x = 0; x < width; ++x)
            result[static_cast<std::size_t>(y) * width + x] = line(&rows[x], width, height, y, down);
    });
    return result;
}

template <class Weight>
Kernel kernel_of(int radius, const Weight& weight) {
    Kernel kernel;
    for (int x = -radius; x <= radius; ++x) kernel.push_back(weight(x));
    return kernel;
}

double sum_of(const Kernel& kernel) {
    double sum = 0;
    for (double weight : kernel) sum += weight;
    return sum;
}

Kernel normalised(Kernel kernel) {
    const double sum = sum_of(kernel);
    for (double& weight : kernel) weight /= sum;
    return kernel;
}

/// Returns the kernel with positive weights that add up to 1 and negative ones that add up to -1.
Kernel balanced(Kernel kernel) {
    double positive = 0, negative = 0;
    for (double weight : kernel) (weight > 0 ? positive : negative) += weight;
    for (double& weight : kernel) weight /= weight > 0 ? positive : -negative;
    return kernel;
}

// ---- colour spaces with D65 white ---------------------------------------------------------------------

constexpr double to_xyz[3][3] = {{0.4123908, 0.3575843, 0.1804808},  // Rec. 709 primaries
                                 {0.2126390, 0.7151687, 0.0721923},
                                 {0.0193308, 0.1191948, 0.9505322}};
constexpr double from_xyz[3][3] = {{3.2409699, -1.5373832, -0.4986108},
                                   {-0.9692436, 1.8759675, 0.0415551},
                                   {0.0556301, -0.2039770, 1.0569715}};

Vec3d product(const double (&m)[3][3], const Vec3d& v) {
    Vec3d result;
    for (int row = 0; row < 3; ++row) result[row] = m[row][0] * v.x + m[row][1] * v.y + m[row][2] * v.z;
    return result;
}

/// Returns XYZ relative to that of white: linear RGB (1, 1, 1).
Vec3d relative_xyz(const Vec3d& rgb) {
    const Vec3d xyz = product(to_xyz, rgb), white = product(to_xyz, Vec3d(1, 1, 1));
    return Vec3d(xyz.x / white.x, xyz.y / white.y, xyz.z / white.z);
}

/// Returns opponent colours. They are linear in radiance, so that filtering them filters light.
Vec3d ycxcz(const Vec3d& rgb) {
    const Vec3d t = relative_xyz(rgb);
    return Vec3d(116 * t.y - 16, 500 * (t.x - t.y), 200 * (t.y - t.z));
}

Vec3d rgb_of_ycxcz(const Vec3d& c) {
    const double y = (c.x + 16) / 116, x = y + c.y / 500, z = y - c.z / 200;
    const Vec3d white = product(to_xyz, Vec3d(1, 1, 1));
    return product(from_xyz, Vec3d(x * white.x, y * white.y, z * white.z));
}

/// Returns L*a*b* with a chroma that decreases in the dark (Hunt effect).
Vec3d hunt_lab(const Vec3d& rgb) {
    const auto f = [](double t) {
        constexpr double delta = 6.0 / 29.0;
        return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29.0;
    };
    const Vec3d t = relative_xyz(rgb);
    const double lightness = 116 * f(t.y) - 16;
    return Vec3d(lightness, 0.01 * lightness * 500 * (f(t.x) - f(t.y)),
                 0.01 * lightness * 200 * (f(t.y) - f(t.z)));
}

double hyab(const Vec3d& a, const Vec3d& b) {
    return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

// ---- FLIP ----------------------------------------------------------------------------------------------

/// The contrast sensitivity of one opponent channel: a1 g(b1) + a2 g(b2), g(b) = sqrt(pi/b) e^(-pi^2 x^2/b)
/// of an angle x in degrees (Andersson et al., Table 1).
struct ContrastSensitivity {
    double a1, b1, a2, b2;
};
constexpr std::array<ContrastSensitivity, 3> contrast_sensitivity{
    {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};

Plane contrast_filtered(const Plane& plane, int width, int height, const ContrastSensitivity& s,
                        double pixels_per_degree) {
    const double widest = 0.04;  // the same radius for all channels
    const int radius = static_cast<int>(std::ceil(3 * std::sqrt(widest / (2 * pi * pi)) * pixels_per_degree));
    // The sum of two Gaussians is not separable, but each Gaussian is.
    const auto gaussian = [&](double b) {
        return kernel_of(radius, [&](int x) {
            const double angle = x / pixels_per_degree;
            return std::exp(-pi * pi * angle * angle / b);
        });
    };
    const Kernel first = gaussian(s.b1), second = gaussian(s.b2);
    const double share1 = s.a1 * std::sqrt(pi / s.b1) * sum_of(first) * sum_of(first);
    const double share2 = s.a2 * std::sqrt(pi / s.b2) * sum_of(second) * sum_of(second);
    const Kernel unit = normalised(first);
    Plane result = filtered(plane, width, height, unit, unit);
    if (share2 > 0) {
        const Kernel unit2 = normalised(second);
        const Plane other = filtered(plane, width, height, unit2, unit2);
        for (std::size_t i = 0; i < result.size(); ++i)
            result[i] = (share1 * result[i] + share2 * other[i]) / (share1 + share2);
    }
    return result;
}

/// The perceived picture: Hunt-adjusted colours, and the strength of an edge or a point at each pixel.
struct PerceivedImage {
    std::vector<Vec3d> colour;
    Plane edge, point;
};

PerceivedImage perceived_image(std::span<const Rgb> image, int width, int height, double pixels_per_degree) {
    const std::size_t pixels = image.size();
    std::array<Plane, 3> opponent;
    for (Plane& plane : opponent) plane.resize(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        Vec3d rgb;
        for (int c = 0; c < 3; ++c) rgb[c] = std::clamp(static_cast<double>(image[i][c]), 0.0, 1.0);
        const Vec3d value = ycxcz(rgb);
        for (int c = 0; c < 3; ++c) opponent[c][i] = value[c];
    }

    PerceivedImage result;
    // Features are detected in luminance in [0, 1], at the width that the eye perceives as an edge, 0.082
    // degrees.
    Plane luminance_plane(pixels);
    for (std::size_t i = 0; i < pixels; ++i) luminance_plane[i] = (opponent[0][i] + 16) / 116;
    const double deviation = 0.5 * 0.082 * pixels_per_degree;
    const int radius = static_cast<int>(std::ceil(3 * deviation));
    const auto gaussian = [&](int x) { return std::exp(-x * x / (2 * deviation * deviation)); };
    const Kernel smooth = normalised(kernel_of(radius, gaussian));
    const Kernel edge = balanced(kernel_of(radius, [&](int x) { return -x * gaussian(x); }));
    const Kernel point = balanced(
        kernel_of(radius, [&](int x) { return (x * x / (deviation * deviation) - 1) * gaussian(x); }));
    const auto magnitude = [&](const Kernel& kernel) {
        Plane across = filtered(luminance_plane, width, height, kernel, smooth);
        const Plane down = filtered(luminance_plane, width, height, smooth, kernel);
        for (std::size_t i = 0; i < pixels; ++i) across[i] = std::hypot(across[i], down[i]);
        return across;
    };
    result.edge = magnitude(edge);
    result.point = magnitude(point);

    for (int c = 0; c < 3; ++c)
        opponent[c] =
            contrast_filtered(opponent[c], width, height, contrast_sensitivity[c], pixels_per_degree);
    result.colour.resize(pixels);
    tbb::parallel_for(0, height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * width + x;
            Vec3d rgb = rgb_of_ycxcz(Vec3d(opponent[0][i], opponent[1][i], opponent[2][i]));
            for (int c = 0; c < 3; ++c) rgb[c] = std::clamp(rgb[c], 0.0, 1.0);
            result.colour[i] = hunt_lab(rgb);
        }
    });
    return result;
}

/// Compresses colour distances: small distances get most of the range (Andersson et al., 4.1.4).
double compressed_distance(double distance) {
    constexpr double exponent = 0.7, knee = 0.4, knee_value = 0.95;
    static const double largest =
        std::pow(hyab(hunt_lab(Vec3d(0, 1, 0)), hunt_lab(Vec3d(0, 0, 1))), exponent);
    const double d = std::pow(distance, exponent);
    if (d < knee * largest) return knee_value * d / (knee * largest);
    return std::min(1.0, knee_value + (d - knee * largest) / (largest - knee * largest) * (1 - knee_value));
}

}  // namespace

std::vector<float> flip_errors(std::span<const Rgb> image, std::span<const Rgb> reference, int width,
                               int height, float pixels_per_degree) {
    assert(width >= 1 && height >= 1 && pixels_per_degree > 0);
    assert(image.size() == static_cast<std::size_t>(width) * height && image.size() == reference.size());
    const PerceivedImage a = perceived_image(image, width, height, pixels_per_degree);
    const PerceivedImage b = perceived_image(reference, width, height, pixels_per_degree);
    std::vector<float> errors(image.size());
    tbb::parallel_for(0, height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * width + x;
            const double colour = compressed_distance(hyab(a.colour[i], b.colour[i]));
            const double feature =
                std::sqrt(std::max(std::abs(a.edge[i] - b.edge[i]), std::abs(a.point[i] - b.point[i])) /
                          std::sqrt(2.0));
            errors[i] = static_cast<float>(std::pow(colour, 1 - std::min(feature, 1.0)));
        }
    });
    return errors;
}

double structural_similarity(std::span<const float> image, std::span<const float> reference,
                             std::span<const std::uint8_t> mask, int width, int height) {
    const std::size_t pixels = image.size();
    assert(pixels == reference.size() && pixels == mask.size());
    assert(pixels == static_cast<std::size_t>(width) * height);
    const Kernel window = normalised(kernel_of(5, [](int x) { return std::exp(-x * x / (2 * 1.5 * 1.5)); }));
    const auto windowed = [&](const auto& value) {
        Plane plane(pixels);
        for (std::size_t i = 0; i < pixels; ++i) plane[i] = mask[i] ? value(i) : 0.0;
        return filtered(plane, width, height, window, window, Border::zero);
    };
    const auto x = [&](std::size_t i) { return static_cast<double>(image[i]); };
    const auto y = [&](std::size_t i) { return static_cast<double>(reference[i]); };
    const Plane weight = windowed([](std::size_t) { return 1.0; });
    const Plane mean_x = windowed(x), mean_y = windowed(y);
    const Plane xx = windowed([&](std::size_t i) { return x(i) * x(i); });
    const Plane yy = windowed([&](std::size_t i) { return y(i) * y(i); });
    const Plane xy = windowed([&](std::size_t i) { return x(i) * y(i); });

    constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    double sum = 0;
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        if (!mask[i]) continue;
        const double mx = mean_x[i] / weight[i], my = mean_y[i] / weight[i];
        const double variance_x = std::max(0.0, xx[i] / weight[i] - mx * mx);
        const double variance_y = std::max(0.0, yy[i] / weight[i] - my * my);
        const double covariance = xy[i] / weight[i] - mx * my;
        sum += (2 * mx * my + c1) * (2 * covariance + c2) /
               ((mx * mx + my * my + c1) * (variance_x + variance_y + c2));
        ++count;
    }
    assert(count > 0);
    return sum / static_cast<double>(count);
}

}  // namespace haarfield
