#include "fields/preparation/cut_outs.h"

#include <gtest/gtest.h>

#include "tests/fixtures/example_scene.h"
#include "tests/fixtures/example_textures.h"
#include "tests/fixtures/mesh_measures.h"

namespace haarfield {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// Returns noise with grains of a few texels.
Texture clouds(int width, int height, unsigned seed) {
    std::mt19937 random(seed);
    Texture coarse = random_texture(std::max(1, width / 3), std::max(1, height / 3), true);
    for (auto& texel : coarse.texels) texel[3] = static_cast<std::uint8_t>(random());
    Texture texture = random_texture(width, height, true);
    for (int i = 0; i < width * height; ++i)
        texture.texels[std::size_t(i)][3] = static_cast<std::uint8_t>(
            255 * bilinear_channel(coarse, (i % width + 0.5) / width, 1 - (i / width + 0.5) / height, 3));
    return texture;
}

/// Returns count x count squares of `texels` x `texels`, the first one opaque.
Texture chequers(int count, int texels) {
    Texture texture = random_texture(count * texels, count * texels, true);
    for (int i = 0; i < texture.width * texture.height; ++i)
        texture.texels[std::size_t(i)][3] =
            (i % texture.width / texels + i / texture.width / texels) % 2 == 0 ? 255 : 0;
    return texture;
}

/// Returns a disc of radius 0.3 with a soft edge of two texels.
OpacityMap disc(int size) {
    OpacityMap map{size, size, {}};
    for (int i = 0; i < size * size; ++i) {
        const double from = std::hypot(i % size + 0.5 - size / 2.0, i / size + 0.5 - size / 2.0);
        map.opacity.push_back(
            static_cast<std::uint8_t>(std::clamp(127.5 + 127.5 * (0.3 * size - from), 0.0, 255.0)));
    }
    return map;
}

/// Tests whether a point of the plane z = 0 is in a triangle of a mesh in this plane.
bool covers(const Mesh& mesh, const Vec3d& point) {
    return std::ranges::any_of(mesh.triangles, [&](const Triangle& t) {
        int sides = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d a(mesh.positions[t[k]]), b(mesh.positions[t[(k + 1) % 3]]);
            sides += (b - a).cross(point - a).z > 0 ? 1 : -1;
        }
        return std::abs(sides) == 3;
    });
}

/// Returns a square of side 2, centred at the origin, covered once by the image.
Mesh card(int cells = 1) {
    Mesh mesh = upright_square_mesh(1, cells);
    for (const Vec3f& p : mesh.positions) mesh.uvs.emplace_back((p.x + 1) / 2, (p.y + 1) / 2);
    return mesh;
}

TEST(CutOuts, KeepAreasThatAreAtLeastHalfOpaque) {
    std::mt19937 random(3);
    std::size_t inside = 0, asked = 0;
    for (unsigned seed = 0; seed < 12; ++seed) {
        const Texture texture = clouds(5 + int(seed) * 4, 37 - int(seed) * 2, seed);
        const std::vector<OpacityMap> maps{opacity_map(texture)};
        // A triangle with an arbitrary, mirrored and repeated mapping of the image.
        Mesh mesh;
        mesh.positions = {{-1, -0.8f, 0}, {1.1f, -0.9f, 0}, {0.2f, 1, 0}};
        mesh.normals.assign(3, Vec3f(0, 0, 1));
        mesh.vertex_materials.assign(3, 0);
        mesh.material_names = {""};
        mesh.triangles = {{0, 1, 2}};
        for (int k = 0; k < 3; ++k)
            mesh.uvs.emplace_back(uniform(random, -1.5f, 1.5f), uniform(random, -1.5f, 1.5f));
        const Mesh cut = without_cut_outs(mesh, maps, 100000);
        ASSERT_FALSE(cut.triangles.empty());
        for (const Triangle& t : cut.triangles) EXPECT_GT(area_vector(cut, t).z, 0) << "reversed";
        for (int i = 0; i < 400; ++i) {
            double y = uniform(random, 0.0, 1.0), z = uniform(random, 0.0, 1.0);
            if (y + z > 1) y = 1 - y, z = 1 - z;
            const Vec3d p[] = {Vec3d(mesh.positions[0]), Vec3d(mesh.positions[1]), Vec3d(mesh.positions[2])};
            const Imath::V2d t[] = {Imath::V2d(mesh.uvs[0]), Imath::V2d(mesh.uvs[1]),
                                    Imath::V2d(mesh.uvs[2])};
            const Imath::V2d at = t[0] * (1 - y - z) + t[1] * y + t[2] * z;
            const auto is_opaque = [&](double right, double up) {
                return bilinear_channel(texture, at.x + right / texture.width, at.y + up / texture.height,
                                        3) >= 0.5;
            };
            const bool wanted = is_opaque(0, 0);
            bool is_near_outline = false;
            for (const double far : {0.2, 0.4})
                for (int k = 0; k < 12; ++k)
                    is_near_outline |=
                        is_opaque(far * std::cos(k * pi / 6), far * std::sin(k * pi / 6)) != wanted;
            if (is_near_outline) continue;
            ++asked;
            inside += wanted;
            ASSERT_EQ(covers(cut, p[0] * (1 - y - z) + p[1] * y + p[2] * z), wanted)
                << "image " << seed << " at " << at.x << ", " << at.y;
        }
    }
    EXPECT_GT(asked, 2000u);
    EXPECT_GT(inside, 500u);
    EXPECT_LT(inside, asked - 500);
}

TEST(CutOuts, AreConnectedAcrossOpaqueSaddles) {
    for (const bool is_joined : {false, true}) {
        OpacityMap map{6, 6, std::vector<std::uint8_t>(36, is_joined ? 40 : 0)};
        map.opacity[2 * 6 + 2] = map.opacity[3 * 6 + 3] = is_joined ? 255 : 215;
        const Mesh cut = without_cut_outs(card(), std::vector{map}, 1000);
        EXPECT_EQ(covers(cut, {0.01, 0.003, 0}), is_joined);
        EXPECT_TRUE(covers(cut, {1 / 6.0, -1 / 6.0, 0}));
        EXPECT_FALSE(covers(cut, {1 / 6.0, 1 / 6.0, 0}));
    }
}

TEST(CutOuts, HaveTheAreaOfTheOpaqueTexels) {
    const Texture texture = chequers(6, 5);
    for (const int cells : {1, 3, 40}) {
        const Mesh cut = without_cut_outs(card(cells), std::vector{opacity_map(texture)}, 100000);
        // Up to a quarter of a texel may be missing at each of five corners.
        EXPECT_NEAR(surface_area(cut), 2, 0.05) << cells << " cells";
    }
    for (const int size : {20, 128, 500}) {
        const Mesh cut = without_cut_outs(card(3), std::vector{disc(size)}, 100000);
        EXPECT_NEAR(surface_area(cut) / (4 * pi * 0.09), 1, 2.0 / size) << size;
        EXPECT_LT(cut.triangles.size(), 400u);
    }
    // More texels than are used.
    EXPECT_NEAR(surface_area(without_cut_outs(card(), std::vector{disc(1500)}, 100000)) / (4 * pi * 0.09), 1,
                0.002);
}

TEST(CutOuts, AreCoarserWithFewerTriangles) {
    std::size_t last = SIZE_MAX;
    for (const std::size_t most : {1000u, 100u, 60u}) {
        const Mesh cut = without_cut_outs(card(), std::vector{disc(400)}, most);
        EXPECT_LE(cut.triangles.size(), most);
        EXPECT_LE(cut.triangles.size(), last);
        EXPECT_NEAR(surface_area(cut) / (4 * pi * 0.09), 1, 0.1);
        last = cut.triangles.size();
    }
    EXPECT_LE(without_cut_outs(card(), std::vector{disc(400)}, 1).triangles.size(), 32u) << "16 for each";
}

TEST(CutOuts, OfAFineGridFollowItsMeanOpacity) {
    for (const bool is_dense : {false, true}) {
        OpacityMap grid{16, 16, std::vector<std::uint8_t>(256, is_dense ? 255 : 0)};
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 8; ++x) grid.opacity[std::size_t(16 * (y + 4) + x + 4)] ^= 255;
        Mesh mesh = card();
        for (Vec2f& uv : mesh.uvs) uv *= 1e5f;
        EXPECT_EQ(surface_area(without_cut_outs(mesh, std::vector{grid}, 1000)), is_dense ? 4 : 0);
    }
}

TEST(CutOuts, LeaveOpaqueTrianglesUnchanged) {
    Mesh mesh = joined_meshes(card(10), box_mesh({2, 0, 0}, {3, 1, 1}));
    mesh.uvs.resize(mesh.positions.size());
    mesh.material_names = {"card", "box"};
    for (std::size_t v = 121; v < mesh.positions.size(); ++v) mesh.vertex_materials[v] = 1;
    const Mesh cut = without_cut_outs(mesh, std::vector{disc(64), OpacityMap()}, 100000);
    const std::size_t boxed = 12;
    ASSERT_GT(cut.triangles.size(), boxed);
    const std::vector<std::uint8_t> is_cut_out = cut_out_triangles(mesh, std::vector{disc(64), OpacityMap()});
    std::vector<Triangle> whole;
    for (std::size_t t = 0; t < is_cut_out.size(); ++t)
        if (!is_cut_out[t]) whole.push_back(mesh.triangles[t]);
    EXPECT_GT(whole.size(), boxed) << "including the disc's centre";
    EXPECT_TRUE(std::ranges::equal(whole, std::span(cut.triangles).first(whole.size())));
    EXPECT_EQ(mesh_bounds(cut).lower, mesh_bounds(mesh).lower) << "all positions are kept";
    EXPECT_EQ(cut_out_triangles(mesh, {}), std::vector<std::uint8_t>(mesh.triangles.size(), 0));
}

TEST(CutOuts, DegenerateMappingsKeepOrRemoveATriangle) {
    Mesh mesh = card();
    for (Vec2f& uv : mesh.uvs) uv = {0.5f, 0.5f};
    EXPECT_EQ(surface_area(without_cut_outs(mesh, std::vector{disc(64)}, 1000)), 4);
    for (Vec2f& uv : mesh.uvs) uv = {0.05f, 0.5f};
    EXPECT_EQ(surface_area(without_cut_outs(mesh, std::vector{disc(64)}, 1000)), 0);
}

TEST(CutOuts, AreDeterministic) {
    const OpacityMap map = opacity_map(clouds(60, 50, 4));
    const Mesh once = without_cut_outs(card(), std::vector{map}, 2000);
    std::vector<std::vector<double>> elsewhere;  // changes the addresses of later allocations
    for (std::size_t i = 0; i < 40; ++i) elsewhere.emplace_back(i * 37 % 23);
    elsewhere.erase(elsewhere.begin(), elsewhere.begin() + 20);
    const Mesh again = without_cut_outs(card(), std::vector{map}, 2000);
    EXPECT_EQ(once.positions, again.positions);
    EXPECT_EQ(once.triangles, again.triangles);
}

PreparedMesh prepared(const Mesh& mesh, const MeshPreparation& wanted) {
    Result<PreparedMesh> made = prepare_mesh({mesh, {}}, wanted);
    EXPECT_TRUE(made);
    return std::move(*made);
}

TEST(CutOuts, ApplyToOccludersAndNotToTheFineMesh) {
    Mesh mesh = joined_meshes(card(2), sphere_mesh({0, -3, 0}, 1, 40));
    mesh.uvs.resize(mesh.positions.size());
    mesh.material_names = {"card", "ball"};
    for (std::size_t v = 9; v < mesh.positions.size(); ++v) mesh.vertex_materials[v] = 1;
    const PreparedMesh plain = prepared(mesh, {500, 400});
    const PreparedMesh cut = prepared(mesh, {500, 400, {disc(256), {}}});
    EXPECT_FALSE(plain.opaque);
    ASSERT_TRUE(cut.opaque);
    EXPECT_EQ(plain.original.triangles, cut.original.triangles);
    EXPECT_EQ(plain.fine.positions, cut.fine.positions);
    EXPECT_NEAR(surface_area(cut.original) - surface_area(*cut.opaque), 4 - 4 * pi * 0.09, 0.01);
    EXPECT_LE(cut.coarse.triangles.size(), 400u);
    EXPECT_GT(cut.coarse.triangles.size(), 200u);
    EXPECT_NEAR(surface_area(cut.coarse), surface_area(*cut.opaque), 0.03 * surface_area(*cut.opaque));
    EXPECT_NE(field_keys(plain, {}).surroundings, field_keys(cut, {}).surroundings);
    EXPECT_NE(field_keys(cut, {}), field_keys(prepared(mesh, {500, 400, {disc(255), {}}}), {}));

    PreparedMesh finer = cut;
    finer.opaque->positions[0].x += 0.1f;
    EXPECT_NE(field_keys(cut, {}), field_keys(finer, {})) << "although the coarse meshes are equal";

    const PreparedMesh as_it_is = prepared(mesh, {500, 0, {disc(256), {}}});
    EXPECT_EQ(as_it_is.coarse.triangles, as_it_is.opaque->triangles);
    const EntityOcclusion occlusion(as_it_is);
    EXPECT_EQ(occlusion.samples().buried, std::vector<std::uint8_t>(as_it_is.fine.positions.size(), 0));
}

/// Returns a sheet of 2 x 2 m, 1 m above a floor, in uniform light and light from one direction.
ExampleScene over_floor(const PreparedMesh& sheet) {
    ExampleScene example;
    example.add_entity(square_mesh(4, 0, 12), matte(0.7f));
    example.add_entity(sheet, matte(0.5f), 600, 900);
    example.scene.instances = {{0, {}}, {1, {{0, 1, 0}, 1}}};
    example.scene.environment = environment([](const Vec3d& d) {
        return 0.3 + 4000 * std::pow(std::max(0.0, d.dot(Vec3d(0.3, 0.85, 0.2).normalized())), 4000);
    });
    example.scene.eye = {0, 3, 5};
    return example;
}

/// Returns 4 x 4 squares; the image or the mesh itself keeps eight of them.
Mesh sheet_of_squares(bool whole) {
    Mesh mesh;
    mesh.material_names = {""};
    for (int i = 0; i < 16; ++i) {
        const int x = i % 4, z = i / 4;
        if (!whole && (x + z) % 2 != 0) continue;
        Mesh square = square_mesh(0.5f, 0, 4);
        for (const Vec3f& p : square.positions)
            square.uvs.emplace_back((p.x + 0.25f + float(x) / 2) / 2, 1 - (p.z + 0.25f + float(z) / 2) / 2);
        for (Vec3f& p : square.positions) p += Vec3f(float(x) / 2 - 0.75f, 0, float(z) / 2 - 0.75f);
        append_mesh(mesh, square);
    }
    return mesh;
}

TEST(CutOuts, CastTheShadowsOfTheRemainingArea) {
    const Texture texture = chequers(4, 16);
    const ExampleScene cut = over_floor(prepared(sheet_of_squares(true), {0, 0, {opacity_map(texture)}})),
                       modelled = over_floor(prepared(sheet_of_squares(false), {})),
                       whole = over_floor(prepared(sheet_of_squares(true), {}));
    const std::vector<Rgb> right = modelled.dense()[0], dense = cut.dense()[0], baked = cut.radiance()[0],
                           baked_right = modelled.radiance()[0], without_holes = whole.dense()[0];
    double brightest = 0;
    for (const Rgb& value : right) brightest = std::max(brightest, double(luminance(value)));
    const auto error = [&](const std::vector<Rgb>& of, const std::vector<Rgb>& from) {
        double sum = 0;
        for (std::size_t v = 0; v < of.size(); ++v)
            sum += std::pow(double(luminance(of[v]) - luminance(from[v])) / brightest, 2);
        return std::sqrt(sum / double(of.size()));
    };
    EXPECT_LT(error(dense, right), 0.01);
    EXPECT_LT(error(baked, baked_right), 0.01);
    EXPECT_LT(error(baked, dense), 0.02);
    EXPECT_GT(error(without_holes, right), 0.1) << "the holes affect the light";

    // Removed areas are lit as if they existed: on the sunny side, nothing of the object itself occludes
    // them.
    const std::vector<Rgb> sheet = cut.radiance()[1], whole_sheet = whole.radiance()[1];
    const Mesh& fine = cut.mesh(1).fine;
    ASSERT_EQ(sheet.size(), whole_sheet.size());
    std::size_t above = 0;
    for (std::size_t v = 0; v < sheet.size(); ++v) {
        if (fine.normals[v].y < 0.5f) continue;
        ++above;
        EXPECT_NEAR(luminance(sheet[v]) / luminance(whole_sheet[v]), 1, 0.02);
    }
    EXPECT_GT(above, 100u);
}

TEST(CutOuts, WithoutRemainingAreaAreLitAndBlockNoLight) {
    Texture clear = chequers(4, 4);
    for (auto& texel : clear.texels) texel[3] = 0;
    const PreparedMesh sheet = prepared(sheet_of_squares(true), {0, 0, {opacity_map(clear)}});
    ASSERT_TRUE(sheet.opaque);
    EXPECT_TRUE(sheet.opaque->triangles.empty());
    const ExampleScene scene = over_floor(sheet);
    ExampleScene floor = over_floor(sheet);
    floor.scene.instances.pop_back();
    const SceneColours radiance = scene.radiance();
    EXPECT_EQ(radiance[0], floor.radiance()[0]);
    for (const Rgb& value : radiance[1]) EXPECT_TRUE(is_finite(value));
}

}  // namespace
}  // namespace haarfield
