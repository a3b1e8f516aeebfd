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
};

/// The light at a place.
struct ProbedLight {
    Image light;             ///< Lat-long, linear, in a right-handed frame with y up.
    AffineMap frame;         ///< From the file's coordinates to that frame.
    std::size_t lights = 0;  ///< Number of the file's lights that are in the image.
};

/// Renders the light at a place: the scene as POV-Ray shows it, with radiosity and media if the file has
/// them. Lights are discs with an angular radius of one degree and their irradiance at the place, where
/// nothing occludes them.
///
/// errors  those of SceneQueries; a name in `without` that the scene does not have.
/// cost    four runs of POV-Ray.
Result<ProbedLight> probed_light(const std::filesystem::path& file, const LightProbe& probe,
                                 const Progress& progress = {});

}  // namespace haarfield
