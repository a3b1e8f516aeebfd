#include "shading/bake/error_budget.h"

#include <gtest/gtest.h>

#include <map>

#include "shading/bake/ray_renderer.h"
#include "tests/fixtures/example_scene.h"
#include "tests/fixtures/with_threads.h"

namespace haarfield {
namespace {

/// A floor, a ball whose occlusion is interpolated from its field, and a block whose occlusion is exact.
class Room : public ExampleScene {
public:
    explicit Room(std::uint32_t samples = 400) {
        PreparedMesh floor_mesh = prepared_as_is(square_mesh(5, 0, 8));
        floor_mesh.coarse = square_mesh(5, 0);
        scene.instances = {
            {add_entity(floor_mesh, matte(0.6f), 6, 18), {}},
            {add_entity(sphere_mesh({0, 0.4f, 0}, 0.4f, 8), matte(0.5f), samples, samples),
             {{-0.6f, 0, 0}, 1}},
            {add_entity(box_mesh({-0.4f, 0, -0.4f}, {0.4f, 0.8f, 0.4f}, 2), matte(0.4f)), {{0.6f, 0, 0}, 1}}};
        const Vec3d sun = Vec3d(0.5, 0.7, 0.3).normalized();
        scene.environment = environment(
            [&](const Vec3d& d) { return 0.5 + 0.3 * d.y + 6 * std::exp(40 * (d.dot(sun) - 1)); });
        scene.eye = {2, 2, 3};
    }

    RenderSettings settings() const {
        RenderSettings settings;
        settings.face_size = size;
        settings.light_coefficients = 0;
        settings.occlusion = Occlusion::fields;
        return settings;
    }
    std::vector<const Mesh*> originals() const {
        std::vector<const Mesh*> result;
        for (std::size_t i = 0; i < scene.entities.size(); ++i) result.push_back(&mesh(i).original);
        return result;
    }
    ErrorBudget budget(const RenderSettings& settings, std::size_t vertices = 60) const {
        return *error_budget(scene, originals(), settings, vertices);
    }
};

const Room& room() {
    static const Room example;
    return example;
}

std::map<std::string, BudgetEntry> by_name(const ErrorBudget& budget) {
    std::map<std::string, BudgetEntry> entries;
    for (const BudgetEntry& entry : budget.entries) entries[entry.name] = entry;
    return entries;
}

TEST(ErrorBudget, ExactComponentsHaveNoError) {
    const auto entries = by_name(room().budget(room().settings()));
    ASSERT_EQ(entries.size(), 11u);
    EXPECT_EQ(entries.at("sources").relative_rmse, 0) << "there are none";
    EXPECT_LT(entries.at("lighting").relative_rmse, 1e-5);
    EXPECT_LT(entries.at("coarse mesh").relative_rmse, 1e-5);
    EXPECT_EQ(entries.at("depth").relative_rmse, 0);
    EXPECT_LT(entries.at("visibility").relative_rmse, 2e-3) << "rounded to bytes";
    EXPECT_LT(entries.at("lobes").relative_rmse, 3e-3);
    EXPECT_LT(entries.at("impostors").relative_rmse, 3e-3);
    EXPECT_GT(entries.at("planar field").relative_rmse, 5e-4);
    EXPECT_GT(entries.at("spherical field").relative_rmse, 5e-4);
    EXPECT_GT(entries.at("resolution").relative_rmse, 3e-4);
}

TEST(ErrorBudget, EachApproximationShowsInItsOwnEntryOnly) {
    const auto before = by_name(room().budget(room().settings()));
    const auto expect_only = [&](const std::map<std::string, BudgetEntry>& entries,
                                 const std::string& changed) {
        for (const auto& [name, entry] : entries)
            if (name == changed) {
                EXPECT_GT(entry.relative_rmse, 5 * before.at(name).relative_rmse + 0.005) << name;
            } else if (name != "all at the vertices") {
                EXPECT_NEAR(entry.relative_rmse, before.at(name).relative_rmse, 1e-6)
                    << name << " by " << changed;
            }
    };
    RenderSettings few = room().settings();
    few.light_coefficients = 4;
    expect_only(by_name(room().budget(few)), "lighting");
    RenderSettings shallow = room().settings();
    shallow.depth = 2;
    expect_only(by_name(room().budget(shallow)), "depth");
    std::vector<const Mesh*> others = room().originals();
    const Mesh larger = box_mesh({-0.5f, 0, -0.5f}, {0.5f, 1, 0.5f});
    others[2] = &larger;
    expect_only(by_name(*error_budget(room().scene, others, room().settings(), 60)), "coarse mesh");
}

TEST(ErrorBudget, FieldsHaveAnErrorWhereTheyAreInterpolated) {
    const Room coarse(40), fine(3000);
    const auto few = by_name(coarse.budget(coarse.settings(), 200)),
               many = by_name(fine.budget(fine.settings(), 200));
    for (const char* name : {"planar field", "spherical field"}) {
        EXPECT_GT(few.at(name).relative_rmse, 2 * many.at(name).relative_rmse) << name;
        EXPECT_GT(few.at(name).points, 10u);
        EXPECT_LT(few.at(name).points, few.at("lighting").points);
    }
}

TEST(ErrorBudget, FieldsHaveNoErrorForExactOccluders) {
    RenderSettings exact = room().settings();
    exact.occlusion = Occlusion::exact;
    const auto looked_up = by_name(room().budget(room().settings())), seen = by_name(room().budget(exact));
    for (const char* name : {"planar field", "spherical field"}) {
        EXPECT_LT(seen.at(name).points, looked_up.at(name).points) << name;
        EXPECT_LT(seen.at(name).relative_rmse, 0.5 * looked_up.at(name).relative_rmse) << name;
    }
    EXPECT_LT(seen.at("all at the vertices").relative_rmse,
              looked_up.at("all at the vertices").relative_rmse);
}

/// `baked` is the radiance of a bake, and `exact` that of the oracle with finer texels.
TEST(ErrorBudget, AllTogetherIsTheBakeAgainstTheFinestOracle) {
    const ErrorBudget budget = room().budget(room().settings());
    const auto baked = total(*scene_radiance(room().scene, room().settings()));
    RenderSettings fine = room().settings();
    fine.face_size *= 4;
    const DenseScene dense(room().scene, fine.face_size);
    DenseShader shader(dense);
    ASSERT_EQ(budget.vertices.size(), 60u);
    float worst_before = INFINITY;
    double error = 0, energy = 0;
    for (const BudgetVertex& at : budget.vertices) {
        EXPECT_EQ(at.baked, baked[at.instance][at.vertex]);
        const ShadedEntity& entity = room().scene.entities[room().scene.instances[at.instance].entity];
        const Rgb exact = shader.radiance(at.instance, surface_point(entity, at.vertex)).total();
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(at.exact[c], exact[c], 1e-5 * exact[c]);
        const Vec3f difference = at.baked - at.exact;
        EXPECT_LE(difference.length(), worst_before) << "the worst come first";
        worst_before = difference.length();
        error += double(difference.length2());
        energy += double(exact.dot(exact));
    }
    EXPECT_NEAR(budget.entries.back().relative_rmse, std::sqrt(error / energy), 1e-5);
}

/// Vertices that have nearly exact radiance differ from few rays by the error of the rays alone.
TEST(ErrorBudget, SeparatesTheErrorOfTheBakeFromTheNoiseOfItsRays) {
    const RayScene rays(room().scene);
    std::vector<BudgetVertex> exact, bright;
    for (std::uint32_t vertex = 0; vertex < 54; ++vertex) {
        const std::size_t instance = vertex % 2 == 0 ? 0 : 2;
        if (room().scene.entities[instance].occlusion->samples().buried[vertex]) continue;
        BudgetVertex& at = exact.emplace_back();
        at.instance = std::uint32_t(instance);
        at.vertex = vertex;
        at.direct = ray_estimate(rays, instance, vertex, 1 << 17).radiance;
        bright.push_back(at);
        bright.back().direct *= 1.05f;
    }
    const BudgetEntry none = *ray_difference(room().scene, exact, 256);
    EXPECT_GT(none.noise, 1e-3);
    EXPECT_GT(none.relative_rmse, 0.7 * none.noise);
    EXPECT_LT(none.without_noise(), 0.7 * none.noise);
    const BudgetEntry some = *ray_difference(room().scene, bright, 256);
    EXPECT_NEAR(some.without_noise(), 0.05, 0.003);
    EXPECT_NEAR(some.bias, 0.05, 0.003);
}

TEST(ErrorBudget, DoesNotDependOnTheNumberOfThreads) {
    const auto figures = [](std::size_t threads) {
        const ErrorBudget budget = with_threads(threads, [] { return room().budget(room().settings(), 20); });
        std::vector<double> result;
        for (const BudgetEntry& entry : budget.entries)
            result.insert(result.end(), {entry.relative_rmse, entry.relative_99, entry.bias});
        return result;
    };
    EXPECT_EQ(figures(1), figures(3));
}

TEST(InterpolationError, IsThatBetweenTheCorners) {
    ExampleScene plain;
    plain.scene.instances = {{plain.add_entity(square_mesh(2, 0), matte(0.5f)), {}}};
    plain.scene.environment = environment([](const Vec3d&) { return 1.0; });
    RenderSettings settings;
    settings.face_size = ExampleScene::size;
    const MeshPoint middle{0, 0, 0.3f, 0.3f};
    const BudgetEntry none = *interpolation_error(plain.scene, {&middle, 1}, settings);
    EXPECT_EQ(none.points, 1u);
    EXPECT_LT(none.relative_rmse, 1e-6);

    // A specular reflection between the corners, which are outside of it.
    plain.scene.entities[0].materials = {glossy(200, LobeConvention::povray)};
    const Vec3d sun = Vec3d(0, 1, 0);
    plain.scene.environment = environment([&](const Vec3d& d) { return std::exp(300 * (d.dot(sun) - 1)); });
    plain.scene.eye = {0, 1, 0};
    const MeshPoint at{0, 0, 0.5f, 0};
    const ShadedEntity& entity = plain.scene.entities[0];
    const DenseScene dense(plain.scene, settings.face_size);
    DenseShader shader(dense);
    const auto corner = [&](std::size_t c) {
        return shader.radiance(0, surface_point(entity, entity.mesh->triangles[0][c])).total();
    };
    const Rgb exact = shader.radiance(0, *surface_point(entity, at)).total(),
              found = corner(0) * 0.5f + corner(1) * 0.5f;
    const BudgetEntry some = *interpolation_error(plain.scene, {&at, 1}, settings);
    EXPECT_GT(some.relative_rmse, 0.5);
    EXPECT_NEAR(some.relative_rmse, double((found - exact).length() / exact.length()), 1e-4);
    EXPECT_NEAR(some.bias, double(found.x / exact.x) - 1, 1e-4);
}

}  // namespace
}  // namespace haarfield
