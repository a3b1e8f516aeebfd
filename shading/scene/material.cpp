#include "shading/scene/material.h"

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

double phong_lobe(const Material& material, const Vec3d& mirror, const Vec3d& light) {
    return std::pow(std::max(0.0, mirror.dot(light)), double(material.shininess));
}

double blinn_lobe(const Material& material, const Vec3d& normal, const Vec3d& mirror, const Vec3d& light) {
    const Vec3d to_eye = normal * (2 * normal.dot(mirror)) - mirror;
    return std::pow(std::max(0.0, normal.dot((to_eye + light).normalized())), 1 / double(material.roughness));
}

}  // namespace

double metallic_fresnel(double cosine) {
    const double incidence = std::acos(std::min(cosine, 1.0)) / (pi / 2), from_pole = incidence - 1.12;
    return std::clamp(0.014567225 / (from_pole * from_pole) - 0.011612903, 0.0, 1.0);
}

Components<Vec3d> reflectance(const Material& material, const Vec3d& normal, const Vec3d& mirror,
                              const Vec3d& light) {
    const double cosine = normal.dot(light);
    if (cosine <= 0) return {};
    const Vec3d diffuse = Vec3d(material.diffuse) * (cosine / pi), specular(material.specular);
    if (material.specular == Rgb(0.0f)) return {diffuse};
    if (material.convention == LobeConvention::physical)
        return {diffuse, specular * (phong_lobe(material, mirror, light) * cosine *
                                     (double(material.shininess) + 2) / (2 * pi))};
    double highlight = 0;
    if (material.phong > 0) highlight += double(material.phong) * phong_lobe(material, mirror, light);
    if (material.blinn > 0) highlight += double(material.blinn) * blinn_lobe(material, normal, mirror, light);
    Vec3d tint(1.0);
    if (material.metallic > 0)
        tint -= (Vec3d(1.0) - Vec3d(material.pigment)) *
                (double(material.metallic) * (1 - metallic_fresnel(cosine)));
    return {diffuse, specular * tint * (highlight / pi)};
}

}  // namespace haarfield
