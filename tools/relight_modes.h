#pragma once
/// The changes that `relight` makes from frame to frame: the light, the view or the placement of instances.

#include "scenes/scene.h"
#include "shading/transfer/relight_session.h"
#include "tools/scene_options.h"

namespace haarfield {

struct RelightOptions {
    SceneOptions scene;
    RenderChoices render;
    std::string output;
    bool spin_light = false, orbit = false;
    std::vector<float> axis{0, 1, 0};  ///< Axis of the spin.
    std::vector<std::string> lights;   ///< Image files.
    /// Instance and path; each path is valid for path_points.
    std::vector<std::pair<std::string, std::string>> moves;
    /// Instance and degrees; the latter are valid for place_in.
    std::vector<std::pair<std::string, std::string>> turns;
    bool keyframes = false;  ///< Use the scene's keyframes.
    int frames = 48;
    int first_frame = 1, last_frame = 0;  ///< Range of rendered frames, counted from 1; 0: the last frame.
    std::string format = "png";
    std::string movie;
    int frames_per_second = 24;  ///< Of the movie.
};

/// Returns the positions of a path, `X,Y,Z:X,Y,Z:...`; none if one is invalid for place_in.
std::optional<std::vector<Vec3f>> path_points(std::string_view text);

/// The data from which frames are made.
struct RelightStage {
    const RelightOptions& options;
    Scene scene;  ///< Camera and instances are those of the current frame.
    RenderSettings settings;
    std::vector<Environment> environments;
    std::vector<LatLongImage> backgrounds;  ///< The environments as images.
    std::vector<float> weights;             ///< Of the environments, in the current frame.
    Rotation rotation;                      ///< Of the environments, in the current frame.
    RelightSession* session = nullptr;

    Rgb background(const Vec3f& direction) const;
};

/// A way to change a scene from frame to frame.
struct RelightMode {
    std::string name;
    std::function<Result<Done>(const Progress&)> prepare;  ///< Computes the transfer vectors.
    std::function<void(double share)> change;              ///< share: 0 in the first frame, 1 in the last.
    bool closed = false;     ///< The frame after the last would equal the first.
    bool by_vertex = false;  ///< Frames with fewer vertices cost less; see RelightSession::frame_of.
    bool rests = false;      ///< All frames but the last may be coarser; see FrameQuality.
    bool in_full = false;    ///< Without transfer vectors: every frame is a RelightSession::commit.
};

/// Returns the mode that the options select. The stage must outlive the mode, and its session must exist.
///
/// errors  --move or --rotate names an unknown instance or one instance twice; no keyframes.
Result<RelightMode> chosen_mode(RelightStage& stage);

}  // namespace haarfield
