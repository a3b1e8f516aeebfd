#pragma once
/// Concentrated light: sources in an environment that are so bright and small that the texels of a cubemap
/// would blur them.
///
/// An environment is split into a smooth remainder, represented by wavelets, and its sources: suns, lamps,
/// bright windows. Each source is represented by a few directions, which are evaluated exactly with shadow
/// rays and the BRDF.

#include <span>

#include "shading/scene/environment.h"

namespace haarfield {

/// Light from one direction.
struct DirectionalLight {
    Vec3f direction{0, 1, 0};  ///< Towards the light; unit length.
    Rgb irradiance{0, 0, 0};   ///< Radiance * solid angle: on a surface that faces the light. [W/m^2]
};

/// A sun, lamp or window.
struct LightSource {
    std::vector<DirectionalLight> lights;  ///< The few directions that represent it.
    std::vector<DirectionalLight> parts;   ///< Pixels of an image or fractions of them; 4,096 directions of a
                                           ///< disc.
    double share = 0;        ///< Of the environment's light: irradiance, summed over all directions.
    double solid_angle = 0;  ///< [sr]
};

/// The criteria for sources, and for the number of directions of a source.
///
/// Measured over real environments: thresholds between 10 and 1,000 make little difference to the picture;
/// fewer directions show as steps in penumbrae. A bright pixel is split before its source is divided into
/// directions: a single direction would cast a hard shadow.
struct SourceRule {
    double threshold = 100;             ///< A source consists of pixels above this multiple of the mean
                                        ///< luminance of the environment,
    double least_share = 0.002;         ///< in regions with at least this fraction of its light above their
                                        ///< surroundings.
    int least_lights = 4;               ///< The number of directions is the largest of this,
    double fraction_per_light = 0.005;  ///< share / this,
    double solid_angle_of_a_light = 1.5e-4;  ///< and solid_angle / this, [sr]
    int most_lights = 256;                   ///< but at most this.
    /// A pixel is split into squares until each has at most this fraction of the environment's light
    double fraction_per_direction = 0.0005;
    double solid_angle_per_direction = 1.5e-5;  ///< and this solid angle [sr],
    int most_splits = 16;                       ///< but along each edge into at most this number.
    /// Multiplies the number of directions and the number of squares of a pixel, with their limits.
    int direction_factor = 1;
};

/// The largest width of a smooth image. Wider images with even widths and heights are halved until they are
/// no wider. Four of its pixels span a texel of a cubemap with 256 texels per edge. [pixels]
inline constexpr int widest_smooth = 4096;

/// An environment, split into sources and the remainder.
struct SplitLight {
    LatLongImage smooth;               ///< The remainder of the image, reduced to widest_smooth.
    std::vector<LightSource> sources;  ///< Discs first, then regions of the image from the top.
};

/// Separates the sources from an environment: discs entirely; bright regions by the amount above the mean of
/// the surrounding pixels.
///
/// environment  clean (clean_environment).
/// accuracy     smooth image and sources together preserve the environment's energy, by channel, to 1e-5.
/// cost         about 20 ms for 1024 x 512 pixels; memory only for the smooth image and the sources.
SplitLight split_light(const Environment& environment, const SourceRule& rule = {});

/// Clusters the parts of a source into at most `count` lights. Repeatedly divides the cluster with the
/// largest product of light and extent; each cluster emits from its mean direction. The clusters are the same
/// for all lit points: directions that differ between vertices show as noise.
///
/// count    at least 1.
/// returns  the parts themselves if there are no more than `count`.
std::vector<DirectionalLight> reduced_lights(std::span<const DirectionalLight> parts, int count);

/// Returns the lights of all sources.
std::vector<DirectionalLight> all_lights(std::span<const LightSource> sources);

}  // namespace haarfield
