#pragma once
/// Concentrated light: what of an environment is so bright and so small that texels of a cubemap would blur
/// it.
///
/// An environment is split into a smooth remainder, which wavelets serve well, and its sources: suns, lamps,
/// bright windows. Each source is cut into a few directions, which shadow rays and the BRDF itself then serve
/// exactly.

#include <span>

#include "shading/scene/environment.h"

namespace haarfield {

/// Light from one direction.
struct DirectionalLight {
    Vec3f direction{0, 1, 0};  ///< Towards the light; unit length.
    Rgb irradiance{0, 0, 0};   ///< Radiance * solid angle: on a surface that faces it. [W/m^2]
};

/// One sun, lamp or window.
struct LightSource {
    std::vector<DirectionalLight> lights;  ///< The few that stand for it.
    std::vector<DirectionalLight> parts;   ///< Pixels of an image or fractions of them; 4,096 of a disc.
    double share = 0;        ///< Of the environment's light: irradiance, summed over all directions.
    double solid_angle = 0;  ///< [sr]
};

/// What counts as a source, and into how many directions it is cut.
///
/// Measured over real environments: between 10 and 1,000 the threshold matters little to the picture; fewer
/// directions than these show as steps in penumbrae. A bright pixel is split before its source is cut into
/// directions: as a single point it would cast a hard shadow.
struct SourceRule {
    double threshold = 100;      ///< Pixels of so many times the environment's mean luminance,
    double least_share = 0.002;  ///< in regions that have so much of its light, above what surrounds them.
    int least_lights = 4;        ///< As many directions as the greatest of these asks for:
    double share_of_a_light = 0.005;         ///< share / this,
    double solid_angle_of_a_light = 1.5e-4;  ///< solid angle / this. [sr]
    int most_lights = 256;                   ///< A source.
    /// A pixel is split into squares until each has at most this share of the environment's light
    double share_of_a_part = 0.0005;
    double solid_angle_of_a_part = 1.5e-5;  ///< and this solid angle [sr],
    int most_splits = 16;                   ///< but along each edge into at most so many.
};

/// An environment, parted.
struct SplitLight {
    LatLongImage smooth;               ///< What remains of the image.
    std::vector<LightSource> sources;  ///< Discs first, then regions of the image from the top.
};

/// Takes the sources out of an environment: discs whole, of a bright region what is above the mean of the
/// pixels around it.
///
/// environment  clean (clean_environment).
/// accuracy     smooth image and parts have the environment's energy, by channel, to 1e-5.
/// cost         some 20 ms for 1024 x 512 pixels.
SplitLight split_light(const Environment& environment, const SourceRule& rule = {});

/// A source's parts as so many lights or fewer: cut in two again and again, always the piece of the most
/// light times extent; each piece sheds its light from its mean direction. The same for all points that are
/// lit, since directions that differ from vertex to vertex show as noise.
///
/// count    at least 1.
/// returns  the parts themselves if they are no more than that.
std::vector<DirectionalLight> few_lights(std::span<const DirectionalLight> parts, int count);

/// The lights of all sources.
std::vector<DirectionalLight> all_lights(std::span<const LightSource> sources);

}  // namespace haarfield
