#include <gtest/gtest.h>

#include <fstream>

#include "scenes/scene_shading.h"
#include "scenes/scenes.h"
#include "shading/bake/dense_renderer.h"
#include "tests/fixtures/example_scene.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

using Rows = std::array<std::array<double, 4>, 3>;

Vec3f times(const Rows& m, const Vec3f& v) {
    Vec3d result;
    for (std::size_t i = 0; i < 3; ++i)
        result[int(i)] = m[i][0] * double(v.x) + m[i][1] * double(v.y) + m[i][2] * double(v.z) + m[i][3];
    return Vec3f(result);
}

/// Writes a mesh with flat sides and without normals, so that normals follow from the positions alone.
void write_obj(const std::filesystem::path& file, const Mesh& mesh, const Rows& moved, bool turn_round) {
    std::ofstream stream(file);
    stream.precision(9);
    for (const Vec3f& position : mesh.positions) {
        const Vec3f p = times(moved, position);
        stream << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
    }
    for (const auto& [a, b, c] : mesh.triangles)
        stream << "f " << a + 1 << ' ' << (turn_round ? c : b) + 1 << ' ' << (turn_round ? b : c) + 1 << '\n';
}

constexpr Rows identity{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

/// An instance's keys in a scene file, and its matrix, computed by hand.
struct Place {
    const char* keys;
    Rows matrix;
    bool is_mirrored;
};

const std::vector<Place>& places() {
    static const std::vector<Place> all{
        // x to z, z to -x, after scaling
        {"translate = [0.2, 0.1, 0.1]\nscale = [2, 0.5, 1]\nrotate = [0, -90, 0]\n",
         {{{0, 0, -1, 0.2}, {0, 0.5, 0, 0.1}, {2, 0, 0, 0.1}}},
         false},
        {"translate = [-1.3, 0.8, 0.3]\nscale = [1, -1.5, 1]\n",
         {{{1, 0, 0, -1.3}, {0, -1.5, 0, 0.8}, {0, 0, 1, 0.3}}},
         true},
        {"matrix = [[0.6, 0.2, 0, 1.4], [0, 0.9, 0.3, 0.05], [0.1, 0, 0.7, -0.8]]\n",
         {{{0.6, 0.2, 0, 1.4}, {0, 0.9, 0.3, 0.05}, {0.1, 0, 0.7, -0.8}}},
         false},
        {"translate = [1.2, 0.05, 1.2]\nscale = -0.8\nrotate = [180, 0, 0]\n",
         {{{-0.8, 0, 0, 1.2}, {0, 0.8, 0, 0.05}, {0, 0, 0.8, 1.2}}},
         true},
    };
    return all;
}

/// A scene from a file, and the same scene with meshes in world coordinates.
class AffineInstances : public testing::Test {
protected:
    struct Prepared {
        Scene scene;
        SceneEntities entities;
        ShadedScene shaded;
    };

    static void SetUpTestSuite() {
        const TestFolder folder;
        const Mesh floor = square_mesh(5, 0, 6);
        const Mesh stool = joined_meshes(box_mesh({-0.4f, 0.3f, -0.2f}, {0.3f, 0.5f, 0.3f}, 2),
                                         box_mesh({0.1f, 0, 0}, {0.25f, 0.4f, 0.15f}, 2));
        write_obj(folder / "floor.obj", floor, identity, false);
        write_obj(folder / "stool.obj", stool, identity, false);
        const std::string head = R"(
camera = { position = [2, 2, 3], target = [0, 0, 0] }
environment.sky = {}
materials.wood = { diffuse = [0.4, 0.2, 0.1], specular = [0.2, 0.2, 0.2], shininess = 20, convention = "povray" }
)";
        std::string entities, by_hand, instances, plain;
        const auto add_entity = [](const std::string& name, const std::string& file) {
            return "[entities." + name + "]\nmesh = \"" + file +
                   "\"\nmaterial = \"wood\"\nfine_vertices = 1\ncoarse_triangles = 0\n";
        };
        const auto add_instance = [](const std::string& name) {
            return "[[instances]]\nentity = \"" + name + "\"\n";
        };
        entities = add_entity("floor", "floor.obj") + add_entity("stool", "stool.obj");
        by_hand = add_entity("floor", "floor.obj");
        instances = plain = add_instance("floor");
        for (std::size_t i = 0; i < places().size(); ++i) {
            const std::string name = "stool_" + std::to_string(i);
            write_obj(folder / (name + ".obj"), stool, places()[i].matrix, places()[i].is_mirrored);
            instances += add_instance("stool") + places()[i].keys;
            by_hand += add_entity(name, name + ".obj");
            plain += add_instance(name);
        }
        affine = prepared(folder, "affine", head + entities + instances);
        world = prepared(folder, "world", head + by_hand + plain);
    }
    static void TearDownTestSuite() {
        delete affine;
        delete world;
    }

    static Prepared* prepared(const TestFolder& folder, const std::string& name, const std::string& text) {
        std::ofstream(folder / (name + ".toml")) << text;
        const Result<Scene> scene = read_scene(folder / (name + ".toml"));
        EXPECT_TRUE(scene) << scene.error().message();
        SceneEntityOptions options;
        options.fields_folder = folder / name;
        options.face_size = ExampleScene::size;
        Result<SceneEntities> entities = prepare_scene_entities(*scene, options);
        EXPECT_TRUE(entities) << entities.error().message();
        const LatLongImage light = environment(
            [](const Vec3d& d) { return 0.4 + 2 * std::exp(6 * (d.x * 0.6 + d.y * 0.7 + d.z * 0.4 - 1)); });
        auto* result = new Prepared{*scene, std::move(*entities), {}};
        result->shaded = shaded_scene(result->scene, result->entities, light);
        return result;
    }

    /// Expects equal values at equal positions and normals. A few vertices may differ, because a sample point
    /// next to an edge may be on its other side.
    static void expect_same(const SceneColours& found, const SceneColours& wanted, float tolerance) {
        std::size_t count = 0, different = 0;
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            const Mesh &a = *affine->shaded.entities[affine->shaded.instances[i].entity].mesh,
                       &b = *world->shaded.entities[world->shaded.instances[i].entity].mesh;
            const Placement& placement = affine->shaded.instances[i].placement;
            ASSERT_EQ(a.positions.size(), b.positions.size()) << i;
            for (std::size_t v = 0; v < a.positions.size(); ++v, ++count) {
                std::size_t same = b.positions.size();
                for (std::size_t w = 0; w < b.positions.size(); ++w)
                    if ((placement.point_to_world(a.positions[v]) - b.positions[w]).length() < 1e-5f &&
                        (placement.direction_to_world(a.normals[v]) - b.normals[w]).length() < 1e-4f)
                        same = w;
                ASSERT_LT(same, b.positions.size()) << "instance " << i << ", vertex " << v;
                different +=
                    (found[i][v] - wanted[i][same]).length() > tolerance * (1 + wanted[i][same].length());
            }
        }
        EXPECT_LE(different, count / 100);
        EXPECT_GT(count, 400u);
    }

    static RenderSettings settings() {
        RenderSettings settings;
        settings.face_size = ExampleScene::size;
        settings.light_coefficients = 0;
        settings.occlusion = Occlusion::exact;
        return settings;
    }

    static Prepared *affine, *world;
};

AffineInstances::Prepared* AffineInstances::affine = nullptr;
AffineInstances::Prepared* AffineInstances::world = nullptr;

TEST_F(AffineInstances, EqualHandMadeMeshesForTheOracle) {
    expect_same(total(*dense_scene_radiance(affine->shaded, settings())),
                total(*dense_scene_radiance(world->shaded, settings())), 1e-3f);
}

TEST_F(AffineInstances, BakesAgreeWithTheOracleOnHandMadeMeshes) {
    expect_same(total(*scene_radiance(affine->shaded, settings())),
                total(*dense_scene_radiance(world->shaded, settings())), 4e-3f);
}

TEST_F(AffineInstances, MoveInASession) {
    RelightSession session(affine->shaded, settings(), {0.003f});
    ASSERT_TRUE(session.vary_instance(1));
    Placement placement = affine->shaded.instances[1].placement;
    const Vec3f step(-0.4f, 0.3f, -0.9f);
    placement.translate += step;
    session.place(1, placement);
    ASSERT_TRUE(session.frame());
    const SceneColours frame = session.radiance();
    ASSERT_TRUE(session.commit());

    ShadedScene moved = world->shaded;
    moved.instances[1].placement.translate += step;
    const SceneColours wanted = total(*dense_scene_radiance(moved, settings()));
    expect_same(session.radiance(), wanted, 4e-3f);
    expect_same(frame, wanted, 0.04f);
}

TEST_F(AffineInstances, ReferenceScenesContainTheHandMadeMeshes) {
    for (std::size_t i = 0; i < affine->scene.instances.size(); ++i) {
        const Mesh &a = affine->entities.of_instance(i).mesh.original,
                   &b = world->entities.of_instance(i).mesh.original;
        const Placement& placement = affine->scene.instances[i].placement;
        ASSERT_EQ(a.triangles.size(), b.triangles.size());
        for (std::size_t t = 0; t < a.triangles.size(); ++t) {
            Vec3f middle_a(0, 0, 0), middle_b(0, 0, 0);
            for (std::size_t k = 0; k < 3; ++k) {
                middle_a += placement.point_to_world(a.positions[a.triangles[t][k]]) / 3.0f;
                middle_b += b.positions[b.triangles[t][k]] / 3.0f;
            }
            EXPECT_LT((middle_a - middle_b).length(), 1e-5f);
            const auto side = [t](const Mesh& mesh) {
                const auto& [p, q, r] = mesh.triangles[t];
                return (mesh.positions[q] - mesh.positions[p])
                    .cross(mesh.positions[r] - mesh.positions[p])
                    .normalized();
            };
            EXPECT_LT((placement.direction_to_world(side(a)) - side(b)).length(), 1e-4f);
        }
    }
}

}  // namespace
}  // namespace haarfield
