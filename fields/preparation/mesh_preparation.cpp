#include "fields/preparation/mesh_preparation.h"

#include "fields/mesh/mesh_subdivision.h"
#include "fields/mesh/mesh_topology.h"
#include "fields/preparation/crossed_vertices.h"
#include "fields/preparation/cut_outs.h"
#include "fields/preparation/mesh_simplification.h"
#include "fields/preparation/sheet_backs.h"
#include "fields/preparation/thin_sheets.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <optional>

namespace haarfield {

namespace {

/// Returns a coarser cut of the triangles that images cut, and a simplification of all others. Throws
/// Interrupted.
Mesh coarse_and_cut(const Mesh& mesh, const std::vector<std::uint8_t>& is_cut_out,
                    const MeshPreparation& wanted, const Progress& progress) {
    Mesh cut = mesh, rest = mesh;
    cut.triangles.clear();
    rest.triangles.clear();
    for (std::size_t t = 0; t < is_cut_out.size(); ++t)
        (is_cut_out[t] ? cut : rest).triangles.push_back(mesh.triangles[t]);
    const std::uint32_t share =
        rest.triangles.empty() ? wanted.coarse_triangles : wanted.coarse_triangles / 2;
    Mesh coarse = without_cut_outs(cut, wanted.opacity, share);
    if (rest.triangles.size() > share) {
        rest = simplified(rest, share, wanted.faces, progress);
    } else {
        rest.uvs.clear();
        rest.colours.clear();
        rest.original_vertices.clear();
    }
    append_mesh(coarse, rest);
    return coarse;
}

/// Tests whether two triangles of one piece intersect that share no position. Different pieces may cross each
/// other, as in furniture.
bool intersects_itself(const Mesh& mesh, const Progress& progress) {
    using Exact = CGAL::Exact_predicates_inexact_constructions_kernel;
    using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;
    struct Found {};
    const MergedPositions merged = merged_positions(mesh.positions);
    const std::vector<std::uint32_t> pieces = triangle_pieces(mesh, merged);
    const auto exact = [&](std::uint32_t t) {
        std::array<Exact::Point_3, 3> p;
        for (int k = 0; k < 3; ++k) {
            const Vec3f& q = mesh.positions[mesh.triangles[t][k]];
            p[k] = Exact::Point_3(q.x, q.y, q.z);
        }
        return Exact::Triangle_3(p[0], p[1], p[2]);
    };
    const auto have_one_position = [&](std::uint32_t s, std::uint32_t t) {
        for (std::uint32_t a : mesh.triangles[s])
            for (std::uint32_t b : mesh.triangles[t])
                if (merged.index[a] == merged.index[b]) return true;
        return false;
    };
    std::vector<Box> boxes;
    boxes.reserve(mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) boxes.emplace_back(exact(t).bbox(), t);
    try {
        CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
            if (pieces[a.info()] != pieces[b.info()] || have_one_position(a.info(), b.info())) return;
            if (progress.stop.stop_requested()) throw Found{};
            if (CGAL::do_intersect(exact(a.info()), exact(b.info()))) throw Found{};
        });
    } catch (const Found&) {
        return true;
    }
    return false;
}

}  // namespace

const Mesh& blocking_surface(const PreparedMesh& prepared) {
    return prepared.opaque ? *prepared.opaque : prepared.original;
}

Mesh visible_surface(const PreparedMesh& prepared) {
    Mesh surface = prepared.original;
    append_mesh(surface, prepared.backs);
    return surface;
}

Result<PreparedMesh> prepare_mesh(ImportedMesh imported, const MeshPreparation& wanted,
                                  const Progress& progress) {
    constexpr std::size_t most_triangles_for_self_intersection = 200000, most_cut_triangles = 100000;
    const Error stopped = interruption();
    if (imported.mesh.triangles.empty()) return Error{"", "the mesh has no triangles"};

    PreparedMesh prepared;
    prepared.findings = imported.findings;
    prepared.original = std::move(imported.mesh);
    orient_triangles(prepared.original, prepared.findings, wanted.faces);
    if (prepared.original.triangles.size() <= most_triangles_for_self_intersection)
        prepared.findings.self_intersecting = intersects_itself(prepared.original, progress);
    if (progress.stop.stop_requested()) return stopped;

    try {
        const std::vector<std::uint8_t> is_cut_out = cut_out_triangles(prepared.original, wanted.opacity);
        if (std::ranges::find(is_cut_out, 1) != is_cut_out.end()) {
            prepared.opaque = without_cut_outs(prepared.original, wanted.opacity, most_cut_triangles);
            if (progress.stop.stop_requested()) return stopped;
        }
        // Cut meshes have no surface to measure a distance to.
        MeshPreparation cut = wanted;
        if (cut.coarse_triangles == chosen_by_distance) cut.coarse_triangles = fewest_coarse;
        if (wanted.coarse_triangles == 0 ||
            blocking_surface(prepared).triangles.size() <= cut.coarse_triangles)
            prepared.coarse = blocking_surface(prepared);
        else if (prepared.opaque)
            prepared.coarse = coarse_and_cut(prepared.original, is_cut_out, cut, progress);
        else
            prepared.coarse = simplified(prepared.original, wanted.coarse_triangles, wanted.faces, progress);
    } catch (const Interrupted&) {
        return stopped;
    }

    if (prepared.findings.open_components > 0 || wanted.faces == ClosedFaces::inwards)
        prepared.backs = seen_backs(prepared.original, blocking_surface(prepared));
    prepared.findings.backs = prepared.backs.triangles.size();
    prepared.fine = subdivided(visible_surface(prepared), wanted.fine_vertices, progress);
    if (progress.stop.stop_requested()) return stopped;
    if (wanted.split_crossed && prepared.findings.open_components > 0)
        split_crossed_vertices(prepared.fine, prepared.original);
    prepared.findings.parted_vertices = part_thin_sheets(prepared.fine, prepared.original);
    return prepared;
}

}  // namespace haarfield
