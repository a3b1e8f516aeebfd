#include "tools/view/visible_vertices.h"

#include "scenes/camera_frame.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cassert>

namespace haarfield {
namespace {

constexpr float beside = 1.1f;  ///< Half widths of the picture, with a margin.
/// The smallest cosine between a normal and the direction to the eye. Smooth normals may point away at a
/// visible outline.
constexpr float least_cosine = -0.3f;

/// The view frustum of a camera, with a margin.
class ViewFrustum {
public:
    explicit ViewFrustum(const Camera& camera) : eye_(camera.position) {
        const CameraFrame frame = camera_frame(camera);
        forward_ = Vec3f(frame.forward);
        right_ = Vec3f(frame.right);
        up_ = Vec3f(frame.up);
        half_height_ = beside * static_cast<float>(std::tan(0.5 * double(camera.vertical_fov)));
        half_width_ = half_height_ * static_cast<float>(camera.width) / static_cast<float>(camera.height);
    }

    bool may_see(const Vec3f& point, const Vec3f& normal) const {
        const Vec3f away = point - eye_;
        const float ahead = away.dot(forward_);
        return ahead > 0 && std::abs(away.dot(right_)) <= half_width_ * ahead &&
               std::abs(away.dot(up_)) <= half_height_ * ahead &&
               -away.dot(normal) >= least_cosine * away.length();
    }

private:
    Vec3f eye_, forward_, right_, up_;
    float half_width_, half_height_;
};

}  // namespace

VertexMask visible_vertices(const Design& design, const Camera& camera, const SceneEntities& entities,
                            std::span<const std::uint32_t> ids) {
    const ViewFrustum outlook(camera);
    VertexMask seen;
    for (const std::uint32_t id : ids) {
        const std::optional<std::size_t> place = place_of(design, id);
        assert(place);
        const Mesh& mesh = entities.entities[design.entities[*place]]->mesh.fine;
        const Placement& placement = design.scene.instances[*place].placement;
        std::vector<std::uint8_t> own(mesh.positions.size());
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, own.size(), 8192), [&](const auto& range) {
            for (std::size_t v = range.begin(); v < range.end(); ++v)
                own[v] = outlook.may_see(placement.point_to_world(mesh.positions[v]),
                                         placement.direction_to_world(mesh.normals[v]));
        });
        std::vector<std::uint8_t>& chosen = seen.emplace_back(own);
        for (const auto& [a, b, c] : mesh.triangles)
            if (own[a] || own[b] || own[c]) chosen[a] = chosen[b] = chosen[c] = 1;
    }
    return seen;
}

}  // namespace haarfield
