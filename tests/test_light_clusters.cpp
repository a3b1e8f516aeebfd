#include "shading/bake/clustered_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "shading/transfer/relight_session.h"
#include "tests/fixtures/example_scene.h"
#include "tests/fixtures/relative_error.h"

namespace haarfield {
namespace {

/// A post on a floor under two suns, one of them wide.
struct PostUnderSuns : ExampleScene {
    PostUnderSuns() {
        floor = add_entity(square_mesh(4, 0, 64), matte(0.5f));
        Material lacquer = glossy(40, LobeConvention::physical);
        lacquer.diffuse = Rgb(0.3f);
        post = add_entity(box_mesh({-0.2f, 0, -0.2f}, {0.2f, 1, 0.2f}, 6), lacquer, 400, 300);
        scene.instances = {{floor, {}}, {post, {}}, {post, {{1.1f, 0, 0.7f}, 0.6f}}};
        scene.environment = environment([](const Vec3d& d) { return 0.2 + 0.1 * d.y; });
        scene.environment.suns = {{Vec3f(Vec3d(0.6, 0.5, 0.2).normalized()), 0.02f, Rgb(3, 2, 1)},
                                  {Vec3f(Vec3d(-0.5, 0.6, 0.4).normalized()), 0.09f, Rgb(1, 1, 2)}};
        scene.eye = {2, 2, 4};
    }
    std::vector<DirectionalLight> lights() const {
        return all_lights(split_light(scene.environment).sources);
    }
    std::size_t floor, post;
};

/// Returns points of the floor, in rows.
std::vector<ShadingPoint> floor_receivers() {
    std::vector<ShadingPoint> receivers;
    for (int row = 0; row < 40; ++row)
        for (int column = 0; column < 40; ++column) {
            ShadingPoint receiver;
            receiver.from = {-1.6f + 0.08f * float(column), 1e-3f, -1.6f + 0.08f * float(row)};
            receiver.brdf.normal = {0, 1, 0};
            receiver.brdf.mirror = Vec3f(Vec3d(0.55, 0.5, 0.25).normalized());
            receiver.brdf.diffuse = Rgb(0.2f, 0.15f, 0.1f);
            receiver.brdf.specular = Rgb(0.5f);
            receiver.brdf.lobes[0] = {LobeAxis::mirror, 1, 60};
            receivers.push_back(receiver);
        }
    return receivers;
}

TEST(LightClusters, DivideLightsIntoCones) {
    const PostUnderSuns example;
    const std::vector<DirectionalLight> lights = example.lights();
    for (const float angle : {0.01f, 0.06f, 0.3f}) {
        std::multiset<float> left;
        for (const DirectionalLight& light : lights) left.insert(light.direction.x);
        for (const LightCluster& cluster : light_clusters(lights, angle)) {
            ASSERT_FALSE(cluster.lights.empty());
            EXPECT_EQ(cluster.tried, std::min<std::size_t>(4, cluster.lights.size()));
            EXPECT_GT(cluster.cosine, std::cos(1.5f * angle));
            EXPECT_NEAR(cluster.cosine * cluster.cosine + cluster.sine * cluster.sine, 1, 1e-6);
            std::array<Vec3f, 3> flux{Vec3f(0.0f), Vec3f(0.0f), Vec3f(0.0f)};
            for (const auto& [direction, irradiance] : cluster.lights) {
                EXPECT_GE(direction.dot(cluster.axis), cluster.cosine - 1e-6f);
                for (std::size_t c = 0; c < 3; ++c) flux[c] += direction * irradiance[int(c)];
                const auto found = left.find(direction.x);
                ASSERT_NE(found, left.end());
                left.erase(found);
            }
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_LT((flux[c] - cluster.flux[c]).length(), 1e-6f * (1 + flux[c].length()));
        }
        EXPECT_TRUE(left.empty()) << angle;
    }
    EXPECT_TRUE(light_clusters({}).empty());
}

TEST(LightClusters, LightAsAllRaysDo) {
    const PostUnderSuns example;
    ShadowRays rays;
    rays.build(example.scene);
    const std::vector<DirectionalLight> lights = example.lights();
    const std::vector<LightCluster> clusters = light_clusters(lights);
    ASSERT_LT(clusters.size() * 4, lights.size());
    const std::vector<ShadingPoint> receivers = floor_receivers();
    std::vector<Outgoing> wanted_components(receivers.size());
    add_source_light(rays, lights, receivers, wanted_components);
    const std::vector<Rgb> wanted = total({wanted_components})[0],
                           wanted_diffuse = diffuse_component({wanted_components})[0];
    std::vector<Rgb> found(receivers.size(), Rgb(0.0f)), found_diffuse = found;
    add_clustered_light(rays, clusters, receivers, found, found_diffuse);
    EXPECT_LT(relative_rmse(found, wanted), 5e-3);
    EXPECT_LT(relative_rmse(found_diffuse, wanted_diffuse), 4e-3);
    EXPECT_GT(relative_rmse(found_diffuse, wanted), 0.05);  // there is a specular part
    std::vector<Outgoing> components(receivers.size());
    add_clustered_light(rays, clusters, receivers, components);
    EXPECT_LT(relative_rmse(total({components})[0], found), 1e-6);
    EXPECT_EQ(diffuse_component({components})[0], found_diffuse);
}

TEST(LightClusters, HaveAtMostTheWantedNumberOfLights) {
    const std::vector<DirectionalLight> lights = PostUnderSuns().lights();
    std::size_t all = 0;
    for (const LightCluster& cluster : light_clusters(lights, 0.06f, 5)) {
        EXPECT_LE(cluster.lights.size(), 5u);
        all += cluster.lights.size();
    }
    EXPECT_EQ(all, lights.size());
    const std::vector<DirectionalLight> equal(9, lights[0]);
    EXPECT_EQ(light_clusters(equal, 0.06f, 5).size(), 1u) << "equal directions cannot be separated";
    std::vector<DirectionalLight> adjacent = equal;
    for (std::size_t i = 0; i < 8; ++i)
        adjacent[i].direction.x = std::nextafter(adjacent[i].direction.x, 2.0f);
    EXPECT_LE(light_clusters(adjacent, 0.06f, 5).size(), 2u);
}

TEST(LightClusters, IncludeLightThatIsPartlyBelowTheHorizon) {
    const PostUnderSuns example;
    ShadowRays rays;
    rays.build(example.scene);
    const std::vector<DirectionalLight> lights = example.lights();
    const std::vector<LightCluster> clusters = light_clusters(lights);
    for (const LightCluster& cluster : clusters) {
        if (cluster.sine < 1e-3f) continue;
        ShadingPoint receiver;
        receiver.from = {0, 3, 0};  // above everything
        receiver.brdf.normal = Vec3f(Vec3d(cluster.axis.cross(Vec3f(0, 0, 1))).normalized());
        receiver.brdf.diffuse = Rgb(0.3f);
        Rgb found(0.0f);
        Outgoing by_sources;
        add_source_light(rays, lights, {&receiver, 1}, {&by_sources, 1});
        const Rgb wanted = by_sources.total();
        add_clustered_light(rays, clusters, {&receiver, 1}, {&found, 1});
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], wanted[c], 1e-5f * wanted[c]) << cluster.axis;
    }
}

TEST(LightClusters, ReportAndReuseVisibility) {
    const PostUnderSuns example;
    ShadowRays rays;
    rays.build(example.scene);
    const std::vector<LightCluster> clusters = light_clusters(example.lights());
    const std::vector<ShadingPoint> receivers = floor_receivers();
    std::vector<Rgb> first(receivers.size(), Rgb(0.0f)), again = first, dark = first, bright = first;
    std::vector<ClusterVisibility> visibility(receivers.size() * clusters.size());
    add_clustered_light(rays, clusters, receivers, first, {}, visibility);
    for (const ClusterVisibility one :
         {ClusterVisibility::lit, ClusterVisibility::blocked, ClusterVisibility::partly})
        EXPECT_GT(std::ranges::count(visibility, one), 20);
    EXPECT_EQ(std::ranges::count(visibility, ClusterVisibility::unknown), 0);
    add_clustered_light(rays, clusters, receivers, again, {}, visibility);
    EXPECT_EQ(again, first);
    std::ranges::fill(visibility, ClusterVisibility::blocked);
    add_clustered_light(rays, clusters, receivers, dark, {}, visibility);
    EXPECT_EQ(dark, std::vector<Rgb>(receivers.size(), Rgb(0.0f)));
    std::ranges::fill(visibility, ClusterVisibility::lit);
    add_clustered_light(rays, clusters, receivers, bright, {}, visibility);
    for (const Rgb& radiance : bright)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(radiance[c], bright[0][c], 1e-6f);
}

TEST(ShadowRays, LeaveAnInstanceOut) {
    const PostUnderSuns example;
    ShadowRays rays;
    rays.build(example.scene);
    const std::array<Vec3f, 2> points{Vec3f(-1, 0.5f, 0), Vec3f(0.5f, 0.1f, 0.7f)};
    EXPECT_EQ(rays.blocked(points, 3, {1, 0, 0}), 3);
    EXPECT_EQ(rays.blocked(points, 3, {1, 0, 0}, 1), 2);
    EXPECT_EQ(rays.blocked(points, 3, {1, 0, 0}, 2), 1);
}

class FramesUnderSuns : public testing::TestWithParam<FrameQuality> {
protected:
    static RenderSettings settings() {
        RenderSettings settings;
        settings.face_size = ExampleScene::size;
        return settings;
    }
    static double error_against_commit(RelightSession& session) {
        EXPECT_TRUE(session.frame(GetParam()));
        const SceneColours found = session.radiance();
        EXPECT_TRUE(session.commit());
        return relative_scene_rmse(found, session.radiance());
    }
    PostUnderSuns example;
};

TEST_P(FramesUnderSuns, AreTheCommitsWhileLightTurns) {
    RelightSession session(example.scene, settings(), {});
    ASSERT_TRUE(session.vary_light());
    for (const double angle : {0.0, 0.5, 2.5}) {
        session.turn_environment(rotation_about({0, 1, 0}, angle));
        EXPECT_LT(error_against_commit(session), GetParam() == FrameQuality::still ? 0.01 : 0.03) << angle;
    }
}

TEST_P(FramesUnderSuns, AreTheCommitsWhileAnInstanceMoves) {
    RelightSession session(example.scene, settings(), {});
    ASSERT_TRUE(session.vary_instance(2));
    for (const Vec3f& place :
         {Vec3f(1.1f, 0, 0.7f), Vec3f(-0.9f, 0, 0.4f), Vec3f(0, 1.2f, 0), Vec3f(9, 0, 0)}) {
        session.place(2, {place, 0.6f});
        EXPECT_LT(error_against_commit(session), GetParam() == FrameQuality::still ? 0.02 : 0.04) << place;
    }
}

INSTANTIATE_TEST_SUITE_P(Quality, FramesUnderSuns,
                         testing::Values(FrameQuality::still, FrameQuality::moving));

}  // namespace
}  // namespace haarfield
