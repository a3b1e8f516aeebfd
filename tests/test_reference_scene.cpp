#include "bridge/povray/reference_scene.h"

#include "bridge/povray/povray_process.h"
#include "scenes/scene_import.h"
#include "scenes/scene_reader.h"
#include "shading/visibility/light_filters.h"
#include "tests/fixtures/bridge_fixtures.h"

#include <fmt/format.h>

namespace haarfield {
namespace {

Result<Image> rendered(const TestFolder& folder, const Camera& camera,
                       std::span<const ReferenceInstance> instances, const LatLongImage& environment,
                       int lights) {
    const Result<ReferenceFiles> files =
        write_reference_scene(folder.path(), "reference", camera, instances, environment, lights);
    if (!files) return files.error();
    PovrayOptions options;
    options.width = camera.width;
    options.height = camera.height;
    options.declarations = {without_background};
    if (Result<PovrayRun> run = run_povray(files->scene, folder / "reference.exr", options); !run)
        return run.error();
    return read_image(folder / "reference.exr");
}

/// A triangle, and a smaller one in front of it on the right.
TEST(ReferenceScene, ShowsLeftHandedFilesAsPovrayDoes) {
    const TestFolder folder;
    constexpr const char* mesh =
        "mesh2 { vertex_vectors { 6, <-1, -1, 0>, <1, -1, 0>, <-1, 1, 0>, <0.2, 0, -1>, <0.8, 0, -1>, "
        "<0.8, 0.7, -1> } face_indices { 2, <0, 1, 2>, <3, 4, 5> } }\n";
    write_text(folder / "own.inc", mesh);
    write_text(folder / "own.pov",
               std::string("#version 3.7;\nglobal_settings { assumed_gamma 1 }\ncamera { location <1, 1, -4> "
                           "right x up y angle 45 look_at <0, 0, 0> }\nobject { ") +
                   mesh + "pigment { rgb 1 } finish { emission 1 ambient 0 diffuse 0 } }\n");
    Camera camera = frontal_camera(4, 48);
    PovrayOptions options;
    options.width = options.height = 48;
    ASSERT_TRUE(run_povray(folder / "own.pov", folder / "own.exr", options));
    const Result<Image> own = read_image(folder / "own.exr");
    ASSERT_TRUE(own) << own.error().message();

    const std::filesystem::path model = folder / "own.inc";
    const Result<ImportedScene> imported = scene_of_models({&model, 1}, folder.path(), {});
    ASSERT_TRUE(imported) << imported.error().message();
    const Result<SceneEntities> entities = original_entities(imported->scene);
    ASSERT_TRUE(entities) << entities.error().message();
    camera.position = Vec3f(1, 1, 4);
    camera.target = Vec3f(0, 0, 0);
    camera.vertical_fov = float(pi) / 4;
    const std::vector<ReferenceInstance> instances = reference_instances(imported->scene, *entities);
    const Result<Image> found = rendered(folder, camera, instances, constant_environment(16, Rgb(1.0f)), 64);
    ASSERT_TRUE(found) << found.error().message();
    int covered = 0, different = 0;
    for (std::size_t i = 0; i < own->pixels.size(); ++i) {
        const bool is_covered = own->pixels[i].x > 0.5f;
        covered += is_covered;
        different += is_covered != (found->pixels[i].x > 0.05f);
    }
    EXPECT_GT(covered, 300);
    EXPECT_LT(different, 8);
}

/// A scene file may name a mesh2 file without turning its coordinates.
TEST(ReferenceScene, LeftHandedFilesThatNoInstanceMirrorsAreNamed) {
    const TestFolder folder;
    write_text(folder / "own.inc",
               "mesh2 { vertex_vectors { 3, <-1, -1, 0>, <1, -1, 0>, <-1, 1, 0> } face_indices { 1, <0, 1, "
               "2> } }\n");
    const auto warnings = [&](const std::string& instance) {
        write_text(
            folder / "scene.toml",
            "[camera]\nposition = [0, 0, 4]\ntarget = [0, 0, 0]\n[environment]\nsky = {}\n[materials.m]\n"
            "[entities.e]\nmesh = \"own.inc\"\nmaterial = \"m\"\n[[instances]]\nentity = \"e\"\n" +
                instance);
        const Result<Scene> scene = read_scene(folder / "scene.toml");
        EXPECT_TRUE(scene) << scene.error().message();
        const Result<SceneEntities> entities = original_entities(*scene);
        EXPECT_TRUE(entities) << entities.error().message();
        return std::ranges::count_if(entities->warnings, [](const std::string& warning) {
            return warning.find("own.inc") != warning.npos && warning.find("left-handed") != warning.npos &&
                   warning.find("scale = [1, 1, -1]") != warning.npos;
        });
    };
    EXPECT_EQ(warnings(""), 1);
    EXPECT_EQ(warnings("[[instances]]\nentity = \"e\"\n"), 1) << "once for two instances";
    EXPECT_EQ(warnings("scale = [1, 1, -1]\n"), 0);
    EXPECT_EQ(warnings("matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0]]\n"), 0);
}

/// A lamp lights a wall through a coloured pane and an absorbing block, which are not visible.
TEST(ReferenceScene, FiltersCastTheShadowsOfLightFilters) {
    const TestFolder folder;
    write_text(
        folder / "pane.ply",
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "property float red\nproperty float green\nproperty float blue\nelement face 2\n"
        "property list uchar int vertex_indices\nend_header\n-0.8 -0.8 1 1 0.5 0.25\n"
        "0.4 -0.8 1 1 0.5 0.25\n0.4 0.8 1 0 1 1\n-0.8 0.8 1 1 0.5 0.25\n3 0 1 2\n3 0 2 3\n");
    const Mesh block = box_mesh({-0.2f, -0.3f, 0.2f}, {0.6f, 0.3f, 0.6f});
    std::string obj;
    for (const Vec3f& p : block.positions) obj += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
    for (const auto& [a, b, c] : block.triangles) obj += fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1);
    write_text(folder / "block.obj", obj);
    std::vector<SceneFilter> filters(2);
    filters[0].mesh = folder / "pane.ply";
    filters[0].vertex_colours = true;
    filters[0].colour = Rgb(0.9f);
    filters[1].mesh = folder / "block.obj";
    filters[1].colour = Rgb(0.8f, 1, 1);
    filters[1].absorption = Rgb(0, 2, 1);
    LightFilters expected;
    for (const SceneFilter& filter : filters) {
        Result<FilterMesh> read = read_filter(filter);
        ASSERT_TRUE(read) << read.error().message();
        expected.add(read->mesh.positions, read->mesh.triangles, read->colours, filter.absorption);
    }
    expected.commit();

    const Mesh wall = upright_square_mesh(1.1f, 1);
    Material material;
    material.diffuse = Rgb(0.5f);
    const ReferenceInstance instance{"wall", &wall, {&material, 1}, {}};
    Lamp lamp;
    lamp.position = {0.3f, 0.2f, 4};
    lamp.colour = {2, 2, 2};
    constexpr int size = 40;
    const Camera camera = frontal_camera(3, size);
    std::array<Image, 2> images;
    for (std::size_t k = 0; k < 2; ++k) {
        const Result<ReferenceFiles> files = write_reference_scene(
            folder.path(), "reference", camera, {&instance, 1}, constant_environment(4, Rgb(0.0f)), 16, {},
            {&lamp, 1}, std::span(filters).first(k == 0 ? 0 : 2));
        ASSERT_TRUE(files) << files.error().message();
        EXPECT_EQ(files->includes.size(), k == 0 ? 1u : 3u);
        PovrayOptions options;
        options.width = options.height = size;
        options.declarations = {without_background};
        ASSERT_TRUE(run_povray(files->scene, folder / "reference.exr", options));
        const Result<Image> image = read_image(folder / "reference.exr");
        ASSERT_TRUE(image) << image.error().message();
        images[k] = *image;
    }
    int wrong = 0;
    std::array<int, 2> compared{};
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const Vec3f point(float(2 * x + 1) / size - 1, 1 - float(2 * y + 1) / size, 0);
            const Rgb passed = expected.transmitted(point, lamp.position);
            ++compared[passed == Rgb(1.0f)];
            const auto pixel = std::size_t(size * y + x);
            for (int c = 0; c < 3; ++c)
                wrong +=
                    std::abs(images[1].pixels[pixel][c] / images[0].pixels[pixel][c] - passed[c]) > 3e-3f;
        }
    EXPECT_LE(wrong, 30) << "at the edges of shadows";
    EXPECT_GT(compared[0], 500);
    EXPECT_GT(compared[1], 300);
}

TEST(ReferenceScene, AWhiteFurnaceReflectsTheAlbedo) {
    const TestFolder folder;
    const Mesh mesh = upright_square_mesh(1, 1);
    Material material;
    material.diffuse = Rgb(0.25f, 0.5f, 1);
    const ReferenceInstance instance{"square", &mesh, {&material, 1}, {}};
    const Result<Image> image =
        rendered(folder, frontal_camera(3, 8), {&instance, 1}, constant_environment(64, Rgb(1, 1, 1)), 800);
    ASSERT_TRUE(image) << image.error().message();
    for (const Rgb& pixel : image->pixels)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixel[c] / material.diffuse[c], 1, 0.005);
}

/// One sun of known irradiance; squares that share a mesh, at several places and scales.
TEST(ReferenceScene, ShadesAsTheMaterialSays) {
    const int height = 64, sun_row = 20, sun_column = 70;
    LatLongImage environment = constant_environment(height, Rgb(0, 0, 0));
    const double solid_angle = lat_long_pixel_solid_angle(sun_row, 2 * height, height);
    const Rgb irradiance(3, 2, 1);
    environment.pixels[static_cast<std::size_t>(sun_row * 2 * height + sun_column)] =
        irradiance * static_cast<float>(1 / solid_angle);
    const Vec3d light = lat_long_direction((sun_column + 0.5) / (2 * height), (sun_row + 0.5) / height);
    ASSERT_GT(light.z, 0.2);

    Mesh mesh = upright_square_mesh(0.45f, 2);
    mesh.material_names = {"left", "right"};
    // Two materials: the columns of cells do not share vertices, so the middle ones are doubled.
    const Mesh plain = mesh;
    mesh.triangles.clear();
    for (const auto& triangle : plain.triangles) {
        const bool right = (plain.positions[triangle[0]].x + plain.positions[triangle[1]].x +
                            plain.positions[triangle[2]].x) > 0;
        std::array<std::uint32_t, 3> copy{};
        for (int k = 0; k < 3; ++k) {
            copy[static_cast<std::size_t>(k)] = static_cast<std::uint32_t>(mesh.positions.size());
            mesh.positions.push_back(plain.positions[triangle[static_cast<std::size_t>(k)]]);
            mesh.normals.emplace_back(0, 0, 1);
            mesh.vertex_materials.push_back(right ? 1 : 0);
        }
        mesh.triangles.push_back(copy);
    }

    std::vector<std::vector<Material>> materials(4, std::vector<Material>(2));
    for (int k = 0; k < 4; ++k)
        for (Material& material : materials[static_cast<std::size_t>(k)]) {
            material.convention = k == 3 ? LobeConvention::physical : LobeConvention::povray;
            material.diffuse = Rgb(0.3f, 0.2f, 0.1f);
        }
    for (int side = 0; side < 2; ++side) {
        const auto s = static_cast<std::size_t>(side);
        materials[1][s].specular = Rgb(0.4f, 0.4f, 0.4f);
        materials[1][s].shininess = side ? 3.0f : 12.0f;
        materials[2][s].specular = side ? Rgb(0.5f, 0.25f, 0.125f) : Rgb(0, 0.6f, 0);
        materials[2][s].shininess = 4;
        materials[3][s].specular = Rgb(0.2f, 0.2f, 0.2f);
        materials[3][s].shininess = 5;
    }
    const std::vector<ReferenceInstance> instances{{"a", &mesh, materials[0], {{-0.5f, 0.5f, 0}, 1}},
                                                   {"b", &mesh, materials[1], {{0.5f, 0.5f, 0}, 1.1f}},
                                                   {"c", &mesh, materials[2], {{-0.5f, -0.5f, 0}, 1}},
                                                   {"d", &mesh, materials[3], {{0.5f, -0.5f, 0}, 0.9f}},
                                                   {"e", &mesh, materials[3], {{5, -0.5f, 0}, 1}}};
    const Camera camera = frontal_camera(3, 40);
    const TestFolder folder;
    const Result<ReferenceFiles> files =
        write_reference_scene(folder.path(), "reference", camera, instances, environment, 16);
    ASSERT_TRUE(files) << files.error().message();
    EXPECT_EQ(files->lights, 2) << "one of each set";
    EXPECT_EQ(files->includes.size(), 4u) << "instances of one mesh and material share a file";
    EXPECT_EQ(files->warnings.size(), 1u);
    const Result<Image> image = rendered(folder, camera, instances, environment, 16);
    ASSERT_TRUE(image) << image.error().message();

    int checked = 0;
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 40; ++x) {
            const Vec3d point((x + 0.5) / 20 - 1, 1 - (y + 0.5) / 20, 0);
            const std::size_t quarter = (point.x > 0 ? 1u : 0u) + (point.y < 0 ? 2u : 0u);
            const double place = point.x > 0 ? point.x - 0.5 : point.x + 0.5;
            const double place_y = point.y > 0 ? point.y - 0.5 : point.y + 0.5;
            if (std::abs(place) > 0.38 || std::abs(place_y) > 0.38) continue;
            const Material& material = materials[quarter][place > 0 ? 1 : 0];
            const Vec3d view = (Vec3d(0, 0, 3) - point).normalized(), mirrored(-view.x, -view.y, view.z);
            double lobe = std::pow(std::max(0.0, mirrored.dot(light)), material.shininess);
            if (quarter == 3) lobe *= 0.5 * (material.shininess + 2);
            const Rgb& found = image->pixels[static_cast<std::size_t>(40 * y + x)];
            for (int c = 0; c < 3; ++c) {
                const double expected =
                    irradiance[c] / pi * (material.diffuse[c] * light.z + material.specular[c] * lobe);
                // All channels have 1e-4 of the specular light of the strongest one: see reference_scene.cpp.
                EXPECT_NEAR(found[c], expected, 8e-4 * expected + 1e-4)
                    << "quarter " << quarter << ", pixel " << x << ", " << y;
            }
            ++checked;
        }
    EXPECT_GT(checked, 800);
}

/// POV-Ray replaces vertex normals that agree with each other by the geometric normal.
TEST(ReferenceScene, ShadesWithVertexNormalsThatAgree) {
    LatLongImage environment = constant_environment(64, Rgb(0, 0, 0));
    environment.pixels[static_cast<std::size_t>(20 * 128 + 70)] = Rgb(1, 1, 1);
    const Vec3d light = lat_long_direction(70.5 / 128, 20.5 / 64);
    const double irradiance = lat_long_pixel_solid_angle(20, 128, 64);
    Mesh mesh = upright_square_mesh(1, 2);
    for (const Vec3f& normal :
         {Vec3f(0, 0, 1), Vec3f(0.28f, 0, 0.96f), Vec3f(-0.02f, 0.3f, 0.95f).normalized()}) {
        std::ranges::fill(mesh.normals, normal);
        const Material material;
        const ReferenceInstance instance{"square", &mesh, {&material, 1}, {}};
        const TestFolder folder;
        const Result<Image> image = rendered(folder, frontal_camera(3, 8), {&instance, 1}, environment, 16);
        ASSERT_TRUE(image) << image.error().message();
        const double expected = irradiance / pi * double(material.diffuse.x) * Vec3d(normal).dot(light);
        for (const Rgb& pixel : image->pixels) EXPECT_NEAR(pixel.x / expected, 1, 1e-3);
    }
}

/// A square in front of another one, at the scales of a chair and of a watch. The direction of the sun
/// determines the place of its shadow.
TEST(ReferenceScene, CastsShadowsAtAnyScale) {
    for (float size : {1.0f, 0.002f}) {
        LatLongImage environment = constant_environment(64, Rgb(0, 0, 0));
        environment.pixels[static_cast<std::size_t>(20 * 128 + 64)] = Rgb(1, 1, 1);
        const Vec3d light = lat_long_direction(64.5 / 128, 20.5 / 64);
        const Mesh mesh = upright_square_mesh(1, 1);
        Material material;
        const float above = 0.2f;
        const std::vector<ReferenceInstance> instances{
            {"wall", &mesh, {&material, 1}, {{0, 0, 0}, size}},
            {"blocker", &mesh, {&material, 1}, {Vec3f(0, 0.3f, above) * size, 0.2f * size}}};
        const TestFolder folder;
        Camera camera = frontal_camera(3, 40);
        camera.position *= size;
        const Result<Image> image = rendered(folder, camera, instances, environment, 16);
        ASSERT_TRUE(image) << image.error().message();
        int dark = 0;
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 40; ++x) {
                const double px = (x + 0.5) / 20 - 1, py = 1 - (y + 0.5) / 20;
                // The pixels of the blocker, and those of its shadow on the wall.
                const double seen = 1 / (1 - above / 3);
                const bool blocker = std::abs(px) < 0.21 * seen && std::abs(py - 0.3 * seen) < 0.21 * seen;
                if (blocker) continue;
                const double sx = px + light.x / light.z * above, sy = py + light.y / light.z * above - 0.3;
                const double inside = 0.2 - std::max(std::abs(sx), std::abs(sy));
                if (std::abs(inside) < 0.02) continue;
                const float found = image->pixels[static_cast<std::size_t>(40 * y + x)].x;
                if (inside > 0) ++dark;
                EXPECT_EQ(found == 0, inside > 0) << size << " m, pixel " << x << ", " << y << ": " << found;
            }
        EXPECT_GT(dark, 10);
    }
}

TEST(ReferenceScene, RefusesBadMaterialsAndNormals) {
    const TestFolder folder;
    const Mesh mesh = upright_square_mesh(1, 1);
    const LatLongImage environment = constant_environment(4, Rgb(1, 1, 1));
    const auto accepted = [&](const Mesh& m, std::vector<Material> materials) {
        const ReferenceInstance instance{"a", &m, materials, {}};
        return static_cast<bool>(
            write_reference_scene(folder.path(), "s", frontal_camera(3, 8), {&instance, 1}, environment, 16));
    };
    EXPECT_TRUE(accepted(mesh, {Material{}}));
    EXPECT_FALSE(accepted(mesh, {}));
    for (float bad : {NAN, INFINITY, -1.0f}) {
        Material diffuse, specular, shininess;
        diffuse.diffuse.y = bad;
        specular.specular.z = bad;
        shininess.shininess = bad;
        EXPECT_FALSE(accepted(mesh, {diffuse}));
        EXPECT_FALSE(accepted(mesh, {specular}));
        EXPECT_FALSE(accepted(mesh, {shininess}));
    }
    Mesh broken = mesh;
    broken.normals[1].x = NAN;
    EXPECT_FALSE(accepted(broken, {Material{}}));
    broken.normals.clear();
    EXPECT_FALSE(accepted(broken, {Material{}}));
}

}  // namespace
}  // namespace haarfield
