#pragma once
/// Two measures of perceptual difference between pictures. Both convert pictures to sRGB as a monitor
/// displays them.

#include "fields/base/vector.h"

#include <cstdint>
#include <span>
#include <vector>

namespace haarfield {

/// Returns the FLIP error in [0, 1] per pixel between two pictures of linear RGB, clamped to [0, 1].
///
/// pixels_per_degree  the viewer's resolution, > 0 (asserted).
/// accuracy           bit-identical for any number of threads.
/// cost               about 0.3 s for 640 x 480 on two cores.
/// source             Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astroem and Fairchild 2020, "FLIP: A
///                    Difference Evaluator for Alternating Images": contrast sensitivity filters in YCxCz,
///                    HyAB distance of Hunt-adjusted L*a*b*, edges and points of the luminance. Pixels at the
///                    border are repeated outwards.
std::vector<float> flip_errors(std::span<const Rgb> image, std::span<const Rgb> reference, int width,
                               int height, float pixels_per_degree);

/// Returns the mean structural similarity of two pictures of luma in [0, 1], over the pixels whose mask is 1;
/// at least one (asserted). In [-1, 1]; equal pictures have 1.
///
/// source    Wang, Bovik, Sheikh and Simoncelli 2004, "Image Quality Assessment: From Error Visibility to
///           Structural Similarity": 11 x 11 Gaussian window of sigma 1.5, K1 0.01, K2 0.03. Pixels outside
///           the picture or the mask have no weight in the window.
double structural_similarity(std::span<const float> image, std::span<const float> reference,
                             std::span<const std::uint8_t> mask, int width, int height);

}  // namespace haarfield
