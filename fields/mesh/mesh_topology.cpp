#include "fields/mesh/mesh_topology.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <unordered_map>

namespace haarfield {

namespace {

using Triangle = std::array<std::uint32_t, 3>;
constexpr std::uint32_t none = UINT32_MAX;

struct PositionHash {
    std::size_t operator()(const std::array<std::uint32_t, 3>& bits) const {
        std::uint64_t h = 0;
        for (std::uint32_t b : bits) {
            h = (h ^ b) * 0x9e3779b97f4a7c15u;
            h ^= h >> 29;
        }
        return h;
    }
};

/// A side of a triangle, directed along its edge {low, high}.
struct Side {
    std::uint32_t low, high;
    std::uint32_t triangle;
    bool forwards;  // from low to high

    bool same_edge(const Side& other) const { return low == other.low && high == other.high; }
};

std::vector<Side> sorted_sides(std::span<const Triangle> triangles) {
    std::vector<Side> sides;
    sides.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (int corner = 0; corner < 3; ++corner) {
            const std::uint32_t a = triangles[t][corner], b = triangles[t][(corner + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), t, a < b});
        }
    std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
        return std::tie(x.low, x.high, x.triangle, x.forwards) <
               std::tie(y.low, y.high, y.triangle, y.forwards);
    });
    return sides;
}

/// Calls visit(first, last) with the sides of each edge.
template <class Visit>
void for_each_edge(const std::vector<Side>& sides, const Visit& visit) {
    for (std::size_t first = 0; first < sides.size();) {
        std::size_t last = first + 1;
        while (last < sides.size() && sides[last].same_edge(sides[first])) ++last;
        visit(sides.data() + first, sides.data() + last);
        first = last;
    }
}

/// Returns, by piece, 1 if it has an edge with one triangle only. The result is as long as `pieces`, which
/// may exceed the number of pieces.
std::vector<std::uint8_t> open_pieces(const std::vector<Side>& sides,
                                      const std::vector<std::uint32_t>& pieces) {
    std::vector<std::uint8_t> open(pieces.size());
    for_each_edge(sides, [&](const Side* first, const Side* last) {
        if (last - first == 1) open[pieces[first->triangle]] = 1;
    });
    return open;
}

/// Parts in which triangles can be oriented consistently, and the triangles to reverse so that they agree
/// with the first of their part.
struct Parts {
    std::vector<std::uint32_t> of_triangle;
    std::vector<bool> turned;
    std::uint32_t count = 0;
};

/// The triangle across an edge, and whether it is consistently oriented.
struct Neighbour {
    std::uint32_t triangle = none;
    bool agrees = true;
};

/// Returns each triangle's neighbours across edges that exactly two triangles share.
std::vector<std::array<Neighbour, 3>> neighbours_across_edges(const std::vector<Side>& sides,
                                                              std::size_t triangle_count) {
    std::vector<std::array<Neighbour, 3>> neighbours(triangle_count);
    std::vector<std::uint8_t> filled(triangle_count, 0);
    for_each_edge(sides, [&](const Side* first, const Side* last) {
        if (last - first != 2 || first[0].triangle == first[1].triangle) return;
        const bool agrees = first[0].forwards != first[1].forwards;
        neighbours[first[0].triangle][filled[first[0].triangle]++] = {first[1].triangle, agrees};
        neighbours[first[1].triangle][filled[first[1].triangle]++] = {first[0].triangle, agrees};
    });
    return neighbours;
}

Parts agreeing_parts(const std::vector<Side>& sides, std::size_t triangle_count) {
    const auto neighbours = neighbours_across_edges(sides, triangle_count);
    Parts parts{std::vector<std::uint32_t>(triangle_count, none), std::vector<bool>(triangle_count), 0};
    std::vector<std::uint32_t> open;
    for (std::uint32_t seed = 0; seed < triangle_count; ++seed) {
        if (parts.of_triangle[seed] != none) continue;
        parts.of_triangle[seed] = parts.count;
        open.assign(1, seed);
        while (!open.empty()) {
            const std::uint32_t t = open.back();
            open.pop_back();
            for (const Neighbour& n : neighbours[t])
                if (n.triangle != none && parts.of_triangle[n.triangle] == none) {
                    parts.of_triangle[n.triangle] = parts.count;
                    parts.turned[n.triangle] = parts.turned[t] != !n.agrees;
                    open.push_back(n.triangle);
                }
        }
        ++parts.count;
    }
    return parts;
}

/// Determines which parts are closed: they traverse every edge equally often in both directions. Their volume
/// is then independent of the origin.
std::vector<bool> closed_pieces(const std::vector<Side>& sides, const Parts& parts) {
    std::vector<bool> closed(parts.count, true);
    std::vector<std::pair<std::uint32_t, int>> balance;
    for_each_edge(sides, [&](const Side* first, const Side* last) {
        balance.clear();
        for (const Side* side = first; side != last; ++side)
            balance.emplace_back(parts.of_triangle[side->triangle],
                                 side->forwards != parts.turned[side->triangle] ? 1 : -1);
        std::sort(balance.begin(), balance.end());
        for (std::size_t i = 0; i < balance.size();) {
            const std::uint32_t part = balance[i].first;
            int sum = 0;
            for (; i < balance.size() && balance[i].first == part; ++i) sum += balance[i].second;
            if (sum != 0) closed[part] = false;
        }
    });
    return closed;
}

Vec3d area_vector(const Mesh& mesh, const Triangle& t) {
    const Vec3d p(mesh.positions[t[0]]);
    return (Vec3d(mesh.positions[t[1]]) - p).cross(Vec3d(mesh.positions[t[2]]) - p);
}

/// Sums over the triangles of each part, after inconsistent ones are reversed.
struct PartSums {
    std::vector<double> volume;     ///< Six times the volume. [m^3]
    std::vector<double> area;       ///< Twice the area. [m^2]
    std::vector<double> agreement;  ///< Of normals and triangles: at most three times `area`. [m^2]
    /// Twice the area of unchanged triangles, minus that of reversed ones. [m^2]
    std::vector<double> majority;
    std::vector<double> count;  ///< The number of unchanged triangles, minus that of reversed ones.
};

PartSums part_sums(const Mesh& mesh, const Parts& parts) {
    const std::vector<double> zeros(parts.count, 0.0);
    PartSums sums{zeros, zeros, zeros, zeros, zeros};
    std::vector<std::uint32_t> first(parts.count, none);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::uint32_t part = parts.of_triangle[t];
        if (first[part] == none) first[part] = t;
        const double sign = parts.turned[t] ? -1.0 : 1.0;
        const Triangle& corners = mesh.triangles[t];
        const Vec3d area = area_vector(mesh, corners) * sign;
        // relative to a point of the part, for precision in small pieces far from the origin
        const Vec3d origin(mesh.positions[mesh.triangles[first[part]][0]]);
        sums.volume[part] += area.dot(Vec3d(mesh.positions[corners[0]]) - origin);
        for (std::uint32_t corner : corners) sums.agreement[part] += area.dot(Vec3d(mesh.normals[corner]));
        sums.area[part] += area.length();
        sums.majority[part] += sign * area.length();
        sums.count[part] += sign;
    }
    return sums;
}

/// Closed pieces and the parts that they are made from.
struct ClosedParts {
    std::vector<ClosedPiece> pieces;
    std::vector<std::uint32_t> part_of_piece;
};

ClosedParts closed_pieces_facing_outwards(const Mesh& mesh, const Parts& parts,
                                          const std::vector<bool>& closed, const PartSums& sums) {
    ClosedParts result;
    std::vector<std::uint32_t> piece_of_part(parts.count, none);
    for (std::uint32_t part = 0; part < parts.count; ++part) {
        if (!closed[part] || sums.volume[part] == 0) continue;
        constexpr double clearly = 0.25;  // for comparison: 0.58 for a cube with one normal per corner
        const double outwards = sums.volume[part] > 0 ? 1 : -1;
        const double normals = outwards * sums.agreement[part] / (3 * sums.area[part]),
                     winding = outwards * sums.majority[part] / sums.area[part];
        piece_of_part[part] = static_cast<std::uint32_t>(result.pieces.size());
        result.part_of_piece.push_back(part);
        result.pieces.emplace_back().faces_inwards = (normals != 0 ? normals : winding) < -clearly;
    }
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::uint32_t part = parts.of_triangle[t];
        if (piece_of_part[part] == none) continue;
        ClosedPiece& piece = result.pieces[piece_of_part[part]];
        Triangle corners = mesh.triangles[t];
        if (parts.turned[t] != (sums.volume[part] < 0)) std::swap(corners[1], corners[2]);
        piece.triangles.push_back(corners);
        for (const std::uint32_t corner : corners) piece.bounds.add(mesh.positions[corner]);
    }
    return result;
}

/// Reverses the parts in `turned` that face the wrong way as a whole.
void turn_parts(const Mesh& mesh, const std::vector<bool>& closed, ClosedFaces faces, Parts& parts) {
    const PartSums sums = part_sums(mesh, parts);
    std::vector<bool> wanted_inwards(parts.count, false);
    if (faces == ClosedFaces::inwards) {
        const ClosedParts known = closed_pieces_facing_outwards(mesh, parts, closed, sums);
        const std::vector<std::uint8_t> inwards = inward_pieces(mesh.positions, known.pieces);
        for (std::size_t i = 0; i < inwards.size(); ++i)
            wanted_inwards[known.part_of_piece[i]] = inwards[i] == 1;
    }
    const auto faces_wrongly = [&](std::uint32_t part) {
        if (closed[part] && sums.volume[part] != 0) return (sums.volume[part] < 0) != wanted_inwards[part];
        if (sums.agreement[part] != 0) return sums.agreement[part] < 0;
        return sums.count[part] < 0;
    };
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        if (faces_wrongly(parts.of_triangle[t])) parts.turned[t] = !parts.turned[t];
}

/// Reverses normals that point backwards. Slightly bent normals, as on coarse round shapes, are kept unless
/// their triangle was reversed.
void turn_normals(Mesh& mesh, const std::vector<bool>& turned) {
    constexpr double clearly_backwards = -0.5;
    std::vector<std::uint8_t> wishes(mesh.positions.size(), 0);  // 1: unchanged, 2: reversed, 3: both
    const auto wants_turned = [&](std::uint32_t t, std::uint32_t vertex) {
        const Vec3d area = area_vector(mesh, mesh.triangles[t]);
        return area.dot(Vec3d(mesh.normals[vertex])) < (turned[t] ? 0.0 : clearly_backwards) * area.length();
    };
    std::vector<std::array<bool, 3>> wanted(mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (int corner = 0; corner < 3; ++corner) {
            const std::uint32_t vertex = mesh.triangles[t][corner];
            wanted[t][corner] = wants_turned(t, vertex);
            wishes[vertex] |= wanted[t][corner] ? 2 : 1;
        }
    const std::uint32_t vertex_count = static_cast<std::uint32_t>(mesh.positions.size());
    std::unordered_map<std::uint32_t, std::uint32_t> twin;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (int corner = 0; corner < 3; ++corner) {
            std::uint32_t& vertex = mesh.triangles[t][corner];
            if (!wanted[t][corner] || wishes[vertex] != 3) continue;
            const auto [found, is_new] =
                twin.try_emplace(vertex, static_cast<std::uint32_t>(mesh.positions.size()));
            if (is_new) {
                mesh.copy_vertex(vertex);
                mesh.normals.back() = -mesh.normals.back();
            }
            vertex = found->second;
        }
    for (std::uint32_t vertex = 0; vertex < vertex_count; ++vertex)
        if (wishes[vertex] == 2) mesh.normals[vertex] = -mesh.normals[vertex];
}

std::vector<Triangle> merged_triangles(const Mesh& mesh, const MergedPositions& merged) {
    std::vector<Triangle> triangles = mesh.triangles;
    for (Triangle& t : triangles)
        for (std::uint32_t& corner : t) corner = merged.index[corner];
    return triangles;
}

}  // namespace

MergedPositions merged_positions(std::span<const Vec3f> positions) {
    MergedPositions merged;
    merged.index.reserve(positions.size());
    std::unordered_map<std::array<std::uint32_t, 3>, std::uint32_t, PositionHash> seen;
    seen.reserve(positions.size());
    for (const Vec3f& p : positions) {
        // adding 0 converts -0 to 0
        const std::array<std::uint32_t, 3> bits{std::bit_cast<std::uint32_t>(p.x + 0.0f),
                                                std::bit_cast<std::uint32_t>(p.y + 0.0f),
                                                std::bit_cast<std::uint32_t>(p.z + 0.0f)};
        const auto [found, is_new] =
            seen.try_emplace(bits, static_cast<std::uint32_t>(merged.positions.size()));
        if (is_new) merged.positions.push_back(p);
        merged.index.push_back(found->second);
    }
    return merged;
}

std::vector<std::uint32_t> triangle_pieces(const Mesh& mesh, const MergedPositions& merged) {
    std::vector<std::uint32_t> parent(merged.positions.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&parent](std::uint32_t v) {
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
    };
    for (const Triangle& t : mesh.triangles)
        for (int corner = 1; corner < 3; ++corner) {
            const std::uint32_t a = root(merged.index[t[0]]), b = root(merged.index[t[corner]]);
            parent[std::max(a, b)] = std::min(a, b);
        }
    std::vector<std::uint32_t> pieces;
    pieces.reserve(mesh.triangles.size());
    std::vector<std::uint32_t> piece_of_root(merged.positions.size(), none);
    std::uint32_t count = 0;
    for (const Triangle& t : mesh.triangles) {
        std::uint32_t& piece = piece_of_root[root(merged.index[t[0]])];
        if (piece == none) piece = count++;
        pieces.push_back(piece);
    }
    return pieces;
}

std::vector<std::uint8_t> triangles_of_open_pieces(const Mesh& mesh) {
    const MergedPositions merged = merged_positions(mesh.positions);
    const std::vector<std::uint32_t> pieces = triangle_pieces(mesh, merged);
    const std::vector<std::uint8_t> open = open_pieces(sorted_sides(merged_triangles(mesh, merged)), pieces);
    std::vector<std::uint8_t> of_open_piece;
    of_open_piece.reserve(pieces.size());
    for (const std::uint32_t piece : pieces) of_open_piece.push_back(open[piece]);
    return of_open_piece;
}

std::vector<std::array<std::uint32_t, 3>> edge_neighbours(const Mesh& mesh) {
    const std::vector<Side> sides = sorted_sides(merged_triangles(mesh, merged_positions(mesh.positions)));
    std::vector<std::array<std::uint32_t, 3>> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : neighbours_across_edges(sides, mesh.triangles.size()))
        triangles.push_back({a.triangle, b.triangle, c.triangle});
    return triangles;
}

void leave_out_bad_triangles(Mesh& mesh, MeshFindings& findings) {
    const MergedPositions merged = merged_positions(mesh.positions);
    std::vector<std::pair<Triangle, std::uint32_t>> sorted;
    std::vector<bool> keep(mesh.triangles.size(), true);
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        Triangle t = mesh.triangles[i];
        const Vec3d p(mesh.positions[t[0]]);
        const Vec3d area = (Vec3d(mesh.positions[t[1]]) - p).cross(Vec3d(mesh.positions[t[2]]) - p);
        if (area.length2() == 0) {
            ++findings.degenerate_triangles;
            keep[i] = false;
            continue;
        }
        for (std::uint32_t& corner : t) corner = merged.index[corner];
        std::sort(t.begin(), t.end());
        sorted.emplace_back(t, i);
    }
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 1; i < sorted.size(); ++i)
        if (sorted[i].first == sorted[i - 1].first) {
            ++findings.duplicate_triangles;
            keep[sorted[i].second] = false;
        }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        if (keep[i]) mesh.triangles[kept++] = mesh.triangles[i];
    mesh.triangles.resize(kept);
}

std::vector<ClosedPiece> closed_pieces(const Mesh& mesh) {
    const MergedPositions merged = merged_positions(mesh.positions);
    const std::vector<Side> sides = sorted_sides(merged_triangles(mesh, merged));
    const Parts parts = agreeing_parts(sides, mesh.triangles.size());
    return closed_pieces_facing_outwards(mesh, parts, closed_pieces(sides, parts), part_sums(mesh, parts))
        .pieces;
}

std::vector<PieceKind> triangle_kinds(const Mesh& mesh) {
    const MergedPositions merged = merged_positions(mesh.positions);
    return piece_kinds(merged.positions, merged_triangles(mesh, merged));
}

void orient_triangles(Mesh& mesh, MeshFindings& findings, ClosedFaces faces) {
    const MergedPositions merged = merged_positions(mesh.positions);
    const std::vector<Side> sides = sorted_sides(merged_triangles(mesh, merged));
    const std::vector<std::uint32_t> pieces = triangle_pieces(mesh, merged);

    findings.duplicate_vertices = mesh.positions.size() - merged.positions.size();
    findings.components = pieces.empty() ? 0 : *std::max_element(pieces.begin(), pieces.end()) + 1;
    findings.boundary_edges = findings.non_manifold_edges = 0;
    for_each_edge(sides, [&](const Side* first, const Side* last) {
        findings.boundary_edges += last - first == 1;
        findings.non_manifold_edges += last - first > 2;
    });
    const std::vector<std::uint8_t> open = open_pieces(sides, pieces);
    findings.open_components = std::count(open.begin(), open.end(), 1);

    Parts parts = agreeing_parts(sides, mesh.triangles.size());
    turn_parts(mesh, closed_pieces(sides, parts), faces, parts);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (parts.turned[t]) {
            std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
            ++findings.flipped_triangles;
        }
    turn_normals(mesh, parts.turned);
}

}  // namespace haarfield
