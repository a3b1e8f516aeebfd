#pragma once
/// The light at a place in a POV-Ray scene.

#include "bridge/povray_import/scene_survey.h"
#include "scenes/image.h"

namespace haarfield {

/// Renders what a place sees in all directions, as a lat-long image in a right-handed frame with y up.
///
/// query      what to render. Its size, arguments and camera are replaced.
/// place      in the file's coordinates.
/// frame      scene_frame of the file.
/// width      even; twice the height. [pixels]
/// is_legacy  the picture is decoded from what POV-Ray displays, because the scene has no linear light.
///            Radiance is then at most 1.
/// errors     those of SceneQueries::answer.
/// cost       one run of POV-Ray.
Result<Image> rendered_light(const SceneQueries& queries, SceneQuery query, const Vec3d& place,
                             const AffineMap& frame, int width, bool is_legacy,
                             const Progress& progress = {});

/// Options of a light probe.
struct LightProbe {
    QueryOptions queries{};
    Vec3d place{0, 0, 0};              ///< In the file's coordinates.
    std::vector<std::string> without;  ///< Names or keywords of top-level objects that are left out.
    int width = 1024;                  ///< Of the lat-long image, even. [pixels]
    std::optional<bool> z_up{};        ///< The file's z axis points up; none: found from the camera.
    bool lights = true;                ///< The image has discs that represent the scene's lights.
    /// The scene ends with its own `#version`, on which ambient light under radiosity depends. Scenes that
    /// display their numbers without gamma then need `without_gamma`.
    bool keeps_version = false;
    std::string objects{};  ///< Further objects in POV-Ray's language; may be empty.
    /// Replaces the scene's `assumed_gamma` by 1: the image has the numbers with which POV-Ray computes.
    /// Colours of the scene's images are then approximate.
    bool without_gamma = false;
};

/// The light at a place.
struct ProbedLight {
    Image light;             ///< Lat-long, linear, in a right-handed frame with y up.
    SceneFrame frame;        ///< Of the file's coordinates.
    std::size_t lights = 0;  ///< Number of the file's lights that are in the image.
};

/// Returns the exponent with which POV-Ray converts the numbers of a scene to linear light: its
/// `assumed_gamma`, or 1. Exponents within 0.01 of 1 are 1.
///
/// errors  those of SceneQueries::answer.
/// cost    one run of POV-Ray.
Result<double> gamma_of_scene(const SceneQueries& queries, const Progress& progress = {});

/// A point at which a light's direct light is measured.
struct LitPlace {
    Vec3d place{0, 0, 0};   ///< In the file's coordinates.
    std::size_t light = 0;  ///< Index in SceneSurvey::lights.
};

/// Measures the fraction of the light of lights that reaches points: 1 if nothing occludes it, less in
/// shadows, coloured behind filters. POV-Ray shades a small white surface that faces the light.
///
/// size           distance of that surface from the place, towards the light. At least 0.02 units.
/// samples        those of one place are neighbours.
/// without_gamma  as LightProbe::without_gamma.
/// returns        a fraction for each sample, in [0, 1]; 0 where the light does not point at the place.
/// errors         those of SceneQueries::answer.
/// cost           one run of POV-Ray.
Result<std::vector<Rgb>> light_transmittances(const SceneQueries& queries, const SceneSurvey& survey,
                                              std::span<const LitPlace> samples, double size,
                                              bool without_gamma, const Progress& progress = {});

/// Renders the light at a place: the scene as POV-Ray shows it, with radiosity and media if the file has
/// them. Lights are discs with an angular radius of one degree and their irradiance at the place, where
/// nothing occludes them.
///
/// errors  those of SceneQueries; a name in `without` that the scene does not have.
/// cost    five runs of POV-Ray.
Result<ProbedLight> probed_light(const std::filesystem::path& file, const LightProbe& probe,
                                 const Progress& progress = {});

/// Renders the light at a place of a scene that has been surveyed.
///
/// errors  as above.
/// cost    one run of POV-Ray.
Result<ProbedLight> probed_light(const SceneQueries& queries, const SceneSurvey& survey,
                                 const LightProbe& probe, const Progress& progress = {});

}  // namespace haarfield
