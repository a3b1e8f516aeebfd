#include "fields/preparation/mesh_simplification.h"

#include "fields/mesh/mesh_topology.h"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Edge_collapse_visitor_base.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Edge_length_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_policies.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Midpoint_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#if __has_include(<CGAL/AABB_traits_3.h>)  // CGAL 6
#include <CGAL/AABB_traits_3.h>
#else
#include <CGAL/AABB_traits.h>
#endif

#include <algorithm>
#include <optional>

namespace haarfield {
namespace {

namespace simplification = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
using Triangle = std::array<std::uint32_t, 3>;

/// The stop condition of simplification.
struct EnoughTriangles {
    std::size_t wanted;
    const Surface* surface;

    template <class Cost, class Profile>
    bool operator()(const Cost&, const Profile&, std::size_t, std::size_t) const {
        return surface->number_of_faces() <= wanted;
    }
};

/// Reports the progress of simplification. Throws Interrupted after a stop request, also while the costs of
/// all edges are computed.
struct CollapseProgress : simplification::Edge_collapse_visitor_base<Surface> {
    std::size_t wanted, initial, selected = 0;
    const Surface* surface;
    const Progress* progress;

    CollapseProgress(std::size_t wanted_triangles, const Surface& of, const Progress& to)
        : wanted(wanted_triangles), initial(of.number_of_faces()), surface(&of), progress(&to) {}

    // Costs are boost::optional in CGAL 5 and std::optional in CGAL 6.
    template <class Cost>
    void OnCollected(const Profile&, const Cost&) {
        check();
    }
    template <class Cost>
    void OnSelected(const Profile&, const Cost&, std::size_t, std::size_t) {
        check();
        if (selected++ % 512 == 0 && progress->report && initial > wanted)
            progress->report("simplifying",
                             initial - std::max<std::size_t>(surface->number_of_faces(), wanted),
                             initial - wanted);
    }
    void check() const {
        if (progress->stop.stop_requested()) throw Interrupted{};
    }
};

Surface surface_from(const Mesh& mesh) {
    const MergedPositions merged = merged_positions(mesh.positions);
    std::vector<Kernel::Point_3> points;
    points.reserve(merged.positions.size());
    for (const Vec3f& p : merged.positions) points.emplace_back(p.x, p.y, p.z);
    std::vector<std::array<std::size_t, 3>> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles)
        triangles.push_back({merged.index[t[0]], merged.index[t[1]], merged.index[t[2]]});
    // duplicates points to cut the surface where it is not a manifold
    CGAL::Polygon_mesh_processing::orient_polygon_soup(points, triangles);
    Surface surface;
    CGAL::Polygon_mesh_processing::polygon_soup_to_polygon_mesh(points, triangles, surface);
    return surface;
}

/// Returns positions and triangles only. The surface must have no garbage.
Mesh mesh_from(const Surface& surface) {
    Mesh mesh;
    mesh.material_names = {""};
    for (const auto vertex : surface.vertices()) {
        const Kernel::Point_3& p = surface.point(vertex);
        mesh.positions.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()),
                                    static_cast<float>(p.z()));
    }
    for (const auto face : surface.faces()) {
        Triangle triangle{};
        int corner = 0;
        for (const auto vertex : CGAL::vertices_around_face(surface.halfedge(face), surface))
            triangle[corner++] = vertex;
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

Vec3d area_vector(const Mesh& mesh, const Triangle& t) {
    const Vec3d p(mesh.positions[t[0]]);
    return (Vec3d(mesh.positions[t[1]]) - p).cross(Vec3d(mesh.positions[t[2]]) - p);
}

/// Sets area-weighted normals. A coarse mesh is never shaded, but must have unit normals.
void set_smooth_normals(Mesh& mesh) {
    std::vector<Vec3d> sums(mesh.positions.size(), Vec3d(0, 0, 0));
    for (const Triangle& t : mesh.triangles) {
        const Vec3d area = area_vector(mesh, t);
        for (std::uint32_t corner : t) sums[corner] += area;
    }
    for (std::size_t i = 0; i < sums.size(); ++i)
        mesh.normals[i] = sums[i].length2() > 0 ? Vec3f(sums[i].normalized()) : Vec3f(0, 1, 0);
}

/// Removes triangles without area, which result from rounding to float or from collapses onto a line.
void remove_empty_triangles(Mesh& mesh) {
    std::erase_if(mesh.triangles, [&mesh](const Triangle& t) { return area_vector(mesh, t).length2() == 0; });
}

/// Cuts at non-manifold edges leave fragments that no collapse removes. Drops the smallest parts until there
/// are `wanted` triangles, but at most a hundredth of the surface.
void drop_crumbs(Mesh& mesh, std::size_t wanted) {
    if (mesh.triangles.size() <= wanted) return;
    MergedPositions as_they_are{{}, mesh.positions};
    for (std::uint32_t i = 0; i < mesh.positions.size(); ++i) as_they_are.index.push_back(i);
    const std::vector<std::uint32_t> parts = triangle_pieces(mesh, as_they_are);

    struct Part {
        double area = 0;
        std::uint32_t index = 0;
        std::size_t triangles = 0;
    };
    std::vector<Part> by_area(*std::max_element(parts.begin(), parts.end()) + 1);
    double total = 0;
    for (std::size_t t = 0; t < parts.size(); ++t) {
        const double area = area_vector(mesh, mesh.triangles[t]).length();
        by_area[parts[t]].area += area;
        by_area[parts[t]].index = parts[t];
        ++by_area[parts[t]].triangles;
        total += area;
    }
    std::sort(by_area.begin(), by_area.end(), [](const Part& a, const Part& b) {
        return a.area != b.area ? a.area < b.area : a.index < b.index;
    });
    std::vector<bool> dropped(by_area.size(), false);
    std::size_t left = mesh.triangles.size();
    double dropped_area = 0;
    for (const Part& part : by_area) {
        dropped_area += part.area;
        if (left <= wanted || dropped_area > 0.01 * total) break;
        dropped[part.index] = true;
        left -= part.triangles;
    }
    std::size_t kept = 0;
    for (std::size_t t = 0; t < parts.size(); ++t)
        if (!dropped[parts[t]]) mesh.triangles[kept++] = mesh.triangles[t];
    mesh.triangles.resize(kept);
}

void remove_unused_vertices(Mesh& mesh) {
    std::vector<std::uint32_t> index(mesh.positions.size(), UINT32_MAX);
    std::vector<Vec3f> positions;
    for (Triangle& t : mesh.triangles)
        for (std::uint32_t& corner : t) {
            if (index[corner] == UINT32_MAX) {
                index[corner] = static_cast<std::uint32_t>(positions.size());
                positions.push_back(mesh.positions[corner]);
            }
            corner = index[corner];
        }
    mesh.positions = std::move(positions);
    mesh.normals.assign(mesh.positions.size(), Vec3f(0, 0, 0));
    mesh.vertex_materials.assign(mesh.positions.size(), 0);
}

/// A collapse visits each edge at its vertex, and from each all of them again, so that the centre of a fan of
/// thousands takes minutes. Flips every second edge of such a fan to connect its neighbours, if the two
/// triangles are nearly coplanar. Ends when no vertex has more than `most` edges or no edge can be flipped.
///
/// returns  the largest remaining number of edges at a vertex.
std::size_t turn_edges_of_fans(Surface& surface, std::size_t most) {
    const auto normal = [&](Surface::Vertex_index a, Surface::Vertex_index b, Surface::Vertex_index c) {
        return CGAL::cross_product(surface.point(b) - surface.point(a), surface.point(c) - surface.point(a));
    };
    // Both new triangles are within 60 degrees of the mean of the old normals.
    const auto stays_level = [&](Surface::Halfedge_index h) {
        const auto from = surface.source(h), to = surface.target(h), left = surface.target(surface.next(h)),
                   right = surface.target(surface.next(surface.opposite(h)));
        if (left == right || surface.halfedge(left, right) != Surface::null_halfedge()) return false;
        const auto old = normal(from, to, left) + normal(to, from, right);
        for (const auto& turned : {normal(from, right, left), normal(to, left, right)}) {
            const double along = turned * old;
            if (!(along > 0 && 4 * along * along >= turned.squared_length() * old.squared_length()))
                return false;
        }
        return true;
    };
    std::size_t largest = 0;
    for (const Surface::Vertex_index vertex : surface.vertices()) {
        std::size_t edges = surface.degree(vertex);
        while (edges > most) {
            std::vector<Surface::Halfedge_index> around;
            for (const Surface::Halfedge_index h : surface.halfedges_around_target(surface.halfedge(vertex)))
                around.push_back(h);
            for (std::size_t i = 0; i < around.size(); i += 2)
                if (!surface.is_border(surface.edge(around[i])) && stays_level(around[i]))
                    CGAL::Euler::flip_edge(around[i], surface);
            const std::size_t left = surface.degree(vertex);
            if (left == edges) break;
            edges = left;
        }
        largest = std::max(largest, edges);
    }
    return largest;
}

constexpr std::size_t large_fan = 128, largest_fan = 1000;

/// Returns the RMS distance of up to several thousand vertices of a mesh from a surface. [m]
double distance_from(const Mesh& mesh, const Surface& surface) {
    using Primitive = CGAL::AABB_face_graph_triangle_primitive<Surface>;
#if __has_include(<CGAL/AABB_traits_3.h>)
    using Traits = CGAL::AABB_traits_3<Kernel, Primitive>;
#else
    using Traits = CGAL::AABB_traits<Kernel, Primitive>;
#endif
    const CGAL::AABB_tree<Traits> tree(faces(surface).first, faces(surface).second, surface);
    constexpr std::size_t most = 5000;
    const std::size_t step = std::max<std::size_t>(1, mesh.positions.size() / most);
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < mesh.positions.size(); i += step, ++count) {
        const Vec3f& p = mesh.positions[i];
        sum += tree.squared_distance(Kernel::Point_3(p.x, p.y, p.z));
    }
    return std::sqrt(sum / double(count));
}

/// A stop condition that ends simplification before the surface is too far from a mesh. Whenever the number
/// of triangles has fallen by a factor of sqrt(2), it measures the distance and saves the surface.
class NearSurfaces {
public:
    NearSurfaces(const Mesh& mesh, const Surface& surface) : mesh_(mesh), surface_(surface) {
        double count = most_coarse;
        for (; count > 0.99 * fewest_coarse; count /= std::sqrt(2.0))
            if (count < double(mesh.triangles.size())) counts_.push_back(std::size_t(count + 0.5));
        Bounds bounds;
        for (const Vec3f& p : mesh.positions) bounds.add(p);
        allowed_ = coarse_distance * double(bounds.radius());
    }

    bool are_enough() {
        while (next_ < counts_.size() && surface_.number_of_faces() <= counts_[next_]) {
            Surface now = surface_;
            now.collect_garbage();
            // Large meshes are simplified at least to most_coarse, at any distance.
            const bool is_needed = next_ == 0 && mesh_.triangles.size() > 2 * most_coarse;
            if (!is_needed && distance_from(mesh_, now) > allowed_) return true;
            kept_ = std::move(now);
            ++next_;
        }
        return next_ == counts_.size();
    }
    const std::optional<Surface>& kept() const { return kept_; }  ///< None: use the original mesh.

private:
    const Mesh& mesh_;
    const Surface& surface_;
    std::vector<std::size_t> counts_;
    std::size_t next_ = 0;
    double allowed_ = 0;
    std::optional<Surface> kept_;
};

/// A stop condition that CGAL can copy.
struct NearEnough {
    NearSurfaces* surfaces;

    template <class Cost, class Profile>
    bool operator()(const Cost&, const Profile&, std::size_t, std::size_t) const {
        return surfaces->are_enough();
    }
};

using Quadrics = simplification::GarlandHeckbert_plane_policies<Surface, Kernel>;

/// Costs of collapses: quadrics, and a small share of the squared lengths of edges. In flat regions, all
/// quadrics are zero; without the lengths, collapses make fans of thousands of edges there.
struct CostWithLength : Quadrics {
    using Quadrics::Quadrics;

    template <class Profile, class Placement>
    auto operator()(const Profile& profile, const Placement& placement) const {
        constexpr double length_share = 1e-6;
        auto cost = Quadrics::operator()(profile, placement);
        if (cost) *cost += length_share * CGAL::squared_distance(profile.p0(), profile.p1());
        return cost;
    }
};

/// Places vertices at the minimum of their quadrics if it is near the edge. In flat regions, rounding decides
/// where the minimum is; there, vertices are placed at the better end or in the middle of the edge.
struct PlacementNearEdge {
    const Quadrics* quadrics;

    template <class Profile>
    auto operator()(const Profile& profile) const {
        auto best = (*quadrics)(profile);
        const Kernel::Point_3 middle = CGAL::midpoint(profile.p0(), profile.p1());
        if (best &&
            CGAL::squared_distance(*best, middle) <= CGAL::squared_distance(profile.p0(), profile.p1()))
            return best;
        best = middle;
        for (const Kernel::Point_3& end : {profile.p0(), profile.p1()}) {
            const decltype(best) candidate(end);
            if ((*quadrics)(profile, candidate) < (*quadrics)(profile, best)) best = candidate;
        }
        return best;
    }
};

/// Collapses edges by quadrics. `wanted`: a number of triangles, for the progress alone.
template <class Until>
void collapse(Surface& surface, const Until& until, std::size_t wanted, const Progress& progress) {
    const CostWithLength cost(surface);
    simplification::edge_collapse(surface, until,
                                  CGAL::parameters::get_cost(cost)
                                      .get_placement(PlacementNearEdge{&cost})
                                      .filter(simplification::Bounded_normal_change_filter<>())
                                      .visitor(CollapseProgress(wanted, surface, progress)));
}

}  // namespace

Mesh simplified(const Mesh& mesh, std::size_t wanted, ClosedFaces faces, const Progress& progress) {
    const bool is_by_distance = wanted == chosen_by_distance;
    const std::size_t thinned = std::max<std::size_t>(100000, is_by_distance ? 2 * most_coarse : 8 * wanted);
    Surface surface = surface_from(mesh);
    if (turn_edges_of_fans(surface, large_fan) > largest_fan) return mesh;
    const simplification::Bounded_normal_change_filter<> no_fold;
    if (surface.number_of_faces() > thinned + thinned / 2)
        simplification::edge_collapse(surface, EnoughTriangles{thinned, &surface},
                                      CGAL::parameters::get_cost(simplification::Edge_length_cost<Surface>())
                                          .get_placement(simplification::Midpoint_placement<Surface>())
                                          .filter(no_fold)
                                          .visitor(CollapseProgress(thinned, surface, progress)));
    surface.collect_garbage();
    if (is_by_distance) {
        NearSurfaces near(mesh, surface);
        collapse(surface, NearEnough{&near}, thinned, progress);
        if (!near.kept()) return mesh;
        surface = *near.kept();
    } else {
        collapse(surface, EnoughTriangles{wanted, &surface}, thinned, progress);
        surface.collect_garbage();
    }
    Mesh coarse = mesh_from(surface);
    remove_empty_triangles(coarse);
    if (!is_by_distance) drop_crumbs(coarse, wanted);
    remove_unused_vertices(coarse);
    MeshFindings ignored;
    orient_triangles(coarse, ignored, faces);
    set_smooth_normals(coarse);
    return coarse;
}

std::vector<CoarserMesh> coarser_meshes(const Mesh& mesh, const Progress& progress) {
    constexpr std::size_t step = 3, fewest = 200;
    std::vector<CoarserMesh> result;
    Surface surface = surface_from(mesh);
    if (turn_edges_of_fans(surface, large_fan) > largest_fan) return result;
    for (std::size_t wanted = surface.number_of_faces() / step; wanted >= fewest; wanted /= step) {
        collapse(surface, EnoughTriangles{wanted, &surface}, wanted, progress);
        surface.collect_garbage();
        // Cuts and small pieces end the collapse early.
        if (surface.number_of_faces() > 2 * wanted) break;
        CoarserMesh& coarser = result.emplace_back();
        coarser.distance = static_cast<float>(distance_from(mesh, surface));
        coarser.mesh = mesh_from(surface);
        remove_empty_triangles(coarser.mesh);
        remove_unused_vertices(coarser.mesh);
    }
    return result;
}

}  // namespace haarfield
