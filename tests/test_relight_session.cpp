#include "shading/transfer/relight_session.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <functional>
#include <random>

#include "shading/scene/lighting.h"
#include "tests/fixtures/example_scene.h"
#include "tests/fixtures/random_numbers.h"
#include "tests/fixtures/relative_error.h"

namespace haarfield {
namespace {

LatLongImage sky(double turn) {
    return environment(
        [&](const Vec3d& d) {
            return 0.5 + d.y * 0.3 +
                   5 * std::exp(20 * (d.dot(Vec3d(std::sin(turn), 0.8, std::cos(turn)).normalized()) - 1));
        },
        128);
}

/// A floor and some furniture. The occlusion by one piece is interpolated from its field.
class OpenedScene {
public:
    OpenedScene() {
        Material lacquer = glossy(30, LobeConvention::povray);
        lacquer.diffuse = Rgb(0.4f, 0.2f, 0.1f);
        PreparedMesh floor = prepared_as_is(square_mesh(5, 0, 8));
        floor.coarse = square_mesh(5, 0);
        example.add_entity(floor, matte(0.6f), 6, 18);
        // The knob's lower end is buried in the box.
        example.add_entity(joined_meshes(box_mesh({-0.4f, 0, -0.3f}, {0.4f, 0.8f, 0.3f}, 3),
                                         box_mesh({-0.1f, 0.7f, -0.1f}, {0.1f, 0.9f, 0.1f}, 2)),
                           lacquer, 300, 500);
        example.add_entity(joined_meshes(box_mesh({-0.5f, 0, -0.1f}, {0.5f, 0.2f, 0.1f}, 2),
                                         box_mesh({-0.1f, 0.2f, -0.1f}, {0.1f, 0.7f, 0.1f}, 2)),
                           matte(0.8f));
    }

    explicit OpenedScene(Occlusion how) : OpenedScene() { occlusion = how; }

    RelightSession session() const { return RelightSession(scene(), settings(), {0.003f}); }

    ShadedScene scene() const {
        ShadedScene scene = example.scene;
        scene.instances = {{0, {}}, {1, {{-0.8f, 0, 0}, 1}}, {2, {{0.7f, 0, 0.5f}, 1}}};
        scene.environment = sky(0.4);
        scene.eye = {2, 2, 3};
        return scene;
    }

    RenderSettings settings() const {
        RenderSettings settings;
        settings.face_size = ExampleScene::size;
        settings.exact_triangles = 2;  // the floor
        settings.occlusion = occlusion;
        return settings;
    }

    /// Returns the radiance of a session's instances in a new scene, which has no history.
    SceneColours fresh_bake(const RelightSession& session) const {
        ShadedScene fresh = scene();
        fresh.instances = session.instances();
        fresh.environment = session.scene().environment;
        fresh.eye = session.eye();
        return total(*scene_radiance(fresh, settings()));
    }

    ExampleScene example;
    Occlusion occlusion = Occlusion::fields;
};

const OpenedScene& opened(Occlusion occlusion = Occlusion::fields) {
    static const OpenedScene by_fields(Occlusion::fields), automatic(Occlusion::automatic);
    return occlusion == Occlusion::fields ? by_fields : automatic;
}

double largest_difference(const SceneColours& found, const SceneColours& wanted) {
    double largest = 0;
    EXPECT_EQ(found.size(), wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        EXPECT_EQ(found[i].size(), wanted[i].size());
        for (std::size_t v = 0; v < wanted[i].size(); ++v)
            for (int c = 0; c < 3; ++c)
                largest = std::max(largest, std::abs(double(found[i][v][c]) - double(wanted[i][v][c])));
    }
    return largest;
}

/// Returns a fraction of the light of sky(0.4), in coefficients.
DenseCoefficients dimmed_sky(float share) {
    const Truncation truncation{RenderSettings().light_coefficients};
    const DenseCoefficients whole =
        dense_coefficients(lighting_tree(sky(0.4), ExampleScene::size, truncation), ExampleScene::size);
    const DenseCoefficients* const lights[] = {&whole};
    return weighted_sum(lights, std::span(&share, 1));
}

/// Parametrised by the method of occlusion by other instances.
class RelightSessionBy : public testing::TestWithParam<Occlusion> {};
INSTANTIATE_TEST_SUITE_P(Occlusion, RelightSessionBy,
                         testing::Values(Occlusion::fields, Occlusion::automatic), [](const auto& test) {
                             return test.param == Occlusion::fields ? "Fields" : "Automatic";
                         });

TEST_P(RelightSessionBy, FramesEqualTheCommitForEachVariableInput) {
    RelightSession session = opened(GetParam()).session();
    const auto expect_frame_as_commit = [&](const char* what, double tolerance = 0.012) {
        ASSERT_TRUE(session.frame()) << what;
        const SceneColours frame = session.radiance();
        ASSERT_TRUE(session.commit());
        EXPECT_LT(relative_scene_rmse(frame, session.radiance()), tolerance) << what;
    };
    ASSERT_TRUE(session.vary_light());
    EXPECT_GT(session.transfer_bytes(), 1000u);
    expect_frame_as_commit("as opened");
    session.set_environment(sky(2));
    expect_frame_as_commit("another environment");
    session.turn_environment(rotation_about({0, 1, 0}, 1.3));
    expect_frame_as_commit("turned about y");
    session.turn_environment(rotation_about({1, 0.5, 0}, 0.8));
    expect_frame_as_commit("turned about any axis");

    ASSERT_TRUE(session.vary_eye());
    session.set_eye({-3, 1, 1});
    expect_frame_as_commit("another eye");

    ASSERT_TRUE(session.vary_instance(1));
    session.place(1, {{0.2f, 0.3f, -1}, 1.2f});
    // Frames use the field of the moving instance, which is coarse here.
    expect_frame_as_commit("moved", GetParam() == Occlusion::fields ? 0.012 : 0.1);
}

TEST_P(RelightSessionBy, FramesOfSomeVerticesAreBitIdenticalToWholeFrames) {
    RelightSession session = opened(GetParam()).session();
    std::mt19937 random(5);
    VertexMask first, second;
    for (const ShadedInstance& instance : session.instances()) {
        const std::size_t count = session.scene().entities[instance.entity].mesh->positions.size();
        first.emplace_back(count);
        second.emplace_back(count);
        for (std::size_t v = 0; v < count; ++v)
            (random() % 2 == 0 ? first : second).back()[v] = random() % 4 == 0;
    }
    // Buried vertices get their radiance from vertices that are not chosen.
    const std::span<const std::uint8_t> buried = session.scene().entities[1].occlusion->samples().buried;
    ASSERT_GT(std::count(buried.begin(), buried.end(), 1), 0);
    std::fill(first[1].begin(), first[1].end(), 0);
    second[1].assign(buried.begin(), buried.end());
    const auto expect_as_whole = [&](const char* what) {
        ASSERT_TRUE(session.frame());
        const SceneColours whole = session.radiance();
        ASSERT_TRUE(session.commit());
        ASSERT_TRUE(session.frame_of(first));
        ASSERT_TRUE(session.frame_of(second));
        for (std::size_t i = 0; i < whole.size(); ++i)
            for (std::size_t v = 0; v < whole[i].size(); ++v)
                if (first[i][v] || second[i][v]) {
                    ASSERT_EQ(session.radiance()[i][v], whole[i][v]) << what << ": " << i << ", " << v;
                }
    };
    ASSERT_TRUE(session.vary_eye());
    session.set_eye({-3, 1, 1});
    expect_as_whole("eye");
    ASSERT_TRUE(session.vary_light());
    expect_as_whole("light");
    ASSERT_TRUE(session.vary_instance(1));
    expect_as_whole("instance");
}

/// On one thread, a call checks the stop token between any two reports. If a report requests a stop, it is
/// therefore the last one.
TEST_P(RelightSessionBy, NothingIsReportedAfterAStopRequest) {
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    const auto expect_stops = [&](const char* what, int steps, const auto& call) {
        int total = 0;
        {
            RelightSession session = opened(GetParam()).session();
            ASSERT_TRUE(call(session, Progress{[&](auto...) { ++total; }, {}})) << what;
        }
        EXPECT_GE(total, steps) << what;
        for (const int last : {1, std::max(1, total / 2), total}) {
            RelightSession session = opened(GetParam()).session();
            std::stop_source stop;
            int reports = 0;
            const Result<Done> result = call(session, Progress{[&](auto...) {
                                                                   if (++reports == last) stop.request_stop();
                                                               },
                                                               stop.get_token()});
            ASSERT_FALSE(result) << what << " at " << last;
            EXPECT_EQ(result.error().code, ErrorCode::interrupted);
            EXPECT_EQ(reports, last) << what;
        }
    };
    expect_stops("light", 1, [](RelightSession& s, const Progress& p) { return s.vary_light(p); });
    expect_stops("eye", 1, [](RelightSession& s, const Progress& p) { return s.vary_eye(p); });
    expect_stops("instance", 1, [](RelightSession& s, const Progress& p) { return s.vary_instance(1, p); });
    expect_stops("commit", 1, [](RelightSession& s, const Progress& p) { return s.commit(p); });
}

TEST_P(RelightSessionBy, PreparingChangesNothingButWhenTheWorkIsDone) {
    const auto radiance = [](RelightSession& session) {
        session.turn_environment(rotation_about({0, 1, 0}, 1.3));
        EXPECT_TRUE(session.vary_instance(1));
        session.place(1, {{0.2f, 0.3f, -1}, 1.2f});
        EXPECT_TRUE(session.frame());
        return session.radiance();
    };
    RelightSession prepared = opened(GetParam()).session(), other = opened(GetParam()).session();
    ASSERT_TRUE(prepared.prepare());
    ASSERT_TRUE(prepared.prepare());
    EXPECT_EQ(prepared.transfer_bytes(), 0u);
    EXPECT_EQ(radiance(prepared), radiance(other));
}

TEST(RelightSession, WithoutPruningFramesOfTintedWhiteSurfacesErrByRoundingOnly) {
    ExampleScene example;
    Material white = matte(1.0f);
    white.specular = Rgb(0.3f);
    const std::size_t floor = example.add_entity(square_mesh(4, 0, 12), white),
                      box = example.add_entity(box_mesh({-0.5f, 0, -0.5f}, {0.5f, 1, 0.5f}, 3), matte(0.6f));
    const std::vector<Rgb> tints(example.scene.entities[floor].mesh->positions.size(), Rgb(0.2f));
    example.scene.entities[floor].tints = tints;
    example.scene.instances = {{floor, {}}, {box, {{-0.8f, 0, 0}, 1}}, {box, {{0.8f, 0, 0.2f}, 0.6f}}};
    example.scene.environment =
        environment([](const Vec3d& d) { return std::max(0.1, d.y) * (1.5 + d.x); }, 32);
    example.scene.eye = {3, 2.5f, 4};
    RenderSettings settings;
    settings.face_size = ExampleScene::size;
    settings.bounces.most = any_bounces;
    const SceneColours bake = total(*scene_radiance(example.scene, settings));
    RelightSession session(example.scene, settings, {0.0f});
    ASSERT_TRUE(session.vary_light());
    ASSERT_TRUE(session.frame());
    for (std::size_t i = 0; i < bake.size(); ++i)
        EXPECT_LT(relative_rmse(session.radiance()[i], bake[i]), 0.002) << "light, instance " << i;
    ASSERT_TRUE(session.vary_eye());
    ASSERT_TRUE(session.frame());
    for (std::size_t i = 0; i < bake.size(); ++i)
        EXPECT_LT(relative_rmse(session.radiance()[i], bake[i]), 0.002) << "eye, instance " << i;
}

TEST(RelightSession, ShowsLightsGivenAsCoefficients) {
    RelightSession session = opened().session();
    ASSERT_TRUE(session.vary_light());
    ASSERT_TRUE(session.frame());
    const SceneColours bright = session.radiance();
    session.show_light(dimmed_sky(0.25f));
    ASSERT_TRUE(session.frame());
    for (std::size_t i = 0; i < bright.size(); ++i)
        for (std::size_t v = 0; v < bright[i].size(); ++v)
            EXPECT_NEAR(session.radiance()[i][v].y, bright[i][v].y / 4, 1e-6);
}

TEST(RelightSession, ChangesInvalidateOtherTransferVectors) {
    RelightSession session = opened().session();
    EXPECT_FALSE(session.frame());
    EXPECT_EQ(session.transfer_bytes(), 0u);
    const auto is_void_after = [&](auto vary, auto change) {
        EXPECT_TRUE(vary());
        EXPECT_TRUE(session.frame());
        change();
        const Result<Done> frame = session.frame();
        return !frame && frame.error().what.find("vary_light") != std::string::npos;
    };
    const auto light = [&] { return session.vary_light(); };
    const auto eye = [&] { return session.vary_eye(); };
    const auto instance = [&] { return session.vary_instance(1); };
    float changes = 0;  // so that each change sets another value
    const auto turn = [&] { session.turn_environment(rotation_about({0, 1, 0}, ++changes)); };
    const auto look = [&] { session.set_eye({1, 1, ++changes}); };
    const auto move = [&](std::size_t i) { return [&, i] { session.place(i, {{1, 0, -++changes}, 1}); }; };
    EXPECT_FALSE(is_void_after(light, turn));
    EXPECT_TRUE(is_void_after(light, look));
    EXPECT_TRUE(is_void_after(light, move(1)));
    EXPECT_TRUE(is_void_after(eye, turn));
    EXPECT_FALSE(is_void_after(eye, look));
    EXPECT_TRUE(is_void_after(eye, move(1)));
    EXPECT_TRUE(is_void_after(instance, turn));
    EXPECT_TRUE(is_void_after(instance, look));
    EXPECT_FALSE(is_void_after(instance, move(1)));
    EXPECT_TRUE(is_void_after(instance, move(2)));
    EXPECT_TRUE(is_void_after(light, [&] { session.clone(1); }));
    EXPECT_TRUE(is_void_after(light, [&] { session.remove(3); }));
    EXPECT_TRUE(is_void_after(light, [&] { session.rotate(1, {0, 1, 0}, 1); }));
    // Setting an input to its present value is no change.
    const Placement here = session.instances()[1].placement;
    EXPECT_FALSE(is_void_after(eye, [&] { session.place(1, here); }));
    EXPECT_FALSE(is_void_after(light, [&] { session.set_eye(session.eye()); }));
    EXPECT_FALSE(
        is_void_after(light, [&] { session.set_materials(1, session.scene().entities[1].materials); }));
}

TEST(RelightSession, WhileMovingTheInstanceItselfMayBeCoarser) {
    RelightSession session = opened().session();
    ASSERT_TRUE(session.vary_instance(1));
    session.place(1, {{0.1f, 0, -1}, 1});
    ASSERT_TRUE(session.frame());
    const SceneColours still = session.radiance();
    ASSERT_TRUE(session.frame(FrameQuality::moving));
    EXPECT_EQ(session.radiance()[0], still[0]);
    EXPECT_NE(session.radiance()[1], still[1]);
    EXPECT_LT(relative_scene_rmse({session.radiance()[1]}, {still[1]}), 0.1);
}

TEST(RelightSession, WhileLightMovesLaterBouncesAreAFrameBehind) {
    RenderSettings settings = opened().settings();
    settings.bounces.most = any_bounces;
    RelightSession dragged(opened().scene(), settings, {0.003f}), set(opened().scene(), settings, {0.003f});
    ASSERT_TRUE(dragged.vary_light());
    ASSERT_TRUE(set.vary_light());
    const auto turn = [](RelightSession& session, double angle) {
        session.turn_environment(rotation_about({0, 1, 0}, angle));
        ASSERT_TRUE(session.frame(FrameQuality::moving));
    };
    for (int i = 1; i <= 10; ++i) turn(dragged, 0.05 * i);
    // Another environment has all of its bounces at once.
    set.set_environment(sky(0.4));
    turn(set, 0.5);
    const SceneColours lagging = dragged.radiance();
    for (int i = 0; i < 10; ++i) turn(dragged, 0.5);
    EXPECT_NE(lagging, dragged.radiance());
    EXPECT_LT(relative_scene_rmse(lagging, dragged.radiance()), 0.001);
    // Frames may estimate the last hundredth of the indirect light.
    EXPECT_LT(relative_scene_rmse(dragged.radiance(), set.radiance()), 0.004);
    // After a large change of the light, a frame computes all bounces.
    dragged.show_light(dimmed_sky(0.1f));
    ASSERT_TRUE(dragged.frame(FrameQuality::moving));
    const SceneColours leapt = dragged.radiance();
    ASSERT_TRUE(dragged.frame(FrameQuality::still));
    EXPECT_LT(relative_scene_rmse(leapt, dragged.radiance()), 0.004);
    // The differences above are small: without indirect light, the error is much larger.
    settings.bounces.most = 0;
    RelightSession direct(opened().scene(), settings, {0.003f});
    ASSERT_TRUE(direct.vary_light());
    turn(direct, 0.5);
    EXPECT_GT(relative_scene_rmse(direct.radiance(), set.radiance()), 0.02);
}

TEST(RelightSession, WhileLightMovesThereAreNoMoreBouncesThanRequested) {
    RenderSettings settings = opened().settings();
    settings.bounces.most = 1;
    RelightSession session(opened().scene(), settings, {0.003f});
    ASSERT_TRUE(session.vary_light());
    for (int i = 1; i <= 4; ++i) {
        session.turn_environment(rotation_about({0, 1, 0}, 0.02 * i));
        ASSERT_TRUE(session.frame(FrameQuality::moving));
    }
    const SceneColours moving = session.radiance();
    ASSERT_TRUE(session.frame(FrameQuality::still));
    EXPECT_LT(relative_scene_rmse(moving, session.radiance()), 0.005);  // moving frames are smoothed less
}

Mesh torus_mesh(const Vec3f& centre, float radius, float thickness, std::uint32_t around,
                std::uint32_t across) {
    Mesh mesh;
    mesh.material_names = {"material"};
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t k = 0; k < across; ++k) {
            const float a = float(2 * pi) * float(i) / float(around),
                        b = float(2 * pi) * float(k) / float(across);
            const Vec3f outwards(std::cos(a), 0, std::sin(a));
            const Vec3f normal = outwards * std::cos(b) + Vec3f(0, std::sin(b), 0);
            mesh.positions.push_back(centre + outwards * radius + normal * thickness);
            mesh.normals.push_back(normal);
            mesh.vertex_materials.push_back(0);
            const auto at = [&](std::uint32_t x, std::uint32_t y) {
                return x % around * across + y % across;
            };
            mesh.triangles.push_back({at(i, k), at(i, k + 1), at(i + 1, k)});
            mesh.triangles.push_back({at(i + 1, k), at(i, k + 1), at(i + 1, k + 1)});
        }
    return mesh;
}

/// A torus next to a box on a floor, all with a specular lobe.
class SpecularScene {
public:
    SpecularScene() {
        Material material = matte(0.6f);
        material.specular = Rgb(0.2f);
        material.shininess = 40;
        PreparedMesh floor = prepared_as_is(square_mesh(3, 0, 16));
        floor.coarse = square_mesh(3, 0);
        example.add_entity(floor, material, 6, 18);
        example.add_entity(box_mesh({-0.4f, 0, -0.3f}, {0.4f, 0.8f, 0.3f}, 6), material, 100, 200);
        example.add_entity(torus_mesh({0, 0.2f, 0}, 0.4f, 0.15f, 48, 24), material, 100, 200);
        ShadedScene& scene = example.scene;
        scene.instances = {{0, {}}, {1, {{-0.7f, 0, 0}, 1}}, {2, {{0.5f, 0, 0.3f}, 1}}};
        scene.environment = sky(0.4);
        scene.eye = {2, 1.5f, 3};
    }

    RelightSession session(int bounces = any_bounces) const {
        RenderSettings settings;
        settings.face_size = ExampleScene::size;
        settings.occlusion = Occlusion::fields;
        settings.bounces.most = bounces;
        settings.bounces.directions = 512;
        return RelightSession(example.scene, settings, {0.003f});
    }

    ExampleScene example;
};

TEST(RelightSession, FramesOfAFixedEyeHaveIndirectLightInSpecularReflections) {
    static const SpecularScene opened;
    RelightSession session = opened.session();
    const auto expect_frame_as_commit = [&](const char* what) {
        ASSERT_TRUE(session.frame()) << what;
        EXPECT_FALSE(session.lacks_reflections());
        const SceneColours frame = session.radiance();
        ASSERT_TRUE(session.commit());
        for (std::size_t i = 0; i < frame.size(); ++i)
            EXPECT_LT(relative_scene_rmse({frame[i]}, {session.radiance()[i]}), 0.01)
                << what << ", instance " << i;
    };
    ASSERT_TRUE(session.vary_light());
    expect_frame_as_commit("as opened");
    session.turn_environment(rotation_about({0, 1, 0}, 1.3));
    expect_frame_as_commit("rotated light");
    session.set_environment(sky(2));
    expect_frame_as_commit("another light");

    ASSERT_TRUE(session.vary_instance(1));
    expect_frame_as_commit("instance");
    session.place(1, {{-0.8f, 0, 0.1f}, 1});
    ASSERT_TRUE(session.vary_instance(1));
    expect_frame_as_commit("instance in another place");

    ASSERT_TRUE(session.vary_lamps());
    Lamp lamp;
    lamp.position = {0.3f, 1.5f, 1};
    lamp.colour = Rgb(2.0f);
    session.set_lamps({lamp});
    expect_frame_as_commit("a lamp");
    lamp.colour = Rgb(1.0f, 3.0f, 2.0f);
    session.set_lamps({lamp});
    expect_frame_as_commit("another colour of the lamp");
    ASSERT_TRUE(session.vary_light());
    expect_frame_as_commit("a lamp, and the light varies");

    Material green = opened.example.scene.entities[0].materials.front();
    green.diffuse = Rgb(0.2f, 0.6f, 0.3f);
    session.set_materials(0, {green});
    ASSERT_TRUE(session.vary_light());
    expect_frame_as_commit("another material");

    ASSERT_TRUE(session.vary_eye());
    session.set_eye({-1, 1, 3});
    expect_frame_as_commit("another eye, still");
    session.set_eye({-1, 2, 3});
    ASSERT_TRUE(session.frame(FrameQuality::moving));
    EXPECT_TRUE(session.lacks_reflections());
}

/// Returns zeros, as many as there are values.
SceneColours black(SceneColours values) {
    for (std::vector<Rgb>& of_instance : values) std::ranges::fill(of_instance, Rgb(0.0f));
    return values;
}

/// Returns one component of the radiance of each instance.
SceneColours component(const RelightSession& session, Rgb Outgoing::*part) {
    SceneColours colours(session.instances().size());
    for (std::size_t i = 0; i < colours.size(); ++i)
        for (const Outgoing& value : session.outgoing(i)) colours[i].push_back(value.*part);
    return colours;
}

TEST(RelightSession, FramesHaveTheComponentsOfACommit) {
    static const SpecularScene opened;
    for (const int bounces : {0, any_bounces}) {
        RelightSession session = opened.session(bounces);
        const auto expect_components = [&](const char* what, double of_specular = 0.02,
                                           double of_diffuse = 0.01) {
            ASSERT_TRUE(session.frame()) << what;
            const SceneColours diffuse = component(session, &Outgoing::diffuse),
                               specular = component(session, &Outgoing::specular);
            ASSERT_TRUE(session.commit());
            EXPECT_LT(relative_scene_rmse(diffuse, component(session, &Outgoing::diffuse)), of_diffuse)
                << what << ", bounces " << bounces;
            EXPECT_LT(relative_scene_rmse(specular, component(session, &Outgoing::specular)), of_specular)
                << what << ", bounces " << bounces;
            EXPECT_GT(largest_difference(specular, black(specular)), 0.1);
        };
        Lamp lamp;
        lamp.position = {0.3f, 1.5f, 1};
        lamp.colour = Rgb(2.0f);
        session.set_lamps({lamp});
        ASSERT_TRUE(session.vary_instance(1));
        ASSERT_TRUE(session.frame());
        EXPECT_EQ(component(session, &Outgoing::diffuse), session.radiance());

        session.separate_components(true);
        EXPECT_FALSE(session.has_vectors());
        ASSERT_TRUE(session.vary_instance(1));
        session.place(1, {{-0.8f, 0, 0.1f}, 1});
        // Indirect light stays as it was before the motion.
        expect_components("instance", 0.05, bounces > 0 ? 0.03 : 0.01);
        ASSERT_TRUE(session.vary_light());
        expect_components("light");
        ASSERT_TRUE(session.vary_eye());
        session.set_eye({-1, 1, 3});
        expect_components("eye");
        ASSERT_TRUE(session.vary_lamps());
        lamp.colour = Rgb(1.0f, 3.0f, 2.0f);
        session.set_lamps({lamp});
        expect_components("lamp");
        session.separate_components(false);
        EXPECT_EQ(component(session, &Outgoing::diffuse), session.radiance());
    }
}

TEST(RelightSession, OcclusionIsChosenForEachCommit) {
    RelightSession session = opened(Occlusion::automatic).session(), fields = opened().session();
    ASSERT_TRUE(session.commit());
    const SceneColours exact = session.radiance();
    ASSERT_TRUE(session.vary_light());
    session.set_occlusion(Occlusion::fields);
    EXPECT_TRUE(session.has_vectors());
    ASSERT_TRUE(session.commit());
    ASSERT_TRUE(fields.commit());
    EXPECT_EQ(session.radiance(), fields.radiance());
    EXPECT_NE(session.radiance(), exact);
    session.set_occlusion(Occlusion::automatic);
    ASSERT_TRUE(session.commit());
    EXPECT_EQ(session.radiance(), exact);
}

TEST(RelightSession, VectorsComputedInTheDarkWorkForOtherLight) {
    ShadedScene scene = opened().scene();
    const Environment bright = scene.environment;
    scene.environment = LatLongImage{4, 2, std::vector<Rgb>(8, Rgb(0.0f))};
    RelightSession session(scene, opened().settings(), {0.003f});
    ASSERT_TRUE(session.vary_light());
    session.set_environment(bright);
    ASSERT_TRUE(session.frame());
    const SceneColours frame = session.radiance();
    ASSERT_TRUE(session.commit());
    EXPECT_LT(relative_scene_rmse(frame, session.radiance()), 0.02);
}

TEST(RelightSession, BeforeItMovesAllVerticesOfTheInstanceAreShaded) {
    RelightSession session = opened().session();
    ASSERT_TRUE(session.vary_instance(1));
    ASSERT_TRUE(session.frame(FrameQuality::moving));
    RenderSettings four_levels = opened().settings();
    four_levels.depth = 4;
    RelightSession coarse(opened().scene(), four_levels);
    ASSERT_TRUE(coarse.commit());
    EXPECT_LT(relative_scene_rmse({session.radiance()[1]}, {coarse.radiance()[1]}), 1e-6);
}

TEST_P(RelightSessionBy, ThirtyRandomEditsEqualAFreshBake) {
    RelightSession session = opened(GetParam()).session();
    std::mt19937 random(2006);
    const auto between = [&](float low, float high) { return uniform(random, low, high); };
    int counts[5] = {};
    for (int edit = 0; edit < 30; ++edit) {
        const std::size_t count = session.instances().size();
        // The floor stays.
        const std::size_t instance = count > 1 ? 1 + random() % (count - 1) : 0;
        unsigned kind = random() % 5;
        if (instance == 0) break;
        if (kind == 1 && count < 4) kind = 0;
        if (kind == 0 && count > 6) kind = 1;
        ++counts[kind];
        const Placement before = session.instances()[instance].placement;
        switch (kind) {
            case 0: EXPECT_EQ(session.clone(instance), count); break;
            case 1: session.remove(instance); break;
            case 2:
                session.place(instance,
                              {before.translate + Vec3f{between(-1, 1), between(0, 0.3f), between(-1, 1)},
                               before.scale, before.rotate});
                break;
            case 3:
                session.place(instance,
                              {before.translate, before.scale * between(0.8f, 1.25f), before.rotate});
                break;
            default:
                session.rotate(instance, Vec3d{between(-1, 1), between(-1, 1), between(-1, 1)},
                               between(0.1f, 3));
        }
        // Some edits are preceded by the computation of transfer vectors.
        if (edit % 7 == 3) {
            ASSERT_TRUE(session.vary_light());
            ASSERT_TRUE(session.frame());
            EXPECT_EQ(session.radiance().size(), session.instances().size());
        }
    }
    for (const int count : counts) EXPECT_GT(count, 1);
    ASSERT_TRUE(session.commit());
    EXPECT_LT(largest_difference(session.radiance(), opened(GetParam()).fresh_bake(session)), 1e-6);
}

TEST_P(RelightSessionBy, ACommitIncludesEachChangeSinceTheLast) {
    const std::pair<const char*, std::function<void(RelightSession&)>> changes[] = {
        {"light", [](RelightSession& session) { session.set_environment(sky(2)); }},
        {"eye",
         [](RelightSession& session) {
             session.set_eye({-3, 1, 1});
         }},
        {"place",
         [](RelightSession& session) {
             session.place(1, {{0.2f, 0.3f, -1}, 1.2f});
         }},
        {"clone", [](RelightSession& session) { session.clone(1); }},
        {"remove", [](RelightSession& session) { session.remove(1); }},
        {"rotate", [](RelightSession& session) { session.rotate(1, Vec3d(0, 1, 0), 0.7); }}};
    for (const auto& [name, change] : changes) {
        RelightSession session = opened(GetParam()).session(), fresh = opened(GetParam()).session();
        ASSERT_TRUE(session.commit());
        const SceneColours before = session.radiance();
        std::stop_source stop;
        stop.request_stop();
        change(session);
        change(fresh);
        EXPECT_FALSE(session.commit({{}, stop.get_token()}));
        EXPECT_EQ(session.radiance(), before) << name;
        ASSERT_TRUE(session.commit());
        ASSERT_TRUE(fresh.commit());
        EXPECT_EQ(session.radiance(), fresh.radiance()) << name;
        EXPECT_NE(session.radiance(), before) << name;
    }
}

TEST(RelightSession, RotatingBackRestoresTheRadiance) {
    RelightSession session = opened().session();
    ASSERT_TRUE(session.commit());
    const SceneColours before = session.radiance();
    session.rotate(1, {0, 0, 1}, 1);
    session.rotate(1, {1, 2, 1}, -0.3);
    ASSERT_TRUE(session.commit());
    EXPECT_NE(session.radiance(), before);
    session.rotate(1, {1, 2, 1}, 0.3);
    session.rotate(1, {0, 0, 1}, -1);
    ASSERT_TRUE(session.commit());
    EXPECT_EQ(session.radiance(), before);
}

TEST_P(RelightSessionBy, InterruptedCallsChangeNothing) {
    RelightSession session = opened(GetParam()).session();
    ASSERT_TRUE(session.vary_light());
    ASSERT_TRUE(session.frame());
    const SceneColours before = session.radiance();
    std::stop_source stop;
    stop.request_stop();
    const Progress progress{{}, stop.get_token()};
    const auto instances = session.instances();
    const auto is_interrupted = [](const Result<Done>& result) {
        return !result && result.error().code == ErrorCode::interrupted;
    };
    EXPECT_TRUE(is_interrupted(opened(GetParam()).session().prepare(progress)));
    EXPECT_TRUE(is_interrupted(session.vary_eye(progress)));
    EXPECT_TRUE(is_interrupted(session.vary_instance(1, progress)));
    EXPECT_TRUE(is_interrupted(session.commit(progress)));
    EXPECT_TRUE(is_interrupted(session.frame(FrameQuality::still, progress)));
    EXPECT_EQ(session.instances(), instances);
    EXPECT_EQ(session.radiance(), before);
    ASSERT_TRUE(session.frame());
    EXPECT_EQ(session.radiance(), before);
}

TEST(RelightSession, MeasuresTheErrorOfDisplayedRadiance) {
    const OpenedScene opened(Occlusion::exact);
    RelightSession session = opened.session();
    session.turn_environment(rotation_about({0, 1, 0}, 1));
    ASSERT_TRUE(session.commit());
    const auto displayed = [&](float gain) {
        SceneRadiance radiance;
        for (const std::vector<Rgb>& colours : session.radiance()) {
            radiance.emplace_back();
            for (const Rgb& colour : colours) radiance.back().push_back({colour * gain, Rgb(0.0f)});
        }
        return radiance;
    };
    const std::vector<DisplayedPoint> points = area_points(session.scene(), 4096);
    const BakeError exact = *session.error(displayed(1), points, 0.02),
                    brighter = *session.error(displayed(1.5f), points, 0.02);
    EXPECT_LT(exact.at_vertices, 0.1);
    EXPECT_LT(exact.low, exact.total);
    EXPECT_LT(exact.total, exact.high);
    EXPECT_NEAR(brighter.total, std::hypot(0.5, exact.total), 0.15);
}

}  // namespace
}  // namespace haarfield
