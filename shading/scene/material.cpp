#include "shading/scene/material.h"

namespace haarfield {

Components<Vec3d> reflectance(const Material& material, const Vec3d& normal, const Vec3d& mirror,
                              const Vec3d& light) {
    const double cosine = normal.dot(light);
    if (!(cosine > 0)) return {};
    return {Vec3d(material.diffuse) * (cosine / pi),
            specular_reflectance(surface_brdf<double>(material, normal, mirror), light)};
}

}  // namespace haarfield
