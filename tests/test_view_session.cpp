#include "tools/view/view_session.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "scenes/scene_environment.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_shading.h"
#include "shading/bake/renderer.h"
#include "tests/fixtures/test_folder.h"
#include "tests/fixtures/with_threads.h"

#include <Imath/half.h>

namespace haarfield {
namespace {

constexpr auto patience = std::chrono::seconds(60);

/// A session with a chair on a floor under a sky, and pages that record what they receive.
class OpenedSession {
public:
    /// Opens a session. more: additional tables of the scene file.
    explicit OpenedSession(const std::string& more = "") {
        write_text(folder_ / "room.toml",
                   "[camera]\nposition = [1.3, 1.2, 1.9]\ntarget = [0, 0.4, 0]\n"
                   "[environment]\nsky = { turbidity = 3, sun_elevation = 40 }\n"
                   "[materials.lacquer]\ndiffuse = [0.3, 0.12, 0.05]\nspecular = [0.3, 0.3, 0.3]\n"
                   "[entities.floor]\nmesh = \"" HAARFIELD_SOURCE_DIR
                   "/scenes/meshes/floor.obj\"\nmaterial = \"lacquer\"\nfine_vertices = 300\n"
                   "[entities.chair]\nmesh = \"" HAARFIELD_SOURCE_DIR
                   "/scenes/meshes/chair.obj\"\nmaterial = \"lacquer\"\nfine_vertices = 500\n"
                   "coarse_triangles = 300\nplanar_samples = 60\nspherical_samples = 60\n"
                   "[[instances]]\nentity = \"floor\"\n[[instances]]\nentity = \"chair\"\n" +
                       more);
        scene_ = *read_scene(folder_ / "room.toml");
        SceneEntityOptions options;
        options.fields_folder = folder_ / "fields";
        options.face_size = settings_.render.face_size = 16;
        SceneEntities entities = std::move(*prepare_scene_entities(scene_, options));
        settings_.scene_file = folder_ / "room.toml";
        settings_.tasks.output = folder_ / "out";
        shelf_.emplace(scene_.environment, "", folder_ / "lights");
        Audience audience{[this](PageId page, const std::string& text) { note(page, text); },
                          [this](const std::string& text) { note(0, text); },
                          [this](SharedBytes frame) { note(std::move(frame)); },
                          [this](PageId, SharedBytes frame) { note(std::move(frame)); }, [](PageId) {}};
        session_.emplace(scene_, std::move(entities), settings_, *shelf_, audience);
    }

    ViewSession& session() { return *session_; }
    const TestFolder& folder() const { return folder_; }
    const Scene& scene() const { return scene_; }
    const RenderSettings& render() const { return settings_.render; }

    /// Sends a message with an unused number.
    std::uint32_t send(PageId page, nlohmann::json message) {
        message["number"] = ++number_;
        session_->receive(page, message.dump());
        return number_;
    }

    /// Waits for an exact frame that shows a message. Returns it, or null.
    SharedBytes exact(std::uint32_t message = 0) {
        std::unique_lock lock(mutex_);
        const auto is_there = [&] {
            return frame_ && word(*frame_, 3) == std::uint32_t(Exactness::exact) &&
                   word(*frame_, 2) >= message;
        };
        return changed_.wait_for(lock, patience, is_there) ? frame_ : nullptr;
    }

    /// Waits for a text to a page, or to all pages. Returns it, or null if none arrives.
    template <class Fits>
    nlohmann::json told(const Fits& fits) {
        std::unique_lock lock(mutex_);
        nlohmann::json found;
        changed_.wait_for(lock, patience, [&] {
            for (const auto& [page, text] : texts_)
                if (fits(page, text)) found = text;
            return !found.is_null();
        });
        return found;
    }

    std::size_t errors() {
        const std::lock_guard lock(mutex_);
        return std::size_t(
            std::ranges::count_if(texts_, [](const auto& each) { return each.second["type"] == "error"; }));
    }

    static std::uint32_t word(const std::string& bytes, std::size_t place) {
        std::uint32_t value = 0;
        std::memcpy(&value, bytes.data() + 4 * place, 4);
        return value;
    }

private:
    void note(PageId page, const std::string& text) {
        const std::lock_guard lock(mutex_);
        texts_.emplace_back(page, nlohmann::json::parse(text));
        changed_.notify_all();
    }
    void note(SharedBytes frame) {
        const std::lock_guard lock(mutex_);
        frame_ = std::move(frame);
        changed_.notify_all();
    }

    TestFolder folder_;
    Scene scene_;
    ViewSettings settings_;
    std::optional<LightShelf> shelf_;
    std::uint32_t number_ = 0;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<std::pair<PageId, nlohmann::json>> texts_;
    SharedBytes frame_;
    std::optional<ViewSession> session_;  ///< Last member, because it calls all of the above.
};

/// Returns the colours after a frame's header: two objects, uncompressed.
std::string colours_of(const std::string& frame) {
    return frame.substr(24);
}

/// Returns the radiance that `bake` computes for a scene, with the session's fields and settings.
Result<SceneColours> baked(OpenedSession& opened, const Scene& scene) {
    SceneEntityOptions options;
    options.fields_folder = opened.folder() / "fields";
    options.face_size = opened.render().face_size;
    const Result<SceneEntities> entities = prepare_scene_entities(scene, options);
    if (!entities) return entities.error();
    const Result<SceneEnvironment> light = scene_environment(scene);
    if (!light) return light.error();
    const Result<SceneRadiance> radiance =
        scene_radiance(shaded_scene(scene, *entities, light->environment), opened.render());
    if (!radiance) return radiance.error();
    return total(*radiance);
}

TEST(ViewSession, ShowsTheRenderersResultAtRest) {
    OpenedSession opened;
    opened.session().join(1);
    const SharedBytes frame = opened.exact();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->substr(0, 4), "HFF1");
    const Result<SceneColours> radiance = baked(opened, opened.scene());
    ASSERT_TRUE(bool(radiance));
    std::size_t at = 24;
    for (std::size_t i = 0; i < radiance->size(); ++i) {
        ASSERT_EQ(OpenedSession::word(*frame, at / 4), i + 1);
        ASSERT_EQ(OpenedSession::word(*frame, at / 4 + 1), (*radiance)[i].size());
        at += 12;
        for (const Rgb& wanted : (*radiance)[i])
            for (int c = 0; c < 3; ++c, at += 2) {
                std::uint16_t half = 0;
                std::memcpy(&half, frame->data() + at, 2);
                ASSERT_NEAR(imath_half_to_float(half), wanted[c], 1e-3f * wanted[c] + 1e-5f) << i;
            }
        at += at % 4;
    }
    EXPECT_EQ(at, frame->size());
}

TEST(ViewSession, LeavesTheNumberOfThreads) {
    with_threads(3, [] {
        OpenedSession opened;
        opened.session().join(1);
        EXPECT_EQ(allowed_threads(), 3u);
        ASSERT_TRUE(opened.exact());
        EXPECT_EQ(allowed_threads(), 3u);
        const std::uint32_t moved =
            opened.send(1, {{"type", "place"}, {"object", 2}, {"translate", {0.3, 0, 0}}});
        ASSERT_TRUE(opened.exact(moved));
        EXPECT_EQ(allowed_threads(), 3u);
    });
}

TEST(ViewSession, BrokenAndStrangersMessagesChangeNothing) {
    OpenedSession opened;
    opened.session().join(1);
    opened.session().join(2);
    const SharedBytes before = opened.exact();
    ASSERT_TRUE(before);
    const std::vector<std::string> files = opened.folder().files();
    std::mt19937 random(19);
    const std::vector<std::string> texts{
        R"({"type":"place","object":2,"translate":[1,0,0]})", R"({"type":"turn_light","rotation":[0,1,0,1]})",
        R"({"type":"save","name":"../outside"})", R"({"type":"light","light":"../../etc/passwd"})",
        R"({"type":"delete","object":1})"};
    for (int i = 0; i < 10000; ++i) {
        std::string text = texts[std::size_t(i) % texts.size()];
        // Page 2 does not steer and may send anything; messages of page 1 are damaged.
        if (i % 2 == 0) {
            text.resize(random() % text.size());
        } else {
            text[random() % text.size()] = static_cast<char>(random() % 256);
        }
        opened.session().receive(i % 2 == 0 ? 1 : 2, text);
    }
    EXPECT_TRUE(opened.told([](PageId page, const nlohmann::json&) { return page == 2; }).is_object());
    // An object, a light and a material that do not exist.
    for (const nlohmann::json& message : {nlohmann::json{{"type", "place"}, {"object", 9}, {"scale", 2}},
                                          {{"type", "light"}, {"light", "../../etc/passwd"}},
                                          {{"type", "material"}, {"name", "gold"}}}) {
        const std::uint32_t number = opened.send(1, message);
        EXPECT_TRUE(opened
                        .told([&](PageId page, const nlohmann::json& text) {
                            return page == 1 && text["type"] == "error" && text.value("number", 0u) == number;
                        })
                        .is_object());
    }
    EXPECT_GE(opened.errors(), 10003u);
    // Errors about invalid messages contain their numbers, too.
    const std::uint32_t number = opened.send(1, {{"type", "mix"}, {"share", 2}});
    EXPECT_TRUE(opened
                    .told([&](PageId page, const nlohmann::json& text) {
                        return page == 1 && text["type"] == "error" && text.value("number", 0u) == number &&
                               text.value("about", "") == "mix";
                    })
                    .is_object());
    // A page that joins receives the unmodified scene.
    opened.session().join(3);
    const nlohmann::json scene = opened.told(
        [](PageId page, const nlohmann::json& text) { return page == 3 && text["type"] == "scene"; });
    EXPECT_FALSE(scene["can_undo"]);
    EXPECT_FALSE(scene["steers"]);
    EXPECT_EQ(colours_of(*opened.exact()), colours_of(*before));
    EXPECT_EQ(opened.folder().files(), files);
}

TEST(ViewSession, UndoRestoresTheColours) {
    OpenedSession opened;
    opened.session().join(1);
    const SharedBytes before = opened.exact();
    ASSERT_TRUE(before);
    const SharedBytes moved =
        opened.exact(opened.send(1, {{"type", "place"}, {"object", 2}, {"translate", {0.3, 0, 0}}}));
    ASSERT_TRUE(moved);
    EXPECT_NE(colours_of(*moved), colours_of(*before));
    const SharedBytes back = opened.exact(opened.send(1, {{"type", "undo"}}));
    ASSERT_TRUE(back);
    EXPECT_EQ(colours_of(*back), colours_of(*before));
}

TEST(ViewSession, AnOrbitIsTakenBackInOneStep) {
    OpenedSession opened;
    opened.session().join(1);
    const SharedBytes before = opened.exact();
    ASSERT_TRUE(before);
    const Vec3f eye = opened.scene().camera.position;
    const auto look = [&](double x, std::uint32_t gesture) {
        return opened.send(1, {{"type", "look"},
                               {"gesture", gesture},
                               {"position", {x, double(eye.y), double(eye.z)}},
                               {"target", {0, 0.4, 0}},
                               {"vertical_fov", 40},
                               {"width", 640},
                               {"height", 480}});
    };
    // A change of the window only is not a step, with any rounding errors.
    look(double(eye.x) * (1 + 1e-7), 1);
    for (const double x : {1.0, 0.5, -0.5}) look(x, 2);
    const SharedBytes there = opened.exact(look(-1.2, 2));
    ASSERT_TRUE(there);
    EXPECT_NE(colours_of(*there), colours_of(*before));
    const std::uint32_t undo = opened.send(1, {{"type", "undo"}});
    const nlohmann::json state = opened.told([](PageId, const nlohmann::json& text) {
        return text["type"] == "state" && text.value("steps", false);
    });
    ASSERT_TRUE(state.is_object());
    EXPECT_EQ(state["camera"]["position"][0], eye.x);
    EXPECT_FALSE(state["can_undo"]);
    EXPECT_EQ(colours_of(*opened.exact(undo)), colours_of(*before));
    EXPECT_EQ(colours_of(*opened.exact(opened.send(1, {{"type", "redo"}}))), colours_of(*there));
}

TEST(ViewSession, ExposureScalesTheColours) {
    OpenedSession opened;
    opened.session().join(1);
    const SharedBytes before = opened.exact();
    ASSERT_TRUE(before);
    const SharedBytes after = opened.exact(opened.send(1, {{"type", "exposure"}, {"stops", 1}}));
    ASSERT_TRUE(after);
    for (std::size_t at = 36; at < 36 + 600; at += 2) {
        std::uint16_t one = 0, two = 0;
        std::memcpy(&one, before->data() + at, 2);
        std::memcpy(&two, after->data() + at, 2);
        ASSERT_FLOAT_EQ(2 * imath_half_to_float(one), imath_half_to_float(two));
    }
}

/// Compares the colours of the first object between the session and the renderer.
///
/// glow  emission of all of its surfaces.
double largest_difference_to_bake(OpenedSession& opened, const SharedBytes& frame, const Scene& scene,
                                  const Rgb& glow = Rgb(0.0f)) {
    const Result<SceneColours> radiance = baked(opened, scene);
    if (!radiance) return INFINITY;
    double largest = 0;
    std::size_t at = 36;
    for (const Rgb& reflected : radiance->front()) {
        const Rgb wanted = reflected + glow;
        for (int c = 0; c < 3; ++c, at += 2) {
            std::uint16_t half = 0;
            std::memcpy(&half, frame->data() + at, 2);
            largest = std::max(largest, double(std::abs(imath_half_to_float(half) - wanted[c])) /
                                            (double(wanted[c]) + 0.01));
        }
    }
    return largest;
}

TEST(ViewSession, LampsChangeWhileTheSceneIsOpen) {
    OpenedSession opened("[[lights]]\nname = \"bulb\"\nposition = [0.5, 1.5, 0.5]\ncolour = [3, 2, 1]\n");
    opened.session().join(1);
    const SharedBytes before = opened.exact();
    ASSERT_TRUE(before);
    SharedBytes frame = opened.exact(opened.send(
        1, {{"type", "lamp"}, {"name", "bulb"}, {"colour", {1, 4, 2}}, {"position", {-0.5, 1.25, 0.5}}}));
    ASSERT_TRUE(frame);
    Scene scene = opened.scene();
    scene.lamps[0].colour = {1, 4, 2};
    scene.lamps[0].position = {-0.5f, 1.25f, 0.5f};
    EXPECT_LT(largest_difference_to_bake(opened, frame, scene), 2e-3);
    frame = opened.exact(opened.send(1, {{"type", "undo"}}));
    ASSERT_TRUE(frame);
    EXPECT_EQ(colours_of(*frame), colours_of(*before));
}

TEST(ViewSession, TheSunMovesWhileTheSceneIsOpen) {
    OpenedSession opened;
    opened.session().join(1);
    ASSERT_TRUE(opened.exact());
    const SharedBytes frame = opened.exact(
        opened.send(1, {{"type", "sky"}, {"turbidity", 6}, {"sun_elevation", 15}, {"sun_azimuth", -100}}));
    ASSERT_TRUE(frame);
    Scene scene = opened.scene();
    scene.environment.sky->turbidity = 6;
    scene.environment.sky->sun_elevation = radians(15.0f);
    scene.environment.sky->sun_azimuth = radians(-100.0f);
    EXPECT_LT(largest_difference_to_bake(opened, frame, scene), 2e-3);
    const nlohmann::json state = opened.told(
        [](PageId, const nlohmann::json& text) { return text["type"] == "state" && text.contains("light"); });
    EXPECT_EQ(state["light"]["light"], "sky");
    EXPECT_NEAR(state["light"]["sky"]["sun_elevation"], 15, 1e-4);
}

TEST(ViewSession, ThePartOfAModelGetsAMaterialThatCanBeEdited) {
    OpenedSession opened("[entities.stool]\nmesh = \"" HAARFIELD_SOURCE_DIR
                         "/scenes/meshes/floor.obj\"\nfine_vertices = 300\ncoarse_triangles = 0\n"
                         "[[instances]]\nentity = \"stool\"\ntranslate = [0, 0.5, 0]\nscale = 0.2\n");
    opened.session().join(1);
    const SharedBytes before = opened.exact();
    ASSERT_TRUE(before);
    const SharedBytes copied =
        opened.exact(opened.send(1, {{"type", "own_material"}, {"object", 3}, {"part", 0}}));
    ASSERT_TRUE(copied);
    EXPECT_EQ(colours_of(*copied), colours_of(*before));
    const nlohmann::json state = opened.told([](PageId, const nlohmann::json& text) {
        return text["type"] == "state" && text.contains("part_materials");
    });
    ASSERT_TRUE(state.is_object());
    const std::string name = state["part_materials"][2][0];
    ASSERT_TRUE(state["materials"].contains(name));
    SharedBytes frame = opened.exact(opened.send(
        1, {{"type", "material"}, {"name", name}, {"diffuse", {0.9, 0.1, 0.1}}, {"emission", {1, 0, 0}}}));
    ASSERT_TRUE(frame);
    EXPECT_NE(colours_of(*frame), colours_of(*before));
    for (int step = 0; step < 2; ++step) frame = opened.exact(opened.send(1, {{"type", "undo"}}));
    ASSERT_TRUE(frame);
    EXPECT_EQ(colours_of(*frame), colours_of(*before));
    // A part with a material of the scene keeps it.
    opened.send(1, {{"type", "own_material"}, {"object", 1}, {"part", 0}});
    EXPECT_TRUE(opened
                    .told([](PageId, const nlohmann::json& text) {
                        return text["type"] == "error" && text.value("about", "") == "own_material";
                    })
                    .is_object());
}

TEST(ViewSession, UnsavedChangesAreAutosaved) {
    OpenedSession opened;
    opened.session().join(1);
    ASSERT_TRUE(opened.exact(opened.send(1, {{"type", "place"}, {"object", 2}, {"translate", {0.3, 0, 0}}})));
    const Result<Scene> left = read_scene(opened.folder() / "room.autosave.toml");
    ASSERT_TRUE(bool(left));
    EXPECT_EQ(left->instances[1].placement.translate, Vec3f(0.3f, 0, 0));
    ASSERT_TRUE(opened.exact(opened.send(1, {{"type", "undo"}})));
    EXPECT_FALSE(std::filesystem::exists(opened.folder() / "room.autosave.toml"));
}

TEST(ViewSession, ExposureDoesNotChangeLamps) {
    OpenedSession opened(
        "[[lights]]\nposition = [0.5, 1.5, 0.5]\ncolour = [3, 2, 1]\nlooks_like = \"chair\"\n");
    opened.session().join(1);
    SharedBytes frame = opened.exact();
    ASSERT_TRUE(frame);
    Scene scene = opened.scene();
    EXPECT_LT(largest_difference_to_bake(opened, frame, scene), 2e-3);
    frame = opened.exact(opened.send(1, {{"type", "exposure"}, {"stops", -2}}));
    ASSERT_TRUE(frame);
    scene.environment.exposure = -2.0f;
    EXPECT_LT(largest_difference_to_bake(opened, frame, scene), 2e-3);
    // The shape of the light (looks_like) is restored, and does not shadow it, as before.
    ASSERT_TRUE(opened.exact(opened.send(1, {{"type", "delete"}, {"object", 2}})));
    frame = opened.exact(opened.send(1, {{"type", "undo"}}));
    ASSERT_TRUE(frame);
    EXPECT_LT(largest_difference_to_bake(opened, frame, scene), 2e-3);
}

TEST(ViewSession, EditedEmittersLightOtherSurfaces) {
    OpenedSession opened;
    opened.session().join(1);
    ASSERT_TRUE(opened.exact());
    const SharedBytes frame = opened.exact(opened.send(1, {{"type", "material"},
                                                           {"name", "lacquer"},
                                                           {"diffuse", {0.3, 0.12, 0.05}},
                                                           {"specular", {0, 0, 0}},
                                                           {"shininess", 60},
                                                           {"emission", {0.5, 1, 2}}}));
    ASSERT_TRUE(frame);
    Scene scene = opened.scene();
    scene.materials["lacquer"].specular = Rgb(0.0f);
    scene.materials["lacquer"].emission = Rgb(0.5f, 1, 2);
    EXPECT_LT(largest_difference_to_bake(opened, frame, scene, Rgb(0.5f, 1, 2)), 2e-3);
}

TEST(ViewSession, SavesInsideItsFolderOnly) {
    OpenedSession opened;
    opened.session().join(1);
    const std::vector<std::string> files = opened.folder().files();
    const std::uint32_t outside = opened.send(1, {{"type", "save"}, {"name", "../../other scene"}});
    EXPECT_TRUE(opened
                    .told([&](PageId, const nlohmann::json& text) {
                        return text["type"] == "error" && text.value("number", 0u) == outside;
                    })
                    .is_object());
    EXPECT_EQ(opened.folder().files(), files);
    opened.send(1, {{"type", "save"}, {"name", "other/../scene"}});
    const nlohmann::json saved =
        opened.told([](PageId, const nlohmann::json& text) { return text["type"] == "saved"; });
    ASSERT_TRUE(saved.is_object());
    const std::filesystem::path file = saved["file"].get<std::string>();
    EXPECT_EQ(std::filesystem::canonical(file).parent_path(),
              std::filesystem::canonical(opened.folder().path()));
    EXPECT_TRUE(bool(read_scene(file)));
}

TEST(ViewSession, ThePageThatStaysSteers) {
    OpenedSession opened;
    opened.session().join(1);
    opened.session().join(2);
    opened.session().leave(1);
    const nlohmann::json steering = opened.told([](PageId page, const nlohmann::json& text) {
        return page == 2 && text["type"] == "steering" && text["steers"] == true;
    });
    EXPECT_TRUE(steering.is_object());
}

}  // namespace
}  // namespace haarfield
