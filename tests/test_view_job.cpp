#include "tools/view/view_job.h"

#include <gtest/gtest.h>

namespace haarfield {
namespace {

using What = ViewJob::For;
using Of = Variation::Of;

PartialPlace moved(std::uint32_t object) {
    return {object, Vec3f(1, 0, 0), {}, {}};
}

SetView look_from(const Vec3f& position) {
    SetView look;
    look.camera.position = position;
    return look;
}

TEST(ViewJob, ContinuesForTheSameGesture) {
    const std::optional<Vec3f> eye = Vec3f(3, 2, 1);
    for (const What what : {What::vectors, What::likely}) {
        EXPECT_FALSE(job_ends_for({what, {Of::light, 0}}, TurnLight{}, eye));
        EXPECT_FALSE(job_ends_for({what, {Of::light, 0}}, MixLights{0.5f}, eye));
        EXPECT_FALSE(job_ends_for({what, {Of::eye, 0}}, look_from({0, 1, 5}), eye));
        EXPECT_FALSE(job_ends_for({what, {Of::object, 2}}, moved(2), eye));
    }
    PartialPlace turned = moved(2);
    turned.rotate = Rotation();
    EXPECT_FALSE(job_ends_for({What::shade, {}}, turned, eye));
}

TEST(ViewJob, EndsForAnotherGesture) {
    const std::optional<Vec3f> eye = Vec3f(3, 2, 1);
    const SetView away = look_from({0, 1, 5});
    for (const What what : {What::vectors, What::likely}) {
        EXPECT_TRUE(job_ends_for({what, {Of::light, 0}}, moved(2), eye));
        EXPECT_TRUE(job_ends_for({what, {Of::light, 0}}, away, eye));
        EXPECT_TRUE(job_ends_for({what, {Of::object, 1}}, moved(2), eye));
        EXPECT_TRUE(job_ends_for({what, {Of::eye, 0}}, TurnLight{}, eye));
    }
    for (const What what : {What::vectors, What::likely, What::shade, What::recommit, What::commit})
        for (const Content& content :
             {Content(NamedLights{}), Content(moved(1)), Content(away), Content(CloneObject{1}),
              Content(DeleteObject{1}), Content(StepBack{})})
            EXPECT_TRUE(job_ends_for({what, {Of::object, 2}}, content, eye)) << int(what);
}

TEST(ViewJob, ContinuesIfNoColoursChange) {
    const Vec3f eye(3, 2, 1);
    for (const What what : {What::vectors, What::likely, What::shade, What::recommit, What::commit}) {
        const ViewJob job{what, {Of::object, 2}};
        // A change of the window only, with a page's rounding errors; and any eye position if there is no
        // specular term.
        EXPECT_FALSE(job_ends_for(job, look_from(eye * 1.0000001f), eye)) << int(what);
        EXPECT_FALSE(job_ends_for(job, look_from({0, 1, 5}), std::nullopt)) << int(what);
        for (const Content& content :
             {Content(Select{}), Content(Save{}), Content(Steer{}), Content(FrameDisplayed{1})})
            EXPECT_FALSE(job_ends_for(job, content, eye)) << int(what);
    }
    // A frame takes less time than restarting the job.
    EXPECT_FALSE(job_ends_for({What::frame, {Of::light, 0}}, moved(2), eye));
    EXPECT_FALSE(job_ends_for({}, moved(2), eye));
}

}  // namespace
}  // namespace haarfield
