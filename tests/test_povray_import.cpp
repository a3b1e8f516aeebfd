#include "bridge/povray_import/dual_contour.h"
#include "bridge/povray_import/imported_scene.h"
#include "bridge/povray_import/light_probe.h"
#include "bridge/povray_import/object_surfaces.h"
#include "fields/base/names.h"
#include "fields/file/write_file.h"
#include "fields/mesh/mesh_topology.h"
#include "fields/model/mesh_reader.h"
#include "scenes/image.h"
#include "scenes/scene_entities.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_writer.h"
#include "scenes/texture.h"
#include "shading/scene/environment.h"
#include "shading/visibility/light_filters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace haarfield {
namespace {

std::filesystem::path written_scene(const std::string& name, const std::string& text) {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("haarfield_" + name);
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    EXPECT_TRUE(write_file(folder / "scene.pov", text));
    return folder / "scene.pov";
}

/// Returns a grid whose lines cross a solid with a signed distance and a normal, found by bisection.
template <class Distance>
CrossedGrid crossed(int cells, const Distance& distance) {
    CrossedGrid grid;
    grid.cells.fill(cells);
    for (int axis = 0; axis < 3; ++axis) {
        grid.lines[std::size_t(axis)].resize(grid.line_count(axis));
        for (std::size_t line = 0; line < grid.line_count(axis); ++line) {
            Vec3d p(0, 0, 0);
            p[(axis + 1) % 3] = double(line / std::size_t(cells + 1));
            p[(axis + 2) % 3] = double(line % std::size_t(cells + 1));
            constexpr int steps = 16;
            for (int k = 0; k < cells * steps; ++k) {
                Vec3d a = p, b = p;
                a[axis] = double(k) / steps;
                b[axis] = double(k + 1) / steps;
                const bool before = distance(a) < 0, after = distance(b) < 0;
                if (before == after) continue;
                for (int i = 0; i < 50; ++i) {
                    const Vec3d m = (a + b) / 2;
                    ((distance(m) < 0) == before ? a : b) = m;
                }
                Vec3d gradient;
                for (int c = 0; c < 3; ++c) {
                    Vec3d step(0, 0, 0);
                    step[c] = 1e-6;
                    gradient[c] = distance(a + step) - distance(a - step);
                }
                grid.lines[std::size_t(axis)][line].push_back(
                    {a[axis], Vec3f(gradient.normalized()), before, after});
            }
        }
    }
    return grid;
}

/// Counts edges that do not have one triangle in each direction, by position.
std::size_t open_edges(const ContouredMesh& mesh) {
    std::map<std::array<float, 3>, std::uint32_t> index;
    std::vector<std::uint32_t> merged;
    for (const Vec3f& p : mesh.positions)
        merged.push_back(index.emplace(std::array{p.x, p.y, p.z}, std::uint32_t(index.size())).first->second);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& triangle : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = merged[triangle[k]], b = merged[triangle[(k + 1) % 3]];
            if (a < b) ++edges[{a, b}];
            if (b < a) --edges[{b, a}];
        }
    return std::size_t(std::ranges::count_if(edges, [](const auto& edge) { return edge.second != 0; }));
}

TEST(DualContour, SphereIsClosedSmoothAndFacesOutwards) {
    const Vec3d centre(8.1, 7.9, 8.3);
    const auto distance = [&](const Vec3d& p) { return (p - centre).length() - 5; };
    const ContouredMesh mesh = dual_contour(crossed(16, distance));
    EXPECT_GT(mesh.triangles.size(), 500u);
    EXPECT_EQ(open_edges(mesh), 0u);
    EXPECT_EQ(mesh.sheet_triangles, 0u);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3d out = Vec3d(mesh.positions[v]) - centre;
        EXPECT_NEAR(out.length(), 5, 0.08);
        EXPECT_GT(out.normalized().dot(Vec3d(mesh.normals[v])), 0.99);
    }
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3d p(mesh.positions[a]),
            across = (Vec3d(mesh.positions[b]) - p).cross(Vec3d(mesh.positions[c]) - p);
        EXPECT_GT(across.dot(p - centre), 0);
    }
}

TEST(DualContour, BoxesKeepTheirEdgesAndCorners) {
    const Vec3d lower(3.3, 3.4, 3.6), upper(12.2, 11.7, 12.6);
    const ContouredMesh mesh = dual_contour(crossed(16, [&](const Vec3d& p) {
        const Vec3d a = lower - p, b = p - upper;
        return std::max({a.x, a.y, a.z, b.x, b.y, b.z});
    }));
    EXPECT_EQ(open_edges(mesh), 0u);
    double nearest = 1;
    for (const Vec3f& p : mesh.positions) {
        nearest = std::min(nearest, (Vec3d(p) - upper).length());
        const Vec3d a = lower - Vec3d(p), b = Vec3d(p) - upper;
        EXPECT_NEAR(std::max({a.x, a.y, a.z, b.x, b.y, b.z}), 0, 1e-4);
    }
    EXPECT_LT(nearest, 1e-3);
}

TEST(DualContour, RoundEdgesHaveNoNotches) {
    const auto distance = [](const Vec3d& p) {  // A cone on a cap.
        const double up = p.y - 2.1, side = std::hypot(p.x - 12.05, p.z - 11.9) - (8 - up * 0.4);
        return std::max({side / std::hypot(1.0, 0.4), -up, up - 15});
    };
    const ContouredMesh mesh = dual_contour(crossed(24, distance));
    EXPECT_EQ(open_edges(mesh), 0u);
    for (const Vec3f& p : mesh.positions)
        EXPECT_NEAR(distance(Vec3d(p)), 0, 0.12) << p.x << ' ' << p.y << ' ' << p.z;
}

TEST(DualContour, SheetsAreOpen) {
    CrossedGrid grid;
    grid.cells.fill(8);
    for (int axis = 0; axis < 3; ++axis) grid.lines[std::size_t(axis)].resize(grid.line_count(axis));
    for (std::size_t line = 0; line < grid.line_count(1); ++line)
        grid.lines[1][line].push_back({4.25, Vec3f(0, 1, 0), false, false});
    const ContouredMesh mesh = dual_contour(grid);
    EXPECT_EQ(mesh.triangles.size(), 7u * 7u * 2u);
    EXPECT_EQ(mesh.sheet_triangles, mesh.triangles.size());
    for (const Vec3f& p : mesh.positions) EXPECT_FLOAT_EQ(p.y, 4.25f);
}

TEST(DualContour, ThinWallsWithinACellStayApart) {
    const auto distance = [](const Vec3d& p) {
        return std::max(std::abs(p.x - 8.0) - 0.55, (p - Vec3d(8)).length() - 6);
    };
    const ContouredMesh mesh = dual_contour(crossed(16, distance));
    EXPECT_EQ(open_edges(mesh), 0u);
    for (const Vec3f& p : mesh.positions) EXPECT_NEAR(distance(Vec3d(p)), 0, 0.1);
}

/// A scene with one object of each kind of finish and pigment.
constexpr const char* scene_text_3 = R"(#version 3.7;
global_settings{assumed_gamma 1}
camera{location <0,2,-8> look_at <0,0,0> angle 50}
light_source{<5,9,-9> rgb <.5,.75,1>}
background{rgb <.1,.2,.4>}
sphere{<-2.5,0,0>,1 pigment{rgb <1,.5,.2>} finish{diffuse .6 phong .7 phong_size 40}}
#for(I,0,1) box{-1,1 scale .6 translate 2*I*x
  pigment{gradient y color_map{[.5 rgb x][.5 rgb z]}} finish{diffuse .5 specular .4 roughness .02 ambient 0}} #end
plane{y,-1 pigment{rgb .5}}
sphere{0,1e5 pigment{rgb 1} inverse}
sphere{<0,2,0>,.5 pigment{rgbt <1,1,1,.9>} interior{ior 1.5}}
)";

/// Imports a scene from its text.
Result<ImportedPovrayScene> imported_text(const std::string& name, const std::string& text, int detail) {
    const std::filesystem::path file = written_scene(name, text);
    PovrayImport options;
    options.detail = detail;
    return imported_povray_scene(file, file.parent_path() / "out", "scene", options);
}

class PovrayImportTest : public testing::Test {
protected:
    static const ImportedPovrayScene& imported() {
        static const ImportedPovrayScene scene = [] {
            const Result<ImportedPovrayScene> result = imported_text("povray_import", scene_text_3, 24);
            EXPECT_TRUE(result) << result.error().message();
            return result ? *result : ImportedPovrayScene();
        }();
        return scene;
    }
    static ImportedMesh mesh_of(const std::string& name) {
        MeshReaderOptions options;
        options.appearance = true;
        for (const Entity& entity : imported().scene.entities)
            if (entity.name == name) return *read_mesh(entity.mesh, options);
        ADD_FAILURE() << "no entity " << name;
        return {};
    }
};

TEST_F(PovrayImportTest, ObjectsBecomeMeshesWithColoursAndFinishes) {
    const Scene& scene = imported().scene;
    ASSERT_EQ(scene.entities.size(), 6u);  // A sphere, two boxes, and the zones of the plane.
    EXPECT_EQ(imported().transparent, 1u);
    const SceneMaterial& sphere = scene.materials.at("sphere");
    EXPECT_NEAR(sphere.diffuse.x, 0.6, 0.006);
    EXPECT_NEAR(sphere.phong, 0.7, 0.02);
    EXPECT_NEAR(sphere.shininess, 40, 4);  // Normals of a coarse mesh.
    const SceneMaterial& box = scene.materials.at("box");
    EXPECT_NEAR(box.diffuse.x, 0.5, 0.005);
    EXPECT_NEAR(box.blinn, 0.4, 0.01);
    EXPECT_NEAR(box.roughness, 0.02, 0.001);
    const ImportedMesh ball = mesh_of("sphere");
    for (const Rgb& colour : ball.mesh.colours) {
        EXPECT_NEAR(colour.x, 1, 1e-4);
        EXPECT_NEAR(colour.y, 0.5, 1e-4);
    }
    for (const Vec3f& p : ball.mesh.positions) EXPECT_NEAR((p - Vec3f(-2.5f, 0, 0)).length(), 1, 0.01);
    EXPECT_TRUE(triangles_of_open_pieces(ball.mesh).empty() ||
                std::ranges::none_of(triangles_of_open_pieces(ball.mesh),
                                     [](std::uint8_t open) { return open != 0; }));
}

TEST_F(PovrayImportTest, PigmentsThatVaryBecomeAnImage) {
    const SceneMaterial& material = imported().scene.materials.at("box");
    EXPECT_FALSE(material.vertex_colours);
    TextureSource source;
    source.image.file = material.image;
    const Result<Texture> pigments = read_texture(source);
    ASSERT_TRUE(pigments) << pigments.error().message();
    const Mesh box = mesh_of("box").mesh;
    ASSERT_EQ(box.uvs.size(), box.positions.size());
    std::size_t red = 0, blue = 0;
    for (const auto& [a, b, c] : box.triangles) {
        const Vec3f p = (box.positions[a] + box.positions[b] + box.positions[c]) / 3;
        const float pattern = p.y - std::floor(p.y);
        if (std::abs(pattern - 0.5f) > 0.45f || std::abs(pattern - 0.5f) < 0.05f) continue;
        const Rgb colour = pigments->colour_at((box.uvs[a] + box.uvs[b] + box.uvs[c]) / 3.0f),
                  expected = pattern < 0.5f ? Rgb(1, 0, 0) : Rgb(0, 0, 1);
        ++(pattern < 0.5f ? red : blue);
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(colour[channel], expected[channel], 0.01f) << p.x << ' ' << p.y << ' ' << p.z;
    }
    EXPECT_GT(red, 20u);
    EXPECT_GT(blue, 20u);
}

TEST_F(PovrayImportTest, InfiniteObjectsAreDividedByDistance) {
    const auto reach = [](const ImportedMesh& mesh) {
        float farthest = 0;
        for (const Vec3f& p : mesh.mesh.positions)
            farthest = std::max({farthest, std::abs(p.x), std::abs(p.z)});
        return farthest;
    };
    const float near = reach(mesh_of("plane")), around = reach(mesh_of("plane_around")),
                far = reach(mesh_of("plane_far"));
    EXPECT_LT(near, 10);  // The finite objects have a radius of three.
    EXPECT_GT(near, 3);
    EXPECT_LT(around, 45);
    EXPECT_GT(around, near);
    EXPECT_GT(far, 200);
}

TEST_F(PovrayImportTest, MeshesWithImageCoordinatesAreClosed) {
    const ImportedMesh box = mesh_of("box");
    EXPECT_TRUE(std::ranges::none_of(triangles_of_open_pieces(box.mesh),
                                     [](std::uint8_t open) { return open != 0; }));
}

TEST_F(PovrayImportTest, SceneFilesKeepCameraMaterialsAndColours) {
    const Scene& scene = imported().scene;
    const std::filesystem::path folder = scene.entities.front().mesh.parent_path(),
                                file = folder / "kept.toml";
    ASSERT_TRUE(write_file(file, scene_text(scene, folder)));
    const Result<Scene> read = read_scene(file);
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_LT((read->camera.position - scene.camera.position).length(), 1e-4f);
    for (const auto& [name, material] : scene.materials) {
        EXPECT_EQ(read->materials.at(name).vertex_colours, material.vertex_colours) << name;
        EXPECT_EQ(read->materials.at(name).image.filename(), material.image.filename()) << name;
        EXPECT_NEAR(read->materials.at(name).diffuse.x, material.diffuse.x, 1e-6) << name;
    }
}

TEST_F(PovrayImportTest, OnlyLightsIlluminateAFileWithoutRadiosity) {
    const Scene& scene = imported().scene;
    EXPECT_EQ(scene.bounces, 0);
    EXPECT_FALSE(scene.environment.lights);
    EXPECT_NEAR(scene.materials.at("sphere").ambient.x, 0.1, 1e-3);  // POV-Ray's default.
    EXPECT_EQ(scene.materials.at("sphere").emission, Rgb(0.0f));
    EXPECT_EQ(scene.materials.at("box").ambient, Rgb(0.0f));
    EXPECT_FALSE(scene.materials.at("sphere").reflection.is_there());
}

TEST(PovrayImport, BroadHighlightsAndSaturatedPigmentsAreMeasured) {
    const auto imported =
        imported_text("povray_finish",
                      "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location -9*z look_at 0}\n"
                      "light_source{<5,9,-9> rgb 1}\n"
                      "torus{2,.6 rotate x*50 pigment{rgb <.9,.75,.2>} finish{specular .4 roughness .06}}\n"
                      "sphere{0,1 pigment{rgb <0,.9,0>} finish{diffuse .7 ambient .2}}\n",
                      32);
    ASSERT_TRUE(imported) << imported.error().message();
    const SceneMaterial &torus = imported->scene.materials.at("torus"),
                        &sphere = imported->scene.materials.at("sphere");
    EXPECT_NEAR(torus.blinn, 0.4, 0.02);
    EXPECT_NEAR(torus.roughness, 0.06, 0.006);
    EXPECT_NEAR(torus.diffuse.x, 0.6, 0.012);
    EXPECT_EQ(torus.phong, 0);
    EXPECT_NEAR(sphere.diffuse.y, 0.7, 0.007);
    EXPECT_NEAR(sphere.ambient.y, 0.2, 0.002);
    EXPECT_FALSE(sphere.reflection.is_there());
}

TEST(PovrayImport, NarrowHighlightsAreMeasured) {
    const auto imported =
        imported_text("povray_narrow",
                      "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location -9*z look_at 0}\n"
                      "light_source{<5,9,-9> rgb 1}\ntorus{2,.6 rotate x*50 pigment{rgb <.9,.75,.2>} "
                      "finish{phong 1 phong_size "
                      "400}}\n",
                      24);
    ASSERT_TRUE(imported) << imported.error().message();
    EXPECT_NEAR(imported->scene.materials.at("torus").phong, 1, 0.02);
    EXPECT_NEAR(imported->scene.materials.at("torus").shininess, 400, 12);
}

TEST(PovrayImport, FilesWithAGammaKeepTheirNumbers) {
    const auto imported =
        imported_text("povray_gamma",
                      "#version 3.7;\nglobal_settings{assumed_gamma 2.2}\ncamera{location -9*z look_at 0}\n"
                      "background{rgb <.1,.2,.4>}\nlight_source{<5,9,-9> rgb .5}\n"
                      "sphere{0,1 pigment{rgb <.5,.25,1>} finish{diffuse .6 ambient .2}}\n"
                      "torus{2,.3 pigment{gradient y color_map{[.5 rgb .2][.5 rgb .7]}}}\n",
                      24);
    ASSERT_TRUE(imported) << imported.error().message();
    const Scene& scene = imported->scene;
    EXPECT_NEAR(scene.assumed_gamma, 2.2, 0.005);
    EXPECT_NEAR(scene.lamps.at(0).colour.x, 0.5, 1e-6);
    EXPECT_NEAR(scene.materials.at("sphere").diffuse.x, 0.6, 0.01);
    EXPECT_NEAR(scene.materials.at("sphere").ambient.x, 0.2, 0.003);
    MeshReaderOptions options;
    options.appearance = true;
    const auto sphere = std::ranges::find(scene.entities, "sphere", &Entity::name);
    ASSERT_NE(sphere, scene.entities.end());
    const Result<ImportedMesh> mesh = read_mesh(sphere->mesh, options);
    ASSERT_TRUE(mesh) << mesh.error().message();
    for (const Rgb& colour : mesh->mesh.colours) EXPECT_LT((colour - Rgb(0.5f, 0.25f, 1)).length(), 2e-3f);
    const Result<Image> sky = read_image(scene.environment.image);
    ASSERT_TRUE(sky) << sky.error().message();
    EXPECT_LT((sky->pixels.front() - Rgb(0.1f, 0.2f, 0.4f)).length(), 2e-3f);
    // Images are linear light.
    const Result<Image> pigments = read_image(scene.materials.at("torus").image);
    ASSERT_TRUE(pigments) << pigments.error().message();
    for (const Rgb& pixel : pigments->pixels)
        EXPECT_TRUE(pixel.x < 0.01f || std::abs(pixel.x - std::pow(0.2f, 2.2f)) < 0.005f ||
                    std::abs(pixel.x - std::pow(0.7f, 2.2f)) < 0.005f)
            << pixel.x;
    const std::filesystem::path folder = sphere->mesh.parent_path(), file = folder / "kept.toml";
    ASSERT_TRUE(write_file(file, scene_text(scene, folder)));
    const Result<Scene> read = read_scene(file);
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_NEAR(read->assumed_gamma, scene.assumed_gamma, 1e-4);
}

TEST(PovrayImport, LargeObjectsThatComeNearAreCutLikePlanes) {
    const auto imported = imported_text(
        "povray_disc",
        "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location <0,3,-9> look_at 0}\n"
        "light_source{<5,9,-9> rgb 1}\nsphere{0,1 pigment{rgb .5}}\ndisc{-y,y,5000 pigment{rgb .5}}\n"
        "sphere{0,4000 hollow pigment{rgb 1}}\n",
        24);
    ASSERT_TRUE(imported) << imported.error().message();
    EXPECT_EQ(imported->distant, 1u) << "the sky";
    EXPECT_EQ(imported->failed, 0u);
    const auto disc = std::ranges::find(imported->scene.entities, "disc", &Entity::name);
    ASSERT_NE(disc, imported->scene.entities.end());
    const Result<ImportedMesh> mesh = read_mesh(disc->mesh);
    ASSERT_TRUE(mesh) << mesh.error().message();
    for (const Vec3f& p : mesh->mesh.positions) EXPECT_NEAR(p.y, -1, 1e-3);
}

TEST(PovrayImport, PigmentsThatAreTransparentInPlacesHaveAlpha) {
    const auto imported =
        imported_text("povray_stripes",
                      "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location -9*z look_at 0}\n"
                      "light_source{<5,9,-9> rgb 1}\nplane{y,-3 pigment{rgb .5}}\n"
                      "box{-1,1 pigment{gradient y color_map{[.7 rgb <1,.5,.2>][.7 rgbt 1]} scale .5}}\n",
                      24);
    ASSERT_TRUE(imported) << imported.error().message();
    EXPECT_EQ(imported->transparent, 0u);
    const auto box = std::ranges::find(imported->scene.entities, "box", &Entity::name);
    ASSERT_NE(box, imported->scene.entities.end());
    TextureSource source;
    source.image.file = imported->scene.materials.at("box").image;
    source.alpha = AlphaMode::blend;
    const Result<Texture> pigments = read_texture(source);
    ASSERT_TRUE(pigments) << pigments.error().message();
    ASSERT_TRUE(pigments->has_alpha);
    MeshReaderOptions options;
    options.appearance = true;
    const Result<ImportedMesh> read = read_mesh(box->mesh, options);
    ASSERT_TRUE(read) << read.error().message();
    const Mesh& mesh = read->mesh;
    std::array<int, 2> found{};
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3f p = (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3;
        const float pattern = 2 * p.y - std::floor(2 * p.y);
        if (std::abs(pattern - 0.35f) > 0.3f && std::abs(pattern - 0.85f) > 0.1f) continue;
        const bool is_opaque = pattern < 0.7f;
        const Vec2f at = (mesh.uvs[a] + mesh.uvs[b] + mesh.uvs[c]) / 3.0f;
        EXPECT_NEAR(pigments->opacity_at(at), is_opaque ? 1 : 0, 0.02f) << p.x << ' ' << p.y << ' ' << p.z;
        const Rgb colour = pigments->colour_at(at);
        EXPECT_TRUE(!is_opaque || (colour - Rgb(1, 0.5f, 0.2f)).length() < 0.02f) << p.x << ' ' << p.y;
        ++found[is_opaque];
    }
    EXPECT_GT(found[0], 100);
    EXPECT_GT(found[1], 100);
}

TEST(PovrayImport, SmallObjectsThatPovrayTakesForInfiniteHaveTheirOwnGrid) {
    // An infinite cylinder, of which an open piece is left.
    const auto imported = imported_text(
        "povray_clipped",
        "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location <0,3,-9> look_at 0}\n"
        "light_source{<5,9,-9> rgb 1}\nplane{y,-2 pigment{rgb .5}}\n"
        "quadric{<1,0,1>,<0,0,0>,<0,0,0>,-1 clipped_by{plane{y,1} plane{-y,1}} pigment{rgb .5}}\n",
        24);
    ASSERT_TRUE(imported) << imported.error().message();
    const auto cylinder = std::ranges::find(imported->scene.entities, "quadric", &Entity::name);
    ASSERT_NE(cylinder, imported->scene.entities.end());
    Bounds box;
    const Result<ImportedMesh> mesh = read_mesh(cylinder->mesh);
    ASSERT_TRUE(mesh) << mesh.error().message();
    for (const Vec3f& p : mesh->mesh.positions) {
        EXPECT_NEAR(std::hypot(p.x, p.z), 1, 0.02);
        box.add(p);
    }
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(box.lower[axis], -1, 0.12);
        EXPECT_NEAR(box.upper[axis], 1, 0.12);
    }
    EXPECT_EQ(imported->distant, 0u);
    for (const std::string& warning : imported->warnings)
        EXPECT_EQ(warning.find("wrong places"), std::string::npos) << warning;
}

TEST(PovrayImport, ClippedPlanesAreSheetsAndOrthographicCamerasDistant) {
    // Lines along x and y meet nothing, so that the plane's half-space seems to be empty.
    const auto imported = imported_text("povray_clipped_plane",
                                        "#version 3.7;\nglobal_settings{assumed_gamma 1}\n"
                                        "camera{orthographic location <0,0,-9> look_at 0 right 8*x up 6*y}\n"
                                        "light_source{<5,9,-9> rgb 1}\n"
                                        "plane{z,0.1 clipped_by{box{<-2,-1,-1>,<2,1,1>}} pigment{rgb .5}}\n",
                                        24);
    ASSERT_TRUE(imported) << imported.error().message();
    ASSERT_EQ(imported->scene.entities.size(), 1u);
    Bounds box;
    const Result<ImportedMesh> mesh = read_mesh(imported->scene.entities[0].mesh);
    ASSERT_TRUE(mesh) << mesh.error().message();
    for (const Vec3f& p : mesh->mesh.positions) box.add(p);
    EXPECT_LT((box.lower - Vec3f(-2, -1, -0.1f)).length(), 0.3f);
    EXPECT_LT((box.upper - Vec3f(2, 1, -0.1f)).length(), 0.3f);
    EXPECT_FALSE(imported->scene.finds_camera);
    const Camera& camera = imported->scene.camera;
    EXPECT_NEAR(camera.position.z * std::tan(camera.vertical_fov / 2), 3, 0.01);
    EXPECT_EQ(camera.height, 480);
    EXPECT_TRUE(std::ranges::any_of(imported->warnings, [](const std::string& warning) {
        return warning.find("orthographic") != std::string::npos;
    }));
}

TEST(PovrayImport, ThinPartsOfUnionsAreWhole) {
    // The rod is thinner than half a cell of the union's first grid.
    const auto imported =
        imported_text("povray_thin",
                      "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location <0,3,-9> look_at 0}\n"
                      "light_source{<5,9,-9> rgb 1}\n"
                      "union{box{-1,1} cylinder{<.3,0,.2>,<.9,2.5,.5>,.035} pigment{rgb .5}}\n",
                      32);
    ASSERT_TRUE(imported) << imported.error().message();
    ASSERT_EQ(imported->scene.entities.size(), 1u);
    const Result<ImportedMesh> mesh = read_mesh(imported->scene.entities.front().mesh);
    ASSERT_TRUE(mesh) << mesh.error().message();
    const Vec3f from(0.54f, 1.0f, 0.32f), to(0.9f, 2.5f, 0.5f);
    for (int step = 1; step <= 50; ++step) {
        const Vec3f at = from + (to - from) * (float(step) / 50);
        float nearest = INFINITY;
        for (const Vec3f& p : mesh->mesh.positions)
            nearest = std::min(nearest, (Vec3f(p.x, p.y, -p.z) - at).length());
        EXPECT_LT(nearest, 0.06f) << step;
    }
    for (const std::string& warning : imported->warnings)
        EXPECT_EQ(warning.find("narrower"), std::string::npos) << warning;
}

TEST(PovrayImport, GridsAreNoFinerThanPixels) {
    // The second union has the same thin rod, but is 42 pixels wide.
    const auto imported =
        imported_text("povray_distant",
                      "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location <0,3,-9> look_at 0}\n"
                      "light_source{<5,9,-9> rgb 1}\n"
                      "#declare Rod=union{box{-1,1} cylinder{<.3,0,.2>,<.9,2.5,.5>,.035} pigment{rgb .5}}\n"
                      "object{Rod}\nobject{Rod translate <4,0,30>}\n",
                      32);
    ASSERT_TRUE(imported) << imported.error().message();
    ASSERT_EQ(imported->scene.entities.size(), 2u);
    std::array<std::size_t, 2> triangles{};
    for (std::size_t e = 0; e < 2; ++e) {
        const Result<ImportedMesh> mesh = read_mesh(imported->scene.entities[e].mesh);
        ASSERT_TRUE(mesh) << mesh.error().message();
        triangles[e] = mesh->mesh.triangles.size();
    }
    EXPECT_GT(triangles[0], 3 * triangles[1]);
    for (const std::string& warning : imported->warnings)
        EXPECT_EQ(warning.find("narrower"), std::string::npos) << warning;
}

/// Returns the share of a mesh's area where the interpolated normal is off by more than 10 degrees.
///
/// normal  the exact one near a point.
template <class Normal>
double wrong_share(const Mesh& mesh, const Normal& normal) {
    double wrong = 0, all = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3f centre = (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3.0f;
        const double area = double(
            (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]).length());
        const Vec3f shown = mesh.normals[a] + mesh.normals[b] + mesh.normals[c];
        all += area;
        if (Vec3d(shown).normalized().dot(normal(Vec3d(centre))) < std::cos(10 * pi / 180)) wrong += area;
    }
    return wrong / all;
}

TEST(PovrayImport, EdgesThatAreRoundedWithinACellAreRound) {
    const auto imported =
        imported_text("povray_rounded",
                      "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location <0,0,-4> look_at 0}\n"
                      "light_source{<5,9,-9> rgb 1}\nsuperellipsoid{<.1,.1> pigment{rgb .5}}\n"
                      "box{-1,1 rotate <20,30,0> translate 3*x pigment{rgb .5}}\n",
                      16);
    ASSERT_TRUE(imported) << imported.error().message();
    ASSERT_EQ(imported->scene.entities.size(), 2u);
    const Result<ImportedMesh> rounded = read_mesh(imported->scene.entities[0].mesh);
    ASSERT_TRUE(rounded) << rounded.error().message();
    EXPECT_LT(wrong_share(rounded->mesh,
                          [](const Vec3d& p) {
                              // The gradient of |x|^20 + |y|^20 + |z|^20.
                              const double largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
                              Vec3d gradient;
                              for (int c = 0; c < 3; ++c) gradient[c] = std::pow(p[c] / largest, 19);
                              return gradient.normalized();
                          }),
              0.01);
    // Sharp edges stay sharp.
    const Result<ImportedMesh> box = read_mesh(imported->scene.entities[1].mesh);
    ASSERT_TRUE(box) << box.error().message();
    for (const auto& [a, b, c] : box->mesh.triangles)
        EXPECT_GT(std::min(box->mesh.normals[a].dot(box->mesh.normals[b]),
                           box->mesh.normals[a].dot(box->mesh.normals[c])),
                  0.99f);
}

TEST(PovrayImport, PigmentsMayBeBrighterThanOne) {
    const auto imported =
        imported_text("povray_bright",
                      "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location <0,1,-6> look_at 0}\n"
                      "light_source{<5,9,-9> rgb 1}\n#default{finish{ambient 0 diffuse .6}}\n"
                      "sphere{-2*x,1 pigment{rgb <1.5,.5,.2>}}\n"
                      "box{-1,1 translate 2*x pigment{checker rgb 1.2 rgb .9 scale 4 translate 2*y}}\n"
                      "sphere{3*y,1 pigment{rgb 2}}\n",
                      16);
    ASSERT_TRUE(imported) << imported.error().message();
    const auto material_of = [&](std::size_t entity) {
        return imported->scene.materials.at(imported->scene.entities[entity].material);
    };
    MeshReaderOptions options;
    options.appearance = true;
    const auto colour_of = [&](std::size_t entity) {
        return read_mesh(imported->scene.entities[entity].mesh, options)->mesh.colours.front();
    };
    EXPECT_EQ(imported->scene.entities[0].name, "sphere");
    const Rgb red = material_of(0).pigment * colour_of(0);
    EXPECT_NEAR(red.x, 1.5f, 0.02f);
    EXPECT_NEAR(red.y, 0.5f, 0.02f);
    EXPECT_NEAR(red.z, 0.2f, 0.02f);
    EXPECT_NEAR(material_of(0).diffuse.x / material_of(0).pigment.x, 0.6f, 0.01f);
    // The image has the colours of the checker.
    const SceneMaterial checked = material_of(1);
    EXPECT_NEAR(checked.pigment.x, 1.2f, 0.02f);
    const Result<Image> image = read_image(checked.image);
    ASSERT_TRUE(image) << image.error().message();
    const auto shows = [&](float number) {
        return std::ranges::any_of(image->pixels, [&](const Rgb& pixel) {
            return std::abs(pixel.x * checked.pigment.x - number) < 0.01f;
        });
    };
    EXPECT_TRUE(shows(1.2f));
    EXPECT_TRUE(shows(0.9f));
    // Twice the pigment would reflect 1.2 of the light.
    EXPECT_NEAR(material_of(2).diffuse.x, 1, 0.01f);
    EXPECT_TRUE(std::ranges::any_of(imported->warnings, [](const std::string& warning) {
        return warning.find(":8: sphere has pigments up to 2") != std::string::npos;
    }));
}

TEST(PovrayImport, ACameraInsideAnObjectSeesItsWalls) {
    const auto imported =
        imported_text("povray_room",
                      "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location -2*z look_at 0}\n"
                      "light_source{<0,2,0> rgb 1}\nbox{-3,3 pigment{rgb .5}}\nsphere{0,1 pigment{rgb .5}}\n",
                      24);
    ASSERT_TRUE(imported) << imported.error().message();
    for (const Entity& entity : imported->scene.entities)
        EXPECT_EQ(entity.faces, entity.name == "box" ? ClosedFaces::inwards : ClosedFaces::outwards)
            << entity.name;
}

TEST(PovrayImport, TheSkyIlluminatesAFileWithRadiosity) {
    const auto imported = imported_text(
        "povray_radiosity",
        "#version 3.7;\nglobal_settings{assumed_gamma 1 radiosity{count 20}}\ncamera{location -9*z look_at "
        "0}\n"
        "background{rgb <.1,.2,.4>}\nlight_source{<5,9,-9> rgb 1}\nsphere{0,1 pigment{rgb .5}}\n",
        24);
    ASSERT_TRUE(imported) << imported.error().message();
    EXPECT_FALSE(imported->scene.bounces);
    EXPECT_TRUE(imported->scene.environment.lights);
    EXPECT_EQ(imported->scene.materials.at("sphere").ambient, Rgb(0.0f));
}

TEST_F(PovrayImportTest, PicturesAreNotMirrored) {
    const Scene& scene = imported().scene;
    EXPECT_FALSE(scene.finds_camera);
    // The file's camera looks along +z, with +x to the right. Here it looks along -z.
    EXPECT_LT((scene.camera.position - Vec3f(0, 2, 8)).length(), 1e-4f);
    EXPECT_LT(scene.camera.target.z, 8);
    const double across = 2 * std::tan(25 * pi / 180);
    EXPECT_NEAR(scene.camera.vertical_fov, 2 * std::atan(across / 2 / 1.33), 1e-4);
    ASSERT_EQ(scene.lamps.size(), 1u);
    EXPECT_EQ(scene.lamps[0].position, Vec3f(5, 9, 9));
    EXPECT_EQ(scene.lamps[0].colour, Rgb(0.5f, 0.75f, 1));
}

TEST_F(PovrayImportTest, DistantObjectsAreTheEnvironment) {
    const Result<Image> image = read_image(imported().scene.environment.image);
    ASSERT_TRUE(image) << image.error().message();
    EXPECT_EQ(image->width, 1024);
    EXPECT_EQ(imported().distant, 1u);
    EXPECT_EQ(imported().failed, 0u);
}

TEST_F(PovrayImportTest, TransparentObjectsAreNamedWithTheirLine) {
    const auto& warnings = imported().warnings;
    EXPECT_TRUE(std::ranges::any_of(warnings, [](const std::string& warning) {
        return warning.find("scene.pov:11: sphere is transparent") != std::string::npos;
    })) << testing::PrintToString(warnings);
}

TEST_F(PovrayImportTest, TransparentObjectsFilterLightAndStayInPovray) {
    const Scene& scene = imported().scene;
    ASSERT_EQ(scene.filters.size(), 1u);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(scene.filters[0].colour[c], 0.9, 0.002);
    const ImportedMesh ball = *read_mesh(scene.filters[0].mesh);
    for (const Vec3f& p : ball.mesh.positions) EXPECT_NEAR((p - Vec3f(0, 2, 0)).length(), 0.5, 0.005);

    ASSERT_TRUE(scene.surroundings);
    EXPECT_TRUE(scene.surroundings->left_handed);
    // Rendered by itself, the scene shows the ball and the sky, but not the opaque objects.
    const std::filesystem::path picture = scene.surroundings->file.parent_path() / "picture.png";
    const Result<Done> rendered = render_sandboxed(
        scene.surroundings->file, {scene.surroundings->file.parent_path(), scene.surroundings->folder},
        picture, {"+W80", "+H60"}, {});
    ASSERT_TRUE(rendered) << rendered.error().message();
    const Result<Image> shown = read_image(picture);
    ASSERT_TRUE(shown) << shown.error().message();
    const auto pixel = [&](int x, int y) { return shown->pixels[std::size_t(y * shown->width + x)]; };
    const Rgb sky = pixel(2, 2);
    EXPECT_NEAR(sky.z, 0.4, 0.01);
    EXPECT_GT((pixel(40, 8) - sky).length(), 0.01) << "the ball";
    EXPECT_LT((pixel(40, 30) - sky).length(), 0.005) << "no box";
}

TEST(PovrayImport, GlassAbsorbsLightInside) {
    const auto imported =
        imported_text("povray_glass",
                      "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location -9*z look_at 0}\n"
                      "light_source{<5,9,-9> rgb 1}\nplane{y,-1 pigment{rgb .5}}\n"
                      "box{-.5,.5 pigment{rgbt <1,1,1,.95>} finish{diffuse 0}\n"
                      "interior{ior 1.5 fade_distance .6 fade_power 1001 fade_color <.2,.8,.5>}}\n",
                      24);
    ASSERT_TRUE(imported) << imported.error().message();
    ASSERT_EQ(imported->scene.filters.size(), 1u);
    const SceneFilter& filter = imported->scene.filters[0];
    // POV-Ray's exponential attenuation is exp(-(1 - fade_color) distance / fade_distance).
    const std::array wanted{0.8f / 0.6f, 0.2f / 0.6f, 0.5f / 0.6f};
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(filter.colour[c], 0.95, 0.001);
        EXPECT_NEAR(filter.absorption[c], wanted[std::size_t(c)], 0.003);
    }
}

TEST(PovrayImport, PartsOfGlassFilterByTheirOwnColour) {
    // A hollow ball of glass that is half full of wine, which does not touch it.
    const auto imported =
        imported_text("povray_wine",
                      "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location -9*z look_at 0}\n"
                      "light_source{<5,9,-9> rgb 1}\nplane{y,-3 pigment{rgb .5}}\nunion{"
                      "difference{sphere{0,2} sphere{0,1.6} pigment{rgbf <1,1,1,.95>} finish{diffuse 0}}"
                      "difference{sphere{0,1.3} plane{-y,0} pigment{rgbf <.9,.1,.2,.9>} finish{diffuse 0}"
                      "interior{fade_distance 2 fade_power 1001 fade_color <1,.4,.5>}}}\n",
                      32);
    ASSERT_TRUE(imported) << imported.error().message();
    ASSERT_EQ(imported->scene.filters.size(), 2u);
    const SceneFilter &glass = imported->scene.filters[0], &wine = imported->scene.filters[1];
    const std::array absorption{0.0f, 0.3f, 0.25f}, pigment{0.81f, 0.09f, 0.18f};
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(glass.colour[c], 0.95, 0.001);
        EXPECT_NEAR(glass.absorption[c], 0, 0.01);
        EXPECT_NEAR(wine.colour[c], pigment[std::size_t(c)], 0.001);
        EXPECT_NEAR(wine.absorption[c], absorption[std::size_t(c)], 0.02);
    }
    const Result<SceneEntities> entities = original_entities(imported->scene);
    ASSERT_TRUE(entities) << entities.error().message();
    // From above: two walls of glass, the wine, and two walls. From the side at the top: glass alone.
    const Rgb through = entities->filters->transmitted({0.2f, 5, 0.3f}, {0.2f, -5, 0.3f}),
              above = entities->filters->transmitted({-5, 1, 0.1f}, {5, 1, 0.1f});
    const float way = std::sqrt(1.3f * 1.3f - 0.13f);
    for (int c = 0; c < 3; ++c) {
        const float clear = std::pow(0.95f, 4.0f), red = wine.colour[c] * wine.colour[c];
        EXPECT_NEAR(above[c], clear, 0.01);
        EXPECT_NEAR(through[c], clear * red * std::exp(-absorption[std::size_t(c)] * way), 0.02);
    }
}

TEST(PovrayImport, FiltersOfPatternsAreVertexColours) {
    const auto imported = imported_text(
        "povray_stained",
        "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location -9*z look_at 0}\n"
        "light_source{<5,9,-9> rgb 1}\nplane{y,-3 pigment{rgb .5}}\n"
        "box{-1,1 pigment{gradient y color_map{[0 rgbf <1,.4,.4,1>][1 rgbf <.4,.4,1,1>]} scale 2 "
        "translate -y} finish{diffuse 0}}\n",
        32);
    ASSERT_TRUE(imported) << imported.error().message();
    ASSERT_EQ(imported->scene.filters.size(), 1u);
    EXPECT_TRUE(imported->scene.filters[0].vertex_colours);
    const Result<SceneEntities> entities = original_entities(imported->scene);
    ASSERT_TRUE(entities) << entities.error().message();
    for (const float y : {-0.8f, -0.3f, 0.4f, 0.9f}) {
        const Rgb passed = entities->filters->transmitted({-5, y, 0.1f}, {5, y, 0.1f});
        const float red = 0.7f - 0.3f * y, blue = 0.7f + 0.3f * y;
        EXPECT_NEAR(passed.x, red * red, 0.03) << y;
        EXPECT_NEAR(passed.y, 0.16, 0.005) << y;
        EXPECT_NEAR(passed.z, blue * blue, 0.03) << y;
    }
}

TEST(PovrayImport, ReflectionsStayReflections) {
    const auto imported = imported_text(
        "povray_mirror",
        "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location -9*z look_at 0}\n"
        "light_source{<5,9,-9> rgb 1}\nsphere{0,1 pigment{rgb .5} finish{reflection .25 diffuse .5}}\n"
        "torus{2,.3 pigment{rgb 1} finish{diffuse .5}}\n",
        24);
    ASSERT_TRUE(imported) << imported.error().message();
    const Reflection& mirror = imported->scene.materials.at("sphere").reflection;
    EXPECT_NEAR(mirror.at_normal.x, 0.25, 0.01);
    EXPECT_EQ(mirror.at_normal, mirror.at_grazing);
    EXPECT_FALSE(imported->scene.materials.at("torus").reflection.is_there());
}

TEST(PovrayImport, TheSkyIlluminatesAFileWhoseLightsAreBlack) {
    const std::filesystem::path file = written_scene(
        "povray_black_light",
        "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location -4*z look_at 0}\n"
        "light_source{<5,8,-6> rgb 0}\nbackground{rgb <.2,.3,.5>}\nsphere{0,1 pigment{rgb 1}}\n");
    PovrayImport options;
    options.detail = 16;
    const auto imported = imported_povray_scene(file, file.parent_path() / "out", "scene", options);
    ASSERT_TRUE(imported) << imported.error().message();
    EXPECT_TRUE(imported->scene.lamps.empty());
    // Without any light, the scene's file could not be read.
    EXPECT_TRUE(imported->scene.environment.lights);
}

TEST(PovrayImport, ImportsADeclaredObjectOfAnInclude) {
    const std::filesystem::path file = written_scene(
        "povray_object",
        "#declare R=2;\n#declare Cup=difference{cylinder{0,y*R,1} cylinder{.1*y,3*y,.9} pigment{rgb x}}\n");
    PovrayImport options;
    options.detail = 24;
    options.queries.wrap.object = "Cup";
    const auto imported = imported_povray_scene(file, file.parent_path() / "out", "Cup", options);
    ASSERT_TRUE(imported) << imported.error().message();
    ASSERT_EQ(imported->scene.entities.size(), 1u);
    EXPECT_EQ(imported->scene.entities[0].name, "Cup");
    EXPECT_TRUE(imported->scene.finds_camera);
    options.queries.wrap.object = "Missing";
    EXPECT_FALSE(imported_povray_scene(file, file.parent_path() / "out", "Missing", options));
}

TEST(LightProbe, HasSkyObjectsAndTheIrradianceOfLights) {
    const std::filesystem::path file = written_scene(
        "povray_probe",
        "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location -9*z look_at 0}\n"
        "background{rgb <.1,.2,.4>}\n#declare Ball=sphere{<5,0,0>,1 pigment{rgb <0,.5,0>} finish{emission 1 "
        "ambient 0 "
        "diffuse 0}}\nobject{Ball}\nbox{-.1,.1 pigment{rgb 1}}\nlight_source{<60,50,80> rgb 2}\n");
    LightProbe probe;
    probe.width = 256;
    probe.without = {"box"};
    const Result<ProbedLight> probed = probed_light(file, probe);
    ASSERT_TRUE(probed) << probed.error().message();
    EXPECT_EQ(probed->lights, 1u);
    const Image& light = probed->light;
    ASSERT_EQ(light.width, 256);
    ASSERT_EQ(light.height, 128);
    const auto pixel_at = [&](double x, double y, double z) {
        for (int row = 0; row < light.height; ++row)
            for (int column = 0; column < light.width; ++column) {
                const Vec3d d = lat_long_direction((column + 0.5) / light.width, (row + 0.5) / light.height);
                if (d.dot(Vec3d(x, y, z)) > 0.9997)
                    return light.pixels[std::size_t(row * light.width + column)];
            }
        return Rgb(-1.0f);
    };
    EXPECT_NEAR(pixel_at(1, 0, 0).y, 0.5, 1e-3);
    EXPECT_NEAR(pixel_at(-1, 0, 0).y, 0.2, 1e-3);
    EXPECT_NEAR(pixel_at(0, 0, 1).z, 0.4, 1e-3);
    double irradiance = 0;
    for (int row = 0; row < light.height; ++row)
        for (int column = 0; column < light.width; ++column) {
            const float red = light.pixels[std::size_t(row * light.width + column)].x;
            if (red > 1)
                irradiance += double(red) * lat_long_pixel_solid_angle(row, light.width, light.height);
        }
    EXPECT_NEAR(irradiance, 2 * pi, 0.1 * 2 * pi);  // A disc of few pixels.
    probe.without = {"Missing"};
    EXPECT_FALSE(probed_light(file, probe));
}

TEST(ObjectSurfaces, SlowObjectsAreLeftOutAndOthersKept) {
    const std::filesystem::path file = written_scene(
        "povray_slow",
        "#version 3.7;\nsphere{0,1}\nisosurface{function{x*x+y*y+z*z-1+0.0001*f_noise3d(x*50,y*50,z*50)}"
        " contained_by{box{-2,2}} accuracy 1e-9 max_gradient 50000}\nbox{3,4}\n");
    const std::filesystem::path text = file;
    ASSERT_TRUE(write_file(text,
                           "#version 3.7;\n#include \"functions.inc\"\nsphere{0,1}\nisosurface{function{"
                           "x*x+y*y+z*z-1+0.0001*f_noise3d(x*50,y*50,z*50)} contained_by{box{-2,2}} "
                           "accuracy 1e-9 max_gradient 500000}\nbox{3,4}\n"));
    const Result<SceneQueries> queries = SceneQueries::create(file, {});
    ASSERT_TRUE(queries) << queries.error().message();
    std::vector<GridRequest> requests{{0, Vec3d(0), Vec3d(2), 16, false},
                                      {1, Vec3d(0), Vec3d(4), 64, false},
                                      {2, Vec3d(3.5), Vec3d(1), 16, false}};
    const Result<ObjectSurfaces> surfaces = object_surfaces(*queries, requests, 1.5);
    ASSERT_TRUE(surfaces) << surfaces.error().message();
    EXPECT_EQ(surfaces->slow, std::vector<std::size_t>{1});
    ASSERT_EQ(surfaces->surfaces.size(), 2u);
    EXPECT_EQ(surfaces->surfaces[1].object, 2u);
}

}  // namespace
}  // namespace haarfield
