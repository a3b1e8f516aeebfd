#include "bridge/povray/baked_scene.h"

#include "bridge/files/glb_file.h"
#include "bridge/files/mesh_file.h"
#include "bridge/povray/povray_process.h"
#include "fields/file/write_file.h"
#include "fields/model/mesh_reader.h"
#include "scenes/image.h"
#include "tests/fixtures/bridge_fixtures.h"

#include <cstring>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

namespace haarfield {
namespace {

std::vector<Rgb> random_radiance(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<Rgb> radiance(count);
    for (Rgb& value : radiance)
        for (int c = 0; c < 3; ++c)
            value[c] = std::exp(static_cast<float>(random() % 1000) / 1000 * 6 - 3);  // 0.05 to 20
    return radiance;
}

/// Returns an environment whose pixels have their directions as colours, moved into [0, 1].
LatLongImage direction_environment(int height) {
    LatLongImage image{2 * height, height, {}};
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < 2 * height; ++column) {
            const Vec3d d = lat_long_direction((column + 0.5) / (2 * height), (row + 0.5) / height);
            image.pixels.emplace_back(Vec3f(d * 0.5 + Vec3d(0.5, 0.5, 0.5)));
        }
    return image;
}

Vec3d pixel_ray(const Camera& camera, double x, double y) {
    const Vec3d forward = (Vec3d(camera.target) - Vec3d(camera.position)).normalized();
    const Vec3d right = forward.cross(Vec3d(0, 1, 0)).normalized(), up = right.cross(forward);
    const double half = std::tan(0.5 * static_cast<double>(camera.vertical_fov));
    return (forward + right * ((2 * x / camera.width - 1) * half * camera.width / camera.height) +
            up * ((1 - 2 * y / camera.height) * half))
        .normalized();
}

PovrayOptions options_for(const Camera& camera) {
    PovrayOptions options;
    options.width = camera.width;
    options.height = camera.height;
    return options;
}

/// Vertex colours, light in an image, and the background are numbers of the scene.
TEST(BakedScene, PovrayRaisesNumbersToTheAssumedGamma) {
    const TestFolder folder;
    Mesh mesh = upright_square_mesh(0.5f, 1);
    mesh.material_names = {"plain"};
    const Camera camera = frontal_camera(3, 16);
    const std::vector<Rgb> radiance(mesh.positions.size(), Rgb(0.5f, 0.25f, 0.75f));
    LatLongImage environment{16, 8, std::vector<Rgb>(128, Rgb(0.3f, 0.6f, 0.9f))};
    for (const bool is_mirror : {false, true}) {
        std::vector<Surface> surfaces(1);
        // Faces with reflections have their light in an image.
        if (is_mirror) surfaces[0].reflection.at_normal = surfaces[0].reflection.at_grazing = Rgb(1e-5f);
        BakedInstance instance{"square", &mesh, {}, radiance};
        instance.surfaces = surfaces;
        const Result<BakedFiles> files =
            write_baked_scene(folder.path(), "gamma", camera, {&instance, 1}, {&environment, false, 2.2});
        ASSERT_TRUE(files) << files.error().message();
        ASSERT_TRUE(run_povray(files->scene, folder / "gamma.exr", options_for(camera)));
        const Result<Image> image = read_image(folder / "gamma.exr");
        ASSERT_TRUE(image) << image.error().message();
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(image->pixels[16 * 8 + 8][c], std::pow(radiance[0][c], 2.2f), 2e-3f) << is_mirror;
            EXPECT_NEAR(image->pixels[0][c], std::pow(environment.pixels[0][c], 2.2f), 2e-3f);
        }
    }
}

/// Includes edges of a millimetre, which POV-Ray interpolates only if they are magnified
/// (small_triangle_scale).
TEST(BakedScene, PovrayReproducesVertexColours) {
    for (float size : {1.0f, 0.004f}) {
        const TestFolder folder;
        const int cells = 4, resolution = 40;
        const Mesh mesh = upright_square_mesh(size, cells);
        const std::vector<Rgb> radiance = random_radiance(mesh.positions.size(), 1);
        Camera camera = frontal_camera(3 * size, resolution);
        camera.vertical_fov = 2 * std::atan(1.0f / 3);
        const BakedInstance instance{"floor", &mesh, {}, radiance};
        const Result<BakedFiles> files =
            write_baked_scene(folder.path(), "small", camera, {&instance, 1}, {});
        ASSERT_TRUE(files) << files.error().message();
        EXPECT_EQ(files->clamped_vertices, 0u);
        const Result<RenderedScene> rendered =
            render_scene(files->scene, folder / "small.exr", options_for(camera));
        ASSERT_TRUE(rendered) << rendered.error().message();
        EXPECT_TRUE(rendered->run.warnings.empty()) << rendered->run.warnings.front();

        for (int y = 0; y < resolution; ++y)
            for (int x = 0; x < resolution; ++x) {
                // The point of the square at the pixel's centre, and its triangle.
                const double u = (x + 0.5) / resolution * cells, v = (1 - (y + 0.5) / resolution) * cells;
                const int i = static_cast<int>(u), j = static_cast<int>(v);
                const double s = u - i, t = v - j;
                const auto corner = [&](int a, int b) {
                    return Vec3d(radiance[static_cast<std::size_t>((j + b) * (cells + 1) + i + a)]);
                };
                const Vec3d expected =
                    s > t ? corner(0, 0) * (1 - s) + corner(1, 0) * (s - t) + corner(1, 1) * t
                          : corner(0, 0) * (1 - t) + corner(0, 1) * (t - s) + corner(1, 1) * s;
                const std::size_t pixel = static_cast<std::size_t>(y * resolution + x);
                EXPECT_EQ(rendered->image.coverage[pixel], 1.0f);
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(rendered->image.pixels[pixel][c] / expected[c], 1, 6e-4)
                        << size << " m, pixel " << x << ", " << y;
            }
        EXPECT_TRUE(std::filesystem::exists(folder / "small.png"));
    }
}

TEST(BakedScene, CameraAndBackgroundAgreeWithOurs) {
    const TestFolder folder;
    const Mesh mesh = upright_square_mesh(0.05f, 1);
    const std::vector<Rgb> radiance(mesh.positions.size(), Rgb(3, 2, 1));
    const LatLongImage environment = direction_environment(128);
    Camera camera;
    camera.position = Vec3f(2, 1.5f, -3);
    camera.target = Vec3f(0.2f, 0.3f, 0.1f);
    camera.vertical_fov = 1.2f;
    camera.width = 90;
    camera.height = 60;
    // A small square whose centre should appear at a known place, twice as large as its mesh.
    const Vec3d seen_along = pixel_ray(camera, 63.5, 22.5);
    const Vec3f place(Vec3d(camera.position) + seen_along * 3.0);
    const BakedInstance instance{"mark", &mesh, {place, 2}, radiance};
    const Result<BakedFiles> files =
        write_baked_scene(folder.path(), "view", camera, {&instance, 1}, {&environment});
    ASSERT_TRUE(files) << files.error().message();
    const Result<RenderedScene> rendered =
        render_scene(files->scene, folder / "view.exr", options_for(camera));
    ASSERT_TRUE(rendered) << rendered.error().message();

    double weight = 0, mean_x = 0, mean_y = 0;
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            const float coverage = rendered->image.coverage[static_cast<std::size_t>(y * camera.width + x)];
            weight += coverage;
            mean_x += coverage * (x + 0.5);
            mean_y += coverage * (y + 0.5);
        }
    ASSERT_GT(weight, 2);
    EXPECT_NEAR(mean_x / weight, 63.5, 0.6);
    EXPECT_NEAR(mean_y / weight, 22.5, 0.6);

    PovrayOptions behind = options_for(camera);
    behind.declarations = {background_only};
    ASSERT_TRUE(run_povray(files->scene, folder / "sky.exr", behind));
    const Result<Image> sky = read_image(folder / "sky.exr");
    ASSERT_TRUE(sky);
    for (int y = 0; y < camera.height; y += 5)
        for (int x = 0; x < camera.width; x += 5) {
            const Vec3d expected = pixel_ray(camera, x + 0.5, y + 0.5);
            const Rgb& found = sky->pixels[static_cast<std::size_t>(y * camera.width + x)];
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(2 * found[c] - 1, expected[c], 0.01) << x << ", " << y;
        }
}

TEST(BakedScene, AnIncludeWorksInAUsersScene) {
    const TestFolder folder;
    const Mesh mesh = upright_square_mesh(1, 1);
    const std::vector<Rgb> radiance(mesh.positions.size(), Rgb(0.25f, 0.5f, 0.75f));
    const std::vector<BakedInstance> instances{{"x", &mesh, {}, radiance},
                                               {"mesh-1", &mesh, {}, radiance},
                                               {"mesh 1", &mesh, {}, radiance},
                                               {"1\n}", &mesh, {}, radiance}};
    const Result<BakedFiles> files =
        write_baked_scene(folder.path(), "2-union.b", frontal_camera(3, 8), instances, {});
    ASSERT_TRUE(files) << files.error().message();
    EXPECT_EQ(files->objects, (std::vector<std::string>{"N2_union_b_X", "N2_union_b_Mesh_1",
                                                        "N2_union_b_Mesh_1_2", "N2_union_b_N1__"}));
    std::string text = "#version 3.6;\nglobal_settings { assumed_gamma 1 adc_bailout 0 }\n";
    for (int repeat = 0; repeat < 2; ++repeat)
        for (const auto& include : files->includes)
            text += "#include \"" + include.filename().string() + "\"\n";
    text +=
        "#if (version != 3.6) #error \"the version was changed\" #end\n"
        "camera { location <0, 0, -3> direction 1.5*z right x up y }\n"
        "object { N2_union_b_Mesh_1_2 scale <1, 1, -1> translate <0.5, 0, 0> }\n";
    ASSERT_TRUE(write_file(folder / "own.pov", text));
    const Result<PovrayRun> run =
        run_povray(folder / "own.pov", folder / "own.exr", options_for(frontal_camera(3, 8)));
    ASSERT_TRUE(run) << run.error().message();
    const Result<Image> image = read_image(folder / "own.exr");
    ASSERT_TRUE(image);
    EXPECT_EQ(image->pixels[8 * 4 + 1], Rgb(0, 0, 0));
    EXPECT_EQ(image->pixels[8 * 4 + 6], Rgb(0.25f, 0.5f, 0.75f));
}

TEST(BakedScene, AnIncludeChangesNoLightsTexturesOrCameraOfAUsersScene) {
    const TestFolder folder;
    const Mesh mesh = upright_square_mesh(1, 1);
    const Rgb baked(0.25f, 0.5f, 0.75f);
    const std::vector<Rgb> radiance(mesh.positions.size(), baked);
    const std::vector<BakedInstance> instances{{"square", &mesh, {}, radiance}};
    const Camera camera = frontal_camera(3, 32);
    const Result<BakedFiles> files = write_baked_scene(folder.path(), "baked", camera, instances, {});
    ASSERT_TRUE(files) << files.error().message();
    const std::string own =
        "#version 3.7;\nglobal_settings { assumed_gamma 1 ambient_light rgb 0.3 }\n"
        "camera { location <0, 0, -3> direction 1.5*z right x up y }\n"
        "light_source { <-20, 5, -20> rgb 2 }\n"
        "plane { -z, -0.5 pigment { checker rgb <0.8, 0.3, 0.1> rgb 0.6 scale 0.3 }\n"
        "  finish { ambient 0.2 diffuse 0.5 phong 0.4 phong_size 8 } }\n";
    const auto rendered = [&](const std::string& name, const std::string& text) {
        EXPECT_TRUE(write_file(folder / (name + ".pov"), text));
        EXPECT_TRUE(run_povray(folder / (name + ".pov"), folder / (name + ".exr"), options_for(camera)));
        return read_image(folder / (name + ".exr"));
    };
    const Result<Image> without = rendered("without", own);
    const Result<Image> with = rendered("with", own +
                                                    "#include \"baked_Square.inc\"\n"
                                                    "object { Baked_Square scale 0.5 translate 0.5*x }\n");
    ASSERT_TRUE(without && with);
    // The square and its shadow, which falls to the right, lie in the right half.
    int colours_of_the_plane = 0, of_the_square = 0;
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            const Rgb &before = without->pixels[y * camera.width + x],
                      &after = with->pixels[y * camera.width + x];
            if (x < camera.width / 2 - 1) {
                EXPECT_EQ(after, before) << x << ' ' << y;
            }
            colours_of_the_plane += before != without->pixels[0];
            of_the_square += (after - baked).length() < 0.01f;
        }
    EXPECT_GT(colours_of_the_plane, 100);
    EXPECT_GT(of_the_square, 20);
}

TEST(BakedScene, SharesEqualColoursAndClampsTheirRange) {
    const TestFolder folder;
    const Mesh mesh = upright_square_mesh(1, 2);
    std::vector<Rgb> radiance(mesh.positions.size(), Rgb(0.5f, 0.5f, 0.5f));
    radiance[4] = Rgb(1e6f, -1, 0.5f);
    radiance[8] = Rgb(-0.0f, 0, 0);
    const BakedInstance instance{"a", &mesh, {}, radiance};
    const Result<BakedFiles> files =
        write_baked_scene(folder.path(), "s", frontal_camera(3, 8), {&instance, 1}, {});
    ASSERT_TRUE(files);
    EXPECT_EQ(files->clamped_vertices, 1u);
    const std::string text = text_of(files->includes.front());
    EXPECT_NE(text.find("texture_list { 3,"), std::string::npos);
    EXPECT_NE(text.find("rgb<65000,0,0.5>"), std::string::npos);
    EXPECT_EQ(text.find("-0,"), std::string::npos);
}

TEST(BakedScene, RefusesInvalidInstancesAndWritesNothing) {
    const TestFolder folder;
    const Mesh mesh = upright_square_mesh(1, 1);
    const std::vector<Rgb> radiance(mesh.positions.size(), Rgb(1, 1, 1));
    const BakedInstance good{"good", &mesh, {}, radiance};
    const auto refused = [&](const BakedInstance& instance, const char* reason) {
        const std::vector<BakedInstance> instances{good, instance};
        const Result<BakedFiles> files =
            write_baked_scene(folder.path(), "scene", frontal_camera(3, 8), instances, {});
        ASSERT_FALSE(files) << reason;
        EXPECT_NE(files.error().message().find(reason), std::string::npos) << files.error().message();
        EXPECT_TRUE(folder.files().empty());
    };
    for (float bad : {NAN, INFINITY}) {
        std::vector<Rgb> broken = radiance;
        broken[2].y = bad;
        refused({"bad", &mesh, {}, broken}, "instance bad: the radiance of vertex 2 is not finite");
        Mesh broken_mesh = mesh;
        broken_mesh.positions[3].x = bad;
        refused({"bad", &broken_mesh, {}, radiance}, "vertex 3");
        refused({"bad", &mesh, {{0, bad, 0}, 1}, radiance}, "translation");
        refused({"bad", &mesh, {{0, 0, 0}, bad}, radiance}, "scale");
    }
    refused({"bad", &mesh, {{0, 0, 0}, 0}, radiance}, "scale");
    refused({"bad", &mesh, {}, std::span(radiance).first(3)},
            "found 3 radiance values; expected one for each of the 4 vertices");
    refused(good, "two instances have this name");
    Mesh empty = mesh;
    empty.triangles.clear();
    refused({"bad", &empty, {}, radiance}, "no triangle");
    Mesh outside = mesh;
    outside.triangles[0][1] = 4;
    refused({"bad", &outside, {}, radiance}, "vertex index 4");
    for (const char* name : {"", "a b", "../a", "a\"b", ".a"})
        EXPECT_FALSE(write_baked_scene(folder.path(), name, frontal_camera(3, 8), {&good, 1}, {})) << name;
    Camera blind = frontal_camera(3, 8);
    blind.target = blind.position;
    EXPECT_FALSE(write_baked_scene(folder.path(), "scene", blind, {&good, 1}, {}));
    EXPECT_TRUE(folder.files().empty());
}

TEST(BakedScene, ReadMeshReadsAnInclude) {
    const TestFolder folder;
    const Mesh mesh = upright_square_mesh(1, 4);
    std::vector<Rgb> radiance(mesh.positions.size());
    for (std::size_t i = 0; i < radiance.size(); ++i) radiance[i] = Rgb(float(i), 1, 0);
    const Placement placement{{1, 2, 3}, 2, rotation_xyz({0.3f, 0.4f, 0.5f})};
    const std::vector<BakedInstance> instances{{"a", &mesh, placement, radiance}};
    const Result<BakedFiles> files =
        write_baked_scene(folder.path(), "s", frontal_camera(3, 8), instances, {});
    ASSERT_TRUE(files) << files.error().message();
    const Result<ImportedMesh> back = read_mesh(files->includes[0]);
    ASSERT_TRUE(back) << back.error().message();
    ASSERT_EQ(back->mesh.triangles.size(), mesh.triangles.size());
    EXPECT_EQ(back->mesh.material_names, std::vector<std::string>{""});
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f expected = placement.point_to_world(mesh.positions[mesh.triangles[t][k]]);
            EXPECT_LT((back->mesh.positions[back->mesh.triangles[t][k]] - expected).length(), 2e-6f) << t;
        }
}

TEST(BakedPly, HoldsWorldPositionsAndBothKindsOfColour) {
    const TestFolder folder;
    const Mesh mesh = upright_square_mesh(1, 1);
    const std::vector<Rgb> radiance(mesh.positions.size(), Rgb(0.2158605f, 7, -1));
    const std::vector<BakedInstance> instances{{"a", &mesh, {{1, 2, 3}, 2}, radiance},
                                               {"b", &mesh, {}, radiance}};
    ASSERT_TRUE(write_baked_ply(folder / "a.ply", instances));
    const std::string text = text_of(folder / "a.ply");
    const std::size_t data = text.find("end_header\n") + 11;
    ASSERT_EQ(text.size(), data + 8 * 47 + 4 * 13);
    float position[3], linear[3];
    std::memcpy(position, &text[data], 12);
    std::memcpy(linear, &text[data + 27], 12);
    EXPECT_EQ(Vec3f(position[0], position[1], position[2]), Vec3f(-1, 0, 3));
    EXPECT_EQ(Rgb(linear[0], linear[1], linear[2]), Rgb(0.2158605f, 7, -1));
    EXPECT_EQ(static_cast<unsigned char>(text[data + 24]), 128);
    EXPECT_EQ(static_cast<unsigned char>(text[data + 25]), 255);
    EXPECT_EQ(static_cast<unsigned char>(text[data + 26]), 0);
    for (std::size_t v = 0; v < 8; ++v) {
        std::int32_t instance = -1, original = 0;
        std::memcpy(&instance, &text[data + 47 * v + 39], 4);
        std::memcpy(&original, &text[data + 47 * v + 43], 4);
        EXPECT_EQ(instance, v < 4 ? 0 : 1) << v;
        EXPECT_EQ(original, -1) << "of no file";
    }
    const Result<ImportedMesh> back = read_mesh(folder / "a.ply");
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(back->mesh.triangles.size(), 4u);
}

/// Returns the JSON chunk and the binary chunk of a GLB file.
std::pair<nlohmann::json, std::string> chunks_of(const std::string& glb) {
    const auto number_at = [&](std::size_t at) {
        std::uint32_t number = 0;
        std::memcpy(&number, &glb.at(at), 4);
        return std::size_t(number);
    };
    EXPECT_EQ(glb.substr(0, 4), "glTF");
    EXPECT_EQ(number_at(4), 2u);
    EXPECT_EQ(number_at(8), glb.size());
    const std::size_t json = number_at(12);
    EXPECT_EQ(json % 4, 0u);
    EXPECT_EQ(glb.substr(16, 4), "JSON");
    EXPECT_EQ(number_at(20 + json) + 28 + json, glb.size());
    EXPECT_EQ(glb.substr(24 + json, 4), std::string("BIN\0", 4));
    return {nlohmann::json::parse(glb.substr(20, json)), glb.substr(28 + json)};
}

std::vector<float> floats_of(const nlohmann::json& scene, const std::string& bytes, std::size_t accessor) {
    const nlohmann::json& view =
        scene["bufferViews"][scene["accessors"][accessor]["bufferView"].get<std::size_t>()];
    std::vector<float> floats(view["byteLength"].get<std::size_t>() / 4);
    const std::size_t each = scene["accessors"][accessor]["type"] == "SCALAR" ? 1 : 3;
    EXPECT_EQ(scene["accessors"][accessor]["count"].get<std::size_t>() * each, floats.size());
    std::memcpy(floats.data(), &bytes.at(view["byteOffset"].get<std::size_t>()), 4 * floats.size());
    return floats;
}

TEST(BakedGlb, HoldsEachInstanceWithUnclampedRadiance) {
    const TestFolder folder;
    const Mesh mesh = upright_square_mesh(1, 1);
    const std::vector<Rgb> first(mesh.positions.size(), Rgb(0.2f, 7, -1)),
        second(mesh.positions.size(), Rgb(3, 0, 0));
    const Placement placement{{1, 2, 3}, 2, rotation_xyz({0.3f, 0.4f, 0.5f})};
    const std::vector<BakedInstance> instances{{"left \"a\" \xff", &mesh, {}, first},
                                               {"b", &mesh, placement, second}};
    ASSERT_TRUE(write_baked_glb(folder / "a.glb", instances));
    const auto [scene, bytes] = chunks_of(text_of(folder / "a.glb"));
    ASSERT_EQ(scene["nodes"].size(), 2u);
    EXPECT_EQ(scene["nodes"][0]["name"], "left \"a\" \xef\xbf\xbd");
    EXPECT_EQ(scene["nodes"][1]["name"], "b");
    EXPECT_FALSE(scene["nodes"][0].contains("matrix"));
    EXPECT_TRUE(scene["materials"][0]["extensions"].contains("KHR_materials_unlit"));
    EXPECT_EQ(scene["extensionsUsed"], nlohmann::json::array({"KHR_materials_unlit"}));
    EXPECT_EQ(scene["scenes"][0]["nodes"], nlohmann::json::array({0, 1}));
    const nlohmann::json& a = scene["meshes"][0]["primitives"][0];
    const nlohmann::json& b = scene["meshes"][1]["primitives"][0];
    EXPECT_EQ(a["indices"], b["indices"]) << "shared";
    EXPECT_EQ(a["attributes"]["POSITION"], b["attributes"]["POSITION"]);
    EXPECT_EQ(a["attributes"]["_RADIANCE"], a["attributes"]["COLOR_0"]);
    EXPECT_NE(a["attributes"]["_RADIANCE"], b["attributes"]["_RADIANCE"]);
    const std::vector<float> positions = floats_of(scene, bytes, a["attributes"]["POSITION"]),
                             normals = floats_of(scene, bytes, a["attributes"]["NORMAL"]),
                             red = floats_of(scene, bytes, a["attributes"]["COLOR_0"]),
                             other = floats_of(scene, bytes, b["attributes"]["COLOR_0"]);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        EXPECT_EQ(Vec3f(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]), mesh.positions[i]);
        EXPECT_EQ(Vec3f(normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]), mesh.normals[i]);
        EXPECT_EQ(Rgb(red[3 * i], red[3 * i + 1], red[3 * i + 2]), first[i]);
        EXPECT_EQ(Rgb(other[3 * i], other[3 * i + 1], other[3 * i + 2]), second[i]);
    }
    EXPECT_EQ(scene["accessors"][a["attributes"]["POSITION"].get<std::size_t>()]["min"],
              nlohmann::json::array({-1, -1, 0}));

    // assimp reads the file independently: the instance is upright, rotated and in its place.
    const Result<ImportedMesh> back = read_mesh(folder / "a.glb");
    ASSERT_TRUE(back) << back.error().message();
    ASSERT_EQ(back->mesh.triangles.size(), 2 * mesh.triangles.size());
    for (std::size_t t = 0; t < back->mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f corner = mesh.positions[mesh.triangles[t % mesh.triangles.size()][k]];
            const Vec3f expected = t < mesh.triangles.size() ? corner : placement.point_to_world(corner);
            EXPECT_LT((back->mesh.positions[back->mesh.triangles[t][k]] - expected).length(), 1e-5f) << t;
        }
}

TEST(BakedCsv, NamesEveryVertexOnce) {
    const TestFolder folder;
    const Mesh mesh = upright_square_mesh(1, 1);
    const std::vector<Rgb> radiance(mesh.positions.size(), Rgb(0.1f, 7, -1));
    const std::vector<BakedInstance> instances{{"a", &mesh, {}, radiance},
                                               {"say \"b\", twice", &mesh, {{1, 2, 3}, 2}, radiance}};
    ASSERT_TRUE(write_baked_csv(folder / "a.csv", instances));
    std::istringstream lines(text_of(folder / "a.csv"));
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "instance,vertex,x,y,z,nx,ny,nz,radiance_r,radiance_g,radiance_b");
    std::getline(lines, line);
    EXPECT_EQ(line, "a,0,-1,-1,0,0,0,1,0.1,7,-1");
    for (int i = 1; i < 4; ++i) std::getline(lines, line);
    std::getline(lines, line);
    EXPECT_EQ(line, "\"say \"\"b\"\", twice\",0,-1,0,3,0,0,1,0.1,7,-1");
    for (int i = 1; i < 4; ++i) std::getline(lines, line);
    EXPECT_TRUE(line.starts_with("\"say \"\"b\"\", twice\",3,"));
    EXPECT_FALSE(std::getline(lines, line));
}

/// Two squares with passes of different kinds.
struct PassedSquares {
    const Mesh mesh = upright_square_mesh(1, 1);
    const std::vector<Rgb> radiance = values(0.5f), open[2] = {values(0.25f), values(0.75f)},
                           shadow[2] = {values(3), values(-7)};
    const std::vector<BakedInstance> instances{
        {"a", &mesh, {}, radiance, {}, {}, {{"occlusion", open[0], true}, {"own_shadow", shadow[0]}}},
        {"b", &mesh, {}, radiance, {}, {}, {{"occlusion", open[1], true}, {"own_shadow", shadow[1]}}}};

private:
    /// Returns a different value for each vertex.
    std::vector<Rgb> values(float first) const {
        std::vector<Rgb> made;
        for (std::size_t v = 0; v < mesh.positions.size(); ++v)
            made.push_back(Rgb(first, 2 * first, -first) + Rgb(float(v)));
        return made;
    }
};

TEST(BakedPly, HoldsPassesBehindTheInstance) {
    const TestFolder folder;
    const PassedSquares squares;
    ASSERT_TRUE(write_baked_ply(folder / "a.ply", squares.instances));
    const std::string text = text_of(folder / "a.ply");
    EXPECT_NE(text.find("property int instance\nproperty int original_vertex\nproperty float "
                        "occlusion\nproperty float own_shadow_r\n"
                        "property float own_shadow_g\nproperty float own_shadow_b\nelement face"),
              std::string::npos);
    const std::size_t data = text.find("end_header\n") + 11, each = 47 + 16;
    ASSERT_EQ(text.size(), data + 8 * each + 4 * 13);
    for (std::size_t v = 0; v < 8; ++v) {
        float numbers[4];
        std::memcpy(numbers, &text[data + each * v + 47], sizeof numbers);
        EXPECT_EQ(numbers[0], squares.open[v / 4][v % 4].x) << v;
        EXPECT_EQ(Rgb(numbers[1], numbers[2], numbers[3]), squares.shadow[v / 4][v % 4]) << v;
    }
    EXPECT_TRUE(read_mesh(folder / "a.ply"));
}

TEST(BakedCsv, HasColumnsOfPasses) {
    const TestFolder folder;
    const PassedSquares squares;
    ASSERT_TRUE(write_baked_csv(folder / "a.csv", squares.instances));
    std::istringstream lines(text_of(folder / "a.csv"));
    std::string line;
    std::getline(lines, line);
    EXPECT_TRUE(line.ends_with(",radiance_b,occlusion,own_shadow_r,own_shadow_g,own_shadow_b")) << line;
    for (int v = 0; v < 6; ++v) std::getline(lines, line);
    EXPECT_EQ(line, "b,1,1,-1,0,0,0,1,1.5,2,0.5,1.75,-6,-13,8");
}

TEST(BakedGlb, HoldsPassesAsAttributes) {
    const TestFolder folder;
    const PassedSquares squares;
    ASSERT_TRUE(write_baked_glb(folder / "a.glb", squares.instances));
    const auto [scene, bytes] = chunks_of(text_of(folder / "a.glb"));
    for (std::size_t i = 0; i < 2; ++i) {
        const nlohmann::json& attributes = scene["meshes"][i]["primitives"][0]["attributes"];
        const std::vector<float> open = floats_of(scene, bytes, attributes["_OCCLUSION"]),
                                 shadow = floats_of(scene, bytes, attributes["_OWN_SHADOW"]);
        ASSERT_EQ(open.size(), 4u);
        ASSERT_EQ(shadow.size(), 12u);
        for (std::size_t v = 0; v < 4; ++v) {
            EXPECT_EQ(open[v], squares.open[i][v].x);
            EXPECT_EQ(Rgb(shadow[3 * v], shadow[3 * v + 1], shadow[3 * v + 2]), squares.shadow[i][v]);
        }
    }
    EXPECT_TRUE(read_mesh(folder / "a.glb"));
}

TEST(BakedFilesForOthers, RefusePassesThatDoNotFitOrAreNotFinite) {
    const TestFolder folder;
    const Mesh mesh = upright_square_mesh(1, 1);
    const std::vector<Rgb> radiance(4, Rgb(1.0f)), few(3, Rgb(1.0f)), bad{Rgb(1), Rgb(1), Rgb(INFINITY), {}};
    for (const auto& [values, words] :
         {std::pair(&few, "3 values of diffuse"), std::pair(&bad, "diffuse of vertex 2")}) {
        const std::vector<BakedInstance> instances{
            {"a", &mesh, {}, radiance, {}, {}, {{"diffuse", *values}}}};
        const Result<Done> written = write_baked_ply(folder / "a.ply", instances);
        ASSERT_FALSE(written);
        EXPECT_NE(written.error().message().find(words), std::string::npos) << written.error().message();
    }
    EXPECT_TRUE(folder.files().empty());
}

TEST(BakedFilesForOthers, RefuseNonFiniteValuesAndWriteNothing) {
    const TestFolder folder;
    const Mesh mesh = upright_square_mesh(1, 1);
    const std::vector<Rgb> radiance(mesh.positions.size(), Rgb(NAN, 0, 0));
    const std::vector<BakedInstance> instances{{"a", &mesh, {}, radiance}};
    EXPECT_FALSE(write_baked_glb(folder / "a.glb", instances));
    EXPECT_FALSE(write_baked_csv(folder / "a.csv", instances));
    EXPECT_FALSE(write_baked_glb(folder / "a.glb", {}));
    EXPECT_TRUE(folder.files().empty());
}

TEST(InterpolationRotation, TurnsNoTriangleEdgeOn) {
    // A wavy board, extruded along z: every triangle is parallel to z.
    Mesh mesh = upright_square_mesh(2, 40);
    for (Vec3f& p : mesh.positions) p.z = p.z + 1e-3f * p.y + 0.2f * std::sin(3 * p.x);
    for (Vec3f& p : mesh.positions) p = Vec3f(p.x, p.z, p.y);
    const std::array<Vec3d, 3> r = interpolation_rotation(mesh).row;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(r[i].dot(r[j]), i == j ? 1 : 0, 1e-12);
    EXPECT_GT(r[0].cross(r[1]).dot(r[2]), 0);
    for (const auto& t : mesh.triangles) {
        const Vec3d a(mesh.positions[t[0]]), b(mesh.positions[t[1]]), c(mesh.positions[t[2]]);
        EXPECT_GT(std::abs((b - a).cross(c - a).normalized().dot(r[2])), 0.05);
    }
}

TEST(SmallTriangleScale, IsAPowerOfTwoThatMakesEdgesLargeEnough) {
    for (float size : {1e-5f, 1e-3f, 0.3f, 1.0f, 40.0f, 5e5f}) {
        const double scale = small_triangle_scale(upright_square_mesh(size, 8));
        EXPECT_EQ(std::exp2(std::round(std::log2(scale))), scale);
        EXPECT_GE(scale * size / 4, 0.1);
        EXPECT_LE(scale * size, 5e5);
    }
}

}  // namespace
}  // namespace haarfield
