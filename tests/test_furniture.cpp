#include "scenes/furniture/furniture.h"

#include "fields/mesh/mesh_topology.h"
#include "fields/mesh/surface_rays.h"
#include "fields/model/mesh_reader.h"
#include "fields/preparation/mesh_preparation.h"
#include "scenes/furniture/modelling.h"
#include "tests/fixtures/mesh_measures.h"

#include <gtest/gtest.h>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <sstream>

namespace haarfield {

namespace {

struct Piece {
    const char* name;
    Mesh mesh;
    std::size_t fewest, most;  // triangles
    std::size_t parts;         // at least
};

std::vector<Piece> furniture() {
    std::vector<Piece> pieces;
    pieces.push_back({"table", table_mesh(), 4200, 4700, 13});
    pieces.push_back({"chair", chair_mesh(), 5100, 5700, 13});
    return pieces;
}

std::vector<Piece> furniture_and_room() {
    std::vector<Piece> pieces = furniture();
    pieces.push_back({"room", room_mesh(), 800, 1000, 6});
    return pieces;
}

std::filesystem::path mesh_folder() {
    return std::filesystem::path(HAARFIELD_SOURCE_DIR) / "scenes" / "meshes";
}

}  // namespace

TEST(Furniture, HasTheTrianglesItPromises) {
    for (const Piece& piece : furniture_and_room()) {
        EXPECT_GE(piece.mesh.triangles.size(), piece.fewest) << piece.name;
        EXPECT_LE(piece.mesh.triangles.size(), piece.most) << piece.name;
    }
    EXPECT_EQ(floor_mesh().triangles.size(), 2u);
}

TEST(Furniture, StandsOnTheFloorInTheMiddle) {
    for (const Piece& piece : furniture()) {
        const Bounds bounds = mesh_bounds(piece.mesh);
        EXPECT_EQ(bounds.lower.y, 0) << piece.name;
        EXPECT_NEAR(bounds.centre().x, 0, 1e-5) << piece.name;
        EXPECT_NEAR(bounds.centre().z, 0, 1e-5) << piece.name;
    }
    EXPECT_NEAR(mesh_bounds(table_mesh()).upper.y, 0.75, 1e-6);
    EXPECT_NEAR(mesh_bounds(chair_mesh()).upper.y, 0.94, 0.02);
}

TEST(Furniture, EveryPartIsClosedAndFacesOutwards) {
    for (const Piece& piece : furniture_and_room()) {
        const MergedPositions merged = merged_positions(piece.mesh.positions);
        const std::vector<std::uint32_t> parts = triangle_pieces(piece.mesh, merged);
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> ways;
        std::map<std::uint32_t, double> volumes;
        for (std::size_t t = 0; t < parts.size(); ++t) {
            const auto& corners = piece.mesh.triangles[t];
            for (int k = 0; k < 3; ++k)
                ++ways[{merged.index[corners[k]], merged.index[corners[(k + 1) % 3]]}];
            volumes[parts[t]] +=
                area_vector(piece.mesh, corners).dot(Vec3d(piece.mesh.positions[corners[0]])) / 3;
        }
        for (const auto& [way, count] : ways) {
            EXPECT_EQ(count, 1) << piece.name;
            EXPECT_TRUE(ways.contains({way.second, way.first})) << piece.name;
        }
        EXPECT_GE(volumes.size(), piece.parts) << piece.name;
        for (const auto& [part, volume] : volumes) EXPECT_GT(volume, 1e-6) << piece.name << ", part " << part;
    }
}

TEST(Furniture, LightEntersTheRoomOnlyThroughItsWindow) {
    const Mesh mesh = room_mesh();
    const SurfaceRays rays(mesh.positions, mesh.triangles);
    const Vec3f eye(-0.4f, 1.2f, 0.3f);
    std::mt19937 random(3);
    const auto number = [&] { return static_cast<float>(random()) * 0x1p-31f - 1; };
    int open = 0, through_panes = 0;
    for (int i = 0; i < 20000; ++i) {
        Vec3f direction(number(), number(), number());
        if (i % 2 == 0) direction = Vec3f(2.4f, 1.45f + 0.8f * number(), 0.9f * number()) - eye;
        if (direction.length() < 0.1f) continue;
        direction.normalize();
        // Where it leaves the wall; what is farther from the opening's edges than `margin`, and from the
        // mullion.
        const auto in_window = [&](float x, float margin, float mullion) {
            const Vec3f p = eye + direction * ((x - eye.x) / direction.x);
            return direction.x > 0 && p.y > 0.85f + margin && p.y < 2.05f - margin &&
                   std::abs(p.z) < 0.7f - margin && std::abs(p.z) >= mullion;
        };
        const bool is_open = !rays.meets_surface(eye, direction);
        open += is_open;
        if (is_open) {
            EXPECT_TRUE(in_window(2.3f, 0, 0) && in_window(2.45f, 0, 0)) << direction;
        }
        if (in_window(2.3f, 0.06f, 0.03f) && in_window(2.45f, 0.06f, 0.03f)) {
            EXPECT_TRUE(is_open) << direction;
            ++through_panes;
        }
    }
    EXPECT_GT(through_panes, 1000);
    EXPECT_GT(open, through_panes);
}

TEST(Furniture, TheParquetCoversTheFloorInBlocksOfFiveSquares) {
    const Mesh mesh = parquet_mesh();
    double area = 0;
    std::array<double, 3> of_material{};
    for (const auto& triangle : mesh.triangles) {
        const Vec3d normal = area_vector(mesh, triangle);
        EXPECT_NEAR(normal.y, 0.11 * 0.11, 1e-6) << "half a square, facing up";
        area += normal.y;
        of_material[mesh.vertex_materials[triangle[0]]] += normal.y;
    }
    EXPECT_NEAR(area, 64, 2);
    for (const double share : of_material) EXPECT_NEAR(share / area, 1.0 / 3, 0.06);
    const SurfaceRays rays(mesh.positions, mesh.triangles);
    std::mt19937 random(5);
    const auto number = [&] { return 3.8f * (static_cast<float>(random()) * 0x1p-31f - 1); };
    for (int i = 0; i < 2000; ++i) {
        const Vec3f above(number(), 1, number());
        EXPECT_TRUE(rays.meets_surface(above, {0, -1, 0})) << above;
    }
}

TEST(Furniture, HasNoNeedlesAndNormalsThatFitTheirFaces) {
    for (const Piece& piece : furniture_and_room())
        for (std::size_t t = 0; t < piece.mesh.triangles.size(); ++t) {
            const auto& corners = piece.mesh.triangles[t];
            const Vec3d area = area_vector(piece.mesh, corners);
            double longest = 0;
            for (int k = 0; k < 3; ++k) {
                const Vec3f edge =
                    piece.mesh.positions[corners[(k + 1) % 3]] - piece.mesh.positions[corners[k]];
                longest = std::max(longest, static_cast<double>(edge.length()));
                const Vec3d normal(piece.mesh.normals[corners[k]]);
                EXPECT_NEAR(normal.length(), 1, 1e-5);
                EXPECT_GT(normal.dot(area), 0.6 * area.length()) << piece.name << ", triangle " << t;
            }
            EXPECT_GT(2 * area.length() / longest, 2e-4) << piece.name << ", triangle " << t;  // height, m
        }
}

TEST(Furniture, CommittedFilesAreWhatTheGeneratorWrites) {
    const std::vector<std::pair<const char*, Mesh>> meshes{{"table.obj", table_mesh()},
                                                           {"chair.obj", chair_mesh()},
                                                           {"floor.obj", floor_mesh()},
                                                           {"parquet.obj", parquet_mesh()},
                                                           {"room.obj", room_mesh()}};
    for (const auto& [name, mesh] : meshes) {
        std::ifstream in(mesh_folder() / name, std::ios::binary);
        std::stringstream text;
        text << in.rdbuf();
        EXPECT_TRUE(text.str() == obj_text(mesh)) << name << ": run haarfield_furniture scenes/meshes";
    }
}

TEST(Furniture, ReadsBackWithoutFindings) {
    for (const Piece& piece : furniture_and_room()) {
        Result<ImportedMesh> imported = read_mesh(mesh_folder() / (std::string(piece.name) + ".obj"));
        ASSERT_TRUE(imported) << imported.error().message();
        EXPECT_EQ(imported->mesh.triangles.size(), piece.mesh.triangles.size()) << piece.name;
        const std::set<std::string> wanted(piece.mesh.material_names.begin(),
                                           piece.mesh.material_names.end());
        const std::set<std::string> found(imported->mesh.material_names.begin(),
                                          imported->mesh.material_names.end());
        EXPECT_EQ(found, wanted) << piece.name;
        const Result<PreparedMesh> prepared = prepare_mesh(*std::move(imported), {25000, 2000});
        ASSERT_TRUE(prepared) << prepared.error().message();
        EXPECT_EQ(prepared->findings.summary(), "") << piece.name;
        EXPECT_LE(prepared->coarse.triangles.size(), 2000u) << piece.name;
        EXPECT_GE(prepared->fine.positions.size(), 25000u) << piece.name;
    }
}

}  // namespace haarfield
