#include "shading/visibility/placed_solids.h"

#include <gtest/gtest.h>

#include "shading/bake/mesh_refinement.h"
#include "shading/bake/ray_renderer.h"
#include "shading/transfer/relight_session.h"
#include "tests/fixtures/example_scene.h"

namespace haarfield {
namespace {

/// A box on a floor of 8 x 8 squares. The box is wider than a square.
struct BoxOnFloor : ExampleScene {
    static constexpr std::size_t floor = 0, box = 1;  // entities and instances

    BoxOnFloor() {
        PreparedMesh floor_mesh = prepared_as_is(square_mesh(4, 0, 8));
        floor_mesh.coarse = square_mesh(4, 0);
        add_entity(floor_mesh, matte(0.7f), 6, 18);
        add_entity(box_mesh({-0.4f, 0, -0.4f}, {0.4f, 0.6f, 0.4f}), matte(0.5f), 300, 300);
        scene.instances = {{floor, {}}, {box, {{0.08f, 0, 0}, 1}}};
        scene.environment = environment([](const Vec3d& d) { return 0.5 + 0.3 * d.y + 0.2 * d.x; });
        scene.eye = {0, 3, 5};
    }
    RenderSettings settings() const {
        RenderSettings settings;
        settings.face_size = size;
        settings.exact_triangles = 2;
        settings.occlusion = Occlusion::exact;
        return settings;
    }
    /// The number of the floor's vertex nearest to a place.
    std::size_t floor_vertex(float x, float z) const {
        const std::vector<Vec3f>& positions = scene.entities[floor].mesh->positions;
        return std::size_t(
            std::ranges::min_element(positions, {},
                                     [&](const Vec3f& p) { return (p - Vec3f(x, 0, z)).length2(); }) -
            positions.begin());
    }
    /// The mean of a floor vertex's neighbours that share a triangle with it, each counted once per triangle.
    double mean_of_neighbours(const std::vector<Rgb>& radiance, std::size_t vertex) const {
        double sum = 0;
        int count = 0;
        for (const auto& triangle : scene.entities[floor].mesh->triangles) {
            if (std::ranges::find(triangle, vertex) == triangle.end()) continue;
            for (const std::uint32_t v : triangle)
                if (v != vertex) {
                    sum += double(radiance[v].x);
                    ++count;
                }
        }
        return sum / count;
    }
};

TEST(PlacedSolids, ContainWhatLiesInOtherInstancesAsTheyArePlaced) {
    BoxOnFloor example;
    Mesh open = box_mesh({-1, -1, -1}, {1, 1, 1});
    open.triangles.pop_back();
    const std::size_t shell = example.add_entity(open, matte(0.5f));
    const Rotation turned = rotation_about({0, 1, 0}, pi / 4);
    example.scene.instances = {{example.floor, {}},
                               {example.box, {{3, 1, 0}, 2, turned}},
                               {example.box, {{-3, 0, 0}, 1}},
                               {shell, {{0, 0, -9}, 1}}};
    const PlacedSolids solids(example.scene);
    EXPECT_TRUE(solids.contain({3, 1.1f, 0}, 0));
    EXPECT_FALSE(solids.contain({3, 1.1f, 0}, 1)) << "its own instance";
    EXPECT_TRUE(solids.contain({3, 1.1f, 0}, 2));
    EXPECT_TRUE(solids.contain({4.05f, 1.1f, 0}, 0)) << "a corner of the turned box, at 1.13 from its axis";
    EXPECT_FALSE(solids.contain({3.7f, 1.1f, 0.7f}, 0)) << "inside the box as it was before it was turned";
    EXPECT_FALSE(solids.contain({3, 0.9f, 0}, 0));
    EXPECT_FALSE(solids.contain({0, 0.1f, 0}, 0));
    EXPECT_FALSE(solids.contain({0, 0, -9}, 0)) << "an open shell has no inside";
    EXPECT_FALSE(PlacedSolids(ShadedScene()).contain({0, 0, 0}, 0));
}

TEST(PlacedSolids, VerticesInsideThemHaveTheRadianceOfTheirNeighbours) {
    const BoxOnFloor example;
    const std::size_t inside = example.floor_vertex(0, 0);
    const ShadingGeometry geometry = *shading_geometry(example.scene, example.settings());
    const SceneLight light = scene_light(example.scene.environment, example.settings());
    const PointShading shading{example.scene, geometry, light, example.settings()};
    const std::vector<Mesh> meshes{example.mesh(0).fine, example.mesh(1).fine};
    const auto expect_filled = [&](const std::vector<Rgb>& floor, const char* by) {
        const double mean = example.mean_of_neighbours(floor, inside);
        EXPECT_GT(mean, 0.05) << by;
        EXPECT_NEAR(double(floor[inside].x), mean, 1e-5) << by;
    };
    const SceneRadiance bake = *scene_radiance(example.scene, example.settings());
    expect_filled(total(bake)[0], "bake");
    expect_filled(diffuse_component(bake)[0], "diffuse component");
    expect_filled(total(*dense_scene_radiance(example.scene, example.settings()))[0], "dense");
    expect_filled(total(*ray_scene_radiance(example.scene, {64}))[0], "rays");
    expect_filled(total({(*mesh_radiance(shading, meshes))[0].radiance})[0], "mesh");
    const LocalSamples& of_floor = example.scene.entities[0].occlusion->samples();
    const LocalSamples& of_box = example.scene.entities[1].occlusion->samples();
    const SampledMesh sampled[] = {{&meshes[0], &of_floor}, {&meshes[1], &of_box}};
    expect_filled(total(*vertex_radiance(shading, sampled, {}))[0], "vertices");
    RenderSettings bounced = example.settings();
    bounced.bounces.most = 1;
    expect_filled(total(*scene_radiance(example.scene, bounced))[0], "bounces");
}

TEST(PlacedSolids, RefinementDoesNotSplitInsideOfThem) {
    const BoxOnFloor example;
    const ShadingGeometry geometry = *shading_geometry(example.scene, example.settings());
    const SceneLight light = scene_light(example.scene.environment, example.settings());
    const PointShading shading{example.scene, geometry, light, example.settings()};
    const Refinement refined = *refined_radiance(
        shading, {0.02f, 6000},
        *mesh_radiance(shading, std::vector<Mesh>{example.mesh(0).fine, example.mesh(1).fine}));
    const RadiantMesh& floor = refined.meshes[0];
    std::size_t deep_inside = 0;
    for (std::size_t v = 0; v < floor.mesh.positions.size(); ++v) {
        const Vec3f& p = floor.mesh.positions[v];
        if (std::abs(p.x - 0.08f) < 0.39f && std::abs(p.z) < 0.39f) {
            EXPECT_TRUE(floor.samples.buried[v]) << v;
            EXPECT_GT(floor.radiance[v].total().x, 0.05f) << v;
            deep_inside += std::abs(p.x - 0.08f) < 0.2f && std::abs(p.z) < 0.2f;
        }
    }
    EXPECT_GT(floor.mesh.positions.size(), 300u);
    EXPECT_LE(deep_inside, 12u) << "one of the start, and what is split along with triangles at the contact";
}

TEST(PlacedSolids, FramesOfSessionsFillVerticesAsBakesDo) {
    const BoxOnFloor example;
    RelightSession session(example.scene, example.settings(), {0.001f});
    const auto expect_filled = [&](float x, FrameQuality quality, const char* varies) {
        ASSERT_TRUE(session.frame(quality)) << varies;
        const std::vector<Rgb>& floor = session.radiance()[0];
        const std::size_t inside = example.floor_vertex(x, 0);
        const double mean = example.mean_of_neighbours(floor, inside);
        EXPECT_GT(mean, 0.05) << varies;
        EXPECT_NEAR(double(floor[inside].x), mean, 1e-5) << varies;
    };
    const auto fresh_bake = [&] {
        ShadedScene fresh = example.scene;
        fresh.instances = session.instances();
        return total(*scene_radiance(fresh, example.settings()));
    };
    const std::size_t middle = example.floor_vertex(0, 0), right = example.floor_vertex(1, 0);
    ASSERT_TRUE(session.vary_light());
    expect_filled(0, FrameQuality::still, "light");
    EXPECT_NEAR(session.radiance()[0][middle].x, fresh_bake()[0][middle].x, 0.005);
    ASSERT_TRUE(session.vary_eye());
    expect_filled(0, FrameQuality::still, "eye");
    EXPECT_NEAR(session.radiance()[0][middle].x, fresh_bake()[0][middle].x, 0.005);
    VertexMask some{std::vector<std::uint8_t>(session.radiance()[0].size(), 0),
                    std::vector<std::uint8_t>(session.radiance()[1].size(), 0)};
    some[0][middle] = 1;
    session.set_eye({0, 3.5f, 5});
    ASSERT_TRUE(session.frame_of(some));
    EXPECT_NEAR(session.radiance()[0][middle].x, fresh_bake()[0][middle].x, 0.005) << "one vertex only";
    session.set_eye(example.scene.eye);
    ASSERT_TRUE(session.vary_instance(example.box));
    for (const FrameQuality quality : {FrameQuality::still, FrameQuality::moving}) {
        session.place(example.box, {{0.08f, 0, 0}, 1});
        expect_filled(0, quality, "instance");
        session.place(example.box, {{1.08f, 0, 0}, 1});
        expect_filled(1, quality, "instance, after it has moved");
        const SceneColours bake = fresh_bake();
        EXPECT_NEAR(session.radiance()[0][middle].x, bake[0][middle].x, 0.1) << "where it was before";
        EXPECT_NEAR(session.radiance()[0][right].x, bake[0][right].x, 0.1) << "where it is";
    }
    ASSERT_TRUE(session.commit());
    EXPECT_EQ(session.radiance(), fresh_bake()) << "a commit";
}

}  // namespace
}  // namespace haarfield
