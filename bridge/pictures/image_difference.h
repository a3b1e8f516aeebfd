#pragma once
/// How far two pictures are apart, as numbers and as a picture.

#include "scenes/image.h"

#include <array>

namespace haarfield {

/// All measures are taken over the same pixels: those that count.
struct ImageDifference {
    std::uint64_t pixels = 0;  ///< That count.
    double rmse = 0;           ///< Root mean square over pixels and channels. [W/(m^2 sr)]
    /// rmse / root mean square of the reference; 0 if both are 0, infinite if only the latter.
    double relative_rmse = 0;
    double bias = 0;                 ///< Mean of image / mean of reference - 1; > 0: image is brighter.
    double psnr_db = 0;              ///< Of sRGB values clamped to [0, 1]; 99 at most (equal images).
    double ssim = 0;                 ///< Of sRGB luma, 1: equal.
    double flip = 0;                 ///< Mean perceptual error, 0: equal, 1: black against white.
    double flip_99 = 0;              ///< 99 % of the pixels have at most this perceptual error.
    std::vector<float> flip_errors;  ///< Perceptual error per pixel, in [0, 1]; 0 outside the mask.
    std::vector<std::uint8_t> mask;  ///< 1: the pixel counts.
};

/// Which pixels are compared, and how they are looked at.
struct ImageDifferenceOptions {
    /// If not empty: a picture of the same size; pixels count where its luminance is at least 1/2.
    Image mask;
    /// Of the viewer of flip: 67 is a 0.7 m wide 4K monitor at 0.7 m. [1/degree]
    float pixels_per_degree = 67;
};

/// Compares an image with a reference.
///
/// mask      a pixel counts where both images cover it by half or more (an image without coverage covers
///           everything), and where the mask says so.
/// ssim      Wang, Bovik, Sheikh and Simoncelli 2004: 11 x 11 Gaussian window of sigma 1.5, K1 0.01,
///           K2 0.03. Pixels that do not count have no weight in the window.
/// flip      after Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astroem and Fairchild 2020, "FLIP: A
///           Difference Evaluator for Alternating Images", on sRGB values clamped to [0, 1]. Simplified:
///           pixels that do not count are made equal in both images, not cut out.
/// cost      some 0.5 s for 640 x 480. Deterministic for any number of threads.
/// errors    sizes differ; non-finite radiance (says where); no pixel counts.
Result<ImageDifference> image_difference(const Image& image, const Image& reference,
                                         const ImageDifferenceOptions& options = {});

/// The colour of a perceptual error in [0, 1]: magma, dark for 0. sRGB-encoded, each in [0, 255].
std::array<std::uint8_t, 3> error_colour(float error);

/// The perceptual error as a picture in error_colour; what does not count is transparent.
///
/// brightest  the error that gets the brightest colour, > 0 (asserted).
Image difference_picture(const ImageDifference& difference, int width, int height, float brightest);

/// How many of the pixels that count have a perceptual error in each of `bins` equal parts of
/// [0, upper]; larger errors are in the last one.
std::vector<std::uint64_t> error_histogram(const ImageDifference& difference, int bins, float upper);

}  // namespace haarfield
