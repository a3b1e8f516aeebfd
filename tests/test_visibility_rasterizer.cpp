#include "fields/rasterizer/visibility_rasterizer.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <random>

#include "fields/field/samplers.h"
#include "fields/rasterizer/contour_rasterizer.h"
#include "fields/rasterizer/span_rasterizer.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/oracles/embree_oracle.h"
#include "tests/oracles/plain_rasterizer.h"

namespace haarfield {
namespace {

/// Returns a torus: u rotates about the axis y, v around the tube.
Mesh torus_mesh(float major, float minor, int segments) {
    Mesh mesh;
    const auto vertex = [&](int i, int j) {
        return static_cast<std::uint32_t>(i % segments * segments + j % segments);
    };
    for (int i = 0; i < segments; ++i)
        for (int j = 0; j < segments; ++j) {
            const double u = 2 * pi * i / segments, v = 2 * pi * j / segments;
            const double across = major + minor * std::cos(v);
            mesh.positions.emplace_back(float(across * std::cos(u)), float(minor * std::sin(v)),
                                        float(across * std::sin(u)));
            mesh.triangles.push_back({vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1)});
            mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i + 1, j)});
        }
    return mesh;
}

/// Returns a sphere without the triangles that extend below its centre.
Mesh hemisphere_mesh(float radius, int segments) {
    Mesh mesh = sphere_mesh({0, 0, 0}, radius, segments);
    std::erase_if(mesh.triangles, [&](const auto& t) {
        return std::any_of(t.begin(), t.end(), [&](auto v) { return mesh.positions[v].y < -1e-6f; });
    });
    return mesh;
}

Mesh triangle_soup(int count, std::uint32_t seed) {
    Mesh mesh;
    std::mt19937 random(seed);
    const auto number = [&] { return static_cast<float>(random() % 200001) / 100000 - 1; };
    for (int i = 0; i < count; ++i) {
        const Vec3f centre(number(), number(), number());
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (int k = 0; k < 3; ++k)
            mesh.positions.push_back(centre + Vec3f(number(), number(), number()) * 0.3f);
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

Mesh turned_round(Mesh mesh) {
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    return mesh;
}

/// Returns the same triangles, all of them two-sided.
Occluder two_sided_of(const Occluder& occluder) {
    OccluderTriangles triangles = occluder.source();
    triangles.one_sided = 0;
    return Occluder(std::move(triangles));
}

/// Returns a rotated mesh, whose edges do not coincide with those of the cubemap.
Mesh turned(Mesh mesh) {
    const Vec3d axis = Vec3d(0.31, 0.87, -0.44).normalized();
    for (Vec3f& position : mesh.positions) {
        const Vec3d p(position);
        position = Vec3f(p * std::cos(0.7) + axis.cross(p) * std::sin(0.7) +
                         axis * axis.dot(p) * (1 - std::cos(0.7)));
    }
    return mesh;
}

struct Example {
    const char* name;
    Mesh mesh;
    bool closed;  ///< Blocks with front faces only.
};

std::vector<Example> examples() {
    std::vector<Example> all;
    all.push_back({"sphere", sphere_mesh({0.1f, -0.2f, 0.05f}, 1, 16), true});
    all.push_back({"torus", turned(torus_mesh(0.8f, 0.3f, 24)), true});
    all.push_back({"box", turned(box_mesh({-0.5f, -0.8f, -0.6f}, {0.5f, 0.4f, 0.7f}, 2)), true});
    all.push_back({"two boxes that penetrate each other",
                   turned(joined_meshes(box_mesh({-0.9f, -0.1f, -0.2f}, {0.8f, 0.2f, 0.3f}, 2),
                                        box_mesh({-0.2f, -0.7f, -0.1f}, {0.1f, 0.9f, 0.2f}, 3))),
                   true});
    all.push_back({"two spheres apart",
                   joined_meshes(sphere_mesh({-0.6f, 0, 0}, 0.4f, 12), sphere_mesh({0.7f, 0.1f, 0}, 0.3f, 9)),
                   true});
    all.push_back({"hemisphere", turned(hemisphere_mesh(1, 14)), false});
    all.push_back({"square", turned(square_mesh(1.5f, 0.2f)), false});
    all.push_back({"triangle soup", triangle_soup(150, 2006), false});
    all.push_back({"fine hemisphere", turned(hemisphere_mesh(1, 30)), false});
    all.push_back({"sphere turned inside out", turned_round(sphere_mesh({0, 0, 0}, 1, 12)), false});
    return all;
}

/// Returns points around the object, near it, just above its triangles, and between its parts.
std::vector<Vec3f> view_points(const Occluder& occluder) {
    const Vec3f centre = occluder.bounds().centre();
    const float radius = occluder.bounds().radius();
    std::vector<Vec3f> points;
    for (const Vec3f& direction : {Vec3f(0.213f, 0.877f, 0.431f), Vec3f(-0.931f, 0.113f, -0.347f),
                                   Vec3f(0.377f, -0.815f, -0.441f), Vec3f(-0.137f, 0.059f, 0.989f)})
        for (const float distance : {1.1f, 2.3f, 5.7f})
            points.push_back(centre + direction.normalized() * radius * distance);
    const std::size_t step = std::max<std::size_t>(1, occluder.triangles().size() / 8);
    for (std::size_t t = 0; t < occluder.triangles().size(); t += step) {
        const auto& [i, j, k] = occluder.triangles()[t];
        const Vec3f &a = occluder.positions()[i], &b = occluder.positions()[j], &c = occluder.positions()[k];
        points.push_back(a * 0.41f + b * 0.36f + c * 0.23f +
                         (b - a).cross(c - a).normalized() * (1e-4f * radius));
    }
    points.push_back(Vec3f(0.0213f, 0.0131f, -0.0517f));
    return points;
}

TEST(VisibilityRasterizer, AgreesWithEmbree) {
    constexpr int size = 16;
    VisibilityRasterizer rasterizer(size);
    int all_points = 0, all_differing = 0;
    for (const Example& example : examples()) {
        const Occluder occluder = make_occluder(example.mesh);
        ASSERT_EQ(occluder.one_sided(), example.closed ? occluder.triangles().size() : 0u) << example.name;
        const EmbreeOracle oracle(occluder);
        const InsideTest is_inside(occluder);
        int blocked = 0, points = 0;
        for (const Vec3f& point : view_points(occluder)) {
            if (is_inside(point)) continue;
            const auto found = rasterizer.open_samples(occluder, point);
            const auto wanted = oracle.open_samples(point, size);
            ASSERT_EQ(found.size(), wanted.size());
            int differing = 0, largest = 0;
            for (std::size_t i = 0; i < wanted.size(); ++i) {
                const int difference = std::abs(int(found[i]) - int(wanted[i]));
                differing += difference;
                largest = std::max(largest, difference);
                blocked += samples_per_texel - wanted[i];
            }
            // Rays within Embree's rounding error of an edge may be classified either way.
            EXPECT_LE(largest, 1) << example.name << " from " << point;
            EXPECT_LE(differing, 2) << example.name << " from " << point;
            all_differing += differing;
            ++points;
        }
        EXPECT_GE(points, 12) << example.name;
        EXPECT_GT(blocked, 2000) << example.name;
        all_points += points;
    }
    EXPECT_LE(all_differing, all_points / 10);
}

/// Returns the number of sub-samples that differ.
int difference(std::span<const std::uint8_t> found, std::span<const std::uint8_t> wanted) {
    int sum = found.size() == wanted.size() ? 0 : 1 << 20;
    for (std::size_t i = 0; i < std::min(found.size(), wanted.size()); ++i)
        sum += std::abs(int(found[i]) - int(wanted[i]));
    return sum;
}

TEST(VisibilityRasterizer, AgreesWithThePlainLoop) {
    for (const int size : {1, 2, 4, 16, 64, 128, 256}) {
        VisibilityRasterizer rasterizer(size);
        PlainRasterizer plain(size);
        int differing = 0;
        double samples = 0;
        for (const Example& example : examples()) {
            const Occluder occluder = make_occluder(example.mesh);
            std::vector<Vec3f> points = view_points(occluder);
            if (size > 64) points.erase(points.begin() + 3, points.end() - 3);
            for (const Vec3f& point : points)
                for (const Vec3f& normal : {Vec3f(0.0f), Vec3f(0.36f, 0.48f, -0.8f)}) {
                    const Vec3f* horizon = normal == Vec3f(0.0f) ? nullptr : &normal;
                    const auto found = rasterizer.open_samples(occluder, point, horizon);
                    const int here = difference(found, plain.open_samples(occluder, point, horizon));
                    EXPECT_LE(here, 2) << example.name << " from " << point << ", size " << size;
                    differing += here;
                    samples += double(found.size()) * samples_per_texel;
                }
        }
        EXPECT_LE(differing, 2e-6 * samples) << "size " << size;
    }
}

// Near triangles block most samples of those behind them, which are not drawn.
TEST(VisibilityRasterizer, ManyLayersOfTrianglesAgreeWithThePlainLoop) {
    const Occluder occluder = make_occluder(triangle_soup(1500, 7));
    std::vector<Vec3f> points = view_points(occluder);
    for (int i = 0; i < 40; ++i) points.push_back(occluder.positions()[std::size_t(i) * 110] * 0.9f);
    for (const int size : {64, 128}) {
        VisibilityRasterizer rasterizer(size);
        PlainRasterizer plain(size);
        for (const Vec3f& point : points)
            for (const Vec3f& normal : {Vec3f(0.0f), Vec3f(0.36f, 0.48f, -0.8f)}) {
                const Vec3f* horizon = normal == Vec3f(0.0f) ? nullptr : &normal;
                EXPECT_LE(difference(rasterizer.open_samples(occluder, point, horizon),
                                     plain.open_samples(occluder, point, horizon)),
                          2)
                    << point << ", size " << size;
            }
    }
}

/// The span rasterizer on all triangles.
class SpansAlone {
public:
    explicit SpansAlone(int size) : blocked_(size), open_(std::size_t(6 * size * size) + 64), size_(size) {}

    std::span<const std::uint8_t> open_samples(const Occluder& occluder, const Vec3f& point,
                                               const Vec3f* horizon = nullptr,
                                               const Rotation* turn = nullptr) {
        const std::vector<std::uint64_t> all(occluder.triangles().size() / 64 + 1, ~std::uint64_t(0));
        block_spans(occluder, look_at(occluder, point, horizon, turn), all.data(), scratch_, blocked_);
        count_open_samples(blocked_, open_.data());
        return {open_.data(), std::size_t(6 * size_ * size_)};
    }

private:
    BlockedSamples blocked_;
    SpanScratch scratch_;
    std::vector<std::uint8_t> open_;
    int size_;
};

/// Returns thin axis-aligned bars that cross each other. Their edges are parallel to sub-columns, and the
/// axes through many view points intersect their edges.
Mesh thin_rods() {
    Mesh rods;
    for (int i = -3; i <= 3; ++i) {
        const float at = 0.25f * static_cast<float>(i);
        rods = joined_meshes(rods, box_mesh({at - 0.004f, -1, -0.004f}, {at + 0.004f, 1, 0.004f}, 2));
        rods = joined_meshes(rods, box_mesh({-1, at - 0.01f, 0}, {1, at + 0.01f, 0.02f}, 3));
    }
    return rods;
}

/// Returns a closed piece, an open one, and unconnected triangles.
Mesh mixed_mesh() {
    Mesh mesh = joined_meshes(turned(box_mesh({-0.5f, -0.8f, -0.6f}, {0.5f, 0.4f, 0.7f}, 4)),
                              turned(hemisphere_mesh(1.1f, 24)));
    mesh = joined_meshes(mesh, turned_round(torus_mesh(0.9f, 0.2f, 16)));
    return joined_meshes(mesh, triangle_soup(30, 11));
}

/// Sample positions of a field of the occluder: on the ground, around the occluder, and above its triangles
/// with horizons.
struct FieldPoint {
    Vec3f point;
    Vec3f normal;  ///< Normal of the horizon; zero: none.
};

std::vector<FieldPoint> field_points(const Occluder& occluder, std::uint32_t count) {
    const Bounds& bounds = occluder.bounds();
    const Vec3f centre = bounds.centre();
    const float radius = bounds.radius();
    std::vector<FieldPoint> points;
    const PlanarSampler planar = planar_sampler({centre.x, bounds.lower.y, centre.z}, radius, count);
    for (std::uint32_t i = 0; i < planar.sample_count(); ++i)
        points.push_back({planar.sample_position(i) + Vec3f(0, 1e-4f * radius, 0), Vec3f(0.0f)});
    const SphericalSampler spherical = spherical_sampler(centre, radius, count);
    for (std::uint32_t i = 0; i < spherical.sample_count(); ++i)
        points.push_back({spherical.sample_position(i), Vec3f(0.0f)});
    const std::size_t step = std::max<std::size_t>(1, occluder.triangles().size() / count);
    for (std::size_t t = 0; t < occluder.triangles().size(); t += step) {
        const auto& [i, j, k] = occluder.triangles()[t];
        const Vec3f &a = occluder.positions()[i], &b = occluder.positions()[j], &c = occluder.positions()[k];
        const Vec3f normal = (b - a).cross(c - a).normalized();
        points.push_back({a * 0.41f + b * 0.36f + c * 0.23f + normal * (1e-4f * radius), normal});
        points.push_back({a + normal * (1e-4f * radius), normal});
    }
    return points;
}

TEST(VisibilityRasterizer, BothPathsAreBitIdentical) {
    std::vector<Example> all = examples();
    all.push_back({"fine sphere", sphere_mesh({0.1f, -0.2f, 0.05f}, 1, 48), true});
    all.push_back({"torus along the axes", torus_mesh(0.8f, 0.3f, 32), true});
    all.push_back({"thin rods", thin_rods(), true});
    all.push_back({"square of many cells", square_mesh(1.5f, 0.25f, 12), false});
    all.push_back({"mixed", mixed_mesh(), false});
    VisibilityRasterizer rasterizer(64);
    SpansAlone spans(64);
    VisibleContour contour;
    ContourScratch scratch;
    std::size_t points = 0, drawn_edges = 0;
    for (const Example& example : all) {
        const Occluder occluder = make_occluder(example.mesh);
        for (const auto& [point, normal] : field_points(occluder, 120)) {
            const Vec3f* horizon = normal == Vec3f(0.0f) ? nullptr : &normal;
            ASSERT_EQ(difference(rasterizer.open_samples(occluder, point, horizon),
                                 spans.open_samples(occluder, point, horizon)),
                      0)
                << example.name << " from " << point;
            const ViewedOccluder viewed = look_at(occluder, point, horizon);
            find_contour(occluder, viewed, contour);
            BlockedSamples blocked(64);
            EXPECT_TRUE(block_contour(occluder, viewed, contour, scratch, blocked)) << example.name;
            drawn_edges += contour.count;
            ++points;
        }
    }
    EXPECT_GT(points, 5000u);
    EXPECT_GT(drawn_edges, 20 * points);
}

/// A quarter turn about y, without rounding errors, and a turn about no axis of the cubemap.
const std::array<Rotation, 2> turns{Rotation{{Vec3d(0, 0, 1), Vec3d(0, 1, 0), Vec3d(-1, 0, 0)}},
                                    rotation_about({0.7, -0.2, 0.5}, 2.3)};

TEST(VisibilityRasterizer, BothPathsAreBitIdenticalForTurnedOccluders) {
    std::vector<Example> all = examples();
    all.push_back({"fine sphere", sphere_mesh({0.1f, -0.2f, 0.05f}, 1, 48), true});
    all.push_back({"thin rods", thin_rods(), true});
    all.push_back({"mixed", mixed_mesh(), false});
    VisibilityRasterizer rasterizer(64);
    SpansAlone spans(64);
    for (const Example& example : all) {
        const Occluder occluder = make_occluder(example.mesh);
        for (const auto& [point, normal] : field_points(occluder, 40))
            for (const Rotation& turn : turns) {
                const Vec3f up = turn(normal), *horizon = normal == Vec3f(0.0f) ? nullptr : &up;
                ASSERT_EQ(difference(rasterizer.open_samples({&occluder, point, horizon, &turn}),
                                     spans.open_samples(occluder, point, horizon, &turn)),
                          0)
                    << example.name << " from " << point;
            }
    }
}

TEST(VisibilityRasterizer, TurnedViewsAreThoseOfTurnedOccluders) {
    VisibilityRasterizer rasterizer(64), other(64);
    for (const Example& example : examples()) {
        const Occluder occluder = make_occluder(example.mesh);
        for (const Rotation& turn : turns) {
            const bool is_exact = &turn == &turns[0];
            const Occluder turned = turned_occluder(occluder, turn);
            int differing = 0, points = 0;
            for (const auto& [point, normal] : field_points(occluder, 40)) {
                const Vec3f up = turn(normal), *horizon = normal == Vec3f(0.0f) ? nullptr : &up;
                const int here = difference(rasterizer.open_samples({&occluder, point, horizon, &turn}),
                                            other.open_samples(turned, turn(point), horizon));
                EXPECT_LE(here, is_exact ? 0 : 20) << example.name << " from " << point;
                differing += here;
                ++points;
            }
            EXPECT_LE(differing, points) << example.name;
        }
    }
}

TEST(VisibilityRasterizer, BothPathsAreBitIdenticalWhereAxesMeetEdgesAndVertices) {
    // From lattice points of a box, every axis runs along edges, through vertices and within faces.
    const Occluder box = make_occluder(box_mesh({-1, -1, -1}, {1, 1, 1}, 4)),
                   sphere = make_occluder(sphere_mesh({0, 0, 0}, 1, 24));
    const Occluder two_sided = two_sided_of(box);
    const std::array<const Occluder*, 3> all{&box, &sphere, &two_sided};
    for (const int size : {8, 64, 256}) {
        VisibilityRasterizer rasterizer(size);
        SpansAlone spans(size);
        for (int x = -3; x <= 3; ++x)
            for (int y = -3; y <= 3; y += size == 256 ? 3 : 1)
                for (int z = -3; z <= 3; z += size == 256 ? 2 : 1) {
                    const Vec3f point = Vec3f(float(x), float(y), float(z)) * 0.5f;
                    for (const Occluder* occluder : all)
                        ASSERT_EQ(difference(rasterizer.open_samples(*occluder, point),
                                             spans.open_samples(*occluder, point)),
                                  0)
                            << "from " << point << ", size " << size;
                }
    }
}

TEST(VisibilityRasterizer, BothPathsAreBitIdenticalWhereEdgesRunAlongSubColumns) {
    // The sides z = 1 and z = -1 of x = 1, and lines between them, exactly at the u of sub-columns of face
    // -x.
    const Occluder box = make_occluder(box_mesh({-1, -1, -1}, {1, 1, 1}, 4));
    VisibilityRasterizer rasterizer(64);
    SpansAlone spans(64);
    for (int i = -767; i <= 767; i += 2) {
        const Vec3f point(2, 0.1875f, static_cast<float>(i) / 512);
        ASSERT_EQ(difference(rasterizer.open_samples(box, point), spans.open_samples(box, point)), 0)
            << "from " << point;
    }
}

TEST(VisibilityRasterizer, BothPathsAreBitIdenticalInThePlaneOfASide) {
    // The upper side appears as the line v = 77/512 of faces +z and -z, exactly on samples. Rounding makes
    // some of its triangles front-facing and others back-facing, and flips some images.
    constexpr float slope = 77 / 512.0f;
    Mesh sheared = box_mesh({-1, -1, -1}, {1, 0, 1}, 16);
    for (Vec3f& position : sheared.positions) position.y -= slope * position.z;
    const Occluder box = make_occluder(sheared);
    const Occluder two_sided = two_sided_of(box);
    const std::array<const Occluder*, 2> both{&box, &two_sided};
    VisibilityRasterizer rasterizer(64);
    SpansAlone spans(64);
    for (int x = -9; x <= 9; ++x)
        for (const int z : {-31, -25, -17, 17, 19, 27})
            for (const Occluder* occluder : both) {
                const float depth = static_cast<float>(z) / 8;
                const Vec3f point(static_cast<float>(x) / 8 + 0.013f, -slope * depth, depth);
                const ViewedOccluder viewed = look_at(*occluder, point, nullptr);
                for (std::uint32_t t = 0; t < occluder->triangles().size(); ++t) {
                    const auto& triangle = occluder->triangles()[t];
                    const bool in_plane = std::all_of(triangle.begin(), triangle.end(), [&](auto v) {
                        return occluder->positions()[v].y == -slope * occluder->positions()[v].z;
                    });
                    if (in_plane) {
                        ASSERT_EQ(facing(*occluder, viewed, t), 0) << "triangle " << t << " from " << point;
                    }
                }
                ASSERT_EQ(difference(rasterizer.open_samples(*occluder, point),
                                     spans.open_samples(*occluder, point)),
                          0)
                    << "from " << point;
            }
}

TEST(VisibilityRasterizer, BlocksThroughAnyNumberOfLayers) {
    for (const int layers : {254, 255, 256, 257, 512}) {
        Mesh plates;
        for (int i = 0; i < layers; ++i)
            plates = joined_meshes(plates, square_mesh(8, -1 - 1e-3f * static_cast<float>(i), 8));
        const Occluder occluder = make_occluder(plates);
        VisibilityRasterizer rasterizer(16);
        SpansAlone spans(16);
        const Vec3f point(0.113f, 0, 0.217f);
        const auto open = rasterizer.open_samples(occluder, point);
        EXPECT_EQ(std::count(open.begin() + 3 * 256, open.begin() + 4 * 256, 0), 256) << layers;
        EXPECT_EQ(difference(open, spans.open_samples(occluder, point)), 0) << layers;
    }
}

TEST(VisibilityRasterizer, TrianglesWithoutAreaChangeNothing) {
    const Mesh plain = turned(box_mesh({-0.5f, -0.8f, -0.6f}, {0.5f, 0.4f, 0.7f}, 3));
    Mesh with_needles = plain;
    const auto first = static_cast<std::uint32_t>(plain.positions.size());
    for (int i = 0; i < 6; ++i) with_needles.positions.push_back(Vec3f(1, 0.5f, 2) * float(i));
    for (std::uint32_t i = 0; i < 4; ++i)
        with_needles.triangles.push_back({first + i, first + i + 1, first + i + 2});
    with_needles.triangles.push_back({first, first, first + 1});
    const Occluder wanted = make_occluder(plain), found = make_occluder(with_needles);
    VisibilityRasterizer one(64), other(64);
    for (const Vec3f& point : view_points(wanted))
        EXPECT_EQ(difference(one.open_samples(found, point), other.open_samples(wanted, point)), 0) << point;
}

TEST(VisibilityRasterizer, ANeedleThatClosesASurfaceLeavesNoLeak) {
    // A box with a vertex in the middle of an edge of its top on one side only, and a triangle without area
    // there.
    Mesh box = box_mesh({-1, -1, -1}, {1, 1, 1});
    Mesh closed;
    closed.positions = box.positions;
    closed.triangles = box.triangles;
    const Occluder whole = make_occluder(box);
    closed.positions = whole.positions();
    closed.triangles = whole.triangles();
    const auto [a, b, c] = closed.triangles[0];
    const auto middle = static_cast<std::uint32_t>(closed.positions.size());
    closed.positions.push_back((closed.positions[a] + closed.positions[b]) * 0.5f);
    closed.triangles[0] = {a, middle, c};
    closed.triangles.push_back({middle, b, c});
    closed.triangles.push_back({a, b, middle});
    const Occluder occluder = make_occluder(closed);
    ASSERT_EQ(occluder.one_sided(), 14u);
    VisibilityRasterizer rasterizer(64), other(64);
    for (const Vec3f& point : view_points(whole))
        EXPECT_LE(difference(rasterizer.open_samples(occluder, point), other.open_samples(whole, point)), 1)
            << point;
}

TEST(VisibilityRasterizer, FromASurfaceTheOppositeHalfSpaceIsRight) {
    constexpr int size = 32;
    VisibilityRasterizer rasterizer(size);
    const Occluder box = make_occluder(box_mesh({-1, -1, -1}, {1, 1, 1}, 4));
    for (const Vec3f& point :
         {Vec3f(1, 1, 1), Vec3f(1, 1, 0.3f), Vec3f(1, 0.3f, 0.2f), Vec3f(1, 0.5f, 0.5f)}) {
        const auto open = rasterizer.open_samples(box, point);
        // No ray that leaves the side x = 1 hits the box.
        EXPECT_EQ(std::count(open.begin(), open.begin() + size * size, 8), size * size) << point;
    }
    const Occluder two = make_occluder(
        joined_meshes(box_mesh({-1, -1, -1}, {1, 1, 1}, 4), box_mesh({2, -9, -9}, {3, 9, 9}, 4)));
    for (const Vec3f& point :
         {Vec3f(1, 1, 1), Vec3f(1, 1, 0.3f), Vec3f(1, 0.3f, 0.2f), Vec3f(1, 0.5f, 0.5f)}) {
        const auto open = rasterizer.open_samples(two, point);
        EXPECT_EQ(std::count(open.begin(), open.begin() + size * size, 0), size * size) << point;
    }
}

TEST(VisibilityRasterizer, SpeckFromAfarAndWallFromNear) {
    VisibilityRasterizer rasterizer(64);
    const Occluder speck = make_occluder(sphere_mesh({0, 0, 0}, 1e-4f, 12));
    for (const Vec3f& point : {Vec3f(1e5f, 0, 0), Vec3f(-3e4f, 8e4f, 1e5f)}) {
        const auto open = rasterizer.open_samples(speck, point);
        EXPECT_GE(std::count(open.begin(), open.end(), 8), std::ptrdiff_t(open.size()) - 1) << point;
    }
    const Occluder wall = make_occluder(box_mesh({-1e5f, -1e5f, -1e5f}, {1e5f, -20, 1e5f}, 6));
    const auto open = rasterizer.open_samples(wall, Vec3f(0.3f, 0, -0.7f));
    EXPECT_EQ(std::count(open.begin() + 3 * 64 * 64, open.begin() + 4 * 64 * 64, 0), 64 * 64);
    EXPECT_EQ(std::count(open.begin() + 2 * 64 * 64, open.begin() + 3 * 64 * 64, 8), 64 * 64);
}

TEST(VisibilityRasterizer, IsBitIdenticalForEveryInstructionSet) {
    const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
    for (const int size : {4, 64, 128})
        for (const Example& example : examples()) {
            const Occluder occluder = make_occluder(example.mesh);
            std::vector<Vec3f> points = view_points(occluder);
            points.erase(points.begin() + 5, points.end() - 5);
            for (const Vec3f& point : points) {
                std::vector<std::vector<std::uint8_t>> answers;
                for (const std::int64_t target : targets) {
                    hwy::SetSupportedTargetsForTest(target);
                    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
                    VisibilityRasterizer rasterizer(size);
                    const auto open = rasterizer.open_samples(occluder, point);
                    answers.emplace_back(open.begin(), open.end());
                }
                for (std::size_t i = 1; i < answers.size(); ++i)
                    EXPECT_EQ(difference(answers[i], answers[0]), 0)
                        << hwy::TargetName(targets[i]) << ", " << example.name << " from " << point;
            }
        }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

TEST(VisibilityRasterizer, DependsNeitherOnScaleNorMuchOnPlace) {
    constexpr int size = 64;
    VisibilityRasterizer rasterizer(size);
    PlainRasterizer plain(size);
    for (const Example& example : examples()) {
        const Occluder unit = make_occluder(example.mesh);
        for (const Vec3f& point : {Vec3f(1.4f, 0.9f, -0.7f), Vec3f(-0.6f, 1.7f, 2.1f)}) {
            const auto open = rasterizer.open_samples(unit, point);
            const std::vector<std::uint8_t> wanted(open.begin(), open.end());
            // Powers of two, which are exact.
            for (const float scale : {0x1p-14f, 0x1p17f}) {
                Mesh scaled = example.mesh;
                for (Vec3f& position : scaled.positions) position *= scale;
                EXPECT_EQ(difference(rasterizer.open_samples(make_occluder(scaled), point * scale), wanted),
                          0)
                    << example.name << " times " << scale;
            }
            // Far from the origin, positions are coarse. The plain loop uses the same positions.
            Mesh moved = example.mesh;
            const Vec3f shift(2e4f, -7e3f, 1e5f);
            for (Vec3f& position : moved.positions) position = position * 100.0f + shift;
            const Occluder far = make_occluder(moved);
            const Vec3f eye = point * 100.0f + shift;
            const auto found = rasterizer.open_samples(far, eye);
            EXPECT_LE(difference(found, plain.open_samples(far, eye)), 2) << example.name << " from afar";
        }
    }
}

/// Returns the blocked solid angle. [sr]
double blocked_solid_angle(std::span<const std::uint8_t> open, int size) {
    double sum = 0;
    for (std::size_t i = 0; i < open.size(); ++i) {
        const int texel = static_cast<int>(i) % (size * size);
        sum += (samples_per_texel - open[i]) / double(samples_per_texel) *
               texel_solid_angle(texel % size, texel / size, size);
    }
    return sum;
}

TEST(VisibilityRasterizer, ASphereBlocksItsCone) {
    const Occluder sphere = make_occluder(sphere_mesh({0, 0, 0}, 1, 64));
    VisibilityRasterizer rasterizer(64);
    const Vec3f direction = Vec3f(0.4f, -0.7f, 0.5f).normalized();
    for (const float distance : {1.05f, 1.5f, 3.0f, 8.0f}) {
        const auto open = rasterizer.open_samples(sphere, direction * distance);
        const double wanted = 2 * pi * (1 - std::sqrt(1 - 1 / double(distance * distance)));
        EXPECT_NEAR(blocked_solid_angle(open, 64), wanted, 5e-3 * wanted) << "from " << distance;
    }
}

/// Returns the solid angle of a rectangle with half sides a and b, at a distance d above its centre. [sr]
double rectangle_solid_angle(double a, double b, double d) {
    return 4 * std::atan(a * b / (d * std::sqrt(a * a + b * b + d * d)));
}

TEST(VisibilityRasterizer, ASquareBlocksItsSolidAngle) {
    const Occluder square = make_occluder(square_mesh(2, 0));
    VisibilityRasterizer rasterizer(256);
    for (const float height : {0.01f, 0.3f, 1.0f, 4.0f, 20.0f})
        for (const float side : {1.0f, -1.0f}) {
            const auto open = rasterizer.open_samples(square, Vec3f(0, side * height, 0));
            const double wanted = rectangle_solid_angle(1, 1, height);
            EXPECT_NEAR(blocked_solid_angle(open, 256), wanted, 0.01 * wanted) << side * height;
        }
}

TEST(VisibilityRasterizer, AHugeSquareBelowBlocksTheLowerHalf) {
    constexpr int size = 64;
    VisibilityRasterizer rasterizer(size);
    const auto open = rasterizer.open_samples(make_occluder(square_mesh(2e4f, -1)), Vec3f(3.3f, 0, -7.1f));
    std::size_t i = 0;
    for (int face = 0; face < 6; ++face)
        for (int row = 0; row < size; ++row)
            for (int column = 0; column < size; ++column, ++i) {
                // No texel row straddles the horizon.
                const bool below = face == 3 || (face != 2 && row >= size / 2);
                EXPECT_EQ(open[i], below ? 0 : 8) << "face " << face << ", row " << row;
            }
}

TEST(VisibilityRasterizer, BlocksTheQuadrantInWhichTheOccluderLies) {
    constexpr int size = 16;
    VisibilityRasterizer rasterizer(size);
    for (int face = 0; face < 6; ++face)
        for (const double u : {-0.5, 0.5})
            for (const double v : {-0.5, 0.5}) {
                const FaceFrame& frame = face_frames[face];
                const Vec3f centre(frame.axis * 4 + frame.right * (4 * u) + frame.down * (4 * v));
                const Vec3f eye(0.3f, -0.2f, 0.1f);
                const Occluder occluder = make_occluder(sphere_mesh(eye + centre, 1, 12));
                const auto open = rasterizer.open_samples(occluder, eye);
                int blocked = 0;
                for (int i = 0; i < 6 * size * size; ++i) {
                    const int row = i / size % size, column = i % size;
                    const bool here = i / (size * size) == face && (column >= size / 2) == (u > 0) &&
                                      (row >= size / 2) == (v > 0);
                    if (!here) {
                        EXPECT_EQ(open[std::size_t(i)], 8)
                            << "face " << face << ", occluder at " << u << " " << v << ", texel " << i;
                    }
                    blocked += 8 - open[std::size_t(i)];
                }
                const int column = static_cast<int>((u + 1) / 2 * size),
                          row = static_cast<int>((v + 1) / 2 * size);
                EXPECT_EQ(open[std::size_t((face * size + row) * size + column)], 0);
                EXPECT_GT(blocked, 80);
            }
}

TEST(VisibilityRasterizer, AClosedSurfaceAroundTheViewPointHasNoCrack) {
    const Mesh meshes[] = {sphere_mesh({0, 0, 0}, 1, 40), turned(sphere_mesh({0, 0, 0}, 1, 31)),
                           box_mesh({-1, -1, -1}, {1, 1, 1}, 8),
                           turned(box_mesh({-1, -1, -1}, {1, 1, 1}, 5))};
    // From the centre of the box and its lattice points, rays hit edges and vertices exactly.
    const Vec3f points[] = {{0, 0, 0},
                            {0.25f, 0.5f, -0.25f},
                            {0.1234f, -0.3071f, 0.2718f},
                            {0.5f, 0.5f, 0.5f},
                            {-0.5771f, 0.01f, 0.31f}};
    for (const int size : {1, 16, 64, 256}) {
        VisibilityRasterizer rasterizer(size);
        for (const Mesh& mesh : meshes) {
            const Occluder around = make_occluder(turned_round(mesh));
            ASSERT_EQ(around.one_sided(), 0u);
            for (const Vec3f& point : points) {
                const auto open = rasterizer.open_samples(around, point);
                EXPECT_EQ(std::count(open.begin(), open.end(), 0), std::ptrdiff_t(open.size()))
                    << "size " << size << " from " << point;
            }
        }
    }
}

TEST(VisibilityRasterizer, ASphereFromOutsideIsWholeAndEndsAtItsSilhouette) {
    constexpr int size = 64, segments = 48;
    const Occluder sphere = make_occluder(sphere_mesh({0, 0, 0}, 1, segments));
    // lower bound of the distance of facets from the centre
    const double inner = std::pow(std::cos(pi / segments), 2);
    VisibilityRasterizer rasterizer(size);
    for (const Vec3f& point :
         {Vec3f(0, 0, 3), Vec3f(1.1f, -0.9f, 0.4f), Vec3f(0, 1.2f, 0), Vec3f(-7, 5, 0)}) {
        const auto open = rasterizer.open_samples(sphere, point);
        const double distance = Vec3d(point).length();
        const Vec3d towards = -Vec3d(point) / distance;
        int inside = 0, between = 0;
        std::size_t i = 0;
        for (int face = 0; face < 6; ++face)
            for (int row = 0; row < size; ++row)
                for (int column = 0; column < size; ++column, ++i) {
                    int in = 0, out = 0;
                    for (int s = 0; s < samples_per_texel; ++s) {
                        const Vec3d ray = sub_sample_direction(face, column, row, s, size).normalized();
                        const double nearest = ray.cross(towards).length() * distance;
                        const bool ahead = ray.dot(towards) > 0;
                        in += ahead && nearest < inner;
                        out += !ahead || nearest > 1 + 1e-6;
                    }
                    EXPECT_LE(open[i], 8 - in) << "face " << face << " row " << row << " column " << column;
                    EXPECT_GE(open[i], out) << "face " << face << " row " << row << " column " << column;
                    inside += in;
                    between += 8 - in - out;
                }
        EXPECT_GT(inside, 500);
        EXPECT_LT(between, inside / 5);
    }
}

TEST(VisibilityRasterizer, ALatticeSeenAlongItsVerticesIsWhole) {
    // Sub-samples have u and v at odd multiples of 1/64. All of them hit vertices; after a shift by half a
    // cell, edge midpoints; from half the height, those of diagonals.
    constexpr int size = 8;
    VisibilityRasterizer rasterizer(size);
    const Occluder floor = make_occluder(square_mesh(4, -1, 256));
    constexpr float half_cell = 1 / 128.0f;
    for (const Vec3f& point : {Vec3f(0, 0, 0), Vec3f(0.5f, 0, -0.25f), Vec3f(half_cell, 0, 0),
                               Vec3f(0, 0, half_cell), Vec3f(-0.25f, -0.5f, 0)}) {
        const auto open = rasterizer.open_samples(floor, point);
        for (std::size_t i = 3 * size * size; i < 4 * size * size; ++i)
            EXPECT_EQ(open[i], 0) << i << " from " << point;
        for (std::size_t i = 2 * size * size; i < 3 * size * size; ++i)
            EXPECT_EQ(open[i], 8) << i << " from " << point;
    }
}

TEST(VisibilityRasterizer, OneSidedTrianglesAreOpenFromBehind) {
    VisibilityRasterizer rasterizer(16);
    const Occluder sphere = make_occluder(sphere_mesh({0, 0, 0}, 1, 16));
    const auto open = rasterizer.open_samples(sphere, Vec3f(0.1f, 0.2f, -0.3f));
    EXPECT_EQ(std::count(open.begin(), open.end(), 8), 6 * 16 * 16);
}

TEST(VisibilityRasterizer, HorizonOmitsOnlyTrianglesBelowIt) {
    constexpr int size = 32;
    const Mesh mesh = joined_meshes(triangle_soup(200, 7), box_mesh({-2, -0.5f, 1.5f}, {2, 0.75f, 2}, 3));
    const Occluder occluder = make_occluder(mesh);
    VisibilityRasterizer rasterizer(size), other(size);
    const Vec3f point(0.05f, 0.11f, -0.07f), normal = Vec3f(0.3f, 0.9f, -0.2f).normalized();
    const double low = 1e-5 * occluder.bounds().radius();
    OccluderTriangles above = occluder.source();
    above.triangles.clear();
    above.one_sided = 0;
    for (std::size_t t = 0; t < occluder.triangles().size(); ++t) {
        const auto is_above = [&](std::uint32_t v) {
            return Vec3d(normal).dot(Vec3d(occluder.positions()[v]) - Vec3d(point)) > low;
        };
        const auto& triangle = occluder.triangles()[t];
        if (!std::any_of(triangle.begin(), triangle.end(), is_above)) continue;
        above.triangles.push_back(triangle);
        above.one_sided += t < occluder.one_sided();
    }
    ASSERT_LT(above.triangles.size(), occluder.triangles().size());
    ASSERT_GT(above.one_sided, 0u);
    const auto found = rasterizer.open_samples(occluder, point, &normal);
    const auto wanted = other.open_samples(Occluder(above), point);
    EXPECT_TRUE(std::equal(found.begin(), found.end(), wanted.begin(), wanted.end()));
    // Above the horizon, the result is exact.
    const EmbreeOracle oracle(occluder);
    int checked = 0;
    for (int i = 0; i < 6 * size * size; ++i) {
        const int face = i / (size * size), row = i / size % size, column = i % size;
        int open = 0;
        bool all_above = true;
        for (int s = 0; s < samples_per_texel; ++s) {
            const Vec3d ray = sub_sample_direction(face, column, row, s, size);
            all_above = all_above && Vec3d(normal).dot(ray) > 0;
            open += oracle.is_open(point, ray);
        }
        if (!all_above) continue;
        EXPECT_LE(std::abs(open - found[std::size_t(i)]), 1) << i;
        ++checked;
    }
    EXPECT_GT(checked, 2 * size * size);
}

TEST(VisibilityRasterizer, DoesNotDependOnEarlierCalls) {
    const Occluder torus = make_occluder(torus_mesh(0.8f, 0.3f, 24)),
                   square = make_occluder(square_mesh(1, 0));
    VisibilityRasterizer used(32), fresh(32);
    used.open_samples(torus, {0, 0.5f, 0});
    const auto found = used.open_samples(square, {0.3f, 1, 2});
    const auto wanted = fresh.open_samples(square, {0.3f, 1, 2});
    EXPECT_TRUE(std::equal(found.begin(), found.end(), wanted.begin(), wanted.end()));
    const auto nothing = used.open_samples(make_occluder(Mesh{}), {0, 0, 0});
    EXPECT_EQ(std::count(nothing.begin(), nothing.end(), 8), 6 * 32 * 32);
}

TEST(VisibilityRasterizer, SeveralOccludersEqualTheirUnion) {
    const std::vector<Example> all = examples();
    VisibilityRasterizer rasterizer(32), other(32);
    for (std::size_t a = 0; a < all.size(); ++a)
        for (std::size_t b = 0; b < all.size(); ++b) {
            if (a == b) continue;
            const Occluder first = make_occluder(all[a].mesh), second = make_occluder(all[b].mesh),
                           both = make_occluder(joined_meshes(all[a].mesh, all[b].mesh));
            for (const Vec3f& point : view_points(both)) {
                const OccluderView views[] = {{&first, point}, {&second, point}};
                const auto found = rasterizer.open_samples(views), wanted = other.open_samples(both, point);
                EXPECT_TRUE(std::equal(found.begin(), found.end(), wanted.begin()))
                    << all[a].name << " and " << all[b].name << " from " << point;
            }
        }
    const auto open = rasterizer.open_samples(std::span<const OccluderView>());
    EXPECT_TRUE(std::all_of(open.begin(), open.end(), [](int n) { return n == samples_per_texel; }));
}

}  // namespace
}  // namespace haarfield
