#include "shading/walk/brdf.h"

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

template <class Real>
Real larger(Real a, Real b) {
    return std::max(a, b);
}
template <class Real>
Real smaller(Real a, Real b) {
    return std::min(a, b);
}
template <class Real>
Real square_root(Real x) {
    return std::sqrt(x);
}
template <class Real>
Real power(Real base, Real exponent) {
    return base > 0 ? std::pow(base, exponent) : Real(0);
}

#include "shading/walk/lobe_mean-inl.h"

/// A direction of light, with its cosines; see lobe_mean.
template <class Real>
struct LightDirection {
    const BasicBrdf<Real>& brdf;
    const Imath::Vec3<Real>& light;
    const Real width;
    const Imath::Vec3<Real> to_eye = brdf.eye();

    static Real all(Real x) { return x; }
    Real mirror() const { return brdf.mirror.dot(light); }
    Real eye_square() const { return (to_eye + light).length2(); }
    Real eye_normal() const { return brdf.normal.dot(to_eye + light); }
    Real across() const { return width > 0 ? brdf.normal.cross(to_eye).normalized().dot(light) : Real(0); }
    Real spread() const { return width; }
};

}  // namespace

double metallic_fresnel(double cosine) {
    const double incidence = std::acos(std::min(cosine, 1.0)) / (pi / 2), from_pole = incidence - 1.12;
    return std::clamp(0.014567225 / (from_pole * from_pole) - 0.011612903, 0.0, 1.0);
}

float lobe_value(const Lobe& lobe, const VertexBrdf& brdf, const Vec3f& light, float spread) {
    return lobe_mean<float>(lobe, LightDirection<float>{brdf, light, spread});
}

double lobe_value(const BasicLobe<double>& lobe, const BasicBrdf<double>& brdf, const Vec3d& light,
                  double spread) {
    return lobe_mean<double>(lobe, LightDirection<double>{brdf, light, spread});
}

Outgoing reflectance(const VertexBrdf& brdf, const Vec3f& light) {
    const float cosine = brdf.normal.dot(light);
    if (!(cosine > 0)) return {};
    return {brdf.diffuse * cosine, specular_reflectance(brdf, light)};
}

}  // namespace haarfield
