#include "bridge/povray_import/bend_refinement.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "bridge/povray_import/object_lattice.h"

namespace haarfield {
namespace {

using EdgeKey = std::array<std::uint32_t, 2>;  // Places of the ends, in rising order.

// Cosines of angles between normals. Surfaces bend by more than 10 degrees; vertices at sharp edges by 37.
constexpr float straight = 0.985f, sharp = 0.8f;
constexpr double shortest = 0.125;  // Of edges that are divided. [cells]
constexpr int divisions = 3;        // In which edges become as short as that.
constexpr std::size_t most_rays = 100000;
constexpr std::size_t most_added = 20000;  // Vertices, for each surface.

/// A ray to a surface, and what is done where it hits.
struct BendRay {
    ProbeRay ray;
    double reach = 0;               ///< Distance from the start to where the surface is expected. [cells]
    std::optional<EdgeKey> edge{};  ///< None: of a place.
    std::uint32_t place = 0;        ///< Unless there is an edge.
};

/// One surface while it is refined. A place is a position; vertices at a sharp edge share theirs.
class BentSurface {
public:
    BentSurface(ObjectSurface& surface, const GridFrame& frame, std::size_t index)
        : surface_(surface),
          frame_(frame),
          index_(index),
          most_vertices_(surface.positions.size() + std::min(2 * surface.positions.size(), most_added)) {
        std::map<std::array<float, 3>, std::uint32_t> places;
        for (const Vec3f& position : surface.positions) {
            const auto count = static_cast<std::uint32_t>(places.size());
            place_of_.push_back(
                places.try_emplace({position.x, position.y, position.z}, count).first->second);
        }
        vertices_.resize(places.size());
        for (std::uint32_t v = 0; v < place_of_.size(); ++v) vertices_[place_of_[v]].push_back(v);
        is_sharp_.resize(places.size());
        for (std::uint32_t place = 0; place < vertices_.size(); ++place)
            is_sharp_[place] = has_sharp_edge(place);
    }

    /// Adds rays to the places near which the surface bends.
    void add_place_rays(std::vector<BendRay>& rays) const {
        std::vector<bool> bends = is_sharp_;
        for (const auto& triangle : surface_.triangles)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
                if (surface_.normals[a].dot(surface_.normals[b]) < straight)
                    bends[place_of_[a]] = bends[place_of_[b]] = true;
            }
        constexpr double reach = 0.5;
        for (std::uint32_t place = 0; place < bends.size(); ++place)
            if (bends[place] && faces_one_side(place))
                rays.push_back({ray_to(Vec3d(position(place)), mean_normal(place), reach), reach, {}, place});
    }

    /// Adds rays to the middles of edges between which the surface bends.
    void add_edge_rays(std::vector<BendRay>& rays) const {
        std::map<EdgeKey, std::array<std::uint32_t, 2>> edges;
        for (const auto& triangle : surface_.triangles)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
                if (is_divisible(a, b)) edges.try_emplace(key_of(a, b), std::array{a, b});
            }
        std::vector<std::pair<double, BendRay>> found;
        for (const auto& [key, ends] : edges) {
            const Vec3d a(surface_.positions[ends[0]]), b(surface_.positions[ends[1]]);
            const double reach = 0.5 * length_of(a, b);
            const Vec3f normal = surface_.normals[ends[0]] + surface_.normals[ends[1]];
            found.push_back({reach, {ray_to((a + b) / 2, normal, reach), reach, key, 0}});
        }
        // If they are too many, the longest edges.
        std::ranges::stable_sort(found, std::ranges::greater(), &std::pair<double, BendRay>::first);
        const std::size_t room = most_vertices_ - std::min(most_vertices_, surface_.positions.size());
        if (found.size() > room) found.resize(room);
        for (auto& [length, ray] : found) rays.push_back(std::move(ray));
    }

    /// Moves a place to where a ray hit, if that is the surface of its vertices.
    void move(const BendRay& sent, const TracedPoint& hit) {
        const std::optional<Vertex> found = vertex_at(sent, hit);
        if (!found) return;
        const Vec3f middle = mean_normal(sent.place);
        float farthest = 1;
        for (const std::uint32_t v : vertices_[sent.place])
            farthest = std::min(farthest, surface_.normals[v].dot(middle));
        const float cosine = found->normal.dot(middle);
        if (is_sharp_[sent.place]) {
            // At a sharp edge, the normal is that of one side.
            if (std::acos(std::min(1.0f, cosine)) > 0.5f * std::acos(farthest)) return;
            is_sharp_[sent.place] = false;
        } else if (cosine < sharp) {
            return;
        }
        for (const std::uint32_t v : vertices_[sent.place]) {
            surface_.positions[v] = found->position;
            surface_.normals[v] = found->normal;
        }
    }

    /// Adds a vertex where a ray hit.
    void divide(const BendRay& sent, const TracedPoint& hit) {
        const std::optional<Vertex> found = vertex_at(sent, hit);
        if (!found) {
            rejected_.insert(*sent.edge);
            return;
        }
        const auto vertex = static_cast<std::uint32_t>(surface_.positions.size());
        surface_.positions.push_back(found->position);
        surface_.normals.push_back(found->normal);
        place_of_.push_back(static_cast<std::uint32_t>(vertices_.size()));
        vertices_.push_back({vertex});
        is_sharp_.push_back(false);
        middles_[*sent.edge] = vertex;
    }

    /// Divides the triangles of divided edges.
    void divide_triangles() {
        std::vector<std::array<std::uint32_t, 3>> triangles;
        const std::size_t solid = surface_.triangles.size() - surface_.sheet_triangles;
        std::size_t solid_after = 0;
        for (std::size_t t = 0; t < surface_.triangles.size(); ++t) {
            add_divided(surface_.triangles[t], triangles);
            if (t + 1 == solid) solid_after = triangles.size();
        }
        surface_.triangles = std::move(triangles);
        surface_.sheet_triangles = surface_.triangles.size() - solid_after;
        middles_.clear();
    }

private:
    struct Vertex {
        Vec3f position, normal;
    };

    const Vec3f& position(std::uint32_t place) const { return surface_.positions[vertices_[place].front()]; }

    bool has_sharp_edge(std::uint32_t place) const {
        for (const std::uint32_t a : vertices_[place])
            for (const std::uint32_t b : vertices_[place])
                if (surface_.normals[a].dot(surface_.normals[b]) < sharp) return true;
        return false;
    }

    Vec3f normal_sum(std::uint32_t place) const {
        Vec3f sum(0, 0, 0);
        for (const std::uint32_t v : vertices_[place]) sum += surface_.normals[v];
        return sum;
    }
    Vec3f mean_normal(std::uint32_t place) const { return normal_sum(place).normalized(); }
    /// False for blades, whose sides face opposite directions.
    bool faces_one_side(std::uint32_t place) const {
        return normal_sum(place).length() > 0.3f * static_cast<float>(vertices_[place].size());
    }

    EdgeKey key_of(std::uint32_t a, std::uint32_t b) const {
        const auto [low, high] = std::minmax(place_of_[a], place_of_[b]);
        return {low, high};
    }

    double length_of(const Vec3d& a, const Vec3d& b) const { return ((b - a) * frame_.scale).length(); }

    bool is_divisible(std::uint32_t a, std::uint32_t b) const {
        const float cosine = surface_.normals[a].dot(surface_.normals[b]);
        constexpr float opposite = -0.8f;
        return cosine < straight && cosine > opposite &&
               !(is_sharp_[place_of_[a]] && is_sharp_[place_of_[b]]) &&
               length_of(Vec3d(surface_.positions[a]), Vec3d(surface_.positions[b])) > 2 * shortest &&
               !rejected_.contains(key_of(a, b));
    }

    ProbeRay ray_to(const Vec3d& point, const Vec3f& normal, double reach) const {
        const Vec3d direction = frame_.local_normal(Vec3d(normal));
        return {index_, frame_.local_point(point) + direction * reach, -direction};
    }

    /// Returns the hit in the scene; none if it is elsewhere, or faces another direction.
    std::optional<Vertex> vertex_at(const BendRay& sent, const TracedPoint& hit) const {
        constexpr double least_cosine = 0.3;
        if (hit.normal.length() < 0.5) return {};
        const double distance = (hit.point - sent.ray.start).dot(sent.ray.direction);
        if (std::abs(distance - sent.reach) > 0.9 * sent.reach) return {};
        Vec3d normal = hit.normal.normalized();
        const double cosine = -normal.dot(sent.ray.direction);
        if (std::abs(cosine) < least_cosine) return {};
        if (cosine < 0) normal = -normal;
        return Vertex{Vec3f((hit.point - frame_.shift) / frame_.scale + frame_.centre),
                      Vec3f((normal * frame_.scale).normalized())};
    }

    /// Adds a triangle, or those into which the middles of its edges divide it.
    void add_divided(const std::array<std::uint32_t, 3>& corners,
                     std::vector<std::array<std::uint32_t, 3>>& triangles) const {
        std::array<std::optional<std::uint32_t>, 3> middles;  // Opposite to the corners.
        std::size_t divided = 0;
        for (std::size_t k = 0; k < 3; ++k)
            if (const auto found = middles_.find(key_of(corners[(k + 1) % 3], corners[(k + 2) % 3]));
                found != middles_.end()) {
                middles[k] = found->second;
                ++divided;
            }
        if (divided == 0) {
            triangles.push_back(corners);
            return;
        }
        // Turned so that the first edge is divided, and the last one is not, unless all are.
        std::size_t first = 0;
        while (!(middles[first] && (divided == 3 || !middles[(first + 2) % 3]))) ++first;
        const std::uint32_t a = corners[first], b = corners[(first + 1) % 3], c = corners[(first + 2) % 3],
                            bc = *middles[first];
        if (divided == 1) {
            triangles.insert(triangles.end(), {{a, b, bc}, {a, bc, c}});
            return;
        }
        const std::uint32_t ca = *middles[(first + 1) % 3];
        if (divided == 3) {
            const std::uint32_t ab = *middles[(first + 2) % 3];
            triangles.insert(triangles.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
            return;
        }
        triangles.push_back({c, ca, bc});
        const auto distance = [&](std::uint32_t i, std::uint32_t j) {
            return (surface_.positions[i] - surface_.positions[j]).length();
        };
        if (distance(a, bc) < distance(b, ca))
            triangles.insert(triangles.end(), {{a, b, bc}, {a, bc, ca}});
        else
            triangles.insert(triangles.end(), {{a, b, ca}, {b, bc, ca}});
    }

    ObjectSurface& surface_;
    const GridFrame& frame_;
    std::size_t index_;
    std::size_t most_vertices_;
    std::vector<std::uint32_t> place_of_;               ///< By vertex.
    std::vector<std::vector<std::uint32_t>> vertices_;  ///< By place.
    std::vector<bool> is_sharp_;                        ///< By place.
    std::map<EdgeKey, std::uint32_t> middles_;
    std::set<EdgeKey> rejected_;
};

}  // namespace

Result<Done> refine_bends(const SceneQueries& queries, std::span<const GridRequest> requests,
                          std::vector<ObjectSurface>& surfaces, double seconds, const Progress& progress) {
    const ObjectLattice lattice(requests, surfaces);
    std::vector<BentSurface> bent;
    std::vector<std::optional<std::size_t>> bent_of(surfaces.size());
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        const auto request = std::ranges::lower_bound(requests, surfaces[s].object, {}, &GridRequest::object);
        if (request->is_cut) continue;
        bent_of[s] = bent.size();
        bent.emplace_back(surfaces[s], lattice.frame(s), s);
    }
    for (int round = 0; round <= divisions; ++round) {
        std::vector<BendRay> sent;
        for (const BentSurface& surface : bent)
            round == 0 ? surface.add_place_rays(sent) : surface.add_edge_rays(sent);
        if (sent.empty()) {
            if (round == 0) continue;
            break;
        }
        if (sent.size() > most_rays) {
            std::ranges::stable_sort(sent, std::ranges::greater(), &BendRay::reach);
            sent.resize(most_rays);
        }
        std::vector<ProbeRay> rays;
        for (const BendRay& ray : sent) rays.push_back(ray.ray);
        HF_TRY(const std::vector<TracedPoint> hits, lattice.traced(queries, rays, seconds, progress));
        for (std::size_t i = 0; i < sent.size(); ++i) {
            BentSurface& surface = bent[*bent_of[sent[i].ray.surface]];
            sent[i].edge ? surface.divide(sent[i], hits[i]) : surface.move(sent[i], hits[i]);
        }
        for (BentSurface& surface : bent) surface.divide_triangles();
    }
    return Done{};
}

}  // namespace haarfield
