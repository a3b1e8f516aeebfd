#include "fields/local_samples.h"

namespace haarfield {

LocalSamples local_samples(const PreparedMesh& prepared, const Occluder& occluder) {
    constexpr float bulging_offset = 1e-3f;
    constexpr float inwards = 0.05f;  // of the way to the middle of the triangles
    const Mesh& mesh = prepared.fine;
    const Occluder original = make_occluder(prepared.original);
    const InsideTest is_inside(original);
    const bool may_bulge = occluder.one_sided < occluder.triangles.size() &&
                           prepared.coarse.triangles.size() != prepared.original.triangles.size();
    const float offset = occluder.bounds.radius() * (may_bulge ? bulging_offset : surface_offset);

    std::vector<Vec3f> sum(mesh.positions.size(), Vec3f(0.0f));
    std::vector<std::uint32_t> count(mesh.positions.size(), 0);
    for (const auto& triangle : mesh.triangles) {
        const Vec3f &a = mesh.positions[triangle[0]], &b = mesh.positions[triangle[1]],
                    &c = mesh.positions[triangle[2]];
        const Vec3f middle = (a + b + c) / 3.0f;
        const Vec3f normal = (b - a).cross(c - a).normalized();
        if (is_inside(middle + normal * offset)) continue;
        for (const std::uint32_t v : triangle) {
            sum[v] += middle;
            ++count[v];
        }
    }
    LocalSamples samples;
    samples.points = mesh.positions;
    samples.buried.assign(mesh.positions.size(), 0);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3f& normal = mesh.normals[v];
        if (count[v] == 0) {
            samples.buried[v] = 1;
            continue;
        }
        const Vec3f towards = sum[v] / static_cast<float>(count[v]) - mesh.positions[v];
        samples.points[v] += (towards - normal * normal.dot(towards)) * inwards + normal * offset;
    }
    return samples;
}

}  // namespace haarfield
