#pragma once
/// Importance sampling of distant light and of emitters for rays.

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "fields/base/embree_device.h"
#include "shading/scene/emitter.h"
#include "shading/scene/environment.h"

namespace haarfield {

/// A sampled direction towards light.
struct LightSample {
    Vec3f direction;  ///< Unit length.
    Rgb radiance;     ///< Radiance from that direction. [W/(m^2 sr)]
    double density;   ///< Probability density of the direction. [1/sr]
    float distance;   ///< To an emitter; far_away for distant light. [m]
    bool is_disc;     ///< From a sun, which no other technique samples.
};

/// The shares of points that distant light reaches, by direction.
struct ArrivingShares {
    static constexpr int rows = 16, columns = 32;
    /// By cell. Cells have equal angles, as the pixels of a lat-long image do; shares are positive.
    std::array<float, std::size_t(rows) * columns> cells;
    std::vector<float> suns;  ///< Of Environment::suns; positive.

    /// Returns the share of a pixel's directions.
    float of_pixel(int row, int column, const LatLongImage& image) const {
        return cells[std::size_t(row * rows / image.height * columns + column * columns / image.width)];
    }
};

/// Samples directions in proportion to an environment's luminance, times the share of points that it reaches:
/// pixels by their inverse CDF, and uniformly within the solid angle of a pixel; discs uniformly.
class EnvironmentSampler {
public:
    /// The environment must outlive it.
    ///
    /// shares  none: all are 1.
    explicit EnvironmentSampler(const Environment& environment,
                                std::optional<ArrivingShares> shares = std::nullopt);

    bool is_black() const { return !(total_ > 0); }  ///< True if there is nothing to sample.

    /// place  in the unit square.
    LightSample sample(const std::array<double, 2>& place) const;

    /// Returns the radiance of the image in a direction, without discs, and the density of sampling it.
    void look_up(const Vec3f& direction, Rgb& radiance, double& density) const;

private:
    /// Returns the density of directions in a pixel with this radiance. [1/sr]
    double density_of(const Rgb& radiance, int row, int column) const;
    double share_of(int row, int column) const;
    double share_of_sun(std::size_t sun) const { return shares_ ? double(shares_->suns[sun]) : 1; }

    const Environment* environment_;
    std::optional<ArrivingShares> shares_;
    std::vector<double> rows_,
        columns_;                ///< Running sums of luminance * solid angle * share: of rows; in each row.
    std::vector<double> discs_;  ///< Running sums, continuing those of the rows.
    double total_ = 0;
};

/// Samples points of emitters in proportion to radiance times area.
class EmitterSampler {
public:
    /// Builds a BVH of the emitters, given in the world.
    explicit EmitterSampler(std::vector<Emitter> emitters);

    bool is_black() const { return emitters_.empty(); }  ///< True if there is nothing to sample.

    /// Returns none if the sampled point faces away.
    std::optional<LightSample> sample(const Vec3f& from, const std::array<double, 2>& place) const;

    /// Returns the nearest emitter in a direction if its front faces the point, with the density of sampling
    /// that direction.
    std::optional<LightSample> look_up(const Vec3f& from, const Vec3f& direction) const;

private:
    std::optional<LightSample> seen(std::size_t emitter, const Vec3f& from, const Vec3d& to) const;

    std::vector<Emitter> emitters_;
    std::vector<double> chances_;  ///< Running sums of luminance * area.
    std::vector<Vec3d> normals_;   ///< Unit length.
    EmbreeDevice device_;
    std::shared_ptr<RTCSceneTy> scene_;
};

}  // namespace haarfield
