#include "fields/preparation/mesh_preparation.h"

#include "fields/mesh/mesh_subdivision.h"
#include "fields/mesh/mesh_topology.h"
#include "fields/preparation/mesh_simplification.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/mesh_measures.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <map>
#include <set>

namespace haarfield {

namespace {

/// Returns a mesh of positions and triangles. Every triangle has separate corners and its face's normal.
Mesh faceted(const std::vector<Vec3f>& positions, const std::vector<std::array<int, 3>>& triangles) {
    Mesh mesh;
    mesh.material_names = {""};
    for (const auto& t : triangles) {
        const Vec3f normal =
            (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]).normalized();
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (int corner : t) {
            mesh.positions.push_back(positions[corner]);
            mesh.normals.push_back(normal);
            mesh.vertex_materials.push_back(0);
        }
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

Mesh box(const Vec3f& lower, const Vec3f& upper) {
    std::vector<Vec3f> p;
    for (int i = 0; i < 8; ++i)
        p.emplace_back(i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z);
    return faceted(p, {{0, 2, 3},
                       {0, 3, 1},
                       {4, 5, 7},
                       {4, 7, 6},
                       {0, 1, 5},
                       {0, 5, 4},
                       {2, 6, 7},
                       {2, 7, 3},
                       {0, 4, 6},
                       {0, 6, 2},
                       {1, 3, 7},
                       {1, 7, 5}});
}

/// Returns a closed smooth sphere of radius 1 with 2 * stacks * slices triangles (fewer at the poles).
Mesh sphere(int stacks, int slices, const Vec3f& centre = {0, 0, 0}) {
    Mesh mesh;
    mesh.material_names = {""};
    const auto add = [&](double theta, double phi) {
        const Vec3f n(static_cast<float>(std::sin(theta) * std::cos(phi)),
                      static_cast<float>(std::cos(theta)),
                      static_cast<float>(std::sin(theta) * std::sin(phi)));
        mesh.positions.push_back(centre + n);
        mesh.normals.push_back(n);
        mesh.vertex_materials.push_back(0);
    };
    add(0, 0);
    for (int i = 1; i < stacks; ++i)
        for (int j = 0; j < slices; ++j) add(pi * i / stacks, 2 * pi * j / slices);
    add(pi, 0);
    const auto at = [&](int i, int j) {
        if (i == 0) return 0u;
        if (i == stacks) return static_cast<std::uint32_t>(mesh.positions.size() - 1);
        return static_cast<std::uint32_t>(1 + (i - 1) * slices + j % slices);
    };
    for (int i = 0; i < stacks; ++i)
        for (int j = 0; j < slices; ++j) {
            if (i > 0) mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            if (i + 1 < stacks) mesh.triangles.push_back({at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)});
        }
    return mesh;
}

Mesh floor_square(float side) {
    const float h = side / 2;
    Mesh mesh;
    mesh.material_names = {""};
    mesh.positions = {{-h, 0, -h}, {-h, 0, h}, {h, 0, h}, {h, 0, -h}};
    mesh.normals.assign(4, Vec3f(0, 1, 0));
    mesh.vertex_materials.assign(4, 0);
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

/// Returns the number of edges, by position, that only one triangle uses.
int open_edges(const Mesh& mesh) {
    const MergedPositions merged = merged_positions(mesh.positions);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = merged.index[t[k]], b = merged.index[t[(k + 1) % 3]];
            ++uses[std::minmax(a, b)];
        }
    int open = 0;
    for (const auto& [edge, count] : uses) open += count == 1;
    return open;
}

PreparedMesh prepared(const Mesh& mesh, const MeshPreparation& wanted) {
    Result<PreparedMesh> result = prepare_mesh({mesh, {}}, wanted);
    EXPECT_TRUE(result) << (result ? "" : result.error().message());
    return result ? *std::move(result) : PreparedMesh{};
}

}  // namespace

TEST(Subdivision, MakesAnEvenGridOfASquare) {
    const Mesh fine = subdivided(floor_square(6), 3000);
    ASSERT_GE(fine.positions.size(), 3000u);
    ASSERT_LE(fine.positions.size(), 3300u);
    double least = INFINITY, most = 0;
    for (const auto& t : fine.triangles) {
        const Vec3d normal = area_vector(fine, t);
        EXPECT_GT(normal.y, 0);
        least = std::min(least, normal.y);
        most = std::max(most, normal.y);
        for (int k = 0; k < 3; ++k) {
            const Vec3d a = Vec3d(fine.positions[t[(k + 1) % 3]]) - Vec3d(fine.positions[t[k]]);
            const Vec3d b = Vec3d(fine.positions[t[(k + 2) % 3]]) - Vec3d(fine.positions[t[k]]);
            EXPECT_GT(std::atan2(a.cross(b).length(), a.dot(b)), 0.999 * pi / 4);
        }
    }
    EXPECT_LE(most, 2.0001 * least);
    EXPECT_NEAR(surface_area(fine), 36, 1e-4);
}

TEST(Subdivision, FinishesTheLastRoundIfThatIsNear) {
    const Mesh fine = subdivided(floor_square(6), 1000);  // 33 x 33 = 1089
    EXPECT_EQ(fine.positions.size(), 1089u);
    std::set<long> areas;
    for (const auto& t : fine.triangles) areas.insert(std::lround(1e6 * area_vector(fine, t).length()));
    EXPECT_EQ(areas.size(), 1u);
}

TEST(Subdivision, ClosedStaysClosedAcrossSeams) {
    const Mesh cube = box({0, 0, 0}, {1, 2, 3});
    const Mesh fine = subdivided(cube, 5000);
    EXPECT_GE(fine.positions.size(), 5000u);
    EXPECT_EQ(open_edges(fine), 0);
    EXPECT_NEAR(signed_volume(fine), 6, 1e-4);
    EXPECT_NEAR(surface_area(fine), 22, 1e-4);
    for (const Vec3f& n : fine.normals)  // seams stay sharp
        EXPECT_EQ(std::abs(n.x) + std::abs(n.y) + std::abs(n.z), 1.0f);
}

TEST(Subdivision, InterpolatesNormalsAndKeepsMaterials) {
    Mesh mesh = sphere(8, 16);
    mesh.material_names = {"oak", "fabric"};
    append_mesh(mesh, sphere(6, 12, {3, 0, 0}));
    for (std::size_t i = 8 * 16 - 14; i < mesh.positions.size(); ++i)
        if (mesh.positions[i].x > 1.5f) mesh.vertex_materials[i] = 1;
    const Mesh fine = subdivided(mesh, 4000);
    for (std::size_t i = 0; i < fine.positions.size(); ++i) {
        EXPECT_NEAR(fine.normals[i].length(), 1, 1e-5);
        EXPECT_EQ(fine.vertex_materials[i], fine.positions[i].x > 1.5f ? 1 : 0);
        const Vec3f centre(fine.vertex_materials[i] ? 3.0f : 0.0f, 0, 0);
        EXPECT_GT(fine.normals[i].dot((fine.positions[i] - centre).normalized()), 0.95f);
    }
}

TEST(Subdivision, LeavesAFineMeshUnchanged) {
    const Mesh mesh = sphere(8, 16);
    EXPECT_EQ(subdivided(mesh, 10).triangles, mesh.triangles);
    EXPECT_EQ(subdivided(mesh, 0).triangles, mesh.triangles);
}

TEST(Subdivision, SplitsEveryTriangleAtANonManifoldEdge) {
    const std::vector<Vec3f> p{{0, 0, 0}, {0, 4, 0}, {1, 0, 0}, {-1, 0, 1}, {-1, 0, -1}};
    const Mesh fan = faceted(p, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
    const Mesh fine = subdivided(fan, 400);
    // T-junctions would be open edges, but only the outer sides may be open
    const MergedPositions merged = merged_positions(fine.positions);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    for (const auto& t : fine.triangles)
        for (int k = 0; k < 3; ++k)
            ++uses[std::minmax(std::uint32_t(merged.index[t[k]]),
                               std::uint32_t(merged.index[t[(k + 1) % 3]]))];
    for (const auto& [edge, count] : uses) {
        const Vec3f a = merged.positions[edge.first], b = merged.positions[edge.second];
        if (a.x == 0 && b.x == 0) {
            EXPECT_EQ(count, 3);
        }
    }
}

TEST(MeshPreparation, CoarseSphereIsCloseClosedAndOutward) {
    const Mesh mesh = sphere(40, 80);
    const PreparedMesh ready = prepared(mesh, {0, 500});
    EXPECT_LE(ready.coarse.triangles.size(), 500u);
    EXPECT_GE(ready.coarse.triangles.size(), 490u);
    EXPECT_EQ(open_edges(ready.coarse), 0);
    EXPECT_NEAR(signed_volume(ready.coarse), signed_volume(mesh), 0.02 * signed_volume(mesh));
    for (const Vec3f& p : ready.coarse.positions) EXPECT_NEAR(p.length(), 1, 0.03);
    EXPECT_EQ(ready.fine.triangles, ready.original.triangles);
    EXPECT_EQ(ready.findings.summary(), "");
}

/// Returns a sphere of radius 1 with waves in two directions.
Mesh wavy_sphere(float height) {
    Mesh mesh = sphere(90, 180);
    for (Vec3f& p : mesh.positions) p = p * (1 + height * std::sin(40 * p.y) * std::sin(40 * p.x));
    return mesh;
}

TEST(MeshPreparation, ChoosesCoarseTrianglesByTheirDistanceFromTheMesh) {
    const std::size_t smooth = prepared(sphere(90, 180), {0, chosen_by_distance}).coarse.triangles.size();
    const std::size_t wavy = prepared(wavy_sphere(0.05f), {0, chosen_by_distance}).coarse.triangles.size();
    EXPECT_GE(smooth, 4000u);
    EXPECT_LE(smooth, 16000u);
    EXPECT_GT(wavy, smooth);
}

TEST(MeshPreparation, KeepsFewTrianglesWhereTheyAreChosenByDistance) {
    const Mesh mesh = sphere(30, 60);
    EXPECT_EQ(prepared(mesh, {0, chosen_by_distance}).coarse.triangles, mesh.triangles);
}

TEST(MeshPreparation, SimplifiesPiecesThatPenetrateEachOther) {
    Mesh mesh = sphere(30, 60);
    append_mesh(mesh, sphere(30, 60, {1, 0.3f, 0.1f}));
    const PreparedMesh ready = prepared(mesh, {0, 800});
    EXPECT_LE(ready.coarse.triangles.size(), 800u);
    EXPECT_EQ(open_edges(ready.coarse), 0);
    EXPECT_EQ(ready.findings.components, 2u);
    EXPECT_FALSE(ready.findings.self_intersecting);
}

TEST(MeshPreparation, TurnsTrianglesToAgreeAndClosedPiecesOutwards) {
    Mesh mesh = sphere(6, 12);
    const double wanted = signed_volume(mesh);
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
        std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
    const std::size_t swapped = (mesh.triangles.size() + 2) / 3;
    const PreparedMesh ready = prepared(mesh, {2000, 0});
    EXPECT_EQ(ready.findings.flipped_triangles, swapped);
    EXPECT_NEAR(signed_volume(ready.original), wanted, 1e-6);
    EXPECT_NEAR(signed_volume(ready.fine), wanted, 1e-4);
    for (std::size_t i = 0; i < ready.fine.positions.size(); ++i)
        EXPECT_GT(ready.fine.normals[i].dot(ready.fine.positions[i]), 0.5f);
}

TEST(MeshPreparation, NormalsTurnWithTheirTriangles) {
    Mesh inside_out = sphere(6, 12);
    for (auto& t : inside_out.triangles) std::swap(t[1], t[2]);
    for (Vec3f& n : inside_out.normals) n = -n;
    const PreparedMesh ready = prepared(inside_out, {0, 0});
    EXPECT_EQ(ready.findings.flipped_triangles, inside_out.triangles.size());
    for (std::size_t i = 0; i < ready.original.positions.size(); ++i)
        EXPECT_GT(ready.original.normals[i].dot(ready.original.positions[i]), 0.9f);
}

TEST(MeshPreparation, AnOpenPieceFacesAsItsNormalsDo) {
    Mesh mesh = floor_square(2);
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);  // now faces down, with normals up
    const PreparedMesh ready = prepared(mesh, {0, 0});
    for (const auto& t : ready.original.triangles) EXPECT_GT(area_vector(ready.original, t).y, 0);
    for (const Vec3f& n : ready.original.normals) EXPECT_EQ(n, Vec3f(0, 1, 0));
    EXPECT_EQ(ready.findings.boundary_edges, 4u);
    EXPECT_EQ(ready.findings.open_components, 1u);
}

TEST(MeshPreparation, SeparatesTheSidesOfASheetWithoutThickness) {
    // A square that is modelled from above and from below, cut along different diagonals, and a separate
    // square.
    const std::vector<Vec3f> p{{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1},
                               {3, 0, 0}, {4, 0, 0}, {4, 0, 1}, {3, 0, 1}};
    const Mesh sheets = faceted(p, {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}, {4, 6, 5}, {4, 7, 6}});
    const PreparedMesh ready = prepared(sheets, {400, 0});
    const float offset = 1e-4f * mesh_bounds(ready.original).radius();
    std::size_t inside = 0;
    for (std::size_t v = 0; v < ready.fine.positions.size(); ++v) {
        const Vec3f& vertex = ready.fine.positions[v];
        if (vertex.x > 2) {
            EXPECT_EQ(vertex.y, 0);
        } else if (vertex.x > 0 && vertex.x < 1 && vertex.z > 0 && vertex.z < 1) {
            EXPECT_FLOAT_EQ(vertex.y, ready.fine.normals[v].y * offset);
            ++inside;
        }
    }
    EXPECT_GT(inside, 100u);
    EXPECT_GE(ready.findings.parted_vertices, inside);
    for (const Vec3f& position : ready.original.positions) EXPECT_EQ(position.y, 0);
}

TEST(MeshPreparation, LeavesAFloorLevelNextToAnOpenWallThatStandsOnIt) {
    Mesh mesh = floor_square(1);
    const Mesh block = box({-0.3f, 0, -0.3f}, {0.3f, 1, 0.3f});
    Mesh wall = block;
    std::erase_if(wall.triangles, [&](const auto& t) { return area_vector(block, t).y > 0; });  // no top
    append_mesh(mesh, wall);
    const PreparedMesh ready = prepared(mesh, {2000, 0});
    EXPECT_GT(ready.findings.parted_vertices, 0u) << "below the wall";
    for (std::size_t v = 0; v < ready.fine.positions.size(); ++v) {
        const Vec3f& vertex = ready.fine.positions[v];
        if (ready.fine.normals[v].y > 0.5f && std::max(std::abs(vertex.x), std::abs(vertex.z)) > 0.3f) {
            EXPECT_EQ(vertex.y, 0) << vertex.x << " " << vertex.z;
        }
    }
}

TEST(MeshPreparation, LeavesSolidsUnchanged) {
    Mesh touching = box({0, 0, 0}, {1, 1, 1});
    append_mesh(touching, box({0.25f, 1, 0.25f}, {0.75f, 2, 0.75f}));
    EXPECT_EQ(prepared(touching, {500, 0}).findings.parted_vertices, 0u);
}

TEST(MeshPreparation, TakesNonManifoldMeshes) {
    Mesh mesh = box({0, 0, 0}, {1, 1, 1});
    append_mesh(mesh, box({1, 1, 0}, {2, 2, 1}));  // touches along an edge, where there are four triangles
    mesh = subdivided(mesh, 3000);
    const PreparedMesh ready = prepared(mesh, {0, 200});
    EXPECT_GT(ready.findings.non_manifold_edges, 0u);
    EXPECT_EQ(ready.findings.components, 1u);
    EXPECT_EQ(ready.findings.open_components, 0u);
    EXPECT_LE(ready.coarse.triangles.size(), 200u);
    EXPECT_NEAR(signed_volume(ready.coarse), 2, 0.02);
    EXPECT_NEAR(surface_area(ready.coarse), 12, 0.1);
}

TEST(MeshPreparation, FindsAPieceThatIntersectsItself) {
    // two triangles that cross and are connected by a third one
    const std::vector<Vec3f> p{{0, 0, 0}, {4, 0, 0}, {0, 0, 4},  {1, -1, 1},
                               {1, 1, 1}, {2, 1, 1}, {-3, 5, -3}};
    const Mesh crossing = faceted(p, {{0, 1, 2}, {3, 4, 5}, {4, 6, 5}, {6, 0, 2}});
    EXPECT_TRUE(prepared(crossing, {0, 0}).findings.self_intersecting);
    const Mesh apart = faceted(p, {{0, 1, 2}, {4, 6, 5}, {6, 0, 2}});
    EXPECT_FALSE(prepared(apart, {0, 0}).findings.self_intersecting);
}

TEST(MeshPreparation, IsDeterministic) {
    const Mesh mesh = sphere(20, 40);
    const PreparedMesh first = prepared(mesh, {3000, 300}), second = prepared(mesh, {3000, 300});
    EXPECT_EQ(first.fine.positions, second.fine.positions);
    EXPECT_EQ(first.fine.triangles, second.fine.triangles);
    EXPECT_EQ(first.coarse.positions, second.coarse.positions);
    EXPECT_EQ(first.coarse.triangles, second.coarse.triangles);
}

TEST(MeshPreparation, StopsWhenAsked) {
    std::stop_source source;
    Progress progress;
    progress.stop = source.get_token();
    progress.report = [&](std::string_view, std::uint64_t, std::uint64_t) { source.request_stop(); };
    const Result<PreparedMesh> result = prepare_mesh({sphere(40, 80), {}}, {20000, 500}, progress);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::interrupted);
}

TEST(Simplified, FlatRegionsHaveNoFans) {
    const Mesh coarse =
        simplified(turned_mesh(box_mesh(Vec3f(-1), Vec3f(1), 60), rotation_xyz({0.3f, 0.5f, 0.7f})), 4000,
                   ClosedFaces::outwards, {});
    EXPECT_GT(coarse.triangles.size(), 3000u);
    EXPECT_LE(coarse.triangles.size(), 4000u);
    std::vector<std::size_t> triangles_at(coarse.positions.size());
    double area = 0;
    for (const auto& [a, b, c] : coarse.triangles) {
        for (const std::uint32_t v : {a, b, c}) ++triangles_at[v];
        const Vec3f p = coarse.positions[a];
        area += 0.5 * double((coarse.positions[b] - p).cross(coarse.positions[c] - p).length());
    }
    EXPECT_LE(std::ranges::max(triangles_at), 24u);
    EXPECT_NEAR(area, 24, 1e-4);
}

TEST(CoarserMeshes, HaveAThirdOfTheTrianglesEachAndSayHowFarTheyAre) {
    const Mesh mesh = sphere(60, 60);
    const std::vector<CoarserMesh> coarser = coarser_meshes(mesh);
    ASSERT_EQ(coarser.size(), 3u);
    std::size_t before = mesh.triangles.size();
    for (const CoarserMesh& level : coarser) {
        EXPECT_LE(level.mesh.triangles.size(), before / 3 + 1);
        EXPECT_GE(level.mesh.triangles.size(), before / 3 - 8);
        before = level.mesh.triangles.size();
        // The vertices of the mesh are on the unit sphere. The simplification is a polyhedron close to it.
        double squares = 0, volume = 0;
        for (const auto& [i, j, k] : level.mesh.triangles) {
            const Vec3d a(level.mesh.positions[i]), b(level.mesh.positions[j]), c(level.mesh.positions[k]);
            const double height = 1 - (a + b + c).length() / 3;
            squares += height * height / double(level.mesh.triangles.size());
            volume += a.dot(b.cross(c)) / 6;
        }
        EXPECT_GT(double(level.distance), 0.2 * std::sqrt(squares));
        EXPECT_LT(double(level.distance), 2 * std::sqrt(squares));
        EXPECT_NEAR(volume, 4 * pi / 3, 0.12);  // It still faces outwards.
    }
    EXPECT_LT(coarser[0].distance, 0.01f);
    EXPECT_LT(coarser[0].distance, coarser[2].distance);
}

TEST(CoarserMeshes, AreNotMadeOfSmallMeshesAndStopOnRequest) {
    EXPECT_TRUE(coarser_meshes(box({0, 0, 0}, {1, 1, 1})).empty());
    std::stop_source stop;
    stop.request_stop();
    EXPECT_THROW(coarser_meshes(sphere(60, 60), {{}, stop.get_token()}), Interrupted);
}

}  // namespace haarfield
