#include "fields/preparation/sheet_backs.h"

#include <gtest/gtest.h>

#include "tests/fixtures/example_meshes.h"

namespace haarfield {
namespace {

Mesh seen_backs(const Mesh& mesh) {
    return haarfield::seen_backs(mesh, mesh);
}

Vec3f facing(const Mesh& mesh, const std::array<std::uint32_t, 3>& t) {
    const Vec3f& a = mesh.positions[t[0]];
    return (mesh.positions[t[1]] - a).cross(mesh.positions[t[2]] - a).normalized();
}

/// Returns a box without the side that faces a unit vector along an axis.
Mesh open_box(const Vec3f& side) {
    Mesh mesh = box_mesh({0, 0, 0}, {1, 1, 1}, 4);
    std::erase_if(mesh.triangles, [&](const auto& t) { return facing(mesh, t).dot(side) > 0.9f; });
    return mesh;
}

TEST(SheetBacks, AnUprightSheetHasOneAtTheSamePlace) {
    Mesh sheet = upright_square_mesh(1, 3);
    sheet.material_names = {"", "paper"};
    sheet.vertex_materials.assign(sheet.positions.size(), 1);
    const Mesh backs = seen_backs(sheet);
    ASSERT_EQ(backs.triangles.size(), sheet.triangles.size());
    EXPECT_EQ(backs.positions.size(), sheet.positions.size());
    for (std::size_t t = 0; t < sheet.triangles.size(); ++t)
        for (const std::size_t corner : {0u, 1u, 2u})
            EXPECT_EQ(backs.positions[backs.triangles[t][corner]],
                      sheet.positions[sheet.triangles[t][(3 - corner) % 3]]);
    EXPECT_EQ(backs.material_names, sheet.material_names);
    EXPECT_EQ(backs.vertex_materials, sheet.vertex_materials);
    for (const Vec3f& normal : backs.normals) EXPECT_EQ(normal, Vec3f(0, 0, -1));
    for (const auto& t : backs.triangles) EXPECT_EQ(facing(backs, t), Vec3f(0, 0, -1));
}

TEST(SheetBacks, FloorsHaveNoneAndSheetsAboveTheGroundHaveOne) {
    EXPECT_TRUE(seen_backs(square_mesh(2, 0, 4)).triangles.empty());
    const Mesh awning = joined_meshes(square_mesh(2, 1.5f, 2), box_mesh({0.9f, 0, 0.9f}, {1, 1.4f, 1}));
    const Mesh backs = seen_backs(awning);
    EXPECT_EQ(backs.triangles.size(), 8u);
    for (const Vec3f& position : backs.positions) EXPECT_EQ(position.y, 1.5f);
}

TEST(SheetBacks, SolidsHaveNone) {
    EXPECT_TRUE(seen_backs(box_mesh({0, 0, 0}, {1, 1, 1}, 2)).triangles.empty());
    EXPECT_TRUE(seen_backs(sphere_mesh({0, 1, 0}, 1, 12)).triangles.empty());
}

TEST(SheetBacks, OnlyVisibleAreasOfAnInsideHaveOne) {
    EXPECT_TRUE(seen_backs(open_box({0, -1, 0})).triangles.empty()) << "stands on its open side";
    EXPECT_EQ(seen_backs(open_box({0, 1, 0})).triangles.size(), 160u) << "the five inner sides";
}

TEST(SheetBacks, AreasVisibleThroughHolesHaveOne) {
    const Mesh box = open_box({0, -1, 0});
    Mesh blocking = box;
    std::erase_if(blocking.triangles, [&](const auto& t) { return facing(box, t).x > 0.9f; });
    EXPECT_EQ(haarfield::seen_backs(box, blocking).triangles.size(), 128u)
        << "the opposite, top and adjacent sides";
}

TEST(SheetBacks, AWallOppositeASmallWindowHasThemEverywhere) {
    Mesh box = box_mesh({0, 0, 0}, {1, 1, 1}, 16);
    const auto middle = [&](const auto& t) {
        return (box.positions[t[0]] + box.positions[t[1]] + box.positions[t[2]]) / 3.0f;
    };
    const Vec3f window(1, 0.5f, 0.5f);
    std::erase_if(box.triangles, [&](const auto& t) {
        const Vec3f aside = middle(t) - window;
        return std::max({std::abs(aside.x), std::abs(aside.y), std::abs(aside.z)}) < 0.15f;
    });
    const Mesh backs = seen_backs(box);
    std::size_t opposite = 0;
    for (const auto& t : backs.triangles) opposite += facing(backs, t).x > 0.9f;
    EXPECT_EQ(opposite, 512u);
}

TEST(SheetBacks, SheetsModelledFromBothSidesGetNone) {
    Mesh back = upright_square_mesh(1, 2);
    for (auto& t : back.triangles) std::swap(t[1], t[2]);
    for (Vec3f& normal : back.normals) normal = -normal;
    EXPECT_TRUE(seen_backs(joined_meshes(upright_square_mesh(1, 3), back)).triangles.empty());
}

TEST(SheetBacks, AreSeparatedFromTheirFrontsInPreparation) {
    ImportedMesh sheet;
    sheet.mesh = upright_square_mesh(1);
    const PreparedMesh ready = *prepare_mesh(std::move(sheet), {400, 0});
    EXPECT_EQ(ready.findings.backs, 2u);
    EXPECT_EQ(ready.original.triangles.size(), 2u);
    EXPECT_EQ(ready.coarse.triangles.size(), 2u);
    EXPECT_EQ(visible_surface(ready).triangles.size(), 4u);
    EXPECT_GE(ready.fine.positions.size(), 400u);
    EXPECT_LE(ready.fine.positions.size(), 440u);
    const float offset = 1e-4f * mesh_bounds(ready.original).radius();
    std::size_t behind = 0;
    for (std::size_t v = 0; v < ready.fine.positions.size(); ++v) {
        const bool is_back = ready.fine.normals[v].z < 0;
        EXPECT_FLOAT_EQ(ready.fine.positions[v].z, is_back ? -offset : 0);
        behind += is_back;
    }
    EXPECT_EQ(2 * behind, ready.fine.positions.size());
}

}  // namespace
}  // namespace haarfield
