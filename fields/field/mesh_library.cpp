#include "fields/field/mesh_library.h"

#include <fmt/format.h>

#include <algorithm>

#include "fields/base/byte_stream.h"
#include "fields/field/library_files.h"
#include "fields/file/section_file.h"
#include "fields/file/write_file.h"
#include "fields/preparation/mesh_simplification.h"

namespace haarfield {
namespace {

using std::filesystem::path;

/// Raised whenever the same mesh and settings would give another prepared mesh, or another file of it.
constexpr std::uint32_t preparation_version = 3;

constexpr const char *entity_section = "entity", *mesh_section = "mesh";

void write_findings(const MeshFindings& findings, ByteSink& sink) {
    for (const std::uint64_t count :
         {findings.polygons, findings.non_finite_vertices, findings.duplicate_vertices,
          findings.degenerate_triangles, findings.duplicate_triangles, findings.non_manifold_edges,
          findings.boundary_edges, findings.flipped_triangles, findings.components, findings.open_components,
          findings.parted_vertices, findings.backs})
        sink.value(count);
    sink.value(std::uint8_t(findings.self_intersecting));
}

MeshFindings findings_from(ByteSource& source) {
    MeshFindings findings;
    for (std::uint64_t* count :
         {&findings.polygons, &findings.non_finite_vertices, &findings.duplicate_vertices,
          &findings.degenerate_triangles, &findings.duplicate_triangles, &findings.non_manifold_edges,
          &findings.boundary_edges, &findings.flipped_triangles, &findings.components,
          &findings.open_components, &findings.parted_vertices, &findings.backs})
        *count = source.value<std::uint64_t>();
    findings.self_intersecting = source.value<std::uint8_t>() != 0;
    return findings;
}

void write_mesh(const Mesh& mesh, ByteSink& sink) {
    sink.values(mesh.positions);
    sink.values(mesh.normals);
    sink.values(mesh.triangles);
    sink.values(mesh.vertex_materials);
    sink.value(std::uint64_t(mesh.material_names.size()));
    for (const std::string& name : mesh.material_names) sink.text(name);
    sink.values(mesh.uvs);
    sink.values(mesh.colours);
    sink.values(mesh.original_vertices);
}

Mesh mesh_from(ByteSource& source) {
    Mesh mesh;
    mesh.positions = source.values<Vec3f>();
    mesh.normals = source.values<Vec3f>();
    mesh.triangles = source.values<std::array<std::uint32_t, 3>>();
    mesh.vertex_materials = source.values<std::uint16_t>();
    for (auto count = source.count(sizeof(std::uint64_t)); count > 0; --count)
        mesh.material_names.push_back(source.text());
    mesh.uvs = source.values<Vec2f>();
    mesh.colours = source.values<Rgb>();
    mesh.original_vertices = source.values<std::int32_t>();
    return mesh;
}

/// The attributes that a mesh must have.
enum class Attributes {
    positions,  ///< Only those of shadow casters.
    all,        ///< Normals and materials, too.
};

/// Tests the sizes of arrays and all indices.
bool is_consistent(const Mesh& mesh, Attributes wanted) {
    const std::size_t count = mesh.positions.size();
    const auto is_optional = [count](const auto& values) { return values.empty() || values.size() == count; };
    const auto is_finite = [](const Vec3f& p) {
        return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
    };
    const auto is_there = [count](const std::array<std::uint32_t, 3>& triangle) {
        return std::ranges::all_of(triangle, [count](std::uint32_t v) { return v < count; });
    };
    return (wanted == Attributes::positions ||
            (mesh.normals.size() == count && mesh.vertex_materials.size() == count)) &&
           is_optional(mesh.normals) && is_optional(mesh.vertex_materials) && is_optional(mesh.uvs) &&
           is_optional(mesh.colours) && is_optional(mesh.original_vertices) &&
           std::ranges::all_of(mesh.positions, is_finite) && std::ranges::all_of(mesh.triangles, is_there) &&
           std::ranges::all_of(mesh.vertex_materials,
                               [&](std::uint16_t m) { return m < mesh.material_names.size(); });
}

bool is_consistent(const LibraryMesh& found) {
    const PreparedMesh& mesh = found.mesh;
    const LocalSamples& samples = *found.occlusion.samples;
    return !mesh.original.triangles.empty() && is_consistent(mesh.original, Attributes::all) &&
           (!mesh.opaque || is_consistent(*mesh.opaque, Attributes::positions)) &&
           is_consistent(mesh.backs, Attributes::all) && is_consistent(mesh.fine, Attributes::all) &&
           is_consistent(mesh.coarse, Attributes::positions) &&
           samples.points.size() == mesh.fine.positions.size() &&
           samples.buried.size() == mesh.fine.positions.size() &&
           std::ranges::all_of(*found.occlusion.coarser, [](const CoarserMesh& coarser) {
               return is_consistent(coarser.mesh, Attributes::positions);
           });
}

std::string mesh_bytes(const PreparedMesh& mesh, const EntityOcclusion& occlusion,
                       const std::vector<CoarserMesh>& coarser) {
    return written_bytes([&](ByteSink& sink) {
        write_mesh(mesh.original, sink);
        sink.value(std::uint8_t(mesh.opaque.has_value()));
        if (mesh.opaque) write_mesh(*mesh.opaque, sink);
        write_mesh(mesh.backs, sink);
        write_mesh(mesh.fine, sink);
        write_mesh(mesh.coarse, sink);
        write_findings(mesh.findings, sink);
        sink.values(occlusion.samples().points);
        sink.values(occlusion.samples().buried);
        sink.value(std::uint64_t(coarser.size()));
        for (const CoarserMesh& level : coarser) {
            write_mesh(level.mesh, sink);
            sink.value(level.distance);
        }
    });
}

/// Reads what mesh_bytes wrote. Nothing if it is not consistent.
std::optional<LibraryMesh> mesh_from(std::string_view bytes) {
    ByteSource source(bytes);
    LibraryMesh found;
    found.mesh.original = mesh_from(source);
    if (source.value<std::uint8_t>()) found.mesh.opaque = mesh_from(source);
    found.mesh.backs = mesh_from(source);
    found.mesh.fine = mesh_from(source);
    found.mesh.coarse = mesh_from(source);
    found.mesh.findings = findings_from(source);
    LocalSamples& samples = found.occlusion.samples.emplace();
    samples.points = source.values<Vec3f>();
    samples.buried = source.values<std::uint8_t>();
    std::vector<CoarserMesh>& coarser = found.occlusion.coarser.emplace();
    for (auto count = source.count(sizeof(float)); count > 0; --count) {
        coarser.emplace_back();
        coarser.back().mesh = mesh_from(source);
        coarser.back().distance = source.value<float>();
    }
    if (!source.is_at_end() || !is_consistent(found)) return std::nullopt;
    return found;
}

std::string name_end(const ContentHash& key) {
    return fmt::format("-{}{}", short_hex(key), mesh_ending);
}

}  // namespace

ContentHash preparation_key(const ImportedMesh& imported, const MeshPreparation& wanted) {
    return content_hash(written_bytes([&](ByteSink& sink) {
        sink.value(preparation_version);
        write_mesh(imported.mesh, sink);
        write_findings(imported.findings, sink);
        sink.value(wanted.fine_vertices);
        sink.value(wanted.coarse_triangles);
        sink.value(std::uint8_t(wanted.split_crossed));
        sink.value(std::uint8_t(wanted.faces));
        for (const OpacityMap& map : wanted.opacity) {
            sink.value(map.width);
            sink.value(map.height);
            sink.values(map.opacity);
        }
    }));
}

std::optional<LibraryMesh> find_library_mesh(const path& folder, const ContentHash& key) {
    for (const path& file : files_ending(folder, name_end(key)))
        if (Result<LibraryMesh> found = read_library_mesh(file)) {
            note_use(file);
            return *std::move(found);
        }
    return std::nullopt;
}

Result<Done> add_library_mesh(const path& folder, std::string_view entity, const ContentHash& key,
                              const PreparedMesh& mesh, const EntityOcclusion& occlusion,
                              const Progress& progress) {
    const std::vector<CoarserMesh>* coarser = nullptr;
    try {
        coarser = &occlusion.coarser(progress);
    } catch (const Interrupted&) {
        return interruption();
    }
    return write_file(library_path(folder, entity, name_end(key)),
                      section_file({{entity_section, std::string(entity)},
                                    {mesh_section, mesh_bytes(mesh, occlusion, *coarser)}}));
}

Result<LibraryMesh> read_library_mesh(const path& file) {
    HF_TRY(const std::vector<Section> sections, read_section_file(file));
    if (const std::string* bytes = section_named(sections, mesh_section))
        if (std::optional<LibraryMesh> found = mesh_from(*bytes)) return *std::move(found);
    return Error{file.string(), "is no prepared mesh"};
}

Result<std::string> read_library_mesh_entity(const path& file) {
    HF_TRY(const Section first, read_first_section(file));
    if (first.name != entity_section) return Error{file.string(), "is no prepared mesh"};
    return first.bytes;
}

}  // namespace haarfield
