#include "fields/model/mesh_reader.h"

#include "fields/base/exception_message.h"
#include "fields/mesh/mesh_topology.h"
#include "fields/mesh/shared_vertices.h"
#include "fields/model/model_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <span>

namespace haarfield {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// Corners at one position whose triangles have similar normals.
struct FacetGroup {
    Vec3d normal;                      ///< Unit normal of the first corner's triangle.
    std::span<std::uint32_t> corners;  ///< As 3 * triangle + corner.
    Vec3d sum{0, 0, 0};                ///< Weighted sum of their triangles' normals.
};

/// Returns a group for each corner. For fans of very many triangles, groups corners whose normals differ by
/// less than about three degrees, to limit the number of pairs, and reorders the corners.
///
/// unit  normals by triangle.
std::vector<FacetGroup> facet_groups(std::span<std::uint32_t> corners, const std::vector<Vec3d>& unit) {
    constexpr std::size_t many = 256;
    constexpr double cells = 32;  // per unit of length
    const auto cell = [&](std::uint32_t corner) {
        const Vec3d at = unit[corner / 3] * cells;
        return std::array{std::lround(at.x), std::lround(at.y), std::lround(at.z)};
    };
    const bool is_large = corners.size() > many;
    if (is_large)
        std::sort(corners.begin(), corners.end(), [&](std::uint32_t a, std::uint32_t b) {
            return std::pair(cell(a), a) < std::pair(cell(b), b);
        });
    std::vector<FacetGroup> groups;
    for (std::size_t begin = 0, end; begin < corners.size(); begin = end) {
        end = begin + 1;
        while (is_large && end < corners.size() && cell(corners[end]) == cell(corners[begin])) ++end;
        groups.push_back({unit[corners[begin] / 3], corners.subspan(begin, end - begin)});
    }
    return groups;
}

/// Returns one normal per corner of every triangle, [3 * triangle + corner].
///
/// A missing normal is the mean over the faces at its position that meet its own face at less than the crease
/// angle. Faces are weighted by area and by the angle at the corner. Weights by area keep a flat board with a
/// rounded edge flat. Weights by angle make the result independent of the choice of diagonals.
std::vector<Vec3f> corner_normals(const Mesh& mesh, float crease_angle) {
    const std::size_t corner_count = 3 * mesh.triangles.size();
    std::vector<Vec3f> normals(corner_count);
    bool complete = true;
    for (std::size_t c = 0; c < corner_count; ++c) {
        normals[c] = mesh.normals[mesh.triangles[c / 3][c % 3]];
        complete = complete && normals[c].length2() > 0;
    }
    if (complete) return normals;

    std::vector<Vec3d> area(mesh.triangles.size()), unit(mesh.triangles.size());
    std::vector<double> weight(corner_count);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        std::array<Vec3d, 3> p;
        for (int k = 0; k < 3; ++k) p[k] = Vec3d(mesh.positions[mesh.triangles[t][k]]);
        area[t] = (p[1] - p[0]).cross(p[2] - p[0]);
        unit[t] = area[t] / area[t].length();
        for (int k = 0; k < 3; ++k) {
            const Vec3d a = p[(k + 1) % 3] - p[k], b = p[(k + 2) % 3] - p[k];
            weight[3 * t + k] = std::atan2(a.cross(b).length(), a.dot(b));
        }
    }
    const MergedPositions merged = merged_positions(mesh.positions);
    std::vector<std::uint32_t> first(merged.positions.size() + 1, 0), around(corner_count);
    const auto place = [&](std::size_t c) { return merged.index[mesh.triangles[c / 3][c % 3]]; };
    for (std::size_t c = 0; c < corner_count; ++c) ++first[place(c) + 1];
    for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::size_t c = 0; c < corner_count; ++c) around[next[place(c)]++] = static_cast<std::uint32_t>(c);

    const double smooth = std::cos(static_cast<double>(crease_angle));
    const auto missing = [&](std::uint32_t corner) { return normals[corner].length2() == 0; };
    const auto set_normal = [&](std::uint32_t corner, const Vec3d& sum) {
        normals[corner] = Vec3f(sum.length2() > 0 ? sum.normalized() : unit[corner / 3]);
    };
    for (std::size_t p = 0; p + 1 < first.size(); ++p) {
        const std::span<std::uint32_t> corners(around.data() + first[p], first[p + 1] - first[p]);
        if (std::none_of(corners.begin(), corners.end(), missing)) continue;
        std::vector<FacetGroup> groups = facet_groups(corners, unit);
        for (FacetGroup& group : groups)
            for (const std::uint32_t c : group.corners) group.sum += area[c / 3] * weight[c];
        for (const FacetGroup& group : groups) {
            Vec3d sum(0, 0, 0);
            for (const FacetGroup& other : groups)
                if (&other == &group || other.normal.dot(group.normal) > smooth) sum += other.sum;
            for (const std::uint32_t c : group.corners)
                if (missing(c)) set_normal(c, sum);
        }
    }
    return normals;
}

/// Removes materials that no triangle uses. Sorts the others by their first use.
void leave_out_unused_materials(FaceGatherer& gatherer) {
    Mesh& mesh = gatherer.mesh;
    constexpr std::uint16_t none = UINT16_MAX;
    std::vector<std::uint16_t> number(mesh.material_names.size(), none);
    std::vector<std::uint16_t> used;
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t corner : triangle) {
            const std::uint16_t material = mesh.vertex_materials[corner];
            if (number[material] != none) continue;
            number[material] = static_cast<std::uint16_t>(used.size());
            used.push_back(material);
        }
    for (std::uint16_t& material : mesh.vertex_materials)
        material = number[material] == none ? std::uint16_t(0) : number[material];  // used by no triangle
    std::vector<std::string> names;
    std::vector<MeshMaterial> descriptions;
    std::vector<bool> mapped, coloured;
    for (const std::uint16_t material : used) {
        names.push_back(std::move(mesh.material_names[material]));
        descriptions.push_back(std::move(gatherer.descriptions[material]));
        mapped.push_back(gatherer.mapped[material]);
        coloured.push_back(gatherer.coloured[material]);
    }
    mesh.material_names = std::move(names);
    gatherer.descriptions = std::move(descriptions);
    gatherer.mapped = std::move(mapped);
    gatherer.coloured = std::move(coloured);
}

/// Below this extent, computations on a mesh lose too many digits in single precision. [m]
constexpr float smallest_extent = 1e-6f;

/// Returns the extent of the vertices in use along the longest axis. [m]
float extent(const Mesh& mesh) {
    Bounds bounds;
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t corner : triangle) bounds.add(mesh.positions[corner]);
    const Vec3f size = bounds.upper - bounds.lower;
    return std::max({size.x, size.y, size.z});
}

}  // namespace

Result<ImportedMesh> read_mesh(const std::filesystem::path& file, const MeshReaderOptions& options) {
    HF_TRY(const ModelFile model, ModelFile::open(file));
    return read_mesh(model, {}, options);
}

Result<ImportedMesh> read_mesh(const ModelFile& model, std::optional<std::size_t> part,
                               const MeshReaderOptions& options) {
    HF_TRY(FaceGatherer gathered, model.faces(part));
    const std::string where = model.file().string();
    try {
        leave_out_bad_triangles(gathered.mesh, gathered.findings);
        leave_out_unused_materials(gathered);
        ImportedMesh imported{std::move(gathered.mesh),         gathered.findings,
                              std::move(gathered.descriptions), std::move(gathered.mapped),
                              std::move(gathered.coloured),     std::move(gathered.unused)};
        if (imported.mesh.triangles.empty()) {
            const std::string found = imported.findings.summary();
            return Error{where, (part ? fmt::format("its part \"{}\" ", model.parts().names[*part]) : "") +
                                    "has no triangle with an area" +
                                    (found.empty() ? "" : " (" + found + ")")};
        }
        if (const float size = extent(imported.mesh); !(size >= smallest_extent))
            return Error{where, fmt::format("is {:.2g} m large; expected at least {} m: is it in metres?",
                                            size, smallest_extent)};
        orient_triangles(imported.mesh, imported.findings, options.faces);
        const std::vector<bool> none(imported.mesh.material_names.size(), false);
        imported.mesh =
            with_shared_vertices(imported.mesh, corner_normals(imported.mesh, options.crease_angle),
                                 {options.appearance ? imported.mapped : none,
                                  options.appearance ? imported.coloured : none, options.originals});
        imported.findings.duplicate_vertices =
            imported.mesh.positions.size() - merged_positions(imported.mesh.positions).positions.size();
        return imported;
    } catch (const std::exception& error) {  // out of memory
        return Error{where, "not a mesh that can be read: " + exception_message(error)};
    }
}

}  // namespace haarfield
