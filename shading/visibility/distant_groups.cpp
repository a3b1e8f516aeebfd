#include "shading/visibility/distant_groups.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace haarfield {
namespace {

/// Least distance from a cube's centre at which an instance belongs to its group. [edges of the cube]
constexpr float least_edges = 16;

/// Cubes of each size that are kept: four along each axis, so that neighbours do not displace each other.
constexpr int kept_along = 4;

constexpr float half_diagonal = 0.8660254f;  // edges

}  // namespace

DistantGroups::DistantGroups(const ShadedScene& scene, const ShadingGeometry& geometry, std::size_t without)
    : scene_(scene), geometry_(geometry), maker_(geometry.face_size) {
    Bounds bounds;
    float least = INFINITY;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const ShadingGeometry::Instance& seen = geometry.instances[i];
        bounds.add(seen.middle, seen.radius);
        if (i == without) continue;
        all_.push_back(i);
        least = std::min(least, seen.nearer);
    }
    // Powers of two, so that the cubes of a scene do not depend on the placements of its instances.
    const float extent = 2 * bounds.radius();
    float edge = std::exp2(std::floor(std::log2(std::max(least / least_edges, 1e-5f * extent))));
    do {
        sizes_.push_back({edge, {}});
        edge *= 2;
    } while (edge < extent);
}

DistantGroups::Surroundings DistantGroups::around(const Vec3f& point) {
    std::array<int, 3> place;
    for (int axis = 0; axis < 3; ++axis)
        place[std::size_t(axis)] = int(std::clamp(std::floor(point[axis] / sizes_[0].edge), -1e9f, 1e9f));
    Cube& found = cube(0, place);
    Surroundings result{nullptr, 0, found.near};
    if (found.joint) {
        Joint& joint = *found.joint;
        if (!joint.is_made) maker_.make(joint.open, joint.tree);
        joint.is_made = true;
        result.distant = &joint.tree;
        result.number = joint.number;
    }
    return result;
}

DistantGroups::Cube& DistantGroups::cube(std::size_t size, const std::array<int, 3>& place) {
    std::vector<Cube>& cubes = sizes_[size].cubes;
    if (cubes.empty()) cubes.resize(kept_along * kept_along * kept_along);
    std::size_t slot = 0;
    for (const int number : place) slot = slot * kept_along + std::size_t(number & (kept_along - 1));
    Cube& kept = cubes[slot];
    if (kept.is_used && kept.place == place) return kept;
    kept.place = place;
    kept.is_used = true;
    fill(size, kept);
    return kept;
}

/// Divides the instances that are near the next larger cube into the cube's group and those near it.
void DistantGroups::fill(std::size_t size, Cube& made) {
    const float edge = sizes_[size].edge;
    const Vec3f centre =
        Vec3f(float(made.place[0]) + 0.5f, float(made.place[1]) + 0.5f, float(made.place[2]) + 0.5f) * edge;
    const Cube* outer = nullptr;
    if (size + 1 < sizes_.size())
        outer = &cube(size + 1, {made.place[0] >> 1, made.place[1] >> 1, made.place[2] >> 1});
    made.near.clear();
    std::shared_ptr<Joint> before = std::exchange(made.joint, outer ? outer->joint : nullptr);
    std::shared_ptr<Joint> own;
    for (const std::uint32_t i : outer ? outer->near : all_) {
        const ShadingGeometry::Instance& seen = geometry_.instances[i];
        const ShadedInstance& placed = scene_.instances[i];
        const float distance = (seen.middle - centre).length(), slack = half_diagonal * edge,
                    reach = geometry_.reach * seen.radius;
        if (distance > reach + slack) continue;
        const bool is_near =
            distance<std::max(least_edges * edge, seen.nearer + slack), leaves_reach = distance> reach -
            slack;
        if (is_near || leaves_reach || !geometry_.impostors[placed.entity]) {
            made.near.push_back(i);
            continue;
        }
        if (!own) {
            // The memory of the cube's last joint is reused unless smaller cubes still use it.
            own = before.use_count() == 1 ? std::move(before) : std::make_shared<Joint>();
            if (made.joint)
                own->open = made.joint->open;
            else
                own->open.assign(std::size_t(cubemap_faces * geometry_.face_size * geometry_.face_size), 255);
            own->is_made = false;
            own->number = ++joints_;
            made.joint = own;
        }
        geometry_.impostors[placed.entity]->hide(placed.placement, centre, own->open);
    }
}

}  // namespace haarfield
