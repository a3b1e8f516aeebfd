#pragma once
/// The dense oracle against POV-Ray's ray tracer, point by point: if they disagree, one of them is wrong.

#include "bridge/povray/reference_picture.h"
#include "scenes/scene.h"
#include "shading/bake/dense_renderer.h"

namespace haarfield {

/// How well the dense oracle and POV-Ray agree.
struct OracleCheck {
    std::size_t points = 0;
    std::size_t agreeing = 0;    ///< Within what the reference is certain of; see oracle_check.
    double relative_rmse = 0;    ///< Oracle less reference, to the reference; over the points.
    double reference_error = 0;  ///< What the reference's own relative error is there, by its two halves.
    double bias = 0;             ///< Mean of the oracle / mean of the reference - 1.
};

/// Compares at random pixels' centres: the point that is seen there is shaded by the oracle, and no vertex or
/// interpolation comes between.
///
/// scene      with the original meshes, fine and as occluders, as the reference has them.
/// camera     of the picture, which has one ray a pixel.
/// face_size  of the oracle's cubemaps.
/// agreeing   root mean squares over the channels: the difference is at most 2.58 standard deviations (99 %)
///            of the reference's error, and the rounding of its half floats. The deviation is the RMS of the
///            reference's half difference within three pixels of the point, or what the whole picture's
///            relative error makes it, if that is more: the lights' errors are alike in neighbouring pixels.
/// cost       some milliseconds a point with faces of 64 texels, 30 with 256.
/// errors     interrupted.
Result<OracleCheck> oracle_check(const ShadedScene& scene, const Camera& camera,
                                 const ReferencePicture& reference, int face_size, std::size_t points,
                                 const Progress& progress = {});

}  // namespace haarfield
