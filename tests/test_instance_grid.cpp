#include "shading/visibility/instance_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/fixtures/random_numbers.h"

namespace haarfield {
namespace {

TEST(InstanceGrid, FindsEverySphereAroundAPointInOrder) {
    std::mt19937 random(7);
    const auto place = [&] { return uniform(random, -20.0f, 20.0f); };
    for (const int count : {0, 1, 3, 1000}) {
        std::vector<Sphere> spheres;
        for (int i = 0; i < count; ++i)
            spheres.push_back({Vec3f{place(), place() * 0.1f, place()}, uniform(random, 0.1f, 4.0f)});
        if (count == 3) spheres[1].radius = 200;  // a floor
        const InstanceGrid grid(spheres);
        std::size_t found = 0, wanted = 0;
        for (int i = 0; i < 2000; ++i) {
            const Vec3f point{place() * 1.5f, place() * 0.2f, place() * 1.5f};
            const auto near = grid.near(point);
            EXPECT_TRUE(std::is_sorted(near.begin(), near.end()));
            EXPECT_EQ(std::adjacent_find(near.begin(), near.end()), near.end());
            found += near.size();
            for (std::uint32_t k = 0; k < spheres.size(); ++k)
                if ((point - spheres[k].centre).length() <= spheres[k].radius) {
                    ++wanted;
                    EXPECT_TRUE(std::binary_search(near.begin(), near.end(), k)) << point << " sphere " << k;
                }
        }
        if (count == 1000) {
            EXPECT_LT(found, 6 * wanted);
        }
    }
}

/// A layer of small spheres 1000 km wide would have a billion cubic cells.
TEST(InstanceGrid, AFlatLayerOfSpheresHasNoMoreCellsThanOthers) {
    std::mt19937 random(8);
    std::vector<Sphere> spheres;
    for (int i = 0; i < 4096; ++i)
        spheres.push_back({Vec3f{uniform(random, 0.0f, 1e6f), 0, uniform(random, 0.0f, 1e6f)}, 1e-3f});
    const InstanceGrid grid(spheres);
    EXPECT_LE(grid.cell_count(), 64 * spheres.size());
    for (std::uint32_t i = 0; i < spheres.size(); ++i) {
        const auto near = grid.near(spheres[i].centre);
        EXPECT_TRUE(std::binary_search(near.begin(), near.end(), i)) << i;
        EXPECT_LE(near.size(), 20u);
    }
}

}  // namespace
}  // namespace haarfield
