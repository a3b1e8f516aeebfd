#include "bridge/povray/interpolated_normals.h"

namespace haarfield {
namespace {

constexpr double tilt = 1e-4;       // [rad] POV-Ray interpolates from 1e-5 on.
constexpr double agreement = 5e-5;  // [rad] Normals that differ by more are interpolated as they are.

}  // namespace

InterpolatedNormals interpolated_normals(const Mesh& mesh) {
    InterpolatedNormals result{mesh.normals, {}};
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const Vec3d normal = Vec3d(mesh.normals[a]).normalized();
        const auto differs = [&](std::uint32_t corner) {
            return (Vec3d(mesh.normals[corner]).normalized() - normal).length() > agreement;
        };
        if (differs(b) || differs(c)) continue;
        const Vec3d area = (Vec3d(mesh.positions[b]) - Vec3d(mesh.positions[a]))
                               .cross(Vec3d(mesh.positions[c]) - Vec3d(mesh.positions[a]));
        if (!(area.length() > 0)) continue;
        const Vec3d geometric = area.normalized(), aside = geometric - normal * normal.dot(geometric);
        if (aside.length() <= tilt) continue;
        if (result.indices.empty()) result.indices = mesh.triangles;
        result.indices[t][0] = static_cast<std::uint32_t>(result.normals.size());
        result.normals.emplace_back((normal + aside.normalized() * tilt).normalized());
    }
    return result;
}

}  // namespace haarfield
