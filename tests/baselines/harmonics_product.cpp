#include "tests/baselines/harmonics_product.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "fields/wavelets/cubemap.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/baselines/harmonics_product.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haarfield::baseline {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

void multiply(const TriplingCoefficients& coefficients, const float* f, const float* g, float* product) {
    const hn::CappedTag<float, harmonics_batch> d;
    for (std::size_t lane = 0; lane < harmonics_batch; lane += hn::Lanes(d))
        for (std::size_t k = 0; k < coefficients.terms.size(); ++k) {
            auto sum = hn::Zero(d), other_sum = hn::Zero(d);  // two, to hide the latency of additions
            for (const auto& [i, j, coefficient] : coefficients.terms[k]) {
                const std::size_t at_i = i * harmonics_batch + lane, at_j = j * harmonics_batch + lane;
                const auto scale = hn::Set(d, coefficient);
                sum = hn::MulAdd(hn::Mul(scale, hn::LoadU(d, f + at_i)), hn::LoadU(d, g + at_j), sum);
                if (i != j)
                    other_sum =
                        hn::MulAdd(hn::Mul(scale, hn::LoadU(d, f + at_j)), hn::LoadU(d, g + at_i), other_sum);
            }
            hn::StoreU(hn::Add(sum, other_sum), d, product + k * harmonics_batch + lane);
        }
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield::baseline
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield::baseline {

HWY_EXPORT(multiply);

namespace {

/// Points and weights of Gauss-Legendre quadrature on [-1, 1], exact for polynomials up to degree 2 count -
/// 1.
struct GaussLegendre {
    std::vector<double> point, weight;

    explicit GaussLegendre(int count) {
        for (int i = 0; i < count; ++i) {
            double x = std::cos(pi * (i + 0.75) / (count + 0.5)), slope = 1;
            for (int newton = 0; newton < 20; ++newton) {
                double value = x, before = 1;
                for (int l = 2; l <= count; ++l)
                    before = std::exchange(value, ((2 * l - 1) * x * value - (l - 1) * before) / l);
                slope = count * (x * value - before) / (x * x - 1);
                x -= value / slope;
            }
            point.push_back(x);
            weight.push_back(2 / ((1 - x * x) * slope * slope));
        }
    }
};

}  // namespace

std::vector<double> harmonics(int order, const Vec3d& direction) {
    std::vector<double> values(static_cast<std::size_t>(order * order));
    // Legendre functions without the power of the sine, which is part of  radial = sin^m e^(i m azimuth).
    // Recurrences in m, then in l, on normalised functions.
    double radial[2] = {1, 0}, diagonal = std::sqrt(1 / (4 * pi));
    for (int m = 0; m < order; ++m) {
        if (m > 0) {
            diagonal *= std::sqrt((2 * m + 1.0) / (2 * m));
            const double real = radial[0] * direction.x - radial[1] * direction.z;
            radial[1] = radial[0] * direction.z + radial[1] * direction.x;
            radial[0] = real;
        }
        double legendre = diagonal, before = 0;
        for (int l = m; l < order; ++l) {
            if (l > m) {
                const double step = std::sqrt((4.0 * l * l - 1) / (double(l) * l - double(m) * m));
                const double last =
                    l - 1 > m
                        ? std::sqrt(((l - 1.0) * (l - 1) - double(m) * m) / (4.0 * (l - 1) * (l - 1) - 1))
                        : 0;
                before = std::exchange(legendre, step * (direction.y * legendre - last * before));
            }
            const auto middle = static_cast<std::size_t>(l * (l + 1));
            if (m == 0) {
                values[middle] = legendre;
            } else {
                values[middle + static_cast<std::size_t>(m)] = std::sqrt(2.0) * legendre * radial[0];
                values[middle - static_cast<std::size_t>(m)] = std::sqrt(2.0) * legendre * radial[1];
            }
        }
    }
    return values;
}

TriplingCoefficients tripling_coefficients(int order) {
    const auto count = static_cast<std::size_t>(order * order);
    const int degree = 3 * (order - 1), rings = degree / 2 + 1, azimuths = degree + 1;
    const GaussLegendre legendre(rings);
    std::vector<double> integrals(count * count * count, 0.0);
    for (int ring = 0; ring < rings; ++ring)
        for (int azimuth = 0; azimuth < azimuths; ++azimuth) {
            const double y = legendre.point[std::size_t(ring)], angle = 2 * pi * azimuth / azimuths;
            const double radius = std::sqrt(1 - y * y);
            const std::vector<double> value =
                harmonics(order, {radius * std::cos(angle), y, radius * std::sin(angle)});
            const double weight = legendre.weight[std::size_t(ring)] * 2 * pi / azimuths;
            for (std::size_t i = 0; i < count; ++i)
                for (std::size_t j = i; j < count; ++j) {
                    const double pair = weight * value[i] * value[j];
                    double* const row = &integrals[(i * count + j) * count];
                    for (std::size_t k = 0; k < count; ++k) row[k] += pair * value[k];
                }
        }
    TriplingCoefficients coefficients;
    coefficients.order = order;
    coefficients.terms.resize(count);
    for (std::size_t k = 0; k < count; ++k)
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t j = i; j < count; ++j) {
                const double integral = integrals[(i * count + j) * count + k];
                if (std::abs(integral) > 1e-9)
                    coefficients.terms[k].push_back({static_cast<std::uint16_t>(i),
                                                     static_cast<std::uint16_t>(j),
                                                     static_cast<float>(integral)});
            }
    return coefficients;
}

void harmonics_product(const TriplingCoefficients& coefficients, const HarmonicsBatch& f,
                       const HarmonicsBatch& g, HarmonicsBatch& product) {
    product.resize(f.size());
    HWY_DYNAMIC_DISPATCH(multiply)(coefficients, f.data(), g.data(), product.data());
}

void RecursiveHarmonicsProduct::operator()(std::span<const Rgb> light,
                                           std::span<const HarmonicsBatch> factors, std::span<Rgb> radiance) {
    assert(!factors.empty() && radiance.size() <= harmonics_batch);
    const HarmonicsBatch* product = factors.data();
    for (const HarmonicsBatch& factor : factors.subspan(1)) {
        harmonics_product(coefficients_, *product, factor, next_);
        std::swap(product_, next_);
        product = &product_;
    }
    std::fill(radiance.begin(), radiance.end(), Rgb(0.0f));
    for (std::size_t k = 0; k < light.size(); ++k)
        for (std::size_t v = 0; v < radiance.size(); ++v)
            radiance[v] += light[k] * (*product)[k * harmonics_batch + v];
}

HarmonicsProjection::HarmonicsProjection(int order, int face_size)
    : count_(static_cast<std::size_t>(order * order)) {
    for (int face = 0; face < cubemap_faces; ++face)
        for (int row = 0; row < face_size; ++row)
            for (int column = 0; column < face_size; ++column) {
                solid_angle_.push_back(static_cast<float>(texel_solid_angle(column, row, face_size)));
                const std::vector<double> values =
                    harmonics(order, Vec3d(texel_direction(face, column, row, face_size)));
                harmonics_.insert(harmonics_.end(), values.begin(), values.end());
            }
}

std::vector<float> HarmonicsProjection::operator()(std::span<const float> texels) const {
    std::vector<float> coefficients(count_, 0.0f);
    for (std::size_t i = 0; i < texels.size(); ++i) {
        if (texels[i] == 0) continue;
        const float share = texels[i] * solid_angle_[i];
        for (std::size_t k = 0; k < count_; ++k) coefficients[k] += share * harmonics_[i * count_ + k];
    }
    return coefficients;
}

std::vector<Rgb> HarmonicsProjection::of_light(std::span<const Rgb> texels) const {
    const float texels_a_face = static_cast<float>(texels.size()) / cubemap_faces;
    std::vector<Rgb> coefficients(count_, Rgb(0.0f));
    for (std::size_t i = 0; i < texels.size(); ++i)
        for (std::size_t k = 0; k < count_; ++k)
            coefficients[k] += texels[i] * (harmonics_[i * count_ + k] / texels_a_face);
    return coefficients;
}

}  // namespace haarfield::baseline
#endif
