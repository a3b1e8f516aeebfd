#pragma once
/// The objects, lights and camera of a scene, as POV-Ray evaluates them.

#include "bridge/povray_import/scene_queries.h"
#include "fields/base/affine_map.h"
#include "fields/model/model_part.h"
#include "scenes/scene_import.h"

namespace haarfield {

/// An object that a scene creates.
struct SurveyedObject {
    std::size_t statement = 0;             ///< Index in WrappedScene::statements.
    Vec3d lower{0, 0, 0}, upper{0, 0, 0};  ///< Its box, in the scene's coordinates. Infinite: beyond 1e6.

    /// Returns the longest side of the box.
    double longest_side() const {
        const Vec3d size = upper - lower;
        return std::max({size.x, size.y, size.z});
    }
    /// Returns true for an object without surface.
    bool is_empty() const { return !(lower.x <= upper.x && lower.y <= upper.y && lower.z <= upper.z); }
    bool is_infinite() const { return longest_side() > 1e6; }  ///< A plane, for example.
};

/// A perspective camera. A ray's direction is direction + x right + y up, x and y from -0.5 to 0.5.
struct SurveyedCamera {
    Vec3d position{0, 0, 0};
    Vec3d direction{0, 0, 1}, right{1, 0, 0}, up{0, 1, 0};  ///< All scaled by one unknown factor.
    bool is_perspective = true;  ///< False: another projection, of which this is an approximation.
    /// Where the rays of an orthographic camera start, in the middle. A perspective camera far behind stands
    /// for it; none: the camera is not orthographic.
    std::optional<Vec3d> plane{};

    Vec3d start() const { return plane.value_or(position); }  ///< Where the middle ray starts.

    /// True if pictures show x to the right, y up and z to the back, as POV-Ray usually does.
    bool is_left_handed() const { return right.cross(up).dot(direction) > 0; }
};

/// The content of a scene.
struct SceneSurvey {
    std::vector<SurveyedObject> objects;  ///< In the order in which POV-Ray creates them.
    std::vector<ModelLight> lights;
    std::vector<std::size_t> unread_lights;  ///< Statements of lights that haarfield does not have.
    std::optional<SurveyedCamera> camera;
    double seconds = 0;  ///< Wall time of the run of POV-Ray, most of which it parses the scene. [s]
};

/// The coordinates of a file.
struct SceneFrame {
    bool z_up = false;        ///< The z axis points up, else y.
    bool left_handed = true;  ///< As POV-Ray's camera usually shows them.

    AffineMap map() const { return upright_frame(z_up, left_handed); }  ///< To a right-handed frame, y up.
};

/// Finds the coordinates of a file from its camera. The upward axis is y, or z if only that agrees with an
/// upright camera. Without a perspective camera, coordinates count as left-handed.
///
/// z_up  replaces the choice of the axis.
SceneFrame scene_frame(const std::optional<SurveyedCamera>& camera, std::optional<bool> z_up = {});

/// Surveys a scene.
///
/// errors  those of SceneQueries::answer.
/// cost    two runs of POV-Ray; up to seven for a camera that is declared and then moved.
Result<SceneSurvey> scene_survey(const SceneQueries& queries, const Progress& progress = {});

}  // namespace haarfield
