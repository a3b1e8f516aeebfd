#include "fields/base/rotation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace haarfield {
namespace {

void expect_equal(const Rotation& a, const Rotation& b, double tolerance) {
    for (std::size_t i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(a.row[i][k], b.row[i][k], tolerance);
}

TEST(Rotation, TurnsCounterClockwiseAsViewedFromTheTipOfTheAxis) {
    const double quarter = pi / 2;
    EXPECT_LT((rotation_about({1, 0, 0}, quarter)(Vec3d(0, 1, 0)) - Vec3d(0, 0, 1)).length(), 1e-12);
    EXPECT_LT((rotation_about({0, 3, 0}, quarter)(Vec3d(0, 0, 1)) - Vec3d(1, 0, 0)).length(), 1e-12);
    EXPECT_LT((rotation_about({0, 0, 1}, quarter)(Vec3d(1, 0, 0)) - Vec3d(0, 1, 0)).length(), 1e-12);
    // A rotation by a third of a turn about the diagonal permutes the axes.
    EXPECT_LT((rotation_about({1, 1, 1}, 2 * pi / 3)(Vec3d(1, 0, 0)) - Vec3d(0, 1, 0)).length(), 1e-12);
}

TEST(Rotation, AnglesAreAboutXThenYThenZ) {
    const Vec3f angles(0.3f, -0.7f, 2.0f);
    const Vec3d v(1, 2, 3);
    const Vec3d wanted =
        rotation_about({0, 0, 1}, 2.0f)(rotation_about({0, 1, 0}, -0.7f)(rotation_about({1, 0, 0}, 0.3f)(v)));
    EXPECT_LT((rotation_xyz(angles)(v) - wanted).length(), 1e-6);
}

TEST(Rotation, HasAnglesInAllCases) {
    for (const float x : {-3.0f, -0.4f, 0.0f, 1.0f, 2.9f})
        for (const float y : {-1.5707964f, -0.6f, 0.0f, 1.2f, 1.5707964f})
            for (const float z : {-2.5f, 0.0f, 0.8f}) {
                const Rotation rotation = rotation_xyz({x, y, z});
                expect_equal(rotation_xyz(angles_xyz(rotation)), rotation, 1e-6);
            }
}

TEST(Rotation, OfDegreesSurvivesBeingWritten) {
    for (const float angle : {-170.0f, -90.0f, 12.5f, 40.0f, 140.0f, 179.0f})
        for (int axis = 0; axis < 3; ++axis) {
            Vec3f angles(0.0f);
            angles[axis] = angle;
            const Rotation rotation = rotation_of_degrees(angles);
            EXPECT_EQ(rotation_of_degrees(degrees_xyz(rotation)), rotation) << angle << " about " << axis;
        }
    for (int i = 0; i < 1000; ++i) {
        const float turn = 0.37f * float(i);
        const Rotation any = rotation_about({1, std::sin(turn), std::cos(3 * turn)}, double(turn));
        const Rotation said = as_degrees(any);
        expect_equal(said, any, 1e-6);
        EXPECT_EQ(rotation_of_degrees(degrees_xyz(said)), said) << i;
        EXPECT_EQ(as_degrees(said), said) << i;
    }
}

}  // namespace
}  // namespace haarfield
