#include "shading/bake/render_passes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "shading/bake/colour_fit.h"
#include "tests/fixtures/lit_box.h"

namespace haarfield {
namespace {

std::vector<SceneColours> totals(const std::vector<SceneRadiance>& passes) {
    std::vector<SceneColours> result;
    for (const SceneRadiance& pass : passes) result.push_back(total(pass));
    return result;
}

/// A scene, ready to be shaded at its vertices.
struct ReadyScene {
    explicit ReadyScene(const ShadedScene& shaded)
        : scene(shaded),
          geometry(*shading_geometry(scene, settings)),
          light(scene_light(scene.environment, settings)) {}
    ReadyScene(const ReadyScene&) = delete;

    SceneRadiance components(bool dense = false) const {
        return dense ? *dense_scene_radiance(scene, settings) : *scene_radiance(shading);
    }
    SceneColours full(bool dense = false) const { return total(components(dense)); }
    std::vector<SceneRadiance> component_passes(const std::vector<RenderPass>& wanted, bool dense) const {
        const SceneRadiance radiance = components(dense);
        const std::vector<std::span<const Outgoing>> spans(radiance.begin(), radiance.end());
        return *render_passes({shading, {}, false, dense}, spans, wanted);
    }
    std::vector<SceneColours> passes(const std::vector<RenderPass>& wanted, bool dense = false) const {
        return totals(component_passes(wanted, dense));
    }
    SceneColours pass(RenderPass wanted, bool dense = false) const { return passes({wanted}, dense)[0]; }

    static RenderSettings of_size() {
        RenderSettings settings;
        settings.face_size = ExampleScene::size;
        return settings;
    }
    const ShadedScene scene;
    const RenderSettings settings = of_size();
    const ShadingGeometry geometry;
    const SceneLight light;
    const PointShading shading{scene, geometry, light, settings};
};

/// Returns a dark specular material, which must not affect passes that do not depend on materials.
Material lacquer() {
    Material material = glossy(30, LobeConvention::povray);
    material.diffuse = Rgb(0.4f, 0.2f, 0.1f);
    material.specular = Rgb(0.5f);
    return material;
}

/// A point of the floor, with objects above or next to it.
class OverAFloor : public testing::Test {
protected:
    void put(const Mesh& mesh) {
        example.scene.instances.push_back({example.add_entity(mesh, lacquer()), {}});
    }
    OverAFloor() { put(square_mesh(0.001f, 0)); }
    ExampleScene example;
};

TEST_F(OverAFloor, OcclusionIsTheOpenFractionForAnyLight) {
    Environment uneven = environment([](const Vec3d& d) { return d.x > 0.5 ? 2.0 : 0.1; });
    uneven.suns.push_back({Vec3f(0.3f, 0.9f, 0.1f).normalized(), 0.01f, Rgb(5.0f)});
    example.scene.environment = uneven;
    const auto expect_open = [&](double share, double tolerance) {
        const ReadyScene ready(example.scene);
        for (const bool dense : {false, true}) {
            const SceneColours found = ready.pass(RenderPass::occlusion, dense);
            for (const Rgb& open : found[0])
                for (int c = 0; c < 3; ++c) {
                    EXPECT_NEAR(open[c], share, tolerance) << dense;
                    EXPECT_LE(open[c], 1.0f);
                }
        }
    };
    expect_open(1, 1e-3);
    put(sphere_mesh({0, 2, 0}, 1, 40));  // occludes the square of its radius over its distance
    expect_open(0.75, 0.01);
    put(box_mesh({0.1f, -300, -300}, {0.2f, 300, 300}));  // occludes half of the remainder
    expect_open(0.375, 0.015);
}

TEST_F(OverAFloor, IrradianceDoesNotDependOnTheMaterial) {
    // The cosine-weighted integral of 1 + y over the hemisphere: pi + 2 pi / 3.
    const auto sky = [](const Vec3d& d) { return 1 + d.y; };
    example.scene.environment = environment(sky);
    for (const bool dense : {false, true})
        EXPECT_NEAR(ReadyScene(example.scene).pass(RenderPass::irradiance, dense)[0][0].y, pi * 5 / 3, 0.01);
    // A wall next to it halves it, by symmetry.
    put(box_mesh({0.1f, -300, -300}, {0.2f, 300, 300}));
    for (const bool dense : {false, true})
        EXPECT_NEAR(ReadyScene(example.scene).pass(RenderPass::irradiance, dense)[0][0].y, pi * 5 / 6, 0.08);
    // A sun adds the cosine of its angle to the normal, unless the wall occludes it.
    for (const float side : {-1.0f, 1.0f}) {
        example.scene.environment = environment(sky);
        example.scene.environment.suns = {{Vec3f(side * 0.8f, 0.6f, 0), 0.005f, Rgb(1, 2, 4)}};
        const ReadyScene ready(example.scene);
        for (const bool dense : {false, true}) {
            const Rgb found = ready.pass(RenderPass::irradiance, dense)[0][0];
            EXPECT_NEAR(found.y, pi * 5 / 6 + (side < 0 ? 0.6 * 2 : 0), 0.08) << side;
            EXPECT_NEAR(found.z - found.x, side < 0 ? 0.6 * 3 : 0, 0.01) << side;
        }
    }
}

/// Returns a glossy floor with two stools, one of them rotated and scaled, in sky light and a sun.
ExampleScene& stools() {
    static ExampleScene example;
    if (!example.scene.entities.empty()) return example;
    PreparedMesh floor = prepared_as_is(square_mesh(4, 0, 8));
    floor.coarse = square_mesh(4, 0);
    example.add_entity(floor, lacquer(), 6, 18);
    Material chrome = glossy(80, LobeConvention::physical);
    chrome.diffuse = Rgb(0.1f, 0.3f, 0.2f);
    example.add_entity(joined_meshes(box_mesh({-0.4f, 0.3f, -0.2f}, {0.3f, 0.5f, 0.3f}, 3),
                                     box_mesh({0.1f, 0, 0}, {0.25f, 0.4f, 0.15f}, 2)),
                       chrome, 100, 200);
    example.scene.instances = {{0, {}},
                               {1, {{0.2f, 0.002f, 0.1f}, 1}},
                               {1, {{-0.9f, 0.2f, 0.3f}, 1.3f, rotation_xyz({0.1f, -0.8f, 0.2f})}}};
    example.scene.environment = environment(
        [](const Vec3d& d) { return 0.4 + 2 * std::exp(6 * (d.x * 0.6 + d.y * 0.7 + d.z * 0.4 - 1)); });
    example.scene.environment.suns = {{Vec3f(0.5f, 0.7f, 0.2f).normalized(), 0.02f, Rgb(2.0f)}};
    example.scene.eye = {2, 2, 3};
    return example;
}

void expect_near(const SceneColours& found, const SceneColours& wanted, float tolerance) {
    ASSERT_EQ(found.size(), wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        ASSERT_EQ(found[i].size(), wanted[i].size());
        for (std::size_t v = 0; v < wanted[i].size(); ++v)
            EXPECT_LE((found[i][v] - wanted[i][v]).length(), tolerance * (1 + wanted[i][v].length()))
                << i << ", " << v;
    }
}

SceneColours sum(SceneColours a, const SceneColours& b) {
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t v = 0; v < a[i].size(); ++v) a[i][v] += b[i][v];
    return a;
}

double luminance_of(const SceneColours& radiance) {
    double sum = 0;
    for (const auto& values : radiance)
        for (const Rgb& value : values) sum += double(luminance(value));
    return sum;
}

TEST(RenderPasses, DiffuseAndSpecularAddUpAndAreThoseOfTheMaterials) {
    ShadedScene matte_scene = stools().scene, shiny_scene = stools().scene;
    for (ShadedEntity& entity : matte_scene.entities) entity.materials[0].specular = Rgb(0.0f);
    for (ShadedEntity& entity : shiny_scene.entities) entity.materials[0].diffuse = Rgb(0.0f);
    const ReadyScene ready(stools().scene), without(matte_scene), alone(shiny_scene);
    for (const bool dense : {false, true}) {
        const auto passes = ready.passes({RenderPass::specular, RenderPass::diffuse}, dense);
        expect_near(sum(passes[0], passes[1]), ready.full(dense), 1e-6f);
        expect_near(passes[1], without.full(dense), 1e-4f);
        expect_near(passes[0], alone.full(dense), 1e-6f);
        EXPECT_GT(luminance_of(passes[0]), 0.05 * luminance_of(passes[1]));
        EXPECT_GT(luminance_of(passes[1]), 0.05 * luminance_of(passes[0]));
        const auto of_matte = without.passes({RenderPass::diffuse, RenderPass::specular}, dense);
        EXPECT_EQ(of_matte[0], without.full(dense));
        EXPECT_EQ(luminance_of(of_matte[1]), 0.0);
    }
}

TEST(RenderPasses, OwnShadowIsTheBakeOfEachInstanceAlone) {
    const ReadyScene all(stools().scene);
    for (const bool dense : {false, true}) {
        const auto found = all.component_passes({RenderPass::own_shadow}, dense);
        for (std::size_t i = 0; i < found[0].size(); ++i) {
            ShadedScene one = stools().scene;
            one.instances = {one.instances[i]};
            const ReadyScene alone(one);
            EXPECT_EQ(found[0][i], alone.components(dense)[0]) << i << ", " << dense;
            EXPECT_EQ(alone.pass(RenderPass::own_shadow, dense), alone.full(dense)) << i << ", " << dense;
        }
        // The stools' shadows on the floor are gone, and their own on themselves are not.
        const SceneColours full = all.full(dense);
        const SceneColours shown = total(found[0]);
        EXPECT_GT(luminance_of({shown[0]}), 1.05 * luminance_of({full[0]}));
        float least = 1e9f, most = 0;
        for (const Rgb& value : shown[1]) {
            least = std::min(least, luminance(value));
            most = std::max(most, luminance(value));
        }
        EXPECT_LT(least, 0.2f * most);
    }
}

/// Passes at the vertices of meshes that belong to no entity.
TEST(RenderPasses, AreThoseOfOtherMeshesToo) {
    const LitBox lit;
    const std::vector<RadiantMesh> radiant = lit.radiant(11);
    std::vector<SampledMesh> meshes;
    std::vector<std::span<const Outgoing>> full;
    for (const RadiantMesh& mesh : radiant) {
        meshes.push_back({&mesh.mesh, &mesh.samples});
        full.emplace_back(mesh.radiance);
    }
    const std::vector<RenderPass> wanted{RenderPass::diffuse, RenderPass::irradiance, RenderPass::own_shadow};
    const auto passes = totals(*render_passes({lit.shading, meshes}, full, wanted));
    for (std::size_t i = 0; i < radiant.size(); ++i) {
        EXPECT_EQ(passes[0][i], total({radiant[i].radiance})[0]);
        const float albedo = i == LitBox::floor ? 0.7f : 0.5f;
        for (std::size_t v = 0; v < full[i].size(); ++v)
            EXPECT_NEAR(passes[1][i][v].x * albedo / float(pi), full[i][v].diffuse.x,
                        1e-4f * (1 + full[i][v].diffuse.x));
    }
    ShadedScene one = lit.example.scene;
    one.instances = {one.instances[LitBox::floor]};
    const ReadyScene alone(one);
    // A floor alone is unshadowed: everywhere as bright as at its first vertex.
    for (const Rgb& value : passes[2][LitBox::floor])
        EXPECT_NEAR(value.x, passes[2][LitBox::floor][0].x, 1e-4f);
    EXPECT_GT(passes[2][LitBox::floor].size(), alone.full()[0].size());
}

TEST(RenderPasses, AreFittedAsTheRadianceIs) {
    LitBox lit;
    for (ShadedEntity& entity : lit.example.scene.entities) entity.materials = {lacquer()};
    std::vector<RadiantMesh> fitted = lit.radiant(11);
    ASSERT_TRUE(fit_radiance(lit.shading, fitted));
    std::vector<SampledMesh> meshes;
    std::vector<std::span<const Outgoing>> full;
    for (const RadiantMesh& mesh : fitted) {
        meshes.push_back({&mesh.mesh, &mesh.samples});
        full.emplace_back(mesh.radiance);
    }
    const std::vector<RenderPass> parts{RenderPass::specular, RenderPass::diffuse, RenderPass::irradiance,
                                        RenderPass::occlusion};
    const auto passes = totals(*render_passes({lit.shading, meshes, true}, full, parts));
    std::size_t different = 0;
    for (std::size_t i = 0; i < full.size(); ++i)
        for (std::size_t v = 0; v < full[i].size(); ++v) {
            const Rgb& specular = passes[0][i][v];
            const Rgb& diffuse = passes[1][i][v];
            // Fitted light is the sum of its fitted terms, unless one of them is clamped.
            const bool is_clamped = diffuse.x <= 0 || specular.x <= 0 || passes[2][i][v].x <= 0;
            if (is_clamped) continue;
            different += std::abs(specular.x + diffuse.x - full[i][v].total().x) > 1e-5f;
            different += std::abs(diffuse.x - passes[2][i][v].x * 0.4f / float(pi)) > 2e-3f * (1 + diffuse.x);
            EXPECT_TRUE(passes[3][i][v].x >= 0 && passes[3][i][v].x <= 1);
        }
    EXPECT_EQ(different, 0u);
    // They are not what unfitted ones are.
    const auto sampled =
        totals(*render_passes({lit.shading, meshes}, full, std::vector{RenderPass::irradiance}));
    EXPECT_NE(sampled[0], passes[2]);
}

}  // namespace
}  // namespace haarfield
