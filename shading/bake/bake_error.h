#pragma once
/// The error of a bake over the pixels of a picture, or over its surfaces, with its causes.

#include "shading/bake/mesh_refinement.h"

namespace haarfield {

/// A point at which a bake is displayed.
struct DisplayedPoint {
    MeshPoint at;  ///< Of the fine mesh of its instance's entity.
    /// Factors on both components, such as the colour of an image.
    Rgb diffuse{1.0f}, specular{1.0f};
    std::uint32_t pixel = 0;  ///< Its number in the picture, row by row from the top.

    /// Returns the radiance that is displayed if the shading has this radiance. [W/(m^2 sr)]
    Vec3d displayed(const Outgoing& radiance) const {
        return Vec3d(radiance.diffuse * diffuse + radiance.specular * specular);
    }
};

/// Returns points that are uniformly distributed over the area of all fine meshes, without buried triangles.
///
/// source  systematic sampling: the k-th point has the area (k + 1/2) / count below it.
std::vector<DisplayedPoint> area_points(const ShadedScene& scene, std::size_t count);

/// An estimate of a mean square. It may be negative by chance.
struct SquareEstimate {
    double square = 0;
    std::vector<double> resampled;  ///< By bootstrap-t: their quantiles are the ends of intervals.
};

/// The point with the largest known error.
struct WorstPoint {
    DisplayedPoint point;
    double error = 0;         ///< Relative to the RMS radiance over all points.
    bool is_between = false;  ///< True: between the vertices. False: of the shading itself.
};

/// The error of a bake: RMS over points, relative to the RMS of their radiance. Radiance is linear and
/// displayed: it includes images, but no emission and no background.
struct BakeError {
    double total = 0;
    double low = 0, high = 0;    ///< The 90 % interval of `total`.
    double between = 0;          ///< By interpolation between the vertices.
    double at_vertices = 0;      ///< Of the direct light where it is computed.
    double indirect = 0;         ///< Of the indirect light where it is computed.
    double shading = 0;          ///< Of both, where they are computed.
    std::size_t points = 0;      ///< At which interpolation was measured.
    std::size_t references = 0;  ///< At which the shading was compared with rays and paths.
    WorstPoint worst;
};

/// Measures the error of bakes of one scene in one light.
///
/// The difference between a bake b and the truth has two summands: the interpolated value less the bake's own
/// shading s of the point, and the error of that shading. The latter is measured against rays
/// (ray_renderer.h) and paths (path_tracer.h), which use no fields, no wavelets and no transport matrix. Two
/// independent estimates r1, r2 at each point give its mean square as the mean of (s - r1) (s - r2), to which
/// the noise of neither contributes. The total includes the product of both summands, the mean of
/// 2 (b - s) (s - r): where interpolation smooths noise of the shading, the bake is closer to the truth than
/// either summand says.
///
/// Errors are relative to the RMS radiance. Its direct light is measured with few rays at up to 131,072
/// points, because a few highlights may contribute most of it. The indirect light is that of the bake's
/// shading at 2,048 points.
///
/// accuracy  bit-identical for any number of threads.
/// cost      about 1 s of processor time for the RMS radiance, once for all meters of a scene.
class BakeErrorMeter {
public:
    /// shading     with its indirect light, if there is any. It must outlive the meter.
    /// population  all displayed points. Buried points are left out when they are chosen.
    BakeErrorMeter(const PointShading& shading, std::vector<DisplayedPoint> population);

    /// Measures another shading of the same scene at the same points. Both share the references of direct
    /// light, so that they must not be used at the same time.
    BakeErrorMeter(const PointShading& shading, const BakeErrorMeter& other);
    BakeErrorMeter(BakeErrorMeter&&) noexcept;             ///< The other one may only be destroyed.
    BakeErrorMeter& operator=(BakeErrorMeter&&) noexcept;  ///< Likewise.
    ~BakeErrorMeter();

    /// The values that a bake displays at a point.
    struct Displayed {
        Outgoing radiance;
        float difference = 0;  ///< MeshRefiner::Located::difference.
    };
    /// The function that returns it for any point of the population.
    using DisplayedRadiance = std::function<Displayed(const MeshPoint&)>;

    /// A point at which the shading was compared with references.
    struct Reference {
        DisplayedPoint point;
        Vec3d shaded{0.0};  ///< What the bake's shading displays. [W/(m^2 sr)]
        /// Shading less the mean of both references, for either kind of light; indirect light was compared at
        /// some points only.
        Vec3d direct{0.0}, indirect{0.0};
        double direct_product = 0, indirect_product = 0;  ///< (s - r1) (s - r2).
        double mixed_product = 0;  ///< Of the direct difference and the indirect one, in both orders.
        bool has_indirect = false;
    };
    /// The error of the shading itself.
    struct Shading {
        SquareEstimate all, direct, indirect;  ///< Relative to the mean square of the radiance.
        std::vector<Reference> references;
    };
    /// Measures the error of the shading at points that are the same each time.
    ///
    /// accuracy  to be reached: noise of the references is small compared with an error of this size. Where
    ///           little light arrives, as in a room with a window, they have up to 64 times as many samples.
    /// count     of points; indirect light is compared at the first 128 of them.
    /// cost      about 1 s of processor time for 512 points and an accuracy of 0.01; some 10 s in rooms where
    ///           paths are noisy.
    /// errors    interrupted.
    Result<Shading> shading_error(double accuracy, const Progress& progress = {}, std::size_t count = 512);

    /// References of points with a common probability.
    struct Stratum {
        double weight = 0;  ///< The share of the population.
        std::vector<Reference> references;
    };
    /// The error of interpolation.
    struct Interpolation {
        SquareEstimate square;
        WorstPoint worst;
        std::size_t points = 0;
        std::vector<Stratum> strata;  ///< Empty: without references.
        /// The points that each contribute more than a 64th of the wanted mean square, with their radiance.
        std::vector<MeshRefiner::KnownPoint> largest;
    };
    /// Measures interpolation at uniformly distributed points that are the same each time, so that only the
    /// first measurement shades points.
    ///
    /// wanted  as in interpolation_error.
    /// errors  interrupted.
    Result<Interpolation> steering_error(const DisplayedRadiance& bake, const Progress& progress = {},
                                         double wanted = 0);

    /// Measures interpolation at other points for each seed: strata by octaves of Displayed::difference, with
    /// Neyman's allocation.
    ///
    /// wanted  error that Interpolation::largest refers to; 0: none is listed.
    /// cost    50 us for each of `count` points.
    /// errors  interrupted.
    Result<Interpolation> interpolation_error(const DisplayedRadiance& bake, std::uint32_t seed,
                                              std::size_t count = 2048, const Progress& progress = {},
                                              double wanted = 0);

    /// Measures interpolation at more points, and compares the shading of some of them with references.
    ///
    /// accuracy  as for shading_error. If the error of interpolation is smaller, the noise is small compared
    ///           with that, down to half of the accuracy or 0.005, whichever is less.
    /// cost      1.0 to 1.1 s of processor time for an accuracy of 0.01, measured in two scenes of 4 and 5
    ///           instances.
    /// errors    interrupted.
    Result<Interpolation> reported_error(const DisplayedRadiance& bake, std::uint32_t seed, double accuracy,
                                         const Progress& progress = {});

    /// Returns the error of a bake by both summands. `shading` may be empty; its references serve if
    /// `between` has none.
    BakeError error(const DisplayedRadiance& bake, const Interpolation& between,
                    const Shading& shading) const;

private:
    struct Truth;
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace haarfield
