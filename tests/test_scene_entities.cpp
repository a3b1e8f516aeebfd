#include "scenes/scene_entities.h"
#include "scenes/scene_shading.h"

#include <gtest/gtest.h>
#include <sys/fsuid.h>

#include <fstream>

#include "fields/file/process_name.h"
#include "tests/fixtures/example_textures.h"

namespace haarfield {
namespace {

class SceneEntitiesTest : public testing::Test {
protected:
    void SetUp() override {
        folder = std::filesystem::temp_directory_path() /
                 ("haarfield_scene_entities_" +
                  std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder);
        write_box(1.0f);
        Entity entity;
        entity.name = "box";
        entity.mesh = folder / "box.obj";
        entity.material = "paint";
        entity.materials["lid"] = "steel";
        entity.fine_vertices = 50;
        entity.coarse_triangles = 0;
        entity.planar_samples = 50;
        entity.spherical_samples = 50;
        scene.entities.push_back(entity);
        scene.materials["paint"].diffuse = Rgb(0.2f);
        scene.materials["steel"].diffuse = Rgb(0.9f);
        scene.instances.push_back({"box_1", 0, {}});
        scene.instances.push_back({"box_2", 0, {{3, 0, 0}, 1}});
        options.fields_folder = folder / "fields";
        options.face_size = 16;
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    void write_box(float height) {
        std::ofstream file(folder / "box.obj");
        for (int i = 0; i < 8; ++i)
            file << "v " << (i & 1) << ' ' << (i & 2 ? height : 0.0f) << ' ' << (i & 4) / 4 * 2 << '\n';
        file << "f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nusemtl lid\nf 3 7 8 4\nusemtl side\nf 1 3 4 2\nf 5 6 8 7\n";
    }

    std::filesystem::path folder;
    Scene scene;
    SceneEntityOptions options;
};

TEST_F(SceneEntitiesTest, MakesOneFieldPerEntityAndReusesItByHash) {
    const auto first = prepare_scene_entities(scene, options);
    ASSERT_TRUE(first) << first.error().message();
    ASSERT_EQ(first->entities.size(), 1u);
    EXPECT_EQ(first->entities[0]->field.planar_handles.size(),
              6u);  // twelve triangles are rasterized exactly
    EXPECT_EQ(first->entity_of_instance, (std::vector<std::size_t>{0, 0}));
    EXPECT_FALSE(first->entities[0]->reused);
    EXPECT_EQ(first->entities[0]->recomputed_because, "");
    EXPECT_GE(first->entities[0]->mesh.fine.positions.size(), 50u);
    EXPECT_EQ(field_defect(first->entities[0]->field), "");

    const auto second = prepare_scene_entities(scene, options);
    ASSERT_TRUE(second) << second.error().message();
    EXPECT_TRUE(second->entities[0]->reused);
    EXPECT_EQ(second->entities[0]->field.pool.node_bytes, first->entities[0]->field.pool.node_bytes);
    EXPECT_EQ(second->entities[0]->field.local_handles, first->entities[0]->field.local_handles);
}

TEST_F(SceneEntitiesTest, WarnsOfOpenEdgesUnlessTheMeshIsFlat) {
    scene.entities[0].materials.clear();
    options.fields = FieldExtent::none;
    const auto warnings = [&](const char* corner) {
        std::ofstream(folder / "box.obj")
            << "v 0 0 0\nv 4 1 0\nv 4 1 3\nv " << corner << "\nf 1 2 3\nf 1 3 4\n";
        const auto entities = prepare_scene_entities(scene, options);
        EXPECT_TRUE(entities) << entities.error().message();
        std::string all;
        for (const std::string& warning : entities->warnings) all += warning;
        return all;
    };
    EXPECT_EQ(warnings("0 0 3"), "");
    EXPECT_NE(warnings("0 0.01 3").find("4 open edges in its only piece"), std::string::npos);
}

TEST_F(SceneEntitiesTest, DifferentMeshesHaveSeparateFields) {
    const auto first = prepare_scene_entities(scene, options);
    ASSERT_TRUE(first);
    write_box(2.0f);
    const auto other = prepare_scene_entities(scene, options);
    ASSERT_TRUE(other);
    EXPECT_FALSE(other->entities[0]->reused);
    EXPECT_EQ(other->entities[0]->recomputed_because, "");
    EXPECT_NE(other->entities[0]->field_file, first->entities[0]->field_file);
    write_box(1.0f);
    const auto again = prepare_scene_entities(scene, options);
    ASSERT_TRUE(again);
    EXPECT_TRUE(again->entities[0]->reused);
    EXPECT_EQ(again->entities[0]->field_file, first->entities[0]->field_file);
}

TEST_F(SceneEntitiesTest, MakesAMeshUnderTwoNamesOnce) {
    ASSERT_TRUE(prepare_scene_entities(scene, options));
    scene.entities[0].name = "crate";
    const auto renamed = prepare_scene_entities(scene, options);
    ASSERT_TRUE(renamed);
    EXPECT_TRUE(renamed->entities[0]->reused);
    EXPECT_EQ(renamed->entities[0]->name, "crate");
}

TEST_F(SceneEntitiesTest, AnotherNumberOfVerticesRecomputesLocalSamplesOnly) {
    ASSERT_TRUE(prepare_scene_entities(scene, options));
    scene.entities[0].fine_vertices = 200;
    const auto finer = prepare_scene_entities(scene, options);
    ASSERT_TRUE(finer);
    EXPECT_FALSE(finer->entities[0]->reused);
    EXPECT_TRUE(finer->entities[0]->surroundings_reused);
    SceneEntityOptions elsewhere = options;
    elsewhere.fields_folder = folder / "elsewhere";
    const auto alone = prepare_scene_entities(scene, elsewhere);
    ASSERT_TRUE(alone);
    EXPECT_FALSE(alone->entities[0]->surroundings_reused);
    const auto bytes = [](const std::filesystem::path& file) {
        std::ifstream stream(file, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(stream), {});
    };
    EXPECT_TRUE(bytes(finer->entities[0]->field_file) == bytes(alone->entities[0]->field_file));
}

TEST_F(SceneEntitiesTest, RecomputesADamagedFieldAndReportsWhy) {
    const auto made = prepare_scene_entities(scene, options);
    ASSERT_TRUE(made);
    std::filesystem::resize_file(made->entities[0]->field_file, 1000);
    const auto damaged = prepare_scene_entities(scene, options);
    ASSERT_TRUE(damaged);
    EXPECT_FALSE(damaged->entities[0]->reused);
    EXPECT_NE(damaged->entities[0]->recomputed_because, "");
    EXPECT_TRUE(prepare_scene_entities(scene, options)->entities[0]->reused);
}

TEST_F(SceneEntitiesTest, AFolderWhereNothingCanBeWrittenIsAnErrorBeforeTheWork) {
    std::filesystem::create_directory(options.fields_folder);
    std::filesystem::permissions(options.fields_folder, std::filesystem::perms(0555));
    Progress progress;
    bool worked = false;
    progress.report = [&](std::string_view stage, std::uint64_t, std::uint64_t) {
        worked |= stage.starts_with("visibility");
    };
    const int before = setfsuid(65534);  // root may write anywhere; `nobody` may not
    const auto refused = prepare_scene_entities(scene, options, progress);
    setfsuid(static_cast<uid_t>(before));
    std::filesystem::permissions(options.fields_folder, std::filesystem::perms(0755));
    ASSERT_FALSE(refused);
    EXPECT_EQ(std::filesystem::path(refused.error().where).parent_path(), options.fields_folder);
    EXPECT_FALSE(worked);
}

TEST_F(SceneEntitiesTest, RemovesFilesOfAKilledRun) {
    std::filesystem::create_directory(options.fields_folder);
    const std::string own = process_name(), ended = own.substr(0, own.find('-')) + "-1-1";
    std::ofstream(options.fields_folder / ("gone.vdb." + ended + ".0.tmp")) << "half";
    std::ofstream(options.fields_folder / "gone.claim") << ended;
    const auto made = prepare_scene_entities(scene, options);
    ASSERT_TRUE(made);
    for (const auto& entry : std::filesystem::directory_iterator(options.fields_folder))
        EXPECT_EQ(entry.path(), made->entities[0]->field_file);
}

TEST_F(SceneEntitiesTest, TurnedInstancesShareTheEntity) {
    scene.instances[1].placement.rotate = rotation_about({0, 1, 0}, 0.7);
    scene.instances.push_back({"box_3", 0, {{0, 0, 5}, 2, rotation_about({1, 0, 1}, 0.70001)}});
    const auto entities = prepare_scene_entities(scene, options);
    ASSERT_TRUE(entities) << entities.error().message();
    ASSERT_EQ(entities->entities.size(), 1u);
    const ShadedScene shaded = shaded_scene(scene, *entities, {});
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(shaded.instances[i].entity, 0u);
        EXPECT_EQ(shaded.instances[i].placement, scene.instances[i].placement);
    }
}

Shape stretched(double x, double y, double z) {
    return placed_shape({Vec3d(x, 0, 0), Vec3d(0, y, 0), Vec3d(0, 0, z)})->shape;
}

TEST_F(SceneEntitiesTest, EachShapeOfAnEntityHasASeparateField) {
    const Shape flat = stretched(2, 0.5, 1), mirrored = stretched(-1, 1, 1);
    Shape nearly_flat = flat;
    nearly_flat.row[0].y = 1e-6;
    for (const Shape& shape : {flat, mirrored, nearly_flat, mirrored, Shape()})
        scene.instances.push_back({"box", 0, {{0, 0, 5}, 1, rotation_about({1, 0, 1}, 0.3)}, shape});
    const auto first = prepare_scene_entities(scene, options);
    ASSERT_TRUE(first) << first.error().message();
    EXPECT_EQ(first->entity_of_instance, (std::vector<std::size_t>{0, 0, 1, 2, 1, 2, 0}));
    ASSERT_EQ(first->entities.size(), 3u);
    EXPECT_TRUE(first->entities[0]->field_file.filename().string().starts_with("box-"));
    EXPECT_EQ(first->entities[1]->name, "box~" + shape_name(flat));
    EXPECT_NE(first->entities[1]->field_file, first->entities[0]->field_file);
    EXPECT_EQ(first->entities[2]->name, "box~" + shape_name(mirrored));
    const auto extent = [](const Mesh& mesh) { return mesh_bounds(mesh).upper - mesh_bounds(mesh).lower; };
    for (const auto& entity : first->entities)
        EXPECT_GE(entity->mesh.fine.positions.size(), 50u) << "what is wanted of vertices is of every shape";
    EXPECT_EQ(extent(first->entities[0]->mesh.original), Vec3f(1, 1, 2));
    for (const Mesh* mesh : {&first->entities[1]->mesh.original, &first->entities[1]->mesh.fine,
                             &first->entities[1]->mesh.coarse})
        EXPECT_EQ(extent(*mesh), Vec3f(1, 0.25f, 1));
    EXPECT_EQ(mesh_bounds(first->entities[2]->mesh.original).lower.x, -1);
    const auto second = prepare_scene_entities(scene, options);
    ASSERT_TRUE(second) << second.error().message();
    for (const auto& entity : second->entities) EXPECT_TRUE(entity->reused) << entity->name;
}

TEST_F(SceneEntitiesTest, ReportsFindingsOfAMeshOnce) {
    for (const Shape& shape : {stretched(2, 0.5, 1), stretched(-1, 1, 1)})
        scene.instances.push_back({"box", 0, {}, shape});
    options.fields = FieldExtent::none;
    const auto entities = prepare_scene_entities(scene, options);
    ASSERT_TRUE(entities);
    EXPECT_EQ(entities->entities.size(), 3u);
    EXPECT_EQ(entities->warnings.size(), 1u) << "6 n-gons triangulated";
}

TEST_F(SceneEntitiesTest, TrianglesFlattenedByRoundingAreOmitted) {
    // A small step in the middle of a face, which an oblique scale flattens to a single point.
    std::ofstream(folder / "box.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1.00001 0.00001 0\n"
                                         "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 5\nf 5 3 4\nf 2 5 4\n";
    scene.entities[0].materials.clear();
    const Rotation slant = rotation_about({0, 0, 1}, -pi / 4);
    std::array<Vec3d, 3> map;
    for (std::size_t i = 0; i < 3; ++i) map[i] = slant.row[i] * (i == 0 ? 2e-4 : 1);
    scene.instances.resize(1);
    scene.instances[0].shape = placed_shape(map)->shape;
    options.fields = FieldExtent::none;
    const auto entities = prepare_scene_entities(scene, options);
    ASSERT_TRUE(entities) << entities.error().message();
    const PreparedMesh& mesh = entities->entities[0]->mesh;
    EXPECT_EQ(mesh.findings.degenerate_triangles, 2u);
    EXPECT_EQ(mesh.original.triangles.size(), 4u);
    EXPECT_EQ(mesh.findings.boundary_edges, 0u);
}

TEST_F(SceneEntitiesTest, CutOutAreasBlockNoLight) {
    Texture texture = random_texture(16, 16, true);
    const auto write_hole = [&](int texels) {
        for (std::size_t i = 0; i < 256; ++i)
            texture.texels[i][3] = int(i % 16) < texels && int(i / 16) < texels ? 0 : 255;
        write_png(texture, folder / "hole.png");
    };
    std::ofstream(folder / "card.mtl") << "newmtl card\nKd 1 1 1\nmap_Kd hole.png\nmap_d hole.png\n";
    std::ofstream(folder / "box.obj")
        << "mtllib card.mtl\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nvt 0 0\nvt 1 0\n"
           "vt 1 1\nvt 0 1\nusemtl card\nf 1/1 2/2 3/3 4/4\n";
    scene.entities[0].material.clear();
    scene.entities[0].materials.clear();
    const auto open_area = [&] {
        const auto entities = prepare_scene_entities(scene, options);
        EXPECT_TRUE(entities) << entities.error().message();
        EXPECT_FALSE(entities->entities[0]->reused);
        const Occluder& blocking = entities->entities[0]->occlusion->original();
        double area = 0;
        for (const auto& [a, b, c] : blocking.triangles())
            area += 0.5 * double((blocking.positions()[b] - blocking.positions()[a])
                                     .cross(blocking.positions()[c] - blocking.positions()[a])
                                     .length());
        return 16 - area;
    };
    write_hole(8);
    EXPECT_NEAR(open_area(), 4, 0.05);
    write_hole(4);
    EXPECT_NEAR(open_area(), 1, 0.05);
}

TEST_F(SceneEntitiesTest, MaterialsOfTheMeshAreMappedByName) {
    const auto entities = prepare_scene_entities(scene, options);
    ASSERT_TRUE(entities);
    const SceneEntity& entity = *entities->entities[0];
    ASSERT_EQ(entity.materials.size(), entity.mesh.fine.material_names.size());
    bool lid = false;
    for (std::size_t m = 0; m < entity.materials.size(); ++m) {
        lid |= entity.mesh.fine.material_names[m] == "lid";
        EXPECT_EQ(entity.materials[m].diffuse.x, entity.mesh.fine.material_names[m] == "lid" ? 0.9f : 0.2f);
    }
    EXPECT_TRUE(lid);
}

}  // namespace
}  // namespace haarfield
