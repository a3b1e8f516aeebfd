#include "bridge/reference_picture.h"

#include "bridge/povray_scene.h"
#include "bridge/reference_scene.h"

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

/// The mean of two pictures of the same objects, with its error.
Image mean_picture(const Image& a, const Image& b) {
    Image mean = a;
    double difference = 0, radiance = 0;
    for (std::size_t i = 0; i < mean.pixels.size(); ++i) {
        mean.pixels[i] = (a.pixels[i] + b.pixels[i]) * 0.5f;
        if (!mean.coverage.empty()) {
            mean.coverage[i] = 0.5f * (a.coverage[i] + b.coverage[i]);
            if (mean.coverage[i] < 0.5f) continue;
        }
        for (int c = 0; c < 3; ++c) {
            const double half = 0.5 * (double(a.pixels[i][c]) - double(b.pixels[i][c]));
            difference += half * half;
            radiance += double(mean.pixels[i][c]) * double(mean.pixels[i][c]);
        }
    }
    mean.relative_error = radiance > 0 ? static_cast<float>(std::sqrt(difference / radiance)) : 0.0f;
    return mean;
}

}  // namespace

Result<ReferencePicture> rendered_reference(const std::filesystem::path& scene, const PovrayOptions& options,
                                            const Progress& progress) {
    ReferencePicture picture;
    std::array<Image, 2> halves;
    const std::array<const char*, 2> alone{first_lights_alone, second_lights_alone};
    for (std::size_t set = 0; set < 2; ++set) {
        PovrayOptions objects = options;
        objects.declarations.push_back(without_background);
        objects.declarations.push_back(alone[set]);
        Progress part = progress;
        if (progress.report)
            part.report = [&progress, set](std::string_view stage, std::uint64_t done, std::uint64_t total) {
                progress.report(stage, set * total + done, 2 * total);
            };
        Result<RenderedScene> half = rendered_scene(scene, objects, part);
        if (!half) return half.error();
        picture.run[set] = std::move(half->run);
        halves[set] = std::move(half->image);
    }
    picture.image = mean_picture(halves[0], halves[1]);
    return picture;
}

LightEstimate estimated_lights(int fewer, double error_of_fewer, int more, double error_of_more,
                               double wanted) {
    assert(0 < fewer && fewer < more && wanted > 0);
    if (error_of_more <= wanted) return {more, error_of_more};
    const double measured =
        std::log(error_of_fewer / error_of_more) / std::log(static_cast<double>(more) / fewer);
    const double power = std::clamp(measured, 0.5, 1.5);
    const double lights = 1.1 * more * std::pow(error_of_more / wanted, 1 / power);
    LightEstimate estimate;
    estimate.lights = static_cast<int>(std::min(std::ceil(lights), double(most_reference_lights)));
    estimate.relative_error = error_of_more * std::pow(static_cast<double>(more) / estimate.lights, power);
    return estimate;
}

}  // namespace haarfield
