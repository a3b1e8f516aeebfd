#include "shading/scene/emitter.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haarfield {
namespace {

constexpr float like_a_point = 0.004f;  ///< Ratio of radius to distance, about that of the sun.
constexpr float near_triangle = 0.05f;  ///< Ratio of radius to distance above which Lambert's formula is
                                        ///< used.
constexpr float point_size = 0.08f;     ///< Largest ratio of radius to distance at which several triangles
                                        ///< are treated as a point.

using Corners = std::array<Vec3f, 3>;

/// Returns the normal with the area as its length.
Vec3f area_vector(const Corners& c) {
    return (c[1] - c[0]).cross(c[2] - c[0]) * 0.5f;
}

Vec3f middle_of(const Corners& c) {
    return (c[0] + c[1] + c[2]) / 3.0f;
}

float radius_of(const Corners& c) {
    const Vec3f middle = middle_of(c);
    return std::max({(c[0] - middle).length(), (c[1] - middle).length(), (c[2] - middle).length()});
}

/// Builds the nodes of a range of triangles, parents before children.
class TreeMaker {
public:
    explicit TreeMaker(EmitterTree& tree) : tree_(tree) {}

    void make(std::uint32_t first, std::uint32_t count) {
        const std::size_t at = tree_.nodes.size();
        tree_.nodes.push_back(node_of(first, count));
        if (count == 1) return;
        const std::uint32_t half = parted(first, count, tree_.nodes[at]);
        make(first, half);
        tree_.nodes[at].second_child = static_cast<std::uint32_t>(tree_.nodes.size());
        make(first + half, count - half);
    }

private:
    EmitterTree::Node node_of(std::uint32_t first, std::uint32_t count) const {
        const std::span<const Emitter> triangles = std::span(tree_.triangles).subspan(first, count);
        Vec3d centre(0.0), facing(0.0), power(0.0);
        double weights = 0;
        for (const Emitter& triangle : triangles) {
            const Vec3d area(area_vector(triangle.corners));
            const double weight = area.length() * double(luminance(triangle.radiance));
            centre += Vec3d(middle_of(triangle.corners)) * weight;
            facing += area * double(luminance(triangle.radiance));
            power += Vec3d(triangle.radiance) * area.length();
            weights += weight;
        }
        EmitterTree::Node node;
        node.centre = Vec3f(centre / weights);
        node.facing = Vec3f(facing / weights);
        node.power = Rgb(Vec3f(power));
        node.first = first;
        node.count = count;
        const Vec3f axis = node.facing.normalized();
        float least = 1, nearest = std::numeric_limits<float>::infinity();
        for (const Emitter& triangle : triangles) {
            const Vec3f middle = middle_of(triangle.corners);
            // Shadow rays end on the surface, not in the middle of a curved one.
            if (const float away = (middle - node.centre).length2(); away < nearest) {
                nearest = away;
                node.place = middle;
            }
            for (const Vec3f& corner : triangle.corners)
                node.radius = std::max(node.radius, (corner - node.centre).length());
            least = std::min(least, area_vector(triangle.corners).normalized().dot(axis));
        }
        node.cone = least > 0 ? std::sqrt(std::max(0.0f, 1 - least * least)) : 1.0f;
        return node;
    }

    /// Sorts the range along the axis of largest extent, of the normals while they differ much, else of the
    /// positions, and divides it in two. Returns the size of the first half.
    std::uint32_t parted(std::uint32_t first, std::uint32_t count, const EmitterTree::Node& node) {
        constexpr float narrow = 0.4f;  // About 24 degrees.
        const bool by_normal = node.cone > narrow;
        const auto key = [&](const Emitter& triangle) {
            return by_normal ? area_vector(triangle.corners).normalized() : middle_of(triangle.corners);
        };
        const auto begin = tree_.triangles.begin() + first, end = begin + count;
        Vec3f lower = key(*begin), upper = lower;
        for (auto triangle = begin; triangle != end; ++triangle) {
            const Vec3f k = key(*triangle);
            for (int axis = 0; axis < 3; ++axis) {
                lower[axis] = std::min(lower[axis], k[axis]);
                upper[axis] = std::max(upper[axis], k[axis]);
            }
        }
        const Vec3f extent = upper - lower;
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        std::stable_sort(begin, end,
                         [&](const Emitter& a, const Emitter& b) { return key(a)[axis] < key(b)[axis]; });
        return count / 2;
    }

    EmitterTree& tree_;
};

/// Collects the patches of one point.
class PatchFinder {
public:
    PatchFinder(const EmitterTree& tree, const Vec3f& point, const Vec3f& normal, const EmitterCut& cut,
                std::vector<EmitterPatch>& patches)
        : tree_(tree),
          point_(point),
          normal_(normal),
          size_(cut.size),
          most_(cut.most),
          most_splits_(4 * cut.most),
          most_power_(luminance(tree.nodes[0].power) * cut.share),
          patches_(patches) {}

    /// Finds the patches. Returns false if there are too many patches or splits, such as for a needle nearby.
    bool find(float size) {
        size_ = size;
        splits_ = 0;
        patches_.clear();
        descend(0);
        return !is_too_much();
    }

    /// Finds the patches without a limit on their number; divides large triangles at most twice.
    void find_all(float size) {
        most_ = most_splits_ = std::numeric_limits<std::size_t>::max();
        cuts_ = 2;
        find(size);
    }

private:
    bool is_too_much() const { return patches_.size() > most_ || splits_ > most_splits_; }

    /// Tests whether a sphere lies below the horizon.
    bool is_below(const Vec3f& centre, float radius) const {
        return (centre - point_).dot(normal_) <= -radius;
    }

    bool is_small(float radius, float distance, float power, float size) const {
        const float room = distance - radius;
        return radius <= size * room && (power <= most_power_ || radius <= like_a_point * room);
    }

    void descend(std::size_t index) {
        if (is_too_much()) return;
        const EmitterTree::Node& node = tree_.nodes[index];
        if (is_below(node.centre, node.radius)) return;
        if (node.count == 1) {
            const Emitter& triangle = tree_.triangles[node.first];
            cut(triangle.corners, triangle.radiance, cuts_);
            return;
        }
        const Vec3f to = node.centre - point_;
        const float distance = to.length();
        if (is_small(node.radius, distance, luminance(node.power), std::min(size_, point_size)) &&
            node.cone < 1) {
            // Either all triangles face the point, or none does.
            const float cosine = -node.facing.normalized().dot(to) / distance,
                        margin = node.radius / distance;
            if (cosine <= -node.cone - margin) return;
            const bool is_above = to.dot(normal_) >= node.radius;
            if (is_above && cosine >= node.cone + margin) {
                add_as_point(node, to, distance);
                return;
            }
        }
        descend(index + 1);
        descend(node.second_child);
    }

    void add_as_point(const EmitterTree::Node& node, const Vec3f& to, float distance) {
        const Vec3f direction = to / distance;
        const float by_area = -node.facing.dot(direction) / (distance * distance);
        const Rgb facing = node.power * by_area;
        patches_.push_back({node.place, direction, facing * normal_.dot(direction), facing,
                            squared_over_four(node.radius / distance)});
    }

    static float squared_over_four(float angle) { return angle * angle / 4; }

    void cut(const Corners& corners, const Rgb& radiance, int cuts) {
        if (is_too_much()) return;
        const Vec3f middle = middle_of(corners), to = middle - point_, area = area_vector(corners);
        const float radius = radius_of(corners), distance = to.length();
        // A triangle emits no light behind its plane, and almost none within it.
        if (!(-area.dot(to) > 1e-6f * area.length() * radius) || is_below(middle, radius)) return;
        if (cuts > 0 && !is_small(radius, distance, luminance(radiance) * area.length(), size_)) {
            ++splits_;
            const Corners half{(corners[1] + corners[2]) / 2.0f, (corners[2] + corners[0]) / 2.0f,
                               (corners[0] + corners[1]) / 2.0f};
            cut({corners[0], half[2], half[1]}, radiance, cuts - 1);
            cut({half[2], corners[1], half[0]}, radiance, cuts - 1);
            cut({half[1], half[0], corners[2]}, radiance, cuts - 1);
            cut(half, radiance, cuts - 1);
            return;
        }
        const Vec3f direction = to / distance;
        const float solid_angle = std::min(-area.dot(direction) / (distance * distance), float(2 * pi)),
                    cosine = normal_.dot(direction);
        const bool is_near = radius > near_triangle * distance || to.dot(normal_) < radius;
        const float projected = is_near ? static_cast<float>(triangle_irradiance(
                                              {Vec3d(corners[0]), Vec3d(corners[1]), Vec3d(corners[2])},
                                              Vec3d(point_), Vec3d(normal_)))
                                        : solid_angle * cosine;
        if (!(projected > 0)) return;
        patches_.push_back({middle, direction, radiance * projected, radiance * solid_angle,
                            squared_over_four(std::sqrt(solid_angle / float(pi)))});
    }

    const EmitterTree& tree_;
    const Vec3f point_, normal_;
    float size_;
    std::size_t most_, most_splits_, splits_ = 0;
    int cuts_ = 12;  ///< Remaining levels of division of a triangle into four.
    const float most_power_;
    std::vector<EmitterPatch>& patches_;
};

}  // namespace

EmitterTree emitter_tree(std::vector<Emitter> emitters) {
    std::erase_if(emitters, [](const Emitter& emitter) {
        return !(luminance(emitter.radiance) > 0) || !(area_vector(emitter.corners).length() > 0);
    });
    EmitterTree tree;
    if (emitters.empty()) return tree;
    tree.triangles = std::move(emitters);
    tree.nodes.reserve(2 * tree.triangles.size());
    TreeMaker(tree).make(0, static_cast<std::uint32_t>(tree.triangles.size()));
    return tree;
}

void find_patches(const EmitterTree& tree, const Vec3f& point, const Vec3f& normal, const EmitterCut& cut,
                  std::vector<EmitterPatch>& patches) {
    patches.clear();
    if (tree.empty()) return;
    constexpr float coarser = 1.5f, coarsest = 0.5f;
    PatchFinder finder(tree, point, normal, cut, patches);
    float size = cut.size;
    bool found = finder.find(size);
    while (!found && size * coarser <= coarsest) found = finder.find(size *= coarser);
    // Many triangles are nearby: uses each as it is.
    if (!found) finder.find_all(size);
}

double triangle_irradiance(const std::array<Vec3d, 3>& corners, const Vec3d& point, const Vec3d& normal) {
    // Clips the triangle at the horizon: at most four corners remain.
    std::array<Vec3d, 4> seen;
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3d a = corners[i] - point, b = corners[(i + 1) % 3] - point;
        const double above = a.dot(normal), next = b.dot(normal);
        if (above > 0) seen[count++] = a;
        if ((above > 0) != (next > 0)) seen[count++] = a + (b - a) * (above / (above - next));
    }
    if (count < 3) return 0;
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3d& a = seen[i];
        const Vec3d& b = seen[(i + 1) % count];
        const Vec3d across = a.cross(b);
        const double sine = across.length();
        if (sine > 0) sum += std::atan2(sine, a.dot(b)) / sine * across.dot(normal);
    }
    return std::abs(sum) / 2;
}

}  // namespace haarfield
