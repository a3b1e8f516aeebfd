#include "shading/visibility/rasterized_visibility.h"

#include <gtest/gtest.h>

#include <hwy/highway.h>

#include <algorithm>

#include "tests/fixtures/example_meshes.h"
#include "tests/oracles/wide_texels.h"

namespace haarfield {
namespace {

TEST(RasterizedVisibility, HoldsEveryTexelOfTheRasterizer) {
    const Occluder sphere = make_occluder(sphere_mesh({0, 0, 0}, 1, 20)),
                   box = make_occluder(box_mesh({-1, -1, -1}, {1, 2, 3}));
    const Vec3f up(0, 1, 0);
    for (const int size : {1, 2, 4, 8, 16, 32, 64, 128, 256}) {
        RasterizedVisibility seen(size);
        VisibilityRasterizer rasterizer(size);
        for (const Vec3f& point : {Vec3f(0.3f, 1.7f, -0.2f), Vec3f(5, 1, 1), Vec3f(0, -3, 0.4f)}) {
            for (const Vec3f* horizon : {static_cast<const Vec3f*>(nullptr), &up}) {
                const OccluderView views[] = {{&sphere, point, horizon}, {&box, point * 3}};
                const WideCubemap<std::uint8_t>& found = seen(views);
                const auto wanted = rasterizer.open_samples(views);
                for (std::size_t face = 0; face < cubemap_faces; ++face) {
                    const std::vector<double> texels = texels_of(found[face], size);
                    double mean = 0;
                    for (std::size_t i = 0; i < texels.size(); ++i) {
                        const double open = open_fraction(wanted[face * texels.size() + i]);
                        ASSERT_NEAR(texels[i], open, 0.51 / 255) << size << " " << point << " face " << face;
                        mean += std::round(255 * open) / 255 / double(texels.size());
                    }
                    EXPECT_NEAR(found[face].mean, mean, 1e-6);
                    EXPECT_EQ(found[face].root == nullptr,
                              *std::min_element(texels.begin(), texels.end()) ==
                                  *std::max_element(texels.begin(), texels.end()));
                }
            }
        }
    }
}

TEST(RasterizedVisibility, MeansOfVaryingCellsAreThoseOfTheirChildren) {
    const Occluder sphere = make_occluder(sphere_mesh({0, 0, 0}, 1, 20));
    const OccluderView view{&sphere, {0.4f, 1.3f, -0.3f}};
    RasterizedVisibility seen(64);
    int checked = 0;
    const auto check = [&](const auto& self, const WideNode<std::uint8_t>* node) -> double {
        double sum = 0;
        for (unsigned cell = 0; cell < wide_cells; ++cell) {
            if (node->varying >> cell & 1u) {
                const double below = self(self, child_of(node, cell));
                EXPECT_NEAR(node->mean[cell], below, 0.51 + 0.5);
                ++checked;
                sum += below / wide_cells;
            } else
                sum += node->mean[cell] / double(wide_cells);
        }
        return sum;
    };
    for (const auto& face : seen(std::span(&view, 1)))
        if (face.root) {
            EXPECT_NEAR(255 * face.mean, check(check, face.root), 0.5);
        }
    EXPECT_GT(checked, 50);
}

TEST(RasterizedVisibility, IsBitIdenticalForAllInstructionSets) {
    const Occluder sphere = make_occluder(sphere_mesh({0, 0, 0}, 1, 20));
    const OccluderView view{&sphere, {0.4f, 1.3f, -0.3f}};
    for (const int size : {2, 8, 32, 64}) {
        RasterizedVisibility seen(size);
        const auto nodes = [&] {
            seen(std::span(&view, 1));
            std::vector<std::array<std::uint32_t, wide_cells + 2>> copies;
            for (const WideNode<std::uint8_t>& node : seen.last().nodes) {
                auto& copy = copies.emplace_back();
                std::copy(node.mean.begin(), node.mean.end(), copy.begin());
                copy[wide_cells] = node.first_child;
                copy[wide_cells + 1] = node.varying;
            }
            return copies;
        };
        const auto wanted = nodes();
        const std::int64_t all = hwy::SupportedTargets();
        for (std::int64_t left = all; left != 0; left &= left - 1) {
            hwy::SetSupportedTargetsForTest(left & -left);
            hwy::GetChosenTarget().Update(hwy::SupportedTargets());
            EXPECT_EQ(nodes(), wanted) << hwy::TargetName(left & -left);
        }
        hwy::SetSupportedTargetsForTest(0);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
}

}  // namespace
}  // namespace haarfield
