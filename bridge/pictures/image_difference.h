#pragma once
/// Measures the difference between two pictures, as numbers and as a picture.

#include "scenes/image.h"

#include <array>

namespace haarfield {

/// The difference between two pictures. All measures use the same pixels: those in the mask.
struct ImageDifference {
    std::uint64_t pixels = 0;  ///< The number of pixels in the mask.
    double rmse = 0;           ///< Root mean square over pixels and channels. [W/(m^2 sr)]
    /// rmse / root mean square of the reference; 0 if both are 0, infinite if only the reference is 0.
    double relative_rmse = 0;
    double bias = 0;     ///< Mean of image / mean of reference - 1. Positive: the image is brighter.
    double psnr_db = 0;  ///< Of sRGB values clamped to [0, 1]; at most 99 (equal images).
    double ssim = 0;     ///< Of sRGB luma, 1: equal.
    double flip = 0;     ///< Mean perceptual error. 0: equal, 1: black and white.
    double flip_99 = 0;  ///< 99 % of the pixels have at most this perceptual error.
    std::vector<float> flip_errors;  ///< Perceptual error per pixel, in [0, 1]; 0 outside the mask.
    std::vector<std::uint8_t> mask;  ///< 1: the pixel is compared.
};

/// The pixels to compare, and the viewing conditions.
struct ImageDifferenceOptions {
    /// If not empty: a picture of the same size. Pixels are compared where its luminance is at least 1/2.
    Image mask;
    /// The viewer's resolution, for flip: 67 is a 0.7 m wide 4K monitor at a distance of 0.7 m. [1/degree]
    float pixels_per_degree = 67;
};

/// Compares an image with a reference.
///
/// mask      a pixel is compared if both images cover at least half of it (an image without coverage covers
///           everything) and options.mask includes it.
/// ssim      Wang, Bovik, Sheikh and Simoncelli 2004: 11 x 11 Gaussian window of sigma 1.5, K1 0.01, K2 0.03.
///           Pixels outside the mask have no weight in the window.
/// flip      after Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astroem and Fairchild 2020, "FLIP: A
///           Difference Evaluator for Alternating Images", on sRGB values clamped to [0, 1]. Simplified:
///           pixels outside the mask are made equal in both images instead of being cut out.
/// cost      about 0.5 s for 640 x 480. Deterministic for any number of threads.
/// errors    different sizes; non-finite radiance (with its pixel); an empty mask.
Result<ImageDifference> image_difference(const Image& image, const Image& reference,
                                         const ImageDifferenceOptions& options = {});

/// Returns the colour of a perceptual error in [0, 1]: magma, dark for 0. sRGB-encoded, each in [0, 255].
std::array<std::uint8_t, 3> error_colour(float error);

/// Returns the perceptual error as a picture in error_colour. Pixels outside the mask are transparent.
///
/// brightest  the error that gets the brightest colour, > 0 (asserted).
Image difference_picture(const ImageDifference& difference, int width, int height, float brightest);

/// Counts the masked pixels whose perceptual error is in each of `bins` equal intervals of [0, upper]. The
/// last interval includes larger errors.
std::vector<std::uint64_t> error_histogram(const ImageDifference& difference, int bins, float upper);

}  // namespace haarfield
