#include <gtest/gtest.h>

#include <fmt/format.h>
#include <array>
#include <cmath>

#include "tests/fixtures/baked_mesh.h"
#include "tests/fixtures/test_folder.h"
#include "tests/fuzz/odd_mesh.h"

namespace haarfield {
namespace {

/// A mesh as text with exact coordinates.
struct ObjText {
    std::string text;
    int vertices = 0;

    int vertex(double x, double y, double z) {
        text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", x, y, z);
        return ++vertices;
    }
    void face(int a, int b, int c) { text += fmt::format("f {} {} {}\n", a, b, c); }
    void triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
        const int i = vertex(a.x, a.y, a.z), j = vertex(b.x, b.y, b.z), k = vertex(c.x, c.y, c.z);
        face(i, j, k);
    }
    void box(const Vec3d& lower, const Vec3d& upper) {
        const int first = vertices + 1;
        for (int i = 0; i < 8; ++i)
            vertex(i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z);
        constexpr std::array<std::array<int, 4>, 6> sides{
            {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
        for (const auto& side : sides)
            text += fmt::format("f {} {} {} {}\n", first + side[0], first + side[1], first + side[2],
                                first + side[3]);
    }
};

BakedMesh baked(const std::string& obj) {
    const TestFolder folder;
    write_text(folder / "mesh.obj", obj);
    return baked_mesh(folder / "mesh.obj", folder / "fields");
}

void expect_baked_or_refused(const std::string& name, const ObjText& mesh) {
    SCOPED_TRACE(name);
    const BakedMesh result = baked(mesh.text);
    EXPECT_EQ(result.defect, "");
    EXPECT_EQ(result.not_finite, 0u) << "of " << result.vertices;
    if (result.refused.empty())
        EXPECT_GT(result.vertices, 0u);
    else
        EXPECT_NE(result.refused.find("mesh.obj"), std::string::npos) << result.refused;
}

TEST(ExtremeMeshes, TrianglesOfAnyExtentAreBakedOrRefusedWithAReason) {
    for (const double extent : {1e-45, 1e-39, 1e-30, 1e-20, 1e-12, 1e-6, 1.0, 1e3, 1e6}) {
        ObjText thin, tiny, needle, box, line;
        thin.triangle({0, 0, extent}, {1, 0, 0}, {0, 1, 0});
        tiny.triangle({0, 0, 0}, {extent, 0, 0}, {0, extent, 0});
        needle.triangle({0, 0, 0}, {extent, 0, 0}, {0, 1, 0.3});
        box.box({0, 0, 0}, {extent, 1, 1});
        line.triangle({0, 0, 0}, {extent, extent, extent}, {0.5 * extent, 0.5 * extent, 0.5 * extent});
        const std::string of = fmt::format(" of {}", extent);
        expect_baked_or_refused("thin" + of, thin);
        expect_baked_or_refused("tiny" + of, tiny);
        expect_baked_or_refused("needle" + of, needle);
        expect_baked_or_refused("box" + of, box);
        expect_baked_or_refused("line" + of, line);
    }
}

TEST(ExtremeMeshes, ExtentsThatAreFarApartAreBakedInOneMesh) {
    ObjText mesh;
    for (const double extent : {1e-38, 1e-30, 1e-9, 1.0, 1e6}) mesh.box({0, 0, 0}, Vec3d(extent));
    expect_baked_or_refused("nested boxes", mesh);
    ObjText far;
    far.box({999999, 999999, 999999}, {1e6, 1e6, 1e6});
    far.box({-1e6, -1e6, -1e6}, {-999999, -999999, -999999});
    expect_baked_or_refused("opposite corners", far);
    EXPECT_EQ(baked(far.text).refused, "");
    ObjText beyond;
    beyond.triangle({0, 0, 0}, {1e30, 0, 0}, {0, 1e-30, 0});
    EXPECT_NE(baked(beyond.text).refused.find("expected coordinates within 1e6 m"), std::string::npos);
}

TEST(ExtremeMeshes, DegenerateTrianglesAreIgnoredAndRefusedIfThereAreNoOthers) {
    ObjText mesh;
    mesh.vertex(1, 2, 3);
    for (int i = 0; i < 1000000; ++i) mesh.text += "f 1 1 1\n";
    EXPECT_NE(baked(mesh.text).refused.find("has no triangle with an area"), std::string::npos);
    mesh.triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    EXPECT_EQ(baked(mesh.text).refused, "");
}

TEST(ExtremeMeshes, SliversAndFansOfThemAreBaked) {
    ObjText fan;
    const int middle = fan.vertex(0, 1, 0);
    for (int i = 0; i < 2000; ++i) fan.vertex(std::cos(i * 1e-3), 1e-4 * (i % 2), std::sin(i * 1e-3));
    for (int i = 0; i < 1999; ++i) fan.face(middle, i + 2, i + 3);
    expect_baked_or_refused("fan", fan);
    ObjText slivers;
    for (int i = 0; i < 200; ++i)
        slivers.triangle({0, 0, i * 1e-3}, {1, 1e-7 * i, i * 1e-3}, {0.5, 1e-7, i * 1e-3});
    expect_baked_or_refused("slivers", slivers);
}

TEST(ExtremeMeshes, RandomBitsAsCoordinatesAreBakedOrRefused) {
    FuzzRandom random(18);
    for (int round = 0; round < 60; ++round)
        expect_baked_or_refused(fmt::format("round {}", round), {odd_mesh(random)});
}

}  // namespace
}  // namespace haarfield
