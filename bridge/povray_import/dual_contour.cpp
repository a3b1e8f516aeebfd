#include "bridge/povray_import/dual_contour.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

namespace haarfield {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

/// Eigenvalues and eigenvectors of a symmetric matrix, by Jacobi's rotations.
struct Eigen {
    std::array<double, 3> values;
    std::array<Vec3d, 3> vectors;
};

Eigen eigen_of(Matrix m) {
    Eigen eigen{{}, {Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)}};
    for (int sweep = 0; sweep < 12; ++sweep)
        for (const auto& [p, q] : {std::pair<std::size_t, std::size_t>(0, 1), {0, 2}, {1, 2}}) {
            if (std::abs(m[p][q]) < 1e-14) continue;
            const double angle = 0.5 * std::atan2(2 * m[p][q], m[q][q] - m[p][p]), c = std::cos(angle),
                         s = std::sin(angle);
            for (std::size_t k = 0; k < 3; ++k) {
                const double a = m[k][p], b = m[k][q];
                m[k][p] = c * a - s * b;
                m[k][q] = s * a + c * b;
            }
            for (std::size_t k = 0; k < 3; ++k) {
                const double a = m[p][k], b = m[q][k];
                m[p][k] = c * a - s * b;
                m[q][k] = s * a + c * b;
            }
            const Vec3d a = eigen.vectors[p], b = eigen.vectors[q];
            eigen.vectors[p] = a * c - b * s;
            eigen.vectors[q] = a * s + b * c;
        }
    eigen.values = {m[0][0], m[1][1], m[2][2]};
    return eigen;
}

/// A crossing on an edge of the grid.
struct EdgeCrossing {
    Vec3d point, normal;
    bool has_normal = true;
};

/// Returns the point x between two corners at which x (matrix x / 2 - right) is least, by coordinate descent.
///
/// stiffness  is added to the diagonal of the matrix.
Vec3d bounded_minimum(const Matrix& matrix, const Vec3d& right, double stiffness, const Vec3d& lower,
                      const Vec3d& upper) {
    constexpr int steps = 40;
    Vec3d x(0, 0, 0);
    for (int step = 0; step < steps; ++step)
        for (std::size_t r = 0; r < 3; ++r) {
            double slope = right[int(r)];
            for (std::size_t c = 0; c < 3; ++c)
                if (c != r) slope -= matrix[r][c] * x[int(c)];
            x[int(r)] = std::clamp(slope / (matrix[r][r] + stiffness), lower[int(r)], upper[int(r)]);
        }
    return x;
}

/// Returns the point in or near the cell that minimises the distances to the planes of the crossings, from
/// their mean.
Vec3d common_point(const std::vector<EdgeCrossing>& crossings, const Vec3d& cell) {
    constexpr double smallest = 0.05;                     // Of the largest eigenvalue.
    constexpr double margin = 0.1, widest_margin = 0.25;  // How far the point may leave the cell.
    Vec3d mean(0, 0, 0);
    for (const EdgeCrossing& crossing : crossings) mean += crossing.point;
    mean /= static_cast<double>(crossings.size());
    Matrix matrix{};
    Vec3d right(0, 0, 0);
    for (const EdgeCrossing& crossing : crossings) {
        if (!crossing.has_normal) continue;
        const Vec3d& n = crossing.normal;
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t c = 0; c < 3; ++c) matrix[r][c] += n[int(r)] * n[int(c)];
        right += n * n.dot(crossing.point - mean);
    }
    const Eigen eigen = eigen_of(matrix);
    const double largest = std::max({eigen.values[0], eigen.values[1], eigen.values[2]});
    Vec3d point = mean;
    for (std::size_t k = 0; k < 3; ++k)
        if (eigen.values[k] > smallest * largest && eigen.values[k] > 0)
            point += eigen.vectors[k] * (eigen.vectors[k].dot(right) / eigen.values[k]);
    const auto is_near = [&](int axis) {
        return point[axis] > cell[axis] - margin && point[axis] < cell[axis] + 1 + margin;
    };
    if (is_near(0) && is_near(1) && is_near(2)) return point;
    // A sharp edge that passes outside: the nearest point to its planes that the cell allows.
    if (!(largest > 0)) return mean;
    constexpr double stiffness = 1e-3;
    return mean + bounded_minimum(matrix, right, stiffness * largest, cell - Vec3d(widest_margin) - mean,
                                  cell + Vec3d(1 + widest_margin) - mean);
}

/// The edges of a cell: those along axis a have the numbers 4 a to 4 a + 3, by their offsets along the next
/// two axes.
struct CellEdge {
    int axis;
    std::array<int, 3> offset;
};
CellEdge cell_edge(int number) {
    const int axis = number / 4;
    CellEdge edge{axis, {0, 0, 0}};
    edge.offset[std::size_t((axis + 1) % 3)] = number & 1;
    edge.offset[std::size_t((axis + 2) % 3)] = number >> 1 & 1;
    return edge;
}

/// Extracts one kind of surface: boundaries of solids, or sheets.
class Contour {
public:
    Contour(const CrossedGrid& grid, ContouredMesh& mesh) : grid_(grid), mesh_(mesh) {}

    void add_solids() {
        set_signs();
        collect(/*sheets=*/false);
        add_quads(/*sheets=*/false);
    }

    void add_sheets() {
        const std::size_t before = mesh_.triangles.size();
        collect(/*sheets=*/true);
        add_quads(/*sheets=*/true);
        mesh_.sheet_triangles = mesh_.triangles.size() - before;
    }

private:
    using Place = std::array<int, 3>;

    std::size_t points(int axis) const {
        return static_cast<std::size_t>(grid_.cells[std::size_t(axis)] + 1);
    }
    std::size_t point_index(const Place& p) const {
        return (static_cast<std::size_t>(p[0]) * points(1) + static_cast<std::size_t>(p[1])) * points(2) +
               static_cast<std::size_t>(p[2]);
    }
    const std::vector<LineCrossing>& line(int axis, const Place& p) const {
        const int next = (axis + 1) % 3, last = (axis + 2) % 3;
        return grid_.lines[std::size_t(axis)][static_cast<std::size_t>(p[std::size_t(next)]) * points(last) +
                                              static_cast<std::size_t>(p[std::size_t(last)])];
    }

    /// Decides by majority which points are inside.
    void set_signs() {
        votes_.assign(points(0) * points(1) * points(2), 0);
        for (int axis = 0; axis < 3; ++axis) {
            const int next = (axis + 1) % 3, last = (axis + 2) % 3;
            for (int i = 0; i <= grid_.cells[std::size_t(next)]; ++i)
                for (int j = 0; j <= grid_.cells[std::size_t(last)]; ++j) {
                    Place p{};
                    p[std::size_t(next)] = i;
                    p[std::size_t(last)] = j;
                    vote(axis, p);
                }
        }
    }

    void vote(int axis, Place p) {
        const std::vector<LineCrossing>& crossings = line(axis, p);
        const auto is_solid = [](const LineCrossing& crossing) { return crossing.is_solid(); };
        auto next = std::ranges::find_if(crossings, is_solid);
        bool inside = next != crossings.end() && next->inside_before;
        const auto& inside_lines = grid_.inside_lines[std::size_t(axis)];
        if (next == crossings.end() && !inside_lines.empty())
            inside =
                inside_lines[static_cast<std::size_t>(&crossings - grid_.lines[std::size_t(axis)].data())];
        for (int k = 0; k <= grid_.cells[std::size_t(axis)]; ++k) {
            while (next != crossings.end() && next->place <= k) {
                inside = next->inside_after;
                next = std::find_if(next + 1, crossings.end(), is_solid);
            }
            p[std::size_t(axis)] = k;
            votes_[point_index(p)] = static_cast<std::uint8_t>(votes_[point_index(p)] + inside);
        }
    }

    bool inside(const Place& p) const { return votes_[point_index(p)] >= 2; }

    std::uint64_t edge_key(int axis, const Place& p) const {
        return point_index(p) * 3 + std::uint64_t(axis);
    }

    /// Finds the crossings on all edges.
    void collect(bool sheets) {
        crossings_.clear();
        cells_.clear();
        edges_.clear();
        for (int axis = 0; axis < 3; ++axis) {
            const int next = (axis + 1) % 3, last = (axis + 2) % 3;
            for (int i = 0; i <= grid_.cells[std::size_t(next)]; ++i)
                for (int j = 0; j <= grid_.cells[std::size_t(last)]; ++j) {
                    Place p{};
                    p[std::size_t(next)] = i;
                    p[std::size_t(last)] = j;
                    collect_line(axis, p, sheets);
                }
        }
    }

    void collect_line(int axis, Place p, bool sheets) {
        const std::vector<LineCrossing>& crossings = line(axis, p);
        if (crossings.empty() && sheets) return;
        auto first = crossings.begin();
        for (int k = 0; k < grid_.cells[std::size_t(axis)]; ++k) {
            p[std::size_t(axis)] = k;
            while (first != crossings.end() && first->place < k) ++first;
            auto end = first;
            const LineCrossing* found = nullptr;
            std::size_t count = 0;
            Place q = p;
            ++q[std::size_t(axis)];
            const bool before = !sheets && inside(p), after = !sheets && inside(q);
            for (; end != crossings.end() && end->place < k + 1; ++end) {
                if (sheets ? end->is_solid() || end->inside_before : !end->is_solid()) continue;
                ++count;
                if (!found || (!sheets && found->inside_after != after)) found = &*end;
            }
            mesh_.double_edges += count > 1;
            mesh_.lost_edges += !sheets && count % 2 == 1 && before == after;
            if (sheets ? !found : before == after) continue;
            EdgeCrossing crossing;
            crossing.point = {double(p[0]), double(p[1]), double(p[2])};
            crossing.has_normal = found != nullptr;
            crossing.point[axis] = found ? found->place : k + 0.5;
            if (found) {
                crossing.normal = Vec3d(found->normal);
                // Outwards.
                if (!sheets && (crossing.normal[axis] > 0) == after) crossing.normal = -crossing.normal;
            } else {
                crossing.normal = Vec3d(0, 0, 0);
                crossing.normal[axis] = after ? -1 : 1;
                ++mesh_.missed_edges;
            }
            edges_.push_back({axis, p, after});
            crossings_[edge_key(axis, p)] = crossing;
        }
    }

    /// The vertices of a cell: a vertex for each group of connected edges.
    struct Cell {
        std::array<std::int32_t, 12> group_of_edge;  ///< -1: not crossed.
        std::vector<Vec3d> points;
        std::vector<std::vector<EdgeCrossing>> crossings;
    };

    static void join(std::array<int, 12>& parent, int a, int b) {
        while (parent[std::size_t(a)] != a) a = parent[std::size_t(a)];
        while (parent[std::size_t(b)] != b) b = parent[std::size_t(b)];
        parent[std::size_t(std::max(a, b))] = std::min(a, b);
    }

    Cell new_cell(const Place& cell, bool sheets) const {
        std::array<const EdgeCrossing*, 12> crossed{};
        for (int e = 0; e < 12; ++e) {
            const CellEdge edge = cell_edge(e);
            Place p = cell;
            for (std::size_t a = 0; a < 3; ++a) p[a] += edge.offset[a];
            const auto found = crossings_.find(edge_key(edge.axis, p));
            if (found != crossings_.end()) crossed[std::size_t(e)] = &found->second;
        }
        std::array<int, 12> parent{};
        for (int e = 0; e < 12; ++e) parent[std::size_t(e)] = e;
        for (int axis = 0; axis < 3; ++axis)
            for (int side = 0; side < 2; ++side) join_on_face(cell, axis, side, sheets, crossed, parent);
        Cell result;
        result.group_of_edge.fill(-1);
        std::array<std::int32_t, 12> group_of_root{};
        group_of_root.fill(-1);
        for (int e = 0; e < 12; ++e) {
            if (!crossed[std::size_t(e)]) continue;
            int root = e;
            while (parent[std::size_t(root)] != root) root = parent[std::size_t(root)];
            std::int32_t& group = group_of_root[std::size_t(root)];
            if (group < 0) {
                group = static_cast<std::int32_t>(result.crossings.size());
                result.crossings.emplace_back();
            }
            result.group_of_edge[std::size_t(e)] = group;
            result.crossings[std::size_t(group)].push_back(*crossed[std::size_t(e)]);
        }
        const Vec3d corner(cell[0], cell[1], cell[2]);
        for (const auto& crossings : result.crossings)
            result.points.push_back(common_point(crossings, corner));
        return result;
    }

    /// Connects the crossed edges of one face of a cell. Where four edges are crossed, separates the two
    /// corners that are inside.
    void join_on_face(const Place& cell, int axis, int side, bool sheets,
                      const std::array<const EdgeCrossing*, 12>& crossed, std::array<int, 12>& parent) const {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        // Edges along u at v = 0 and 1, then edges along v at u = 0 and 1. An edge along a has its offsets
        // along a + 1 in bit 0 and along a + 2 in bit 1.
        const auto along_u = [&](int at_v) { return 4 * u + at_v + 2 * side; };
        const auto along_v = [&](int at_u) { return 4 * v + side + 2 * at_u; };
        const std::array<int, 4> edges{along_u(0), along_v(1), along_u(1), along_v(0)};
        std::vector<int> found;
        for (const int e : edges)
            if (crossed[std::size_t(e)]) found.push_back(e);
        if (found.size() < 4 || sheets) {
            for (std::size_t i = 1; i < found.size(); ++i) join(parent, found[0], found[i]);
            return;
        }
        Place corner = cell;
        corner[std::size_t(axis)] += side;
        // The corner between along_u(0) and along_v(0).
        if (inside(corner)) {
            join(parent, edges[0], edges[3]);
            join(parent, edges[1], edges[2]);
        } else {
            join(parent, edges[0], edges[1]);
            join(parent, edges[2], edges[3]);
        }
    }

    const Cell& cell_at(const Place& place, bool sheets) {
        const std::uint64_t key = point_index(place);
        const auto found = cells_.find(key);
        return found != cells_.end() ? found->second
                                     : cells_.emplace(key, new_cell(place, sheets)).first->second;
    }

    void add_quads(bool sheets) {
        vertex_of_.clear();
        for (const Edge& edge : edges_) {
            const int u = (edge.axis + 1) % 3, v = (edge.axis + 2) % 3;
            const Place& p = edge.place;
            if (p[std::size_t(u)] == 0 || p[std::size_t(v)] == 0 ||
                p[std::size_t(u)] == grid_.cells[std::size_t(u)] ||
                p[std::size_t(v)] == grid_.cells[std::size_t(v)])
                continue;
            const EdgeCrossing& crossing = crossings_.at(edge_key(edge.axis, p));
            std::array<std::uint32_t, 4> corners{};
            constexpr std::array<std::array<int, 2>, 4> around{{{1, 1}, {0, 1}, {0, 0}, {1, 0}}};
            for (std::size_t c = 0; c < 4; ++c) {
                Place place = p;
                place[std::size_t(u)] -= around[c][0];
                place[std::size_t(v)] -= around[c][1];
                const Cell& cell = cell_at(place, sheets);
                const int number = 4 * edge.axis + around[c][0] + 2 * around[c][1];
                const std::int32_t group = cell.group_of_edge[std::size_t(number)];
                corners[c] = vertex(point_index(place), std::size_t(group), cell, crossing, sheets);
            }
            // Counter-clockwise around +axis: the front faces +axis, where the outside is if the end is
            // outside.
            const bool is_turned = sheets ? crossing.normal[edge.axis] < 0 : edge.after;
            if (is_turned) std::swap(corners[1], corners[3]);
            add_quad(corners, crossing.normal);
        }
    }

    /// Returns the vertex of a group with the mean of those normals that are close to the crossing's.
    std::uint32_t vertex(std::uint64_t cell_key, std::size_t group, const Cell& cell,
                         const EdgeCrossing& crossing, bool sheets) {
        constexpr double smooth = 0.8;  // Cosine of the angle between normals of one smooth surface.
        Vec3d sum(0, 0, 0);
        std::uint32_t used = 0, bit = 1;
        for (const EdgeCrossing& other : cell.crossings[group]) {
            Vec3d normal = other.normal;
            if (sheets && normal.dot(crossing.normal) < 0) normal = -normal;
            if (other.has_normal && normal.dot(crossing.normal) > smooth) {
                sum += normal;
                used |= bit;
            }
            bit <<= 1;
        }
        if (used == 0) sum = crossing.normal;
        const Vec3d normal = sum.normalized();
        if (sheets && crossing.normal[crossing.normal.x != 0 ? 0 : crossing.normal.y != 0 ? 1 : 2] < 0)
            used |= 1u << 31;
        const std::array<std::uint64_t, 3> key{cell_key, group, used};
        const auto [found, is_new] =
            vertex_of_.emplace(key, static_cast<std::uint32_t>(mesh_.positions.size()));
        if (is_new) {
            mesh_.positions.emplace_back(cell.points[group]);
            mesh_.normals.emplace_back(normal);
        }
        return found->second;
    }

    /// Adds a quad as two triangles, along the diagonal whose triangles agree better with the normal.
    void add_quad(const std::array<std::uint32_t, 4>& c, const Vec3d& normal) {
        const auto agreement = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
            const Vec3d a(mesh_.positions[i]);
            const Vec3d across = (Vec3d(mesh_.positions[j]) - a).cross(Vec3d(mesh_.positions[k]) - a);
            const double length = across.length();
            return length > 1e-9 ? across.dot(normal) / length : 0;
        };
        const double first = std::min(agreement(c[0], c[1], c[2]), agreement(c[0], c[2], c[3])),
                     second = std::min(agreement(c[1], c[2], c[3]), agreement(c[1], c[3], c[0]));
        if (first >= second) {
            add_triangle(c[0], c[1], c[2]);
            add_triangle(c[0], c[2], c[3]);
        } else {
            add_triangle(c[1], c[2], c[3]);
            add_triangle(c[1], c[3], c[0]);
        }
    }

    void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (a != b && b != c && c != a) mesh_.triangles.push_back({a, b, c});
    }

    struct Edge {
        int axis;
        Place place;
        bool after;  ///< Its end is inside.
    };

    const CrossedGrid& grid_;
    ContouredMesh& mesh_;
    std::vector<std::uint8_t> votes_;
    std::vector<Edge> edges_;
    std::unordered_map<std::uint64_t, EdgeCrossing> crossings_;
    std::unordered_map<std::uint64_t, Cell> cells_;
    std::map<std::array<std::uint64_t, 3>, std::uint32_t> vertex_of_;
};

}  // namespace

ContouredMesh dual_contour(const CrossedGrid& grid) {
    ContouredMesh mesh;
    Contour contour(grid, mesh);
    contour.add_solids();
    contour.add_sheets();
    return mesh;
}

}  // namespace haarfield
