#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "fields/mesh/closed_pieces.h"
#include "fields/mesh/mesh_topology.h"
#include "fields/occluder/occluder.h"
#include "fields/preparation/mesh_preparation.h"
#include "fields/preparation/sheet_backs.h"
#include "scenes/scene_camera.h"
#include "scenes/scene_entities.h"
#include "scenes/scene_import.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_shading.h"
#include "scenes/scene_writer.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

enum class Facing : std::uint8_t { outwards, inwards };

/// Meshes of boxes whose sides share no vertices.
class Boxes {
public:
    Boxes& add(const Vec3f& lower, const Vec3f& upper, Facing facing = Facing::outwards) {
        Mesh box = box_mesh(lower, upper, 2);
        if (facing == Facing::inwards) {
            for (auto& t : box.triangles) std::swap(t[1], t[2]);
            for (Vec3f& normal : box.normals) normal = -normal;
        }
        mesh = mesh.triangles.empty() ? box : joined_meshes(mesh, box);
        return *this;
    }
    /// Returns an OBJ file without normals, so that faces determine the orientation.
    std::string obj(std::uint32_t first = 0) const {
        std::string text;
        for (const Vec3f& p : mesh.positions) text += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
        for (const auto& [a, b, c] : mesh.triangles)
            text += fmt::format("f {} {} {}\n", first + a + 1, first + b + 1, first + c + 1);
        return text;
    }

    Mesh mesh;
};

constexpr Vec3f low{-2, 0, -2}, high{2, 3, 2};

Boxes room() {
    return Boxes().add(low, high, Facing::inwards);
}

/// Returns a room with a block on its floor.
Boxes furnished() {
    return room().add({-0.5f, 0, -0.5f}, {0.5f, 1, 0.5f});
}

/// An L-shaped room: the centre of its bounding box is a corner of the room. Faces point inwards.
constexpr const char* l_shape =
    "v 0 0 0\nv 6 0 0\nv 6 0 3\nv 3 0 3\nv 3 0 6\nv 0 0 6\n"
    "v 0 3 0\nv 6 3 0\nv 6 3 3\nv 3 3 3\nv 3 3 6\nv 0 3 6\n"
    "f 6 5 4 1\nf 4 3 2 1\nf 7 10 11 12\nf 7 8 9 10\n"
    "f 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";

/// A room of 4 x 3 x 4 m with a window of 2 x 1 m in the wall at z = -2. Faces point inwards.
constexpr const char* with_window =
    "v -2 0 -2\nv 2 0 -2\nv 2 3 -2\nv -2 3 -2\nv -2 0 2\nv 2 0 2\nv 2 3 2\nv -2 3 2\n"
    "v -1 1 -2\nv 1 1 -2\nv 1 2 -2\nv -1 2 -2\n"
    "f 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n"
    "f 1 2 10 9\nf 2 3 11 10\nf 3 4 12 11\nf 4 1 9 12\n";

PreparedMesh prepared(const Mesh& mesh, ClosedFaces faces, std::uint32_t coarse_triangles = 0) {
    ImportedMesh imported;
    imported.mesh = mesh;
    return *prepare_mesh(std::move(imported), {.coarse_triangles = coarse_triangles, .faces = faces});
}

/// Returns the winding number of a mesh around a point.
double winding(const Mesh& mesh, const Vec3f& point) {
    return winding_number(mesh.positions, mesh.triangles, Vec3d(point));
}

TEST(WindingNumber, TellsInsideFromOutsideAndTheWayThatFacesTurn) {
    EXPECT_NEAR(winding(Boxes().add(low, high).mesh, {0.3f, 1, 0.2f}), 1, 1e-6);
    EXPECT_NEAR(winding(room().mesh, {0.3f, 1, 0.2f}), -1, 1e-6);
    EXPECT_NEAR(winding(room().mesh, {0.3f, 4, 0.2f}), 0, 1e-6);
}

TEST(ClosedFaces, SolidsThatAreInsideOutAreTurnedUnlessTheyAreRooms) {
    for (const std::uint32_t coarse : {0u, 40u}) {
        const PreparedMesh solid = prepared(room().mesh, ClosedFaces::outwards, coarse),
                           kept = prepared(room().mesh, ClosedFaces::inwards, coarse);
        EXPECT_NEAR(winding(solid.original, {0, 1, 0}), 1, 1e-6);
        EXPECT_NEAR(winding(solid.coarse, {0, 1, 0}), 1, 1e-6);
        EXPECT_NEAR(winding(kept.original, {0, 1, 0}), -1, 1e-6);
        EXPECT_NEAR(winding(kept.coarse, {0, 1, 0}), -1, 1e-6);
        for (std::size_t v = 0; v < kept.original.positions.size(); ++v)
            EXPECT_LT(kept.original.normals[v].dot(kept.original.positions[v] - Vec3f(0, 1.5f, 0)), 0);
    }
}

TEST(ClosedFaces, FurnitureOfARoomFacesOutwards) {
    const PreparedMesh kept = prepared(furnished().mesh, ClosedFaces::inwards);
    EXPECT_NEAR(winding(kept.original, {1, 2, 1}), -1, 1e-6);
    EXPECT_NEAR(winding(kept.original, {0, 0.5f, 0}), 0, 1e-6) << "room and block";
    EXPECT_EQ(make_occluder(kept.original).one_sided(), 48u) << "the block";
}

TEST(ClosedFaces, WithoutAnyRoomTheOutermostPiecesAreTurned) {
    Boxes boxes;
    boxes.add(low, high).add({-0.5f, 0, -0.5f}, {0.5f, 1, 0.5f});
    const PreparedMesh turned = prepared(boxes.mesh, ClosedFaces::inwards);
    EXPECT_NEAR(winding(turned.original, {1, 2, 1}), -1, 1e-6);
    EXPECT_NEAR(winding(turned.original, {0, 0.5f, 0}), 0, 1e-6);
    const PreparedMesh again = prepared(turned.original, ClosedFaces::inwards);
    EXPECT_EQ(again.original.triangles, turned.original.triangles);
}

TEST(Occluder, TheCavityOfASolidIsNotInside) {
    Boxes walls;
    walls.add({-2.2f, -0.2f, -2.2f}, {2.2f, 3.2f, 2.2f}).add(low, high, Facing::inwards);
    const Occluder occluder = make_occluder(walls.mesh);
    EXPECT_EQ(occluder.one_sided(), occluder.triangles().size());
    const InsideTest is_inside(occluder);
    EXPECT_FALSE(is_inside({0.1f, 1, 0.2f}));
    EXPECT_TRUE(is_inside({0.1f, 1, 2.1f}));
    EXPECT_FALSE(is_inside({0.1f, 1, 2.3f}));
}

TEST(SheetBacks, ARoomWithoutWallsHasThemWhereItIsVisibleFromOutside) {
    const Mesh backs = seen_backs(room().mesh, room().mesh);
    EXPECT_EQ(backs.triangles.size(), 40u) << "all sides but the floor";
    const Mesh nested = furnished().add({1, 0.5f, 1}, {1.5f, 1, 1.5f}, Facing::inwards).mesh;
    EXPECT_EQ(seen_backs(nested, nested).triangles.size(), 88u)
        << "including all six sides of the inner room";
}

class ImportedRooms : public testing::Test {
protected:
    std::filesystem::path written(const std::string& name, std::string_view text) {
        write_text(folder / name, text);
        return folder / name;
    }
    /// Returns the value for each entity.
    std::vector<ClosedFaces> faces(const std::vector<std::filesystem::path>& files) {
        const Result<ImportedScene> imported = scene_of_models(files, folder.path(), {});
        EXPECT_TRUE(imported) << imported.error().message();
        std::vector<ClosedFaces> found;
        for (const Entity& entity : imported->scene.entities) found.push_back(entity.faces);
        return found;
    }
    ClosedFaces faces(const Boxes& boxes) { return faces({written("boxes.obj", boxes.obj())}).at(0); }

    const TestFolder folder;
};

TEST_F(ImportedRooms, FaceInwards) {
    constexpr auto outwards = ClosedFaces::outwards, inwards = ClosedFaces::inwards;
    EXPECT_EQ(faces(room()), inwards);
    EXPECT_EQ(faces(furnished()), inwards);
    EXPECT_EQ(faces(room().add({1, 1, 1}, {1.5f, 2, 1.5f}, Facing::inwards)), inwards)
        << "a room inside a room";
    Boxes walls;
    walls.add({-2.2f, -0.2f, -2.2f}, {2.2f, 3.2f, 2.2f}).add(low, high, Facing::inwards);
    EXPECT_EQ(faces(walls), inwards) << "walls with a thickness";
    Boxes rooms;
    rooms.add(low, high, Facing::inwards).add({2.1f, 0, -2}, {5, 3, 2}, Facing::inwards);
    rooms.add({3, 1, 0}, {3.5f, 1.5f, 1});
    EXPECT_EQ(faces(rooms), inwards) << "one of two rooms contains an object";

    EXPECT_EQ(faces({written("l.obj", l_shape)}).at(0), inwards) << "an empty L-shaped room";

    EXPECT_EQ(faces(Boxes().add(low, high)), outwards) << "a solid";
    Boxes chair;  // inside out by mistake: none of its pieces is a room
    chair.add({-0.5f, 1, -0.5f}, {0.5f, 1.1f, 0.5f}, Facing::inwards);
    chair.add({-0.5f, 0, -0.5f}, {-0.4f, 1, -0.4f}, Facing::inwards);
    EXPECT_EQ(faces(chair), outwards);
    Boxes nested;  // a solid inside a solid
    nested.add(low, high).add({-0.5f, 0.5f, -0.5f}, {0.5f, 1, 0.5f});
    EXPECT_EQ(faces(nested), outwards);
    Boxes lid;  // a box with a lid
    lid.add(low, high).add({-2, 3, -2}, {2, 3.1f, 2});
    EXPECT_EQ(faces(lid), outwards);
}

TEST_F(ImportedRooms, TheContentsMayBeInAnotherFile) {
    Boxes two;  // neither is as large as both together
    two.add(low, high, Facing::inwards).add({4, 0, -2}, {7, 3, 2}, Facing::inwards);
    const auto house = written("house.obj", two.obj());
    EXPECT_EQ(faces({house}).at(0), ClosedFaces::outwards);
    const auto table = written("table.obj", Boxes().add({5, 0, 0}, {6, 1, 1}).obj());
    const Result<ImportedScene> both =
        scene_of_models(std::vector{house, table}, folder.path(), {.keep_places = true});
    ASSERT_TRUE(both) << both.error().message();
    EXPECT_EQ(both->scene.entities[0].faces, ClosedFaces::inwards);
    EXPECT_EQ(both->scene.entities[1].faces, ClosedFaces::outwards);
}

TEST_F(ImportedRooms, TheCameraStandsInARoomThatEnclosesEverything) {
    const std::filesystem::path file = written("room.obj", furnished().obj());
    const Result<ImportedScene> inside = scene_of_models({&file, 1}, folder.path(), {.floor = true});
    ASSERT_TRUE(inside) << inside.error().message();
    const Scene& scene = inside->scene;
    EXPECT_FALSE(scene.finds_camera);
    EXPECT_TRUE(contains({low, high}, {scene.camera.position, scene.camera.position}));
    EXPECT_TRUE(contains({low, high}, {scene.camera.target, scene.camera.target}));
    ASSERT_EQ(scene.lamps.size(), 1u) << "nothing else emits light";
    EXPECT_TRUE(contains({low, high}, {scene.lamps[0].position, scene.lamps[0].position}));
    EXPECT_EQ(scene.entities.size(), 1u) << "no floor is added below that of the room";
    EXPECT_EQ(inside->warnings.size(), 2u);

    const std::filesystem::path solid = written("solid.obj", Boxes().add(low, high).obj());
    const Result<ImportedScene> outside = scene_of_models({&solid, 1}, folder.path(), {});
    ASSERT_TRUE(outside) << outside.error().message();
    EXPECT_TRUE(outside->scene.finds_camera);
    EXPECT_TRUE(outside->scene.lamps.empty());
}

TEST_F(ImportedRooms, TheCameraStandsInARoomWithAWindow) {
    const std::filesystem::path file =
        written("window.obj", with_window + Boxes().add({-0.5f, 0, 0}, {0.5f, 0.7f, 1}).obj(12));
    const Result<ImportedScene> imported = scene_of_models({&file, 1}, folder.path(), {.floor = true});
    ASSERT_TRUE(imported) << imported.error().message();
    const Scene& scene = imported->scene;
    EXPECT_FALSE(scene.finds_camera);
    EXPECT_TRUE(contains({low, high}, {scene.camera.position, scene.camera.position}));
    EXPECT_TRUE(scene.lamps.empty()) << "the window lets light in";
    EXPECT_TRUE(scene.environment.sky);
    EXPECT_EQ(scene.entities.size(), 1u) << "no floor is added below that of the room";

    std::string outwards = with_window;  // a house whose fronts face outwards
    for (const char* face : {"f 5 8 7 6", "f 1 5 6 2", "f 2 6 7 3", "f 3 7 8 4", "f 4 8 5 1", "f 1 2 10 9",
                             "f 2 3 11 10", "f 3 4 12 11", "f 4 1 9 12"}) {
        std::istringstream numbers(std::string(face).substr(2));
        std::array<int, 4> v{};
        for (int& number : v) numbers >> number;
        outwards.replace(outwards.find(face), std::string_view(face).size(),
                         fmt::format("f {} {} {} {}", v[3], v[2], v[1], v[0]));
    }
    const std::filesystem::path house = written("house.obj", outwards);
    const Result<ImportedScene> outside = scene_of_models({&house, 1}, folder.path(), {});
    ASSERT_TRUE(outside) << outside.error().message();
    EXPECT_TRUE(outside->scene.finds_camera);
}

TEST_F(ImportedRooms, TheCameraStandsInARoomWhoseMiddleIsACorner) {
    const std::filesystem::path file = written("l.obj", l_shape);
    const Result<ImportedScene> imported = scene_of_models({&file, 1}, folder.path(), {});
    ASSERT_TRUE(imported) << imported.error().message();
    const Vec3f eye = imported->scene.camera.position;
    EXPECT_FALSE(imported->scene.finds_camera);
    EXPECT_TRUE(eye.x > 0 && eye.z > 0 && eye.x < 6 && eye.z < 6 && (eye.x < 3 || eye.z < 3))
        << eye.x << " " << eye.z;
    ASSERT_EQ(imported->scene.lamps.size(), 1u);
    const Vec3f lamp = imported->scene.lamps[0].position;
    EXPECT_TRUE(lamp.x < 3 || lamp.z < 3) << lamp.x << " " << lamp.z;
}

/// A light in a room, and the camera.
constexpr const char* lit_room = R"(
[camera]
position = [1.5, 1.5, 1.5]
target = [0, 0.5, 0]
[[lights]]
kind = "point"
position = [0.3, 2.5, 0.4]
fade_distance = 1
[[instances]]
entity = "room"
[entities.room]
mesh = "room.obj"
fine_vertices = 1500
planar_samples = 20
spherical_samples = 20
)";

class LitRoom : public ImportedRooms {
protected:
    struct Baked {
        std::vector<std::string> warnings;
        /// Positions and radiance of all vertices of the room's inside and of the block.
        std::vector<std::pair<Vec3f, float>> radiance;
    };
    Baked baked(const std::string& obj, const std::string& key) {
        written("room.obj", obj);
        const Result<Scene> scene = read_scene(written("room.toml", lit_room + key));
        EXPECT_TRUE(scene) << scene.error().message();
        const Result<SceneEntities> entities = prepare_scene_entities(*scene, {});
        EXPECT_TRUE(entities) << entities.error().message();
        const ShadedScene shaded =
            shaded_scene(*scene, *entities, Environment(LatLongImage{4, 2, std::vector<Rgb>(8, Rgb(1.0f))}));
        const Result<SceneRadiance> radiance = scene_radiance(shaded, {});
        EXPECT_TRUE(radiance) << radiance.error().message();
        Baked result{camera_troubles(*scene, *entities), {}};
        const Mesh& mesh = entities->entities[0]->mesh.fine;
        for (std::size_t v = 0; v < mesh.positions.size(); ++v)
            if ((mesh.positions[v] + mesh.normals[v] * 0.01f - Vec3f(0, 1.5f, 0)).length2() <
                (mesh.positions[v] - Vec3f(0, 1.5f, 0)).length2())
                result.radiance.emplace_back(mesh.positions[v], luminance((*radiance)[0][v].total()));
        return result;
    }
    /// Returns the mean over the floor.
    static double mean_of_floor(const Baked& baked) {
        double sum = 0, count = 0;
        for (const auto& [position, radiance] : baked.radiance)
            if (std::abs(position.y) < 0.01f) sum += double(radiance), ++count;
        return count > 0 ? sum / count : 0;
    }
};

TEST_F(LitRoom, IsLitAsWallsThatDoNotMeetAre) {
    // Six sheets: an open mesh, in which each sheet faces as its normals do.
    const Mesh mesh = room().mesh;
    std::string sheets = room().obj();
    std::string apart, line;
    std::size_t vertex = 0;
    for (std::size_t at = 0; at < sheets.size(); at = sheets.find('\n', at) + 1) {
        line = sheets.substr(at, sheets.find('\n', at) + 1 - at);
        if (line[0] == 'v') {
            const Vec3f p = mesh.positions[vertex] + mesh.normals[vertex] * (-1e-3f);
            line = fmt::format("v {} {} {}\n", p.x, p.y, p.z);
            ++vertex;
        }
        apart += line;
    }
    const std::string block = Boxes().add({-0.5f, 0.2f, -0.5f}, {0.5f, 1, 0.5f}).obj(std::uint32_t(vertex));
    const Baked open = baked(apart + block, ""), closed = baked(sheets + block, "faces = \"inwards\"\n");
    EXPECT_EQ(closed.warnings, std::vector<std::string>{});
    EXPECT_GT(mean_of_floor(open), 0.01);
    EXPECT_NEAR(mean_of_floor(closed), mean_of_floor(open), 0.03 * mean_of_floor(open))
        << "except for light through the slits";
}

TEST_F(LitRoom, IsBlackAsASolidAndTheWarningNamesTheKey) {
    const Baked solid = baked(furnished().obj(), "");
    ASSERT_EQ(solid.warnings.size(), 1u);
    EXPECT_NE(solid.warnings[0].find("faces = \"inwards\" to [entities.room]"), std::string::npos)
        << solid.warnings[0];
    EXPECT_GT(mean_of_floor(baked(furnished().obj(), "faces = \"inwards\"\n")), 0.01);
}

TEST_F(LitRoom, TheKeyTurnsABoxThatIsModelledAsASolid) {
    const Baked turned = baked(Boxes().add(low, high).obj(), "faces = \"inwards\"\n");
    EXPECT_EQ(turned.warnings, std::vector<std::string>{});
    EXPECT_GT(mean_of_floor(turned), 0.01);
}

TEST_F(LitRoom, AnotherWordIsRefused) {
    written("room.obj", room().obj());
    const Result<Scene> scene = read_scene(written("room.toml", std::string(lit_room) + "faces = \"in\"\n"));
    ASSERT_FALSE(scene);
    EXPECT_NE(scene.error().message().find("expected \"outwards\" or \"inwards\""), std::string::npos);
}

}  // namespace
}  // namespace haarfield
