#include "bridge/pictures/oracle_check.h"

#include <algorithm>
#include <cassert>
#include <memory>

#include "bridge/pictures/preview.h"
#include "fields/base/parallel_loop.h"
#include "fields/base/random_choice.h"

namespace haarfield {
namespace {

constexpr double certain = 2.576;          // standard deviations: 99 %
constexpr double half_rounding = 0x1p-11;  // relative, of the pictures' half floats

double mean_square(const Rgb& colour) {
    const Vec3d v(colour);
    return v.dot(v) / 3;
}

/// Returns the mean squared half difference of the reference within three pixels, where objects are visible.
double error_nearby(const ReferencePicture& reference, int column, int row) {
    constexpr int reach = 3;
    const Image& image = reference.image;
    double sum = 0;
    int count = 0;
    for (int y = std::max(0, row - reach); y <= std::min(image.height - 1, row + reach); ++y)
        for (int x = std::max(0, column - reach); x <= std::min(image.width - 1, column + reach); ++x) {
            const std::size_t i = std::size_t(y) * std::size_t(image.width) + std::size_t(x);
            if (image.coverage[i] < 0.5f) continue;
            sum += mean_square(reference.half_difference[i]);
            ++count;
        }
    return count > 0 ? sum / count : 0;
}

struct CheckedPixel {
    std::size_t pixel = 0;
    MeshPoint at;
    Rgb oracle{0.0f};
    bool counts = false;
};

std::vector<CheckedPixel> random_pixels(const ShadedScene& scene, const Camera& camera, const Image& image,
                                        std::size_t wanted) {
    const std::vector<std::optional<MeshPoint>> points = Preview().points(camera, preview_instances(scene));
    std::vector<CheckedPixel> pixels;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (points[i] && image.coverage[i] == 1) pixels.push_back({i, *points[i], {}, false});
    keep_random(pixels, wanted);
    return pixels;
}

}  // namespace

Result<OracleCheck> oracle_check(const ShadedScene& scene, const Camera& camera,
                                 const ReferencePicture& reference, int face_size, std::size_t points,
                                 const Progress& progress) {
    const Image& image = reference.image;
    assert(camera.width == image.width && camera.height == image.height && !image.coverage.empty());
    std::vector<CheckedPixel> pixels = random_pixels(scene, camera, image, points);
    const DenseScene dense(scene, face_size);
    const Result<Done> shaded = parallel_loop(
        {pixels.size()},
        [&]() -> LoopBody {
            return [&, shader = std::make_shared<DenseShader>(dense)](std::size_t k) {
                const MeshPoint& at = pixels[k].at;
                const auto point = surface_point(scene.entities[scene.instances[at.instance].entity], at);
                if (!point) return;
                // Shading starts at the point itself. On large objects, the offset of shading_point would
                // be visible.
                const ShadedInstance& instance = scene.instances[at.instance];
                ShadingPoint exactly = shading_point(scene, instance, *point);
                exactly.outside = exactly.from;
                pixels[k].oracle = shader->radiance(at.instance, *point, exactly).total();
                pixels[k].counts = true;
            };
        },
        "oracle", progress);
    if (!shaded) return shaded.error();

    OracleCheck check;
    double error = 0, own_error = 0, energy = 0, found = 0, wanted = 0;
    for (const CheckedPixel& pixel : pixels) {
        if (!pixel.counts) continue;
        const Rgb& exact = image.pixels[pixel.pixel];
        const int column = int(pixel.pixel) % image.width, row = int(pixel.pixel) / image.width;
        const double square = mean_square(pixel.oracle - exact),
                     variance = error_nearby(reference, column, row),
                     anywhere =
                         double(*image.relative_error) * double(*image.relative_error) * mean_square(exact),
                     rounding = half_rounding * half_rounding * mean_square(exact);
        ++check.points;
        check.agreeing += square <= certain * certain * std::max(variance, anywhere) + rounding;
        error += square;
        own_error += variance;
        energy += mean_square(exact);
        found += double(pixel.oracle.x) + double(pixel.oracle.y) + double(pixel.oracle.z);
        wanted += double(exact.x) + double(exact.y) + double(exact.z);
    }
    if (energy > 0) {
        check.relative_rmse = std::sqrt(error / energy);
        check.reference_error = std::sqrt(own_error / energy);
        check.bias = found / wanted - 1;
    }
    return check;
}

}  // namespace haarfield
