#include "shading/visibility/cached_visibility.h"

#include <gtest/gtest.h>

#include "tests/fixtures/furnished_room.h"

namespace haarfield {
namespace {

using furnished::Room;

/// The room with an instance for each method of occlusion, and one that is completely occluded.
struct Prepared {
    Room room;
    RenderSettings settings = furnished::settings();
    std::optional<ShadingGeometry> geometry;
    std::optional<SceneLight> light;

    explicit Prepared(Occlusion occlusion) {
        // A ball inside a block.
        room.scene.instances.push_back({room.scene.instances[4].entity, {{-0.6f, 0.2f, 0}, 0.3f}});
        settings.occlusion = occlusion;
        settings.occlusion_error = 0.05f;
        settings.exact_triangles = 2;  // the floor
        geometry = std::move(*shading_geometry(room.scene, settings));
        light = scene_light(room.scene.environment, settings);
    }
    SceneColours radiance(const CachedVisibility* kept = nullptr) const {
        return total(*scene_radiance({room.scene, *geometry, *light, settings, kept}));
    }
    std::size_t kept_vertices(const CachedVisibility& kept) const {
        std::size_t count = 0;
        for (std::size_t i = 0; i < room.scene.instances.size(); ++i) {
            const std::size_t entity = room.scene.instances[i].entity;
            for (const std::uint32_t v : geometry->entities[entity].order) {
                const bool is_buried = room.scene.entities[entity].occlusion->samples().buried[v] != 0;
                if (is_buried)
                    EXPECT_EQ(kept.find(i, v), nullptr);
                else
                    count += kept.find(i, v) != nullptr;
            }
        }
        return count;
    }
};

constexpr std::size_t plenty = std::size_t(1) << 30;

class CachedVisibilityBy : public testing::TestWithParam<Occlusion> {};
INSTANTIATE_TEST_SUITE_P(Occlusion, CachedVisibilityBy,
                         testing::Values(Occlusion::fields, Occlusion::exact, Occlusion::automatic),
                         [](const auto& test) {
                             return test.param == Occlusion::fields  ? "Fields"
                                    : test.param == Occlusion::exact ? "Exact"
                                                                     : "Automatic";
                         });

TEST_P(CachedVisibilityBy, RadianceIsBitIdenticalForNewLightAndANewEye) {
    Prepared prepared(GetParam());
    const CachedVisibility kept = *CachedVisibility::make(prepared.room.scene, *prepared.geometry, plenty);
    const SceneColours first = prepared.radiance(&kept);
    EXPECT_EQ(first, prepared.radiance());
    prepared.room.scene.environment = furnished::sky(2);
    prepared.light = scene_light(prepared.room.scene.environment, prepared.settings);
    prepared.room.scene.eye = {-2, 1, 0.5f};
    const SceneColours second = prepared.radiance(&kept);
    EXPECT_EQ(second, prepared.radiance());
    EXPECT_NE(first, second);
}

TEST_P(CachedVisibilityBy, StoresAsManyVerticesAsMemoryAllows) {
    const Prepared prepared(GetParam());
    const auto kept_in = [&](std::size_t bytes) {
        return *CachedVisibility::make(prepared.room.scene, *prepared.geometry, bytes);
    };
    constexpr std::size_t room = 50'000;
    const CachedVisibility all = kept_in(plenty), some = kept_in(room), none = kept_in(0);
    EXPECT_GT(prepared.kept_vertices(some), 10u);
    EXPECT_LT(prepared.kept_vertices(some), prepared.kept_vertices(all) / 2);
    EXPECT_LE(some.bytes(), room + none.bytes());
    EXPECT_GT(all.bytes(), some.bytes());
    const SceneColours radiance = prepared.radiance();
    EXPECT_EQ(prepared.radiance(&some), radiance);
    EXPECT_EQ(prepared.radiance(&none), radiance);
}

TEST(CachedVisibility, HasNoTreesInsideOtherInstances) {
    const Prepared prepared(Occlusion::exact);
    const CachedVisibility kept = *CachedVisibility::make(prepared.room.scene, *prepared.geometry, plenty);
    const std::size_t inside = prepared.room.scene.instances.size() - 1;
    for (std::size_t i = 0; i <= inside; ++i) {
        int count = 0;
        for (const std::uint32_t v :
             prepared.geometry->entities[prepared.room.scene.instances[i].entity].order)
            if (const VisibilityProduct* visibility = kept.find(i, v)) {
                count += i == inside || !visibility->trees.empty();
                EXPECT_TRUE(i < inside || visibility->trees.empty());
            }
        EXPECT_GT(count, 10) << i;
    }
}

TEST(CachedVisibility, CanBeInterrupted) {
    const Prepared prepared(Occlusion::fields);
    std::stop_source stop;
    stop.request_stop();
    const Result<CachedVisibility> kept =
        CachedVisibility::make(prepared.room.scene, *prepared.geometry, plenty, {{}, stop.get_token()});
    ASSERT_FALSE(kept);
    EXPECT_EQ(kept.error().code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace haarfield
