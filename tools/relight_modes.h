#pragma once
/// What `relight` changes from frame to frame: the light, the view or where instances stand.

#include "scenes/scene.h"
#include "tools/scene_options.h"
#include "tools/seen_session.h"

namespace haarfield {

struct RelightOptions {
    SceneOptions scene;
    RenderChoices render;
    std::string output;
    bool spin_light = false, orbit = false;
    std::vector<float> axis{0, 1, 0};                        ///< Of the spin.
    std::vector<std::string> lights;                         ///< Files.
    std::vector<std::pair<std::string, std::string>> moves;  ///< Instance and path, which has path_points.
    std::vector<std::pair<std::string, std::string>> turns;  ///< Instance and degrees, which are a place_in.
    bool keyframes = false;                                  ///< The scene's.
    int frames = 48;
    int first_frame = 1, last_frame = 0;  ///< Those that are made, counted from 1; 0: the last there is.
    std::string format = "png";
    std::string movie;
    int frames_per_second = 24;  ///< Of the movie.
};

/// The places of a path, `X,Y,Z:X,Y,Z:...`; none if one is no place_in.
std::optional<std::vector<Vec3f>> path_points(std::string_view text);

/// What the frames are made of.
struct RelightStage {
    const RelightOptions& options;
    Scene scene;  ///< Its camera and instances are those of the frame at hand.
    RenderSettings settings;
    std::vector<Environment> environments;
    std::vector<LatLongImage> backgrounds;  ///< The same as pictures.
    std::vector<float> weights;             ///< Of the environments, in the frame at hand.
    Rotation rotation;                      ///< Of the environments, in the frame at hand.
    SeenSession* session = nullptr;

    Rgb background(const Vec3f& direction) const;
};

/// One way to change a scene from frame to frame.
struct RelightMode {
    std::string name;
    std::function<Result<Done>(const Progress&)> prepare;  ///< Makes the transfer vectors.
    std::function<void(double share)> change;              ///< share: 0 in the first frame, 1 in the last.
    bool closed = false;     ///< The frame after the last would be the first one again.
    bool by_vertex = false;  ///< Frames of fewer vertices cost less: see RelightSession::frame_of.
    bool rests = false;      ///< All frames but the last may be coarser: see FrameQuality.
    bool in_full = false;    ///< Without transfer vectors: every frame is RelightSession::commit.
};

/// The mode that the options ask for. The stage must outlive it, and its session be there.
///
/// errors  --move or --rotate names no instance, or one twice; there are no keyframes.
Result<RelightMode> chosen_mode(RelightStage& stage);

}  // namespace haarfield
