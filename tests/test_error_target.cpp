#include "shading/bake/error_target.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "shading/bake/bounced_radiance.h"
#include "shading/bake/path_tracer.h"
#include "shading/bake/ray_renderer.h"
#include "shading/bake/scrambled_sobol.h"
#include "tests/fixtures/lit_box.h"
#include "tests/fixtures/with_threads.h"

namespace haarfield {
namespace {

double square(const Rgb& colour) {
    return double(colour.dot(colour));
}

/// Shades as accurately as bakes do: other than in LitBox, sources are separated, and objects rasterized.
void make_accurate(LitBox& lit) {
    lit.settings.occlusion = Occlusion::exact;
    lit.settings.sources = SourceRule();
    lit.settings.light_coefficients = 0;
    lit.geometry = *shading_geometry(lit.example.scene, lit.settings);
    lit.light = scene_light(lit.example.scene.environment, lit.settings);
}

/// Returns the surface points of displayed points; all must be unburied.
std::vector<InstancePoint> surface_points(const LitBox& lit, const std::vector<DisplayedPoint>& points) {
    std::vector<InstancePoint> result;
    for (const DisplayedPoint& point : points)
        result.push_back(
            {point.at.instance, *surface_point(lit.example.scene.entities[point.at.instance], point.at)});
    return result;
}

/// Returns points of the floor, which no triangle buries.
std::vector<DisplayedPoint> floor_points(const LitBox& lit, std::size_t count) {
    std::vector<DisplayedPoint> points = area_points(lit.example.scene, count);
    std::erase_if(points, [](const DisplayedPoint& point) { return point.at.instance != LitBox::floor; });
    return points;
}

/// Returns the values that the vertices of the fine meshes display.
BakeErrorMeter::DisplayedRadiance by_vertices(const LitBox& lit, const SceneRadiance& radiance) {
    return [&](const MeshPoint& at) {
        BakeErrorMeter::Displayed shown;
        const auto& corners = lit.example.scene.entities[at.instance].mesh->triangles[at.triangle];
        for (std::size_t k = 0; k < 3; ++k)
            shown.radiance += radiance[at.instance][corners[k]] * at.weights()[k];
        shown.difference = 0.1f * shown.radiance.total().length();
        return shown;
    };
}

/// A bake whose values at displayed points are given.
class GivenBake {
public:
    void add(const MeshPoint& at, const BakeErrorMeter::Displayed& shown) { shown_[key(at)] = shown; }
    BakeErrorMeter::Displayed operator()(const MeshPoint& at) const { return shown_.at(key(at)); }

private:
    using Key = std::tuple<std::uint32_t, std::uint32_t, float, float>;
    static Key key(const MeshPoint& at) { return {at.instance, at.triangle, at.u, at.v}; }

    std::map<Key, BakeErrorMeter::Displayed> shown_;
};

TEST(BakeError, AreaPointsAreProportionalToArea) {
    const LitBox lit;
    const std::vector<DisplayedPoint> points = area_points(lit.example.scene, 4096);
    ASSERT_EQ(points.size(), 4096u);
    std::size_t on_floor = 0, in_quarter = 0;
    for (const InstancePoint& point : surface_points(lit, points)) {
        on_floor += point.instance == LitBox::floor;
        in_quarter +=
            point.instance == LitBox::floor && point.point.position.x > 0 && point.point.position.z > 0;
    }
    double box = 0;
    const Mesh& mesh = *lit.example.scene.entities[LitBox::box].mesh;
    const std::vector<std::uint8_t>& buried =
        lit.example.scene.entities[LitBox::box].occlusion->samples().buried;
    for (const auto& [a, b, c] : mesh.triangles)
        if (!buried[a] && !buried[b] && !buried[c])
            box += 0.5 * 1.44 *
                   double((mesh.positions[b] - mesh.positions[a])
                              .cross(mesh.positions[c] - mesh.positions[a])
                              .length());
    EXPECT_NEAR(double(on_floor) / 4096, 16 / (16 + box), 0.002);
    EXPECT_NEAR(double(in_quarter) / double(on_floor), 0.25, 0.01);
}

TEST(BakeError, InterpolationIsThatOfAllPoints) {
    const LitBox lit;
    const SceneRadiance radiance = *scene_radiance(lit.shading);
    const auto bake = by_vertices(lit, radiance);
    const std::vector<DisplayedPoint> points = floor_points(lit, 20000);
    const std::vector<Outgoing> exact = *point_radiance(lit.shading, surface_points(lit, points));
    double error = 0, all = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        error += square(bake(points[k].at).radiance.total() - exact[k].total());
        all += square(exact[k].total());
    }
    const double expected = std::sqrt(error / all);
    EXPECT_GT(expected, 0.02);
    BakeErrorMeter meter(lit.shading, points);
    int inside = 0;
    for (std::uint32_t seed = 0; seed < 10; ++seed) {
        const BakeErrorMeter::Interpolation between = *meter.interpolation_error(bake, seed);
        const BakeError found = meter.error(bake, between, {});
        EXPECT_NEAR(found.between, expected, 0.15 * expected) << "seed " << seed;
        EXPECT_NEAR(found.total, found.between, 1e-12);
        EXPECT_LT(found.high - found.low, 0.25 * found.total);
        inside += found.low <= expected && expected <= found.high;
        EXPECT_GT(found.worst.error, 2 * found.total);
    }
    EXPECT_GE(inside, 7);
    const double steering = std::sqrt(meter.steering_error(bake)->square.square);
    EXPECT_NEAR(steering, expected, 0.3 * expected);
}

TEST(BakeError, ShadingIsComparedWithUnbiasedReferences) {
    LitBox lit;
    make_accurate(lit);
    const std::vector<DisplayedPoint> points = floor_points(lit, 4096);
    const double unchanged = (*BakeErrorMeter(lit.shading, points).shading_error(0.01)).direct.square;
    EXPECT_LT(std::sqrt(std::max(0.0, unchanged)), 0.02);
    // A bake in light that is too bright by a tenth.
    Environment brighter = lit.example.scene.environment;
    for (Rgb& pixel : brighter.image.pixels) pixel *= 1.1f;
    lit.light = scene_light(brighter, lit.settings);
    const BakeErrorMeter::Shading found = *BakeErrorMeter(lit.shading, points).shading_error(0.01);
    EXPECT_NEAR(std::sqrt(found.direct.square), 0.1, 0.012);
    EXPECT_NEAR(found.all.square, found.direct.square, 1e-12);
    EXPECT_EQ(found.indirect.square, 0);
}

TEST(BakeError, IsRelativeToTheRadianceOfFewBrightPoints) {
    LitBox lit;
    make_accurate(lit);
    std::vector<DisplayedPoint> points = floor_points(lit, 40000);
    // One point in 5,000 has nine tenths of the mean square.
    for (std::size_t k = 2500; k < points.size(); k += 5000) points[k].diffuse = Rgb(300.0f);
    const SceneRadiance radiance = *scene_radiance(lit.shading);
    const auto bake = by_vertices(lit, radiance);
    const std::vector<Outgoing> exact = *point_radiance(lit.shading, surface_points(lit, points));
    double error = 0, all = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Vec3d shown = points[k].displayed(exact[k]);
        const Vec3d off = points[k].displayed(bake(points[k].at).radiance) - shown;
        error += off.dot(off);
        all += shown.dot(shown);
    }
    const double expected = std::sqrt(error / all);
    BakeErrorMeter meter(lit.shading, points);
    for (std::uint32_t seed = 0; seed < 3; ++seed)
        EXPECT_NEAR(std::sqrt(meter.interpolation_error(bake, seed)->square.square), expected,
                    0.15 * expected);
}

TEST(BakeError, SmallErrorsThatAreForetoldHaveNarrowIntervals) {
    LitBox lit;
    make_accurate(lit);
    const std::vector<DisplayedPoint> points = floor_points(lit, 20000);
    const std::vector<Outgoing> exact = *point_radiance(lit.shading, surface_points(lit, points));
    const SceneRadiance radiance = *scene_radiance(lit.shading);
    const auto interpolated = by_vertices(lit, radiance);
    // A bake with a hundredth of the errors of interpolation, which it foretells.
    GivenBake bake;
    double error = 0, all = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Outgoing value = exact[k] * 0.99f + interpolated(points[k].at).radiance * 0.01f;
        const double off = square(value.total() - exact[k].total());
        error += off;
        all += square(exact[k].total());
        bake.add(points[k].at, {value, float(std::sqrt(off))});
    }
    const double expected = std::sqrt(error / all);
    BakeErrorMeter meter(lit.shading, points);
    for (std::uint32_t seed = 0; seed < 5; ++seed) {
        const BakeError found = meter.error(bake, *meter.interpolation_error(bake, seed), {});
        EXPECT_NEAR(found.between, expected, 0.05 * expected);
        EXPECT_LT(found.high - found.low, 0.1 * found.total);
    }
}

TEST(BakeError, IntervalsContainErrorsThatFewPointsHave) {
    LitBox lit;
    make_accurate(lit);
    const std::vector<DisplayedPoint> points = floor_points(lit, 20000);
    const std::vector<Outgoing> exact = *point_radiance(lit.shading, surface_points(lit, points));
    // One point in 667 errs 25 times as much as the others, which nothing foretells.
    GivenBake bake;
    double error = 0, all = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Outgoing value = exact[k] * (k % 667 == 333 ? 1.25f : 1.01f);
        error += square(value.total() - exact[k].total());
        all += square(exact[k].total());
        bake.add(points[k].at, {value, 0.0f});
    }
    const double expected = std::sqrt(error / all);
    BakeErrorMeter meter(lit.shading, points);
    int inside = 0;
    for (std::uint32_t seed = 0; seed < 100; ++seed) {
        const BakeError found = meter.error(bake, *meter.interpolation_error(bake, seed), {});
        inside += found.low <= expected && expected <= found.high;
    }
    EXPECT_GE(inside, 88);
    EXPECT_LE(inside, 97);
}

TEST(BakeError, TotalIsThatOfTheBakeWhereItsSummandsDependOnEachOther) {
    LitBox lit;
    make_accurate(lit);
    const std::vector<DisplayedPoint> points = floor_points(lit, 2048);
    // Shading that is too bright by a tenth.
    Environment brighter = lit.example.scene.environment;
    for (Rgb& pixel : brighter.image.pixels) pixel *= 1.1f;
    lit.light = scene_light(brighter, lit.settings);
    BakeErrorMeter meter(lit.shading, points);
    const BakeErrorMeter::Shading shading = *meter.shading_error(0.01);
    for (const double brightness : {1.0, 1.05, 1.2}) {
        const BakeErrorMeter::DisplayedRadiance bake = [&](const MeshPoint& at) {
            BakeErrorMeter::Displayed shown;
            shown.radiance =
                (*point_radiance(lit.shading, surface_points(lit, {{at}})))[0] * float(brightness / 1.1);
            shown.difference = 0.1f * shown.radiance.total().length();
            return shown;
        };
        const BakeError found = meter.error(bake, *meter.steering_error(bake), shading);
        EXPECT_NEAR(found.total, brightness - 1, 0.015);
        EXPECT_NEAR(found.at_vertices, 0.1, 0.015);
    }
}

TEST(BakeError, MetersOfOneSceneShareReferences) {
    LitBox lit;
    make_accurate(lit);
    const std::vector<DisplayedPoint> points = floor_points(lit, 4096);
    BakeErrorMeter first(lit.shading, points);
    ASSERT_TRUE(first.shading_error(0.02, {}, 100));
    Environment brighter = lit.example.scene.environment;
    for (Rgb& pixel : brighter.image.pixels) pixel *= 1.1f;
    lit.light = scene_light(brighter, lit.settings);
    BakeErrorMeter second(lit.shading, first);
    EXPECT_EQ(second.shading_error(0.02)->direct.square,
              BakeErrorMeter(lit.shading, points).shading_error(0.02)->direct.square);
    // A higher accuracy needs separate references.
    EXPECT_EQ(second.shading_error(0.01)->direct.square,
              BakeErrorMeter(lit.shading, points).shading_error(0.01)->direct.square);
}

TEST(BakeError, ReferencesBelowACeilingAreAccurate) {
    LitBox lit;
    lit.example.scene.environment = environment([](const Vec3d& d) { return d.y > 0.5 ? 10000.0 : 1.0; });
    lit.example.scene.instances.push_back({LitBox::floor, {{0, 0.9f, 0}, 3}});
    make_accurate(lit);
    std::vector<DisplayedPoint> points = area_points(lit.example.scene, 4096);
    std::erase_if(points, [&](const DisplayedPoint& point) {
        const std::optional<SurfacePoint> at =
            surface_point(lit.example.scene.entities[LitBox::floor], point.at);
        return point.at.instance != LitBox::floor || !at || std::abs(at->position.x) > 2 ||
               std::abs(at->position.z) > 2;
    });
    const BakeErrorMeter::Shading found = *BakeErrorMeter(lit.shading, points).shading_error(0.02);
    const auto [low, high] = std::ranges::minmax(found.direct.resampled);
    // Most samples are in the bright part of the sky, which the ceiling hides.
    EXPECT_LT(high - low, 2e-3);
}

TEST(BakeError, PathsReduceTheNoiseOfSpecularReferences) {
    LitBox lit;
    make_accurate(lit);
    const FineSurface surface(lit.example.scene);
    const RayScene rays(lit.example.scene);
    const PathTracer paths(rays, surface);
    Material glossy = matte(0.0f);
    glossy.specular = Rgb(0.5f);
    glossy.shininess = 20;
    const std::vector<Material> materials{glossy};
    lit.example.scene.entities[LitBox::floor].materials = materials;
    // The floor in front of the lit side of the box.
    const Vec3f at{0.5f, 0, 0.6f};
    const ShadingPoint seen = shading_point(lit.example.scene, lit.example.scene.instances[LitBox::floor],
                                            {at, Vec3f(0, 1, 0), at + Vec3f(0, 1e-4f, 0), 0});
    const auto deviation = [&](std::uint32_t count) {
        double sum = 0, squares = 0;
        constexpr std::uint32_t seeds = 32;
        for (std::uint32_t seed = 0; seed < seeds; ++seed) {
            const double found =
                double(paths.indirect_radiance(seen.from, seen.brdf, count, seed).specular.x) / seeds;
            sum += found;
            squares += found * found * seeds;
        }
        return std::sqrt(squares - sum * sum);
    };
    EXPECT_GT(deviation(32), 0);
    EXPECT_LT(deviation(2048), deviation(32) / 4);
}

TEST(ErrorTarget, IsReachedAndNotExceededByFar) {
    LitBox lit;
    make_accurate(lit);
    lit.settings.bounces.most = 2;
    for (const double wanted : {0.06, 0.03}) {
        const TargetBake bake =
            *target_bake(lit.shading, {wanted, 100000, false}, area_points(lit.example.scene, 16384));
        EXPECT_EQ(bake.end, SearchEnd::reached);
        EXPECT_LE(bake.error.total, wanted);
        EXPECT_GT(bake.error.total, wanted / 4);
        EXPECT_GE(bake.error.high, bake.error.total);
        EXPECT_LE(bake.error.low, bake.error.total);
        // The truth, by other points and other rays.
        const std::vector<DisplayedPoint> points = floor_points(lit, 1500);
        const std::vector<InstancePoint> at = surface_points(lit, points);
        const RayScene rays(lit.example.scene);
        const PathTracer paths(rays, *bake.indirect->surface);
        const RadiantMesh& floor = bake.meshes[LitBox::floor];
        double error = 0, all = 0;
        for (std::size_t k = 0; k < at.size(); ++k) {
            std::array<Rgb, 2> truth;
            for (std::uint32_t r = 0; r < 2; ++r) {
                const std::uint32_t seed = 1000000 + 2 * std::uint32_t(k) + r;
                const auto& instance = lit.example.scene.instances[at[k].instance];
                const ShadingPoint seen = shading_point(lit.example.scene, instance, at[k].point);
                truth[r] = ray_radiance(rays, at[k].instance, at[k].point, 2048, seed).total() +
                           paths.indirect_radiance(seen.from, seen.brdf, 256, seed).total();
            }
            const Rgb baked = radiance_on(floor, at[k].point.position.x, at[k].point.position.z).total();
            error += double((baked - truth[0]).dot(baked - truth[1]));
            all += double(truth[0].dot(truth[1]));
        }
        EXPECT_LE(std::sqrt(error / all), 1.25 * wanted);
        EXPECT_GE(std::sqrt(error / all), wanted / 5);
    }
}

TEST(ErrorTarget, IsReachedInPicturesThatAreDarkerThanTheScene) {
    LitBox lit;
    make_accurate(lit);
    const std::vector<Material> dark{matte(0.01f)};
    lit.example.scene.entities[LitBox::floor].materials = dark;
    const TargetBake bake = *target_bake(lit.shading, {0.03, 100000, false}, floor_points(lit, 16384));
    EXPECT_EQ(bake.end, SearchEnd::reached);
    EXPECT_LE(bake.error.total, 0.03);
}

TEST(ErrorTarget, RepresentsSourcesByMoreDirectionsIfPenumbraeNeedThem) {
    LitBox lit;
    lit.example.scene.environment.suns = {{Vec3f(0.48f, 0.8f, 0.36f), 0.1f, Rgb(3)}};
    make_accurate(lit);
    const auto bake = [&](int most_lights) {
        lit.settings.sources.most_lights = most_lights;
        lit.light = scene_light(lit.example.scene.environment, lit.settings);
        return *target_bake(lit.shading, {0.04, 100000, false}, floor_points(lit, 16384));
    };
    const TargetBake few = bake(1), enough = bake(256);
    EXPECT_GT(few.source_directions, 1);
    EXPECT_EQ(few.end, SearchEnd::reached);
    EXPECT_EQ(enough.source_directions, 1);
}

TEST(ErrorTarget, TakesAllWaveletsOfTheLightIfFewAreNotEnough) {
    LitBox lit;
    make_accurate(lit);
    const auto bake = [&](int wavelets) {
        lit.settings.light_coefficients = wavelets;
        lit.light = scene_light(lit.example.scene.environment, lit.settings);
        return *target_bake(lit.shading, {0.04, 100000, false}, floor_points(lit, 16384));
    };
    const int most = lit.settings.face_size * lit.settings.face_size;
    const TargetBake few = bake(1), enough = bake(most / 2);
    EXPECT_EQ(few.light_coefficients, 0);
    EXPECT_EQ(few.end, SearchEnd::reached);
    EXPECT_EQ(enough.light_coefficients, most / 2);
}

TEST(ErrorTarget, TakesTheLargestFacesOnlyIfTheTargetIsNotReachedOtherwise) {
    LitBox lit;
    make_accurate(lit);
    lit.settings.bounces.most = 0;
    const auto face_size = [&](double error) {
        const ErrorTarget target{.error = error,
                                 .vertex_budget = 1000,
                                 .by_view = false,
                                 .usual_face_size = lit.settings.face_size,
                                 .most_face_size = 2 * lit.settings.face_size};
        return target_bake(lit.shading, target, floor_points(lit, 16384))->face_size;
    };
    EXPECT_EQ(face_size(0.1), lit.settings.face_size);
    EXPECT_EQ(face_size(0.0005), 2 * lit.settings.face_size);
}

TEST(ErrorTarget, EndsAtTheVertexBudget) {
    const LitBox lit;
    const TargetBake bake =
        *target_bake(lit.shading, {0.001, 600, false}, area_points(lit.example.scene, 4096));
    EXPECT_NE(bake.end, SearchEnd::reached);
    EXPECT_GT(bake.error.total, 0.001);
    std::size_t vertices = 0;
    for (const RadiantMesh& mesh : bake.meshes) vertices += mesh.radiance.size();
    EXPECT_LE(vertices, 600u);
}

TEST(ErrorTarget, StopsEarlyIfIndirectLightIsNotAccurateEnough) {
    LitBox lit;
    make_accurate(lit);
    const auto bake = [&](double error, int most) {
        lit.settings.bounces.most = most;
        const ErrorTarget target{
            .error = error, .vertex_budget = 100000, .by_view = false, .stops_early = true};
        return *target_bake(lit.shading, target, area_points(lit.example.scene, 4096));
    };
    const TargetBake stopped = bake(0.003, any_bounces), reached = bake(0.06, any_bounces);
    EXPECT_TRUE(stopped.is_stopped);
    EXPECT_EQ(stopped.end, SearchEnd::indirect_light);
    EXPECT_EQ(stopped.shaded_points, 0u) << "of the refinement";
    EXPECT_FALSE(reached.is_stopped);
    EXPECT_EQ(reached.meshes.size(), lit.example.scene.instances.size());

    const TargetBake one_bounce = bake(0.003, 1);
    EXPECT_FALSE(one_bounce.is_stopped) << "more vertices do not replace bounces";
    EXPECT_EQ(one_bounce.end, SearchEnd::indirect_light);
}

TEST(ErrorTarget, DoesNotDependOnTheNumberOfThreads) {
    const LitBox lit;
    const auto bake = [&] {
        return *target_bake(lit.shading, {0.05, 100000, true}, area_points(lit.example.scene, 4096));
    };
    const TargetBake one = with_threads(1, bake), many = with_threads(3, bake);
    EXPECT_EQ(one.error.total, many.error.total);
    EXPECT_EQ(one.error.high, many.error.high);
    ASSERT_EQ(one.meshes.size(), many.meshes.size());
    for (std::size_t i = 0; i < one.meshes.size(); ++i) {
        EXPECT_EQ(one.meshes[i].radiance, many.meshes[i].radiance);
        EXPECT_EQ(one.meshes[i].mesh.positions, many.meshes[i].mesh.positions);
    }
}

}  // namespace
}  // namespace haarfield
