#include "fields/rasterizer/visibility_transform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fields/rasterizer/visibility_rasterizer.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/oracles/pixel_reference.h"

namespace haarfield {
namespace {

using reference::Texels;
using Counts = std::vector<std::uint8_t>;

/// Returns the visibility around a sphere and a box from a random point next to them.
Counts example_counts(std::uint32_t seed, int size) {
    static const Occluder occluder = make_occluder(
        joined_meshes(sphere_mesh({0, 0.6f, 0}, 0.5f, 12), box_mesh({-0.8f, 0, -0.1f}, {0.8f, 0.2f, 0.1f})));
    std::mt19937 random(seed);
    const auto coordinate = [&] { return static_cast<float>(random() % 2000) / 500 - 2; };
    VisibilityRasterizer rasterizer(size);
    const auto open = rasterizer.open_samples(occluder, {coordinate(), 1.3f, coordinate()});
    return Counts(open.begin(), open.end());
}

std::size_t face_texels(int size) {
    return std::size_t(size) * std::size_t(size);
}

std::vector<float> face_visibility(const Counts& open, std::size_t face, int size) {
    std::vector<float> visibility;
    for (std::size_t i = 0; i < face_texels(size); ++i)
        visibility.push_back(static_cast<float>(open[face * face_texels(size) + i]) / samples_per_texel);
    return visibility;
}

CubemapTree transformed(const Counts& open, int size, const Vec3f* horizon = nullptr,
                        const Truncation& truncation = {}) {
    CubemapTree tree;
    VisibilityTransform transform(size);
    transform(example_counts(77, size), nullptr, {5}, tree);  // old buffer contents must not matter
    transform(open, horizon, truncation, tree);
    return tree;
}

std::size_t node_count(const CubemapTree& tree) {
    std::size_t count = 0;
    for (const Quadtree& face : tree.faces) count += face.nodes.size();
    return count;
}

std::size_t wavelet_count(const Quadtree& tree) {
    std::size_t count = 0;
    for (const Quadtree::Node& node : tree.nodes)
        for (const float wavelet : node.wavelet) count += wavelet != 0;
    return count;
}

void expect_equal(const Quadtree& found, const Quadtree& wanted, const std::string& where) {
    EXPECT_EQ(found.scaling, wanted.scaling) << where;
    ASSERT_EQ(found.nodes.size(), wanted.nodes.size()) << where;
    for (std::size_t i = 0; i < found.nodes.size(); ++i) {
        ASSERT_EQ(found.nodes[i].children, wanted.nodes[i].children) << where << ", node " << i;
        for (std::size_t kind = 0; kind < 3; ++kind)
            ASSERT_EQ(found.nodes[i].wavelet[kind], wanted.nodes[i].wavelet[kind])
                << where << ", node " << i << ", kind " << kind;
    }
}

/// Returns the squared L2 norm over the unit squares of all faces.
double squared_error(const CubemapTree& tree, const Counts& open, int size) {
    double sum = 0;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const Texels found = reference::texels_of(tree.faces[face], size);
        const std::vector<float> wanted = face_visibility(open, face, size);
        for (std::size_t i = 0; i < found.size(); ++i)
            sum += (found[i] - double(wanted[i])) * (found[i] - double(wanted[i]));
    }
    return sum / static_cast<double>(face_texels(size));
}

double squared_occlusion(const Counts& open, int size) {
    double sum = 0;
    for (const std::uint8_t count : open) sum += std::pow(1 - double(count) / samples_per_texel, 2);
    return sum / static_cast<double>(face_texels(size));
}

double squared_visibility(const Counts& open, int size, const Vec3f* horizon = nullptr) {
    const std::vector<Vec3f> directions = texel_directions(size);
    double sum = 0;
    for (std::size_t i = 0; i < open.size(); ++i)
        if (!horizon || directions[i].dot(*horizon) > 0)
            sum += std::pow(double(open[i]) / samples_per_texel, 2);
    return sum / static_cast<double>(face_texels(size));
}

/// Returns the visibility through a window with the shape of the occluders.
Counts through_a_window(Counts open) {
    for (std::uint8_t& count : open) count = static_cast<std::uint8_t>(samples_per_texel - count);
    return open;
}

/// Returns the smallest energy of a remaining wavelet of any face.
double smallest_energy(const CubemapTree& tree) {
    double smallest = 1;
    for (const Quadtree& face : tree.faces) {
        std::vector<int> level(face.nodes.size(), 0);
        for (std::size_t i = 0; i < face.nodes.size(); ++i) {
            for (unsigned q = 0; q < 4; ++q)
                if (const std::int32_t child = child_of(face.nodes[i], q); child != no_node)
                    level[std::size_t(child)] = level[i] + 1;
            for (const float wavelet : face.nodes[i].wavelet)
                if (wavelet != 0)
                    smallest =
                        std::min(smallest, std::ldexp(double(wavelet) * double(wavelet), -2 * level[i]));
        }
    }
    return smallest;
}

TEST(VisibilityTransform, EqualsTheTransformOfTheTexels) {
    // Bit-identical: all sums are exact in floats.
    for (const int size : {8, 16, 64, 256})
        for (std::uint32_t seed = 0; seed < 5; ++seed) {
            Counts open = example_counts(seed, size);
            if (seed == 0)
                for (std::uint8_t& count : open)
                    count = static_cast<std::uint8_t>(count / 3 + 1);  // no zeros
            const CubemapTree tree = transformed(open, size);
            for (std::size_t face = 0; face < cubemap_faces; ++face)
                expect_equal(tree.faces[face], haar_quadtree<float>(face_visibility(open, face, size), size),
                             "size " + std::to_string(size) + ", seed " + std::to_string(seed));
        }
}

TEST(VisibilityTransform, OneTexelOfAFaceMatters) {
    const int size = 16;
    for (const std::size_t texel : {0u, 7u, 8u, 136u, 255u}) {
        Counts open(6 * face_texels(size), samples_per_texel);
        open[5 * face_texels(size) + texel] = 3;
        const CubemapTree tree = transformed(open, size);
        for (std::size_t face = 0; face < cubemap_faces; ++face)
            expect_equal(tree.faces[face], haar_quadtree<float>(face_visibility(open, face, size), size),
                         "texel " + std::to_string(texel));
    }
}

TEST(VisibilityTransform, KeepsTheLargestWaveletsOfAFace) {
    const int size = 32;
    for (const int kept : {1, 7, 40}) {
        const Counts open = example_counts(3, size);
        const CubemapTree tree = transformed(open, size, nullptr, {kept});
        for (std::size_t face = 0; face < cubemap_faces; ++face)
            expect_equal(tree.faces[face],
                         haar_quadtree<float>(face_visibility(open, face, size), size, {kept}),
                         std::to_string(kept) + " kept");
    }
}

TEST(VisibilityTransform, DropsAllThatTheRelativeErrorOfTheCubemapAllowsAndNoMore) {
    const int size = 32;
    for (std::uint32_t seed = 0; seed < 5; ++seed)
        for (const float error : {0.01f, 0.1f, 0.5f}) {
            const Counts open = example_counts(seed, size);
            const double allowed = double(error) * double(error) * squared_occlusion(open, size);
            const CubemapTree tree = transformed(open, size, nullptr, {0, error});
            const double dropped = squared_error(tree, open, size);
            EXPECT_LE(dropped, allowed * (1 + 1e-5)) << seed << ", " << error;
            // Dropping the smallest remaining wavelet of any face would exceed the error.
            EXPECT_GT(dropped + smallest_energy(tree), allowed * (1 - 1e-5)) << seed << ", " << error;
        }
}

TEST(VisibilityTransform, ARelativeErrorIsRelativeToTheOpenDirectionsIfTheseAreFewer) {
    // Negatives of each other lose the same wavelets.
    const int size = 32;
    for (std::uint32_t seed = 0; seed < 5; ++seed)
        for (const float error : {0.01f, 0.1f, 0.5f}) {
            const Counts outside = example_counts(seed, size), inside = through_a_window(outside);
            ASSERT_LT(squared_visibility(inside, size), squared_occlusion(inside, size)) << seed;
            const CubemapTree tree = transformed(inside, size, nullptr, {0, error});
            const double allowed = double(error) * double(error) * squared_visibility(inside, size),
                         dropped = squared_error(tree, inside, size);
            EXPECT_LE(dropped, allowed * (1 + 1e-5)) << seed << ", " << error;
            EXPECT_GT(dropped + smallest_energy(tree), allowed * (1 - 1e-5)) << seed << ", " << error;
            const CubemapTree negative = transformed(outside, size, nullptr, {0, error});
            for (std::size_t face = 0; face < cubemap_faces; ++face)
                EXPECT_EQ(tree.faces[face].nodes.size(), negative.faces[face].nodes.size()) << seed;
        }
}

TEST(VisibilityTransform, OpenDirectionsBelowTheHorizonDoNotCount) {
    // A window that is almost completely, or half, below the horizon; everything below the horizon is open.
    const int size = 32;
    const std::vector<Vec3f> directions = texel_directions(size);
    for (const Vec3f& normal : {Vec3f(0, 1, 0), Vec3f(0.2f, 0.9f, -0.1f).normalized()})
        for (const float error : {0.1f, 0.3f}) {
            Counts open(6 * face_texels(size));
            for (std::size_t i = 0; i < open.size(); ++i) {
                const Vec3f& d = directions[i];
                const bool is_window = d.x > 0.6f && d.x < 0.97f && std::abs(d.z) < 0.5f;
                open[i] = is_window || d.dot(normal) <= 0 ? samples_per_texel : 0;
            }
            const CubemapTree tree = transformed(open, size, &normal, {0, error});
            double dropped = 0;
            for (std::size_t face = 0; face < cubemap_faces; ++face) {
                const Texels found = reference::texels_of(tree.faces[face], size);
                for (std::size_t i = 0; i < found.size(); ++i)
                    if (const std::size_t texel = face * face_texels(size) + i;
                        directions[texel].dot(normal) > 1e-6f)
                        dropped += std::pow(found[i] - double(open[texel]) / samples_per_texel, 2);
            }
            EXPECT_GT(dropped, 0) << error;
            EXPECT_LE(dropped / static_cast<double>(face_texels(size)),
                      double(error) * double(error) * squared_visibility(open, size, &normal) * (1 + 1e-5))
                << error << ", " << normal;
        }
}

TEST(VisibilityTransform, BothRulesActTogether) {
    const int size = 32;
    const Counts open = example_counts(1, size);
    const CubemapTree by_count = transformed(open, size, nullptr, {20}),
                      by_both = transformed(open, size, nullptr, {20, 0.3f}),
                      by_error = transformed(open, size, nullptr, {0, 0.3f});
    const double allowed = 0.09 * squared_occlusion(open, size);
    EXPECT_LT(squared_error(by_count, open, size), allowed);
    EXPECT_LE(squared_error(by_both, open, size), allowed * (1 + 1e-5));
    EXPECT_LT(node_count(by_both), node_count(by_count));
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        EXPECT_LE(wavelet_count(by_both.faces[face]), 20u);
    EXPECT_LE(node_count(by_both), node_count(by_error));
}

TEST(VisibilityTransform, IsExactAboveTheHorizonAndCheapBelow) {
    const int size = 64;
    const std::vector<Vec3f> directions = texel_directions(size);
    std::mt19937 random(5);
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
        const auto coordinate = [&] { return static_cast<float>(random() % 2001) / 1000 - 1; };
        Vec3f normal = Vec3f(coordinate(), coordinate(), coordinate()).normalized();
        if (seed == 0) normal = {0, 1, 0};
        Counts open = example_counts(seed, size), dark = open;
        for (std::size_t i = 0; i < open.size(); ++i)
            if (directions[i].dot(normal) <= 0) dark[i] = 0;
        const CubemapTree tree = transformed(dark, size, &normal);
        for (std::size_t face = 0; face < cubemap_faces; ++face) {
            const Texels found = reference::texels_of(tree.faces[face], size);
            for (std::size_t i = 0; i < found.size(); ++i) {
                const std::size_t texel = face * face_texels(size) + i;
                if (directions[texel].dot(normal) > 1e-6f) {
                    ASSERT_NEAR(found[i], open[texel] / 8.0, 2e-6) << "seed " << seed << ", texel " << texel;
                }
                ASSERT_GE(found[i], -1e-6);
                ASSERT_LE(found[i], 1 + 1e-6);
            }
        }
        EXPECT_LT(node_count(tree), node_count(transformed(dark, size))) << seed;
    }
}

TEST(VisibilityTransform, AnOpenHalfSpaceHasNoNodes) {
    const Vec3f normal = Vec3f(0.3f, 0.8f, -0.2f).normalized();
    const CubemapTree tree = transformed(Counts(6 * 64 * 64, samples_per_texel), 64, &normal);
    for (const Quadtree& face : tree.faces) {
        EXPECT_TRUE(face.nodes.empty());
        EXPECT_EQ(face.scaling, 1);
    }
}

}  // namespace
}  // namespace haarfield
