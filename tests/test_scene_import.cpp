#include "scenes/scene_import.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "fields/model/model_file.h"
#include "scenes/image.h"
#include "scenes/scene_entities.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_writer.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/random_numbers.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

class SceneImportTest : public testing::Test {
protected:
    std::filesystem::path written(const std::string& name, std::string_view text) {
        write_text(folder / name, text);
        return folder / name;
    }
    Result<ImportedScene> imported(const std::filesystem::path& file, const SceneImport& wanted = {}) {
        return scene_of_models({&file, 1}, folder.path(), wanted);
    }
    /// Writes a scene and reads it again.
    Scene read_back(const Scene& scene) {
        const Result<Scene> read =
            read_scene(written("scene.toml", scene_text(scene, folder.path(), "made\nhere")));
        EXPECT_TRUE(read) << read.error().message();
        return read ? *read : Scene{};
    }

    const TestFolder folder;
};

void expect_near(const Vec3f& found, const Vec3f& wanted, float tolerance) {
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(found[axis], wanted[axis], tolerance);
}

/// Returns the world position of a point of an instance's mesh.
Vec3d placed(const Instance& instance, const Vec3d& p) {
    return instance.placement.point_to_world(instance.shape(p));
}

constexpr const char* two_objects =
    "o left\nv 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\no right\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf 5 6 "
    "7\n";

/// A triangle with three placements (translated, rotated about z, mirrored) below a node that scales by 2,
/// and a camera that points down.
constexpr const char* nodes_gltf = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,3,4]}],
"nodes":[{"name":"group","scale":[2,2,2],"children":[1,2]},{"name":"first","mesh":0,"translation":[1,2,3]},
{"name":"second","mesh":0,"rotation":[0,0,0.7071067811865476,0.7071067811865476]},
{"name":"third","mesh":0,"scale":[-1,1,0.5]},
{"name":"eye","camera":0,"translation":[0,10,0],"rotation":[-0.7071067811865476,0,0,0.7071067811865476]}],
"cameras":[{"type":"perspective","perspective":{"yfov":0.6,"aspectRatio":1.5,"znear":0.1}}],
"meshes":[{"name":"leaf","primitives":[{"attributes":{"POSITION":0}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";

TEST_F(SceneImportTest, NodesBecomeInstancesThatShareEntities) {
    const Result<ImportedScene> result = imported(written("leaves.gltf", nodes_gltf));
    ASSERT_TRUE(result) << result.error().message();
    const Scene& scene = result->scene;
    ASSERT_EQ(scene.entities.size(), 1u);
    EXPECT_EQ(scene.entities[0].mesh, folder / "leaves.gltf");
    EXPECT_EQ(scene.entities[0].part, "leaf");
    ASSERT_EQ(scene.instances.size(), 3u);
    EXPECT_EQ(scene.instances[0].name, "first");
    EXPECT_EQ(scene.instances[2].name, "third");
    const Vec3d p(0.25, 0.5, 0);
    const std::array<Vec3d, 3> wanted{(p + Vec3d(1, 2, 3)) * 2, Vec3d(-p.y, p.x, 0) * 2, Vec3d(-p.x, p.y, 0)};
    for (std::size_t i = 0; i < 3; ++i)
        expect_near(Vec3f(placed(scene.instances[i], p)), Vec3f(wanted[i]), 1e-5f);
    EXPECT_FALSE(scene.finds_camera);
    expect_near(scene.camera.position, {0, 10, 0}, 1e-5f);
    const Vec3f ahead = (scene.camera.target - scene.camera.position).normalized();
    expect_near(ahead, {0, -1, 0}, 1e-5f);
    EXPECT_NEAR(scene.camera.vertical_fov, 0.6, 1e-5);

    // The written file describes the same scene, and its parts can be loaded.
    const Scene again = read_back(scene);
    ASSERT_EQ(again.instances.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i)
        expect_near(Vec3f(placed(again.instances[i], p)), Vec3f(wanted[i]), 1e-5f);
    SceneEntityOptions options;
    options.fields = FieldExtent::none;
    const Result<SceneEntities> entities = prepare_scene_entities(again, options);
    ASSERT_TRUE(entities) << entities.error().message();
    EXPECT_EQ(entities->entities.size(), 2u) << "one of them is mirrored and flattened";
}

TEST_F(SceneImportTest, WritesKeyframesAsTheyAre) {
    const Result<ImportedScene> result = imported(written("leaves.gltf", nodes_gltf));
    ASSERT_TRUE(result) << result.error().message();
    Scene scene = result->scene;
    scene.keyframes = {{1, 1, Vec3f(1, 2, 3), {}, {}}, {2, 1, {}, Vec3f(0, 0.5f, 0), 0.25f}};
    const Scene again = read_back(scene);
    ASSERT_EQ(again.keyframes.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(again.keyframes[i].instance, 1u);
        EXPECT_EQ(again.keyframes[i].time, scene.keyframes[i].time);
        EXPECT_EQ(again.keyframes[i].translate, scene.keyframes[i].translate);
        EXPECT_EQ(again.keyframes[i].scale, scene.keyframes[i].scale);
    }
    EXPECT_EQ(again.keyframes[0].rotate, std::nullopt);
    EXPECT_NEAR(again.keyframes[1].rotate->y, 0.5, 1e-6);
}

TEST_F(SceneImportTest, UntransformedPartsAreOneEntity) {
    const std::filesystem::path file = written("pair.obj", two_objects);
    const Result<ImportedScene> result = imported(file);
    ASSERT_TRUE(result) << result.error().message();
    ASSERT_EQ(result->scene.entities.size(), 1u);
    EXPECT_EQ(result->scene.entities[0].part, "");
    EXPECT_EQ(result->scene.instances.size(), 1u);
    EXPECT_TRUE(result->scene.finds_camera);
    EXPECT_FALSE(result->scene.environment.exposure);
    const Result<ImportedScene> whole = imported(written("leaves.gltf", nodes_gltf), {.whole = true});
    ASSERT_TRUE(whole) << whole.error().message();
    EXPECT_EQ(whole->scene.entities.size(), 1u);
    EXPECT_EQ(whole->scene.entities[0].part, "");
    EXPECT_EQ(whole->scene.instances.size(), 1u);
}

TEST_F(SceneImportTest, TurnsAndScalesAllOfThem) {
    const std::filesystem::path file = written("pair.obj", two_objects);
    const Vec3d p(5, 0.5, 0.25);
    const Result<ImportedScene> upright = imported(file, {.z_up = true, .unit = 0.01});
    ASSERT_TRUE(upright) << upright.error().message();
    expect_near(Vec3f(placed(upright->scene.instances[0], p)), {0.05f, 0.0025f, -0.005f}, 1e-7f);
    const Result<ImportedScene> sized = imported(file, {.size = 3.0});  // the model is 6 units wide
    ASSERT_TRUE(sized) << sized.error().message();
    expect_near(Vec3f(placed(sized->scene.instances[0], p)), Vec3f(p * 0.5), 1e-6f);
}

TEST_F(SceneImportTest, TheFloorLiesBelow) {
    const Result<ImportedScene> result =
        imported(written("pair.obj", two_objects), {.z_up = false, .unit = 2, .floor = true});
    ASSERT_TRUE(result) << result.error().message();
    ASSERT_EQ(result->scene.entities.size(), 4u);
    write_text(folder / "floor.obj", result->floor_obj);
    SceneEntityOptions options;
    options.fields = FieldExtent::none;
    const Result<SceneEntities> entities = prepare_scene_entities(read_back(result->scene), options);
    ASSERT_TRUE(entities) << entities.error().message();
    for (const std::string& warning : entities->warnings)
        EXPECT_EQ(warning.find("floor.obj"), std::string::npos) << warning;
    const Bounds floor = mesh_bounds(entities->entities[1]->mesh.original);
    EXPECT_EQ(floor.lower.y, 0);
    EXPECT_EQ(floor.upper.y, 0);
    EXPECT_LT(floor.lower.x, -1);
    EXPECT_GT(floor.upper.x, 13);
    EXPECT_GT(entities->entities[1]->mesh.original.normals[0].y, 0);
    // The ground continues from the edge of the floor to the horizon.
    const Mesh ground =
        joined_meshes(entities->entities[2]->mesh.original, entities->entities[3]->mesh.original);
    const Bounds around = mesh_bounds(ground);
    const float width = floor.upper.x - floor.lower.x;
    EXPECT_GT(around.upper.x - around.lower.x, 100 * width);
    EXPECT_EQ(around.lower.y, 0);
    EXPECT_EQ(around.upper.y, 0);
    for (const Vec3f& normal : ground.normals) EXPECT_GT(normal.y, 0.99f);
    double area = 0;
    for (const auto& [a, b, c] : ground.triangles) {
        const Vec3d p(ground.positions[a]);
        area += (Vec3d(ground.positions[b]) - p).cross(Vec3d(ground.positions[c]) - p).length() / 2;
    }
    const double outer = double(around.upper.x - around.lower.x);
    EXPECT_NEAR(area, outer * outer - double(width) * double(width), 1e-4 * outer * outer)
        << "no hole, no overlap";
    const auto spacing = [&](std::size_t entity) {
        const Mesh& fine = entities->entities[entity]->mesh.fine;
        double longest = 0;
        for (const auto& [a, b, c] : fine.triangles)
            longest = std::max(longest, double((fine.positions[b] - fine.positions[a]).length()));
        return longest;
    };
    EXPECT_LT(spacing(1), 0.02 * 12) << "vertices are dense below the models";
    EXPECT_LT(spacing(1), 0.5 * spacing(2));
}

TEST_F(SceneImportTest, TheFloorIsAsBrightAsTheEnvironmentBelowTheHorizon) {
    // A floor of albedo a under a uniform radiance L reflects a L.
    const Result<ImportedScene> sky = imported(written("pair.obj", two_objects), {.floor = true});
    ASSERT_TRUE(sky) << sky.error().message();
    EXPECT_EQ(sky->scene.materials.at("floor").diffuse, sky->scene.environment.sky->ground);
    Image image{64, 32, std::vector<Rgb>(64 * 32, Rgb(1.0f)), {}, {}};
    std::fill(image.pixels.begin() + 64 * 16, image.pixels.end(), Rgb(0.5f, 0.25f, 0.125f));
    ASSERT_TRUE(write_image(image, folder / "meadow.exr"));
    const Result<ImportedScene> meadow =
        imported(written("pair.obj", two_objects), {.floor = true, .environment = folder / "meadow.exr"});
    ASSERT_TRUE(meadow) << meadow.error().message();
    EXPECT_EQ(meadow->scene.environment.image, folder / "meadow.exr");
    expect_near(meadow->scene.materials.at("floor").diffuse, {0.5f, 0.25f, 0.125f}, 0.005f);
}

TEST_F(SceneImportTest, ModelsThatOverlapArePlacedSideBySide) {
    const auto box = [](const char* at) {
        return fmt::format("v 0 {0} 0\nv 1 {0} 0\nv 0 {0} 1\nv 0 2 0\nf 1 2 3\nf 1 2 4\nf 1 3 4\n", at);
    };
    const std::vector<std::filesystem::path> files{written("a.obj", box("0")), written("b.obj", box("-1"))};
    const auto placed_at = [&](const SceneImport& wanted, std::vector<std::string>& warnings) {
        const Result<ImportedScene> result = scene_of_models(files, folder.path(), wanted);
        EXPECT_TRUE(result) << result.error().message();
        warnings = result->warnings;
        return std::pair(result->scene.instances[0].placement.translate,
                         result->scene.instances[1].placement.translate);
    };
    std::vector<std::string> warnings;
    const auto [first, second] = placed_at({}, warnings);
    expect_near(first, {0, 0, 0}, 1e-6f);
    expect_near(second, {1.1f, 1, 0}, 1e-6f);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("b.obj overlaps "), std::string::npos) << warnings[0];
    const auto [kept_first, kept_second] = placed_at({.keep_places = true}, warnings);
    expect_near(kept_first, {0, 0, 0}, 0);
    expect_near(kept_second, {0, 0, 0}, 0);
    EXPECT_TRUE(warnings.empty());
    written("b.obj", "v 5 0 0\nv 6 0 0\nv 5 1 0\nf 1 2 3\n");
    EXPECT_EQ(placed_at({}, warnings).second, Vec3f(0, 0, 0)) << "they do not overlap";
    EXPECT_TRUE(warnings.empty());
}

/// Returns a mesh at <1, 2, 3> and a light at <4, 5, 6> in POV-Ray's coordinates.
std::string povray_file(const std::string& camera) {
    return "camera { location <0, 1, -3> " + camera +
           " }\nlight_source { <4, 5, 6> rgb 1 }\nmesh2 { vertex_vectors { 3, <1, 2, 3>, <2, 2, 3>, "
           "<1, 3, 3> } face_indices { 1, <0, 1, 2> } }\n";
}

TEST_F(SceneImportTest, LeftHandedFilesAreMirrored) {
    const auto places = [&](const std::string& text, const SceneImport& wanted) {
        const Result<ImportedScene> result = imported(written("own.pov", text), wanted);
        EXPECT_TRUE(result) << result.error().message();
        const Scene scene = read_back(result->scene);
        return std::pair(Vec3f(placed(scene.instances.at(0), {1, 2, 3})), scene.lamps.at(0).position);
    };
    const std::string usual = povray_file("right x*1.333"), right_handed = povray_file("right -x*1.333");
    const auto [mesh, light] = places(usual, {});
    expect_near(mesh, {1, 2, -3}, 1e-5f);
    expect_near(light, {4, 5, -6}, 1e-5f);
    const auto [upright_mesh, upright_light] = places(usual, {.z_up = true});
    expect_near(upright_mesh, {1, 3, 2}, 1e-5f);
    expect_near(upright_light, {4, 6, 5}, 1e-5f);
    for (const std::string& text :
         {right_handed, povray_file("up y right <-1.333, 0, 0>"),
          "// x.inc: x, baked by haarfield.\n// linear radiance, right-handed, +y up, metres.\n\n" + usual}) {
        expect_near(places(text, {}).first, {1, 2, 3}, 0);
        expect_near(places(text, {}).second, {4, 5, 6}, 0);
    }
}

TEST_F(SceneImportTest, RoomsEncloseModelsInAnyUnit) {
    // A cube from 10 to 12 along x that faces inwards, with a triangle inside.
    const std::vector<std::filesystem::path> files{
        written("room.obj",
                "v 10 0 0\nv 12 0 0\nv 12 2 0\nv 10 2 0\nv 10 0 2\nv 12 0 2\nv 12 2 2\nv 10 2 2\n"
                "f 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 4 3 7 8\nf 1 4 8 5\nf 2 6 7 3\n"),
        written("chair.obj", "v 10.9 0.9 1\nv 11.1 0.9 1\nv 11 1.1 1\nf 1 2 3\n")};
    for (const double unit : {1.0, 10.0}) {
        const Result<ImportedScene> result =
            scene_of_models(files, folder.path(), {.unit = unit, .keep_places = true});
        ASSERT_TRUE(result) << result.error().message();
        EXPECT_EQ(result->scene.entities[0].faces, ClosedFaces::inwards) << unit;
    }
}

TEST_F(SceneImportTest, UnitsThatDoNotFitAreReported) {
    const std::filesystem::path file = written("pair.obj", two_objects);
    const Result<ImportedScene> tiny = imported(file, {.unit = 0.0001});
    ASSERT_TRUE(tiny) << tiny.error().message();
    ASSERT_EQ(tiny->warnings.size(), 1u);
    EXPECT_NE(tiny->warnings[0].find("applied twice"), std::string::npos) << tiny->warnings[0];
    const std::vector<std::filesystem::path> files{
        file, written("large.obj", "v 0 0 100\nv 6000 0 100\nv 0 1 100\nf 1 2 3\n")};
    const Result<ImportedScene> both = scene_of_models(files, folder.path(), {});
    ASSERT_TRUE(both) << both.error().message();
    ASSERT_EQ(both->warnings.size(), 1u);
    EXPECT_NE(both->warnings[0].find("1000 times as large"), std::string::npos) << both->warnings[0];
}

TEST_F(SceneImportTest, AWrongPartIsAnErrorThatListsThem) {
    Scene scene = imported(written("pair.obj", two_objects))->scene;
    scene.entities[0].part = "middle";
    SceneEntityOptions options;
    options.fields = FieldExtent::none;
    const Result<SceneEntities> entities = prepare_scene_entities(scene, options);
    ASSERT_FALSE(entities);
    EXPECT_NE(entities.error().message().find("no part \"middle\""), std::string::npos);
    EXPECT_NE(entities.error().message().find("\"left\", \"right\""), std::string::npos)
        << entities.error().message();
    scene.entities[0].part = "right";
    const Result<SceneEntities> right = prepare_scene_entities(scene, options);
    ASSERT_TRUE(right) << right.error().message();
    EXPECT_EQ(right->entities[0]->mesh.original.triangles.size(), 1u);
}

TEST_F(SceneImportTest, EveryKeyOfASceneIsWrittenAndReadBack) {
    Scene scene;
    written("a.obj", two_objects);
    written("a.png", "an image");
    written("a.exr", "an environment");
    scene.camera = {{1, 2, 3}, {0.5f, 0.25f, -7}, 0.7f, 320, 200};
    scene.environment.image = folder / "a.exr";
    scene.environment.rotation = 1.2f;
    scene.environment.exposure = -1.5f;
    SceneMaterial physical;
    physical.diffuse = Rgb(0.1f, 0.2f, 0.3f);
    physical.specular = Rgb(0.4f, 0.5f, 0.6f);
    physical.shininess = 33;
    physical.image = folder / "a.png";
    physical.emission = Rgb(1, 2, 3);
    SceneMaterial finish;
    finish.convention = LobeConvention::povray;
    finish.pigment = Rgb(0.5f, 1, 0.25f);
    finish.diffuse = finish.pigment * 0.5f;
    finish.emission = finish.pigment * 3.0f;
    finish.specular = Rgb(1.0f);
    finish.phong = 0.5f;
    finish.shininess = 20;
    finish.blinn = 0.25f;
    finish.roughness = 0.01f;
    finish.metallic = 0.5f;
    SceneMaterial tinted = physical;
    tinted.convention = LobeConvention::povray;
    scene.materials = {{"a b\"c", physical}, {"finish", finish}, {"tinted", tinted}};
    Entity entity;
    entity.name = "left one";
    entity.mesh = folder / "a.obj";
    entity.part = "le\\ft\n";
    entity.material = "finish";
    entity.materials = {{"x \"y\"", "a b\"c"}};
    entity.faces = ClosedFaces::inwards;
    entity.fine_vertices = 123;
    entity.coarse_triangles = 0;
    entity.planar_samples = 50;
    entity.spherical_samples = 60;
    scene.entities = {entity};
    Instance instance;
    instance.name = "Jörg's";
    instance.placement = {{1, -2, 0.1f}, 0.3f, rotation_xyz({0.3f, -1.1f, 2})};
    scene.instances = {instance};
    const Scene read = read_back(scene);
    EXPECT_EQ(read.camera.position, scene.camera.position);
    EXPECT_EQ(read.camera.target, scene.camera.target);
    EXPECT_NEAR(read.camera.vertical_fov, 0.7, 1e-6);
    EXPECT_EQ(read.camera.width, 320);
    EXPECT_EQ(read.camera.height, 200);
    EXPECT_FALSE(read.finds_camera);
    EXPECT_TRUE(std::filesystem::equivalent(read.environment.image, scene.environment.image));
    EXPECT_NEAR(read.environment.rotation, 1.2, 1e-6);
    EXPECT_EQ(read.environment.exposure, -1.5f);
    ASSERT_EQ(read.materials.size(), 3u);
    for (const auto& [name, material] : scene.materials) {
        ASSERT_TRUE(read.materials.contains(name)) << name;
        const SceneMaterial& found = read.materials.at(name);
        EXPECT_EQ(found.convention, material.convention) << name;
        expect_near(found.diffuse, material.diffuse, 1e-6f);
        expect_near(found.specular, material.specular, 1e-6f);
        expect_near(found.emission, material.emission, 1e-5f);
        EXPECT_EQ(found.shininess, material.shininess);
        EXPECT_EQ(found.phong, material.phong);
        EXPECT_EQ(found.blinn, material.blinn);
        EXPECT_EQ(found.metallic, material.metallic);
        EXPECT_EQ(found.image.empty(), material.image.empty());
    }
    ASSERT_EQ(read.entities.size(), 1u);
    const Entity& back = read.entities[0];
    EXPECT_EQ(back.name, entity.name);
    EXPECT_EQ(back.part, entity.part);
    EXPECT_EQ(back.material, entity.material);
    EXPECT_EQ(back.materials, entity.materials);
    EXPECT_EQ(back.faces, ClosedFaces::inwards);
    EXPECT_EQ(back.fine_vertices, 123u);
    EXPECT_EQ(back.coarse_triangles, 0u);
    EXPECT_EQ(back.planar_samples, 50u);
    EXPECT_EQ(back.spherical_samples, 60u);
    ASSERT_EQ(read.instances.size(), 1u);
    EXPECT_EQ(read.instances[0].name, instance.name);
    std::mt19937 random(2);
    for (int k = 0; k < 20; ++k) {
        const Vec3d p(random_direction(random));
        expect_near(Vec3f(placed(read.instances[0], p)), Vec3f(placed(instance, p)), 1e-6f);
    }

    Scene sky;
    sky.finds_camera = true;
    sky.environment.sky = AnalyticSky();
    sky.environment.sky->turbidity = 4;
    sky.environment.exposure.reset();
    entity.part.clear();
    entity.material.clear();
    entity.materials.clear();
    sky.entities = {entity};
    sky.instances = {instance};
    const Scene clear = read_back(sky);
    EXPECT_TRUE(clear.finds_camera);
    EXPECT_FALSE(clear.environment.exposure);
    ASSERT_TRUE(clear.environment.sky);
    EXPECT_EQ(clear.environment.sky->turbidity, 4);
    EXPECT_NEAR(clear.environment.sky->sun_elevation, sky.environment.sky->sun_elevation, 1e-6);
}

}  // namespace
}  // namespace haarfield
