#include "bridge/povray/reference_picture.h"

#include "bridge/povray/reference_scene.h"
#include "tests/fixtures/bridge_fixtures.h"

#include <fmt/format.h>

namespace haarfield {
namespace {

/// A square in the shadow of a smaller one, under a sky that is brighter on one side.
class ShadowedSquare {
public:
    ShadowedSquare() : environment_(constant_environment(64, Rgb(0.2f, 0.2f, 0.2f))) {
        for (int row = 0; row < 64; ++row)
            for (int column = 0; column < 128; ++column) {
                const Vec3d d = lat_long_direction((column + 0.5) / 128, (row + 0.5) / 64);
                const auto glow = static_cast<float>(4 * std::exp(8 * (d.dot(Vec3d(0.6, 0, 0.8)) - 1)));
                environment_.pixels[static_cast<std::size_t>(128 * row + column)] +=
                    Rgb(glow, glow, 0.5f * glow);
            }
    }

    /// Returns the scene with the given number of lights.
    ReferenceFiles scene(int lights, int bounces = 0) const {
        const std::vector<ReferenceInstance> instances{
            {"wall", &mesh_, {&material_, 1}, {}},
            {"blocker", &mesh_, {&material_, 1}, {{0.2f, 0.1f, 0.3f}, 0.3f}}};
        return *write_reference_scene(folder_.path(), "shadow", frontal_camera(3, 48), instances,
                                      environment_, lights, {bounces});
    }

    static PovrayOptions options(const char* declaration = nullptr) {
        PovrayOptions options;
        options.width = options.height = 48;
        options.declarations = {without_background};
        if (declaration) options.declarations.push_back(declaration);
        return options;
    }

private:
    TestFolder folder_;
    Mesh mesh_ = upright_square_mesh(1, 1);
    Material material_;
    LatLongImage environment_;
};

double relative_difference(const Image& a, const Image& b) {
    double difference = 0, radiance = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            difference += std::pow(double(a.pixels[i][c]) - double(b.pixels[i][c]), 2);
            radiance += std::pow(double(b.pixels[i][c]), 2);
        }
    return std::sqrt(difference / radiance);
}

TEST(ReferencePicture, IsTheMeanOfTwoSetsOfLightsAndOfAllOfThem) {
    const ShadowedSquare square;
    const ReferenceFiles scene = square.scene(64);
    const Result<ReferencePicture> picture = rendered_reference(scene, ShadowedSquare::options());
    ASSERT_TRUE(picture) << picture.error().message();
    const Image first = rendered_scene(scene.scene, ShadowedSquare::options(first_dome_only))->image,
                second = rendered_scene(scene.scene, ShadowedSquare::options(second_dome_only))->image,
                all = rendered_scene(scene.scene, ShadowedSquare::options())->image;
    EXPECT_GT(relative_difference(first, second), 0.005) << "the sets must be independent";
    for (std::size_t i = 0; i < all.pixels.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const float mean = 0.5f * (first.pixels[i][c] + second.pixels[i][c]);
            EXPECT_NEAR(picture->image.pixels[i][c], mean, 1e-6f);
            EXPECT_NEAR(all.pixels[i][c], mean, 1e-3f * mean + 1e-6f);
        }
    EXPECT_NEAR(*picture->image.relative_error, 0.5 * relative_difference(first, second), 2e-3);
}

TEST(ReferencePicture, AgreesWithRadiosity) {
    const ShadowedSquare square;
    const ReferenceFiles scene = square.scene(512);
    PovrayOptions options = ShadowedSquare::options();
    options.declarations.clear();
    const Result<ReferencePicture> dome = rendered_reference(scene, options);
    const Result<RenderedScene> radiosity = radiosity_picture(scene.scene, options);
    ASSERT_TRUE(dome) << dome.error().message();
    ASSERT_TRUE(radiosity) << radiosity.error().message();
    EXPECT_EQ(radiosity->image.coverage, dome->image.coverage);
    EXPECT_LT(relative_difference(radiosity->image, dome->image), 0.03);
    double found = 0, wanted = 0;
    for (std::size_t i = 0; i < dome->image.pixels.size(); ++i) {
        found += double(radiosity->image.pixels[i].x);
        wanted += double(dome->image.pixels[i].x);
    }
    EXPECT_NEAR(found / wanted, 1, 0.01);
}

TEST(ReferencePicture, GathersBouncesUnderFewLights) {
    const ShadowedSquare square;
    const ReferenceFiles scene = square.scene(512, 2);
    ASSERT_TRUE(scene.has_bounces);
    const Result<ReferencePicture> picture = rendered_reference(scene, ShadowedSquare::options());
    ASSERT_TRUE(picture) << picture.error().message();
    const Image whole = rendered_scene(scene.scene, ShadowedSquare::options())->image,
                direct = rendered_scene(scene.scene, ShadowedSquare::options(without_bounces))->image;
    const std::string text = text_of(scene.scene);
    PovrayOptions few = ShadowedSquare::options(reduced_lights_alone);
    few.declarations.push_back(without_bounces);
    EXPECT_GT(relative_difference(rendered_scene(scene.scene, few)->image, direct), 0.005);
    EXPECT_GT(relative_difference(direct, whole), 0.01);
    EXPECT_LT(relative_difference(picture->image, whole), 0.003);
    EXPECT_LT(*picture->image.relative_error, 0.02);
    // If there are only few lights, all of them are used.
    EXPECT_EQ(text_of(square.scene(64, 2).scene).find(reduced_lights_alone), std::string::npos);
    EXPECT_NE(text.find(reduced_lights_alone), std::string::npos);
}

/// A panel inside a sphere lights the wall in front of it from a tenth of the radius. The camera faces the
/// other way, where all light is indirect.
TEST(ReferencePicture, BouncesOfEmittersDoNotDependOnTheNumberOfLampsInOneHalf) {
    const Mesh sphere = sphere_mesh({0, 0, 0}, 1, 12), square = upright_square_mesh(0.15f, 1);
    const Material material;
    Surface panel;
    panel.material = material;
    panel.emission = Rgb(5.0f);
    std::vector<Emitter> emitters;
    for (const auto& [a, b, c] : square.triangles)
        emitters.push_back({{square.positions[a], square.positions[b], square.positions[c]}, panel.emission});
    const std::vector<ReferenceInstance> instances{
        {"sphere", &sphere, {&material, 1}, {}},
        {"panel", &square, {&material, 1}, {{0, 0, 0.9f}, 1}, {&panel, 1}, emitters}};
    const TestFolder folder;
    const auto half = [&](int lights, std::size_t set) {
        const Result<ReferenceFiles> scene =
            write_reference_scene(folder.path(), fmt::format("sphere_{}", lights), frontal_camera(0.5f, 12),
                                  instances, constant_environment(16, Rgb(0.0f)), lights, {1});
        EXPECT_TRUE(scene && scene->has_emitters);
        PovrayOptions options;
        options.width = options.height = 12;
        return rendered_half(*scene, set, options)->image;
    };
    const Image gathered = half(16, 1);
    EXPECT_GT(luminance(gathered.pixels[6 * 12 + 6]), 0);
    EXPECT_LT(relative_difference(gathered, half(64, 1)), 0.03);
}

TEST(ReferencePicture, EstimatesItsOwnError) {
    const ShadowedSquare square;
    const Result<ReferencePicture> truth = rendered_reference(square.scene(8192), ShadowedSquare::options());
    ASSERT_TRUE(truth) << truth.error().message();
    for (int lights : {32, 128, 512}) {
        const Result<ReferencePicture> picture =
            rendered_reference(square.scene(lights), ShadowedSquare::options());
        ASSERT_TRUE(picture) << picture.error().message();
        const double error = relative_difference(picture->image, truth->image);
        EXPECT_GT(*picture->image.relative_error, 0.5 * error) << lights;
        EXPECT_LT(*picture->image.relative_error, 3 * error) << lights;
    }
}

/// A panel lights the wall behind it from a fiftieth of its size. The camera shows the strip next to it.
TEST(ReferencePicture, EstimatesTheErrorOfSurfacesCloseToEmitters) {
    const Mesh wall = upright_square_mesh(1, 1);
    Mesh panel_mesh = upright_square_mesh(0.5f, 1);
    for (auto& [a, b, c] : panel_mesh.triangles) std::swap(b, c);
    for (Vec3f& normal : panel_mesh.normals) normal = -normal;
    const Material material;
    Surface panel;
    panel.material = material;
    panel.emission = Rgb(5.0f);
    const std::vector<Emitter> emitters = emitters_of(panel_mesh, {&panel, 1});
    const std::vector<ReferenceInstance> instances{
        {"wall", &wall, {&material, 1}, {}},
        {"panel", &panel_mesh, {&material, 1}, {{0, 0, 0.02f}, 1}, {&panel, 1}, emitters}};
    Camera camera = frontal_camera(3, 32);
    camera.position = Vec3f(0.75f, 0, 3);
    camera.target = Vec3f(0.75f, 0, 0);
    camera.vertical_fov = 2 * std::atan(0.24f / 3);
    const TestFolder folder;
    const auto rendered = [&](int lights) {
        const Result<ReferenceFiles> scene =
            write_reference_scene(folder.path(), fmt::format("panel_{}", lights), camera, instances,
                                  constant_environment(16, Rgb(0.0f)), lights);
        EXPECT_TRUE(scene) << scene.error().message();
        PovrayOptions options;
        options.width = options.height = 32;
        options.declarations = {without_background};
        return *rendered_reference(*scene, options);
    };
    const ReferencePicture truth = rendered(16384);
    for (const int lights : {64, 256}) {
        const ReferencePicture picture = rendered(lights);
        const double error = relative_difference(picture.image, truth.image);
        EXPECT_GT(*picture.image.relative_error, 0.9 * error) << lights;
        EXPECT_LT(*picture.image.relative_error, 2 * error) << lights;
    }
}

TEST(ReferencePicture, ExtrapolatesTheNumberOfLightsFromTwoErrors) {
    // Errors of 4 % and 1 % for 256 and 1024 lights decrease as 1/n: 0.5 % needs twice as many, plus a tenth.
    const LightEstimate halved = estimated_lights(256, 0.04, 1024, 0.01, 0.005);
    EXPECT_NEAR(halved.lights, 2253, 1);
    EXPECT_NEAR(halved.relative_error, 0.00455, 1e-5);
    EXPECT_EQ(estimated_lights(256, 0.04, 1024, 0.01, 0.02).lights, 1024);
    // An error that does not decrease is assumed to decrease with the square root.
    EXPECT_NEAR(estimated_lights(256, 0.01, 1024, 0.01, 0.005).lights, 4506, 1);
    const LightEstimate too_many = estimated_lights(256, 0.04, 1024, 0.02, 0.0001);
    EXPECT_EQ(too_many.lights, most_reference_lights);
    EXPECT_GT(too_many.relative_error, 0.001);
}

}  // namespace
}  // namespace haarfield
