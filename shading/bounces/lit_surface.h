#pragma once
/// The diffuse radiance of a scene's surfaces, with shadow edges inside triangles, and points on bright
/// surfaces from which other points gather light.

#include "shading/bounces/fine_surface.h"
#include "shading/scene/vertex_loop.h"

namespace haarfield {

/// Direct light inside triangles whose corners differ much. Each of these is divided into equal cells, which
/// are similar to the triangle: row by row from the edge between its first and second corners.
struct DirectDetail {
    static constexpr std::size_t steps = 8;              ///< Cells along each edge of a triangle.
    static constexpr std::size_t cells = steps * steps;  ///< Cells of a triangle.

    /// The numbers of divided triangles, by instance and triangle of the fine mesh; -1: not divided.
    std::vector<std::vector<std::int32_t>> places;
    /// By number of the triangle and cell: the diffuse radiance by direct light in the centre of the cell,
    /// less that interpolated between the corners of the triangle. [W/(m^2 sr)]
    std::vector<Rgb> differences;

    /// Returns the cell at a point of the triangle.
    ///
    /// u, v  weights of the second and third corners.
    static std::size_t cell_at(float u, float v);
    /// Returns the corners of a cell: their weights of the triangle's second and third corners.
    static std::array<Vec2f, 3> corners(std::size_t cell);
    /// Returns the weights of the triangle's corners in the centre of a cell.
    static std::array<float, 3> centre(std::size_t cell);
};

/// A triangle of an instance's fine mesh.
struct InstanceTriangle {
    std::uint32_t instance = 0, triangle = 0;
};

/// Returns the triangles inside which direct light may differ most from its interpolation: those with the
/// largest products of area and difference between corners, in the order of instances and triangles.
///
/// direct  diffuse radiance by direct light, with tints, by instance and vertex. [W/(m^2 sr)]
/// share   of the light of all surfaces below which a triangle's product is negligible.
/// most    the largest number of triangles.
std::vector<InstanceTriangle> uneven_triangles(const ShadedScene& scene, const SceneColours& direct,
                                               double share, std::size_t most);

/// Averages direct light over the surfaces around vertices, so that transport between vertices keeps the
/// light of patches whose edges cross triangles.
///
/// direct  as for uneven_triangles; changes at the corners of triangles with detail.
void average_detail(const ShadedScene& scene, const DirectDetail& detail, SceneColours& direct);

/// Lit surfaces. All radiance is diffuse.
class LitSurface {
public:
    /// A point of a bright surface, in the world.
    struct BrightPoint {
        Vec3f position;  ///< [m]
        Vec3f normal;    ///< Of the triangle; unit length.
        Rgb radiance;    ///< [W/(m^2 sr)]
        float density;   ///< Probability density of such points, as for density_at. [1/m^2]
    };

    /// radiance  direct and indirect, with tints, by instance and vertex. [W/(m^2 sr)]
    /// cost      some 0.3 us per triangle, and 5 us per triangle with detail.
    LitSurface(const ShadedScene& scene, const SceneColours& radiance, DirectDetail detail);

    /// Returns the radiance at a hit of the front of a surface. [W/(m^2 sr)]
    ///
    /// radiance  that of the constructor.
    Rgb radiance_at(const ShadedScene& scene, const SceneColours& radiance, const SurfaceHit& hit) const;
    /// Returns the probability density of bright points: the luminance of a triangle, or of its cell, over
    /// the integral of luminance over all surfaces. [1/m^2]
    float density_at(const ShadedScene& scene, const SceneColours& radiance, const SurfaceHit& hit) const;
    /// Returns bright points, systematically sampled along a curve through the scene.
    ///
    /// number  as for gathering_directions. Black scenes have no points.
    std::span<const BrightPoint> points(int number) const;

private:
    DirectDetail detail_;
    double whole_ = 0;                              ///< Integral of luminance over all surfaces. [W/sr]
    std::vector<std::vector<BrightPoint>> points_;  ///< By the logarithm of their number.
};

}  // namespace haarfield
