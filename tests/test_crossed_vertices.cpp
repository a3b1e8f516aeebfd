#include "fields/preparation/crossed_vertices.h"

#include <gtest/gtest.h>

#include "scenes/scene_entities.h"
#include "scenes/scene_shading.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

/// Returns an upright square across z = 0 and one across x = 0, with cells x cells squares each.
Mesh crossing_sheets(int cells) {
    const Mesh sheet = upright_square_mesh(1, cells);
    return joined_meshes(sheet, turned_mesh(sheet, rotation_xyz(Vec3f(0, float(pi) / 2, 0))));
}

bool is_on_axis(const Vec3f& p) {
    return std::hypot(p.x, p.z) < 1e-4f;
}

TEST(CrossedVertices, EachSideHasASeparateVertex) {
    const Mesh sheets = crossing_sheets(4);
    Mesh fine = sheets;
    EXPECT_EQ(split_crossed_vertices(fine, sheets), 2u * 5u);
    ASSERT_EQ(fine.triangles.size(), sheets.triangles.size());
    EXPECT_EQ(fine.normals.size(), fine.positions.size());
    EXPECT_EQ(fine.vertex_materials.size(), fine.positions.size());
    std::vector<Vec3f> side(fine.positions.size(), Vec3f(0.0f));
    for (std::size_t t = 0; t < fine.triangles.size(); ++t) {
        Vec3f middle(0.0f);
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_EQ(fine.positions[fine.triangles[t][k]], sheets.positions[sheets.triangles[t][k]]);
            EXPECT_EQ(fine.normals[fine.triangles[t][k]], sheets.normals[sheets.triangles[t][k]]);
            middle += fine.positions[fine.triangles[t][k]];
        }
        for (const std::uint32_t v : fine.triangles[t])
            if (is_on_axis(fine.positions[v])) {
                EXPECT_GE(side[v].dot(middle), 0) << "triangles on both sides";
                side[v] = middle;
            }
    }
}

TEST(CrossedVertices, EdgesOfSolidsAndFlatSheetsHaveNone) {
    for (const Mesh& mesh :
         {upright_square_mesh(1, 4), box_mesh({0, 0, 0}, {1, 1, 1}, 3), sphere_mesh({0, 0, 0}, 1, 12)}) {
        Mesh fine = mesh;
        EXPECT_EQ(split_crossed_vertices(fine, mesh), 0u);
        EXPECT_EQ(fine.triangles, mesh.triangles);
    }
}

/// Under a uniform sky, the crossing sheet occludes half of the light next to it.
TEST(CrossedVertices, AreHalfInShadow) {
    const TestFolder folder;
    write_text(folder / "cross.obj",
               "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 -1 -1\nv 0 -1 1\nv 0 1 1\nv 0 1 -1\nf 1 2 3 4\n"
               "f 5 6 7 8\n");
    Scene scene;
    Entity entity;
    entity.name = "cross";
    entity.mesh = folder / "cross.obj";
    entity.fine_vertices = 400;
    entity.planar_samples = entity.spherical_samples = 20;
    scene.entities.push_back(entity);
    scene.instances.push_back({"cross", 0, {}});
    const Result<SceneEntities> entities = prepare_scene_entities(scene, {});
    ASSERT_TRUE(entities) << entities.error().message();
    const LatLongImage sky{64, 32, std::vector<Rgb>(64 * 32, Rgb(1.0f))};
    const ShadedScene shaded = shaded_scene(scene, *entities, sky);
    const Result<SceneRadiance> radiance = scene_radiance(shaded, RenderSettings());
    ASSERT_TRUE(radiance) << radiance.error().message();
    const Mesh& fine = entities->entities[0]->mesh.fine;
    const float albedo = entities->entities[0]->materials[0].diffuse.x;
    std::size_t crossed = 0;
    for (std::size_t v = 0; v < fine.positions.size(); ++v)
        if (is_on_axis(fine.positions[v]) && std::abs(fine.positions[v].y) < 0.8f) {
            ++crossed;
            EXPECT_NEAR((*radiance)[0][v].total().x / albedo, 0.5f, 0.1f) << fine.positions[v];
        }
    EXPECT_GT(crossed, 20u);
}

}  // namespace
}  // namespace haarfield
