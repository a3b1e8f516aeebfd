#include "scenes/scene_camera.h"

#include "fields/base/names.h"
#include "scenes/camera_frame.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {

namespace {

constexpr double azimuth = 35 * pi / 180, elevation = 25 * pi / 180;
constexpr double filled = 0.9;           // Of the picture's width and height.
constexpr float flatness = 0.05f;        // Ratio of height to width below which an object is flat.
constexpr double nearest_target = 1e-4;  // [m]

/// Calls use(triangle) for every triangle of an instance, with its corners in world coordinates.
template <class Use>
void for_triangles(const Scene& scene, const SceneEntities& entities, std::size_t instance, const Use& use) {
    const Mesh& mesh = entities.of_instance(instance).mesh.original;
    const Placement& placement = scene.instances[instance].placement;
    for (const auto& [a, b, c] : mesh.triangles)
        use(std::array{Vec3d(placement.point_to_world(mesh.positions[a])),
                       Vec3d(placement.point_to_world(mesh.positions[b])),
                       Vec3d(placement.point_to_world(mesh.positions[c]))});
}

std::vector<Bounds> instance_bounds(const Scene& scene, const SceneEntities& entities) {
    std::vector<Bounds> bounds(scene.instances.size());
    for (std::size_t i = 0; i < bounds.size(); ++i)
        for_triangles(scene, entities, i, [&](const std::array<Vec3d, 3>& corners) {
            for (const Vec3d& corner : corners) bounds[i].add(Vec3f(corner));
        });
    return bounds;
}

bool is_flat(const Bounds& bounds) {
    const Vec3f size = bounds.upper - bounds.lower;
    return size.y < flatness * std::max(size.x, size.z);
}

/// Returns by instance whether the picture must show it.
std::vector<bool> counting_instances(const std::vector<Bounds>& bounds) {
    Bounds upright;
    for (const Bounds& box : bounds)
        if (!is_flat(box)) upright.add(box.lower), upright.add(box.upper);
    const auto is_ground = [&](const Bounds& box) {
        const Vec3f size = box.upper - box.lower, wanted = upright.upper - upright.lower;
        return is_flat(box) && size.x >= wanted.x && size.z >= wanted.z;
    };
    std::vector<bool> counts;
    for (const Bounds& box : bounds) counts.push_back(!is_ground(box));
    if (std::ranges::find(counts, true) == counts.end()) counts.assign(bounds.size(), true);
    return counts;
}

/// Half the picture's size at unit depth.
struct HalfSize {
    double across, up;
};

HalfSize half_size(const Camera& camera) {
    const double up = std::tan(0.5 * double(camera.vertical_fov));
    return {up * camera.width / camera.height, up};
}

/// Two planes through the eye that bound the picture along one axis. A point p is in the picture of an eye e
/// if |p - e| <= tangent * depth(p - e). Gathers how far the planes must move to include all points.
class Wedge {
public:
    explicit Wedge(double tangent) : tangent_(tangent) {}

    void add(double along, double depth) {
        above_ = std::max(above_, along - tangent_ * depth);
        below_ = std::max(below_, -along - tangent_ * depth);
    }
    /// Returns the depth of the eye in which both planes meet: the nearest eye that shows all points.
    double depth() const { return -(above_ + below_) / (2 * tangent_); }
    /// Returns the position along the axis where an eye at that depth, or behind it, has equal margins.
    double middle() const { return (above_ - below_) / 2; }

private:
    double tangent_;
    double above_ = -INFINITY, below_ = -INFINITY;
};

Camera framed(Camera camera, const Scene& scene, const SceneEntities& entities) {
    const Vec3d to_eye(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                       std::cos(azimuth) * std::cos(elevation));
    camera.target = Vec3f(0, 0, 0);
    camera.position = Vec3f(to_eye);
    const CameraFrame frame = camera_frame(camera);
    const HalfSize half = half_size(camera);
    Wedge across(filled * half.across), up(filled * half.up);
    double nearest = INFINITY, farthest = -INFINITY;
    const std::vector<bool> counts = counting_instances(instance_bounds(scene, entities));
    for (std::size_t i = 0; i < counts.size(); ++i)
        if (counts[i])
            for_triangles(scene, entities, i, [&](const std::array<Vec3d, 3>& corners) {
                for (const Vec3d& corner : corners) {
                    const double depth = corner.dot(frame.forward);
                    across.add(corner.dot(frame.right), depth);
                    up.add(corner.dot(frame.up), depth);
                    nearest = std::min(nearest, depth);
                    farthest = std::max(farthest, depth);
                }
            });
    const double depth = std::min(across.depth(), up.depth());
    const Vec3d eye = frame.right * across.middle() + frame.up * up.middle() + frame.forward * depth;
    const double to_target = std::max((nearest + farthest) / 2 - depth, nearest_target);
    camera.position = Vec3f(eye);
    camera.target = Vec3f(eye + frame.forward * to_target);
    return camera;
}

/// Tests whether a triangle intersects the picture: clips it by the four planes.
///
/// corners  across and up in half pictures per depth, and the depth.
bool is_in_picture(const std::array<Vec3d, 3>& corners) {
    constexpr std::array<std::array<double, 2>, 4> planes{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
    std::vector<Vec3d> left(corners.begin(), corners.end()), cut;
    for (const auto& [x, y] : planes) {
        const auto inside = [x = x, y = y](const Vec3d& p) { return p.z - x * p.x - y * p.y; };
        cut.clear();
        for (std::size_t i = 0; i < left.size(); ++i) {
            const Vec3d &here = left[i], &next = left[(i + 1) % left.size()];
            const double a = inside(here), b = inside(next);
            if (a > 0) cut.push_back(here);
            if ((a > 0) != (b > 0)) cut.push_back(here + (next - here) * (a / (a - b)));
        }
        left.swap(cut);
        if (left.empty()) return false;
    }
    return true;
}

bool shows_anything(const Scene& scene, const SceneEntities& entities) {
    const CameraFrame frame = camera_frame(scene.camera);
    const HalfSize half = half_size(scene.camera);
    bool found = false;
    for (std::size_t i = 0; i < scene.instances.size() && !found; ++i)
        for_triangles(scene, entities, i, [&](std::array<Vec3d, 3> corners) {
            if (found) return;
            for (Vec3d& corner : corners) {
                const Vec3d from_eye = corner - Vec3d(scene.camera.position);
                corner = {from_eye.dot(frame.right) / half.across, from_eye.dot(frame.up) / half.up,
                          from_eye.dot(frame.forward)};
            }
            found = is_in_picture(corners);
        });
    return found;
}

/// Returns the names of instances in front of the camera whose bounding spheres are smaller than a pixel.
std::vector<std::string> tiny_instances(const Scene& scene, const SceneEntities& entities) {
    const CameraFrame frame = camera_frame(scene.camera);
    const double pixels_per_slope = scene.camera.height / (2 * half_size(scene.camera).up);
    std::vector<Bounds> bounds;
    for (const auto& entity : entities.entities) bounds.push_back(mesh_bounds(entity->mesh.original));
    std::vector<std::string> names;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Bounds& box = bounds[entities.entity_of_instance[i]];
        const Placement& placement = scene.instances[i].placement;
        const double depth = (Vec3d(placement.point_to_world(box.centre())) - Vec3d(scene.camera.position))
                                 .dot(frame.forward),
                     size = 2 * double(box.radius() * placement.scale);
        if (depth > size && size / depth * pixels_per_slope < 1) names.push_back(scene.instances[i].name);
    }
    return names;
}

}  // namespace

Camera scene_camera(const Scene& scene, const SceneEntities& entities) {
    return scene.finds_camera ? framed(scene.camera, scene, entities) : scene.camera;
}

std::vector<std::string> camera_troubles(const Scene& scene, const SceneEntities& entities) {
    std::vector<std::string> troubles;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const EntityOcclusion& occlusion = *entities.of_instance(i).occlusion;
        if (occlusion.in_original()(scene.instances[i].placement.point_to_object(scene.camera.position)))
            troubles.push_back(fmt::format(
                "the camera is inside {}; if that is a room, add faces = \"inwards\" to [entities.{}]",
                scene.instances[i].name, scene.entities[scene.instances[i].entity].name));
    }
    if (const std::vector<std::string> tiny = tiny_instances(scene, entities); !tiny.empty()) {
        constexpr std::size_t most_listed = 5;
        troubles.push_back(fmt::format("smaller than a pixel in the picture: {}; is a scale applied twice?",
                                       quoted_list(tiny, most_listed)));
    }
    if (!shows_anything(scene, entities)) troubles.emplace_back("no object is in the picture");
    return troubles;
}

}  // namespace haarfield
