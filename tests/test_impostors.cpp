#include "shading/visibility/impostors.h"

#include <gtest/gtest.h>

#include "fields/model/mesh_reader.h"
#include "fields/rasterizer/visibility_rasterizer.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/random_numbers.h"

namespace haarfield {
namespace {

constexpr int size = 64;

/// Returns smooth but uneven radiance.
double smooth_light(const Vec3f& direction) {
    return 0.3 + 1.5 * std::exp(3 * double(direction.dot(Vec3f(0.48f, 0.6f, 0.64f)) - 1));
}

/// Weights texels for the irradiance of a surface under that light.
class Irradiance {
public:
    explicit Irradiance(const Vec3f& normal) {
        for (int face = 0; face < cubemap_faces; ++face)
            for (int row = 0; row < size; ++row)
                for (int column = 0; column < size; ++column) {
                    const Vec3f direction = texel_direction(face, column, row, size);
                    weight_.push_back(std::max(0.0, double(direction.dot(normal))) * smooth_light(direction) *
                                      texel_solid_angle(column, row, size));
                }
    }

    /// Returns the irradiance. open: in units of 1 / whole.
    double operator()(std::span<const std::uint8_t> open, double whole) const {
        double sum = 0;
        for (std::size_t i = 0; i < weight_.size(); ++i) sum += weight_[i] * open[i];
        return sum / whole;
    }

private:
    std::vector<double> weight_;
};

const Mesh& chair() {
    static const Mesh mesh = read_mesh(HAARFIELD_SOURCE_DIR "/scenes/meshes/chair.obj")->mesh;
    return mesh;
}

/// Irradiance around an occluder, relative to the unoccluded one.
class SeenFromAfar {
public:
    explicit SeenFromAfar(const Mesh& mesh, const Rotation& rotation = {})
        : occluder_(make_occluder(mesh)),
          turned_(turned_occluder(occluder_, rotation)),
          placement_{{3, -1, 2}, 0.7f, rotation},
          impostors_(*Impostors::make(occluder_, size)) {}

    /// Irradiance at a point with a distance in radii from the centre, on a surface that partly faces the
    /// occluder.
    struct Found {
        double exact, impostors;
        double error() const { return impostors - exact; }
    };
    Found operator()(const Vec3f& direction, float distance, const Vec3f& normal) {
        const Vec3f point = placement_.point_to_world(occluder_.bounds().centre()) +
                            direction * (distance * occluder_.bounds().radius() * placement_.scale);
        const Irradiance irradiance(normal);
        std::vector<std::uint8_t> open(cubemap_faces * size * size, 255);
        const double whole = irradiance(open, 255);
        impostors_.hide(placement_, point, open);
        return {irradiance(rasterizer_.open_samples(turned_, placement_.point_to_turned(point)),
                           samples_per_texel) /
                    whole,
                irradiance(open, 255) / whole};
    }

private:
    const Occluder occluder_, turned_;
    const Placement placement_;
    const Impostors impostors_;
    VisibilityRasterizer rasterizer_{size};
};

TEST(Impostors, OccludeAsTheOccluderDoesFromAllDirections) {
    const Rotation turned = rotation_xyz({0.4f, 1.1f, -0.3f});
    const std::pair<Mesh, float> seen_meshes[] = {{box_mesh({-1, 0, -1}, {1, 2, 1}), 1}, {chair(), 0.4f}};
    for (const auto& [mesh, share] : seen_meshes)
        for (const Rotation& rotation : {Rotation(), turned}) {
            SeenFromAfar seen(mesh, rotation);
            std::mt19937 random(3);
            for (const auto [nearest, farthest, tolerance] :
                 {std::array{2.0f, 3.0f, 0.003f}, std::array{3.0f, 6.0f, 0.0013f},
                  std::array{6.0f, 12.0f, 0.00025f}, std::array{12.0f, 50.0f, 0.0001f},
                  std::array{50.0f, 300.0f, 0.00005f}}) {
                double squares = 0;
                constexpr int count = 120;
                for (int k = 0; k < count; ++k) {
                    const Vec3f direction = random_direction(random);
                    const auto found =
                        seen(direction, nearest * std::pow(farthest / nearest, float(k) / count), -direction);
                    squares += found.error() * found.error() / count;
                }
                EXPECT_LT(std::sqrt(squares), tolerance * (nearest < 6 ? share : 1))
                    << mesh.triangles.size() << ", from " << nearest;
            }
        }
}

TEST(Impostors, ChangeContinuouslyWithTheDistance) {
    SeenFromAfar seen(chair(), rotation_xyz({0.4f, 1.1f, -0.3f}));
    const Vec3f direction = Vec3f(0.7f, 0.5f, -0.3f).normalized();
    double before = -1, largest = 0;
    for (float distance = 2; distance < 60; distance *= 1.01f) {
        const double now = seen(direction, distance, Vec3f(-1, 0.2f, 0).normalized()).impostors;
        if (before >= 0) largest = std::max(largest, std::abs(now - before));
        before = now;
    }
    EXPECT_LT(largest, 1.5e-3);
}

TEST(Impostors, OccludeNothingInsideTheirSphere) {
    const Occluder box = make_occluder(box_mesh({-1, -1, -1}, {1, 1, 1}));
    const Impostors impostors = *Impostors::make(box, size);
    std::vector<std::uint8_t> open(cubemap_faces * size * size, 200);
    for (const float x : {0.0f, 0.5f, 1.7f}) impostors.hide({}, {x, 0, 0}, open);
    EXPECT_EQ(std::ranges::count(open, 200), std::ptrdiff_t(open.size()));
}

TEST(Impostors, AnInterruptionIsAnError) {
    std::stop_source stop;
    stop.request_stop();
    EXPECT_FALSE(Impostors::make(make_occluder(chair()), size, stop.get_token()));
}

}  // namespace
}  // namespace haarfield
