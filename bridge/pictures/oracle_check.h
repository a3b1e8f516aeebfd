#pragma once
/// Compares the dense oracle with POV-Ray's ray tracer, point by point. If they disagree, one of them is
/// wrong.

#include "bridge/povray/reference_picture.h"
#include "scenes/scene.h"
#include "shading/bake/dense_renderer.h"

namespace haarfield {

/// The agreement of the dense oracle with POV-Ray.
struct OracleCheck {
    std::size_t points = 0;
    std::size_t agreeing = 0;  ///< Points that agree within the reference's uncertainty; see oracle_check.
    double relative_rmse = 0;  ///< Oracle minus reference, relative to the reference, over the points.
    /// Relative error of the reference at the points, estimated from its two halves.
    double reference_error = 0;
    double bias = 0;  ///< Mean of the oracle / mean of the reference - 1.
};

/// Compares radiance at the centres of random pixels. The oracle shades the surface point that is visible
/// there, so that neither vertices nor interpolation contribute.
///
/// scene      has the original meshes, fine and as occluders, as the reference has them.
/// camera     the camera of the picture, which has one ray per pixel.
/// face_size  width of the oracle's cubemap faces. [texels]
/// agreeing   a point agrees if the difference is at most 2.58 standard deviations (99 %) of the reference's
///            error plus the rounding of its half floats, as root mean squares over the channels. The
///            standard deviation is the larger of two estimates: the RMS of the reference's half difference
///            within three pixels, and the relative error of the whole picture, because the lights' errors
///            are alike in neighbouring pixels.
/// cost       a few milliseconds per point with faces of 64 texels, 30 ms with 256.
/// errors     interrupted.
Result<OracleCheck> oracle_check(const ShadedScene& scene, const Camera& camera,
                                 const ReferencePicture& reference, int face_size, std::size_t points,
                                 const Progress& progress = {});

}  // namespace haarfield
