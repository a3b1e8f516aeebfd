#include "fields/base/placement.h"

#include <gtest/gtest.h>

namespace haarfield {
namespace {

TEST(Placement, IsTheIdentityByDefault) {
    const Vec3f point(0.1f, -2, 3e5f);
    EXPECT_EQ(Placement().point_to_world(point), point);
    EXPECT_EQ(Placement().point_to_object(point), point);
}

TEST(Placement, ScalesAndThenTranslates) {
    const Placement placement{{1, -2, 0.5f}, 4};
    EXPECT_EQ(placement.point_to_world(Vec3f(0, 0, 0)), Vec3f(1, -2, 0.5f));
    EXPECT_EQ(placement.point_to_world(Vec3f(1, 2, -3)), Vec3f(5, 6, -11.5f));
    EXPECT_EQ(placement.point_to_world(Vec3d(1, 2, -3)), Vec3d(5, 6, -11.5));
}

TEST(Placement, TakesPointsToTheWorldAndBack) {
    for (const float scale : {1e-3f, 0.7f, 1.0f, 30.0f})
        for (const Vec3f& translate : {Vec3f(0, 0, 0), Vec3f(0.2f, -0.7f, 3), Vec3f(-50, 8, 0.1f)}) {
            const Placement placement{translate, scale};
            for (const Vec3f& point : {Vec3f(0, 0, 0), Vec3f(0.3f, 0.8f, -1.1f), Vec3f(-4, 0.01f, 9)}) {
                // Each of the four operations rounds, relative to the size of its world coordinates.
                const float rounding = 4e-7f * (translate.length() / scale + point.length());
                EXPECT_LE((placement.point_to_object(placement.point_to_world(point)) - point).length(),
                          rounding)
                    << scale << ", " << translate << ", " << point;
                EXPECT_LE((Vec3d(placement.point_to_world(point)) - placement.point_to_world(Vec3d(point)))
                              .length(),
                          double(rounding * scale))
                    << scale << ", " << translate << ", " << point;
            }
        }
}

}  // namespace
}  // namespace haarfield
