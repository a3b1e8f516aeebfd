#include "bridge/povray/reference_picture.h"

#include "bridge/povray/povray_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

/// Returns the mean of two pictures of the same objects, with its relative error.
///
/// common_error  RMS radiance of the error that both pictures have in common.
Image mean_picture(const Image& a, const Image& b, double common_error, std::vector<Rgb>& half_difference) {
    Image mean = a;
    half_difference.resize(mean.pixels.size());
    double difference = 0, radiance = 0;
    for (std::size_t i = 0; i < mean.pixels.size(); ++i) {
        mean.pixels[i] = (a.pixels[i] + b.pixels[i]) * 0.5f;
        half_difference[i] = (a.pixels[i] - b.pixels[i]) * 0.5f;
        if (!mean.coverage.empty()) {
            mean.coverage[i] = 0.5f * (a.coverage[i] + b.coverage[i]);
            if (mean.coverage[i] < 0.5f) continue;
        }
        for (int c = 0; c < 3; ++c) {
            difference += double(half_difference[i][c]) * double(half_difference[i][c]);
            radiance += double(mean.pixels[i][c]) * double(mean.pixels[i][c]);
            difference += common_error * common_error;
        }
    }
    mean.relative_error = radiance > 0 ? static_cast<float>(std::sqrt(difference / radiance)) : 0.0f;
    return mean;
}

/// Returns the progress of the part-th of `parts` runs of equal length.
Progress part_of(const Progress& progress, std::size_t part, std::size_t parts) {
    Progress result = progress;
    if (progress.report)
        result.report = [report = progress.report, part, parts](std::string_view stage, std::uint64_t done,
                                                                std::uint64_t total) {
            report(stage, part * total + done, parts * total);
        };
    return result;
}

/// Adds the times and warnings of a run to those of another.
void add_run(const PovrayRun& run, PovrayRun& sum) {
    sum.parse_seconds += run.parse_seconds;
    sum.trace_seconds += run.trace_seconds;
    for (const std::string& warning : run.warnings)
        if (std::ranges::find(sum.warnings, warning) == sum.warnings.end()) sum.warnings.push_back(warning);
}

/// The runs before this picture's two runs, and the number of all runs.
struct RunsOfPicture {
    std::size_t before, all;
};
Result<Done> add_difference(const std::filesystem::path& scene, PovrayOptions options,
                            const char* declaration, RenderedScene& picture, const Progress& progress,
                            RunsOfPicture runs) {
    HF_TRY(const RenderedScene with,
           rendered_scene(scene, options, part_of(progress, runs.before, runs.all)));
    options.declarations.push_back(declaration);
    HF_TRY(const RenderedScene without,
           rendered_scene(scene, options, part_of(progress, runs.before + 1, runs.all)));
    for (std::size_t i = 0; i < picture.image.pixels.size(); ++i)
        picture.image.pixels[i] += with.image.pixels[i] - without.image.pixels[i];
    add_run(with.run, picture.run);
    add_run(without.run, picture.run);
    return Done{};
}

}  // namespace

Result<RenderedScene> rendered_half(const ReferenceFiles& scene, std::size_t set,
                                    const PovrayOptions& options, const Progress& progress) {
    const char* const own_lights = set == 0 ? first_dome_only : second_dome_only;
    const char* const other_lights = set == 0 ? second_dome_only : first_dome_only;
    PovrayOptions objects = options;
    objects.declarations.insert(objects.declarations.end(), {without_background, own_lights});
    if (!scene.has_bounces) return rendered_scene(scene.scene, objects, progress);
    // Lamps and radiosity have different errors: each half uses one of the methods.
    const bool gathers_emitters = scene.has_emitters && set == 1;
    const std::size_t runs = gathers_emitters ? 5 : 3;
    PovrayOptions alone = objects;
    alone.declarations.push_back(without_bounces);
    Result<RenderedScene> direct = rendered_scene(scene.scene, alone, part_of(progress, 0, runs));
    if (!direct) return direct;
    PovrayOptions few = objects;
    few.declarations.emplace_back(reduced_lights_alone);
    HF_TRY_DONE(add_difference(scene.scene, few, without_bounces, *direct, progress, {1, runs}));
    if (!gathers_emitters) return direct;
    PovrayOptions gathered = objects;
    gathered.declarations.insert(gathered.declarations.end(), {other_lights, emitters_by_radiosity});
    HF_TRY_DONE(add_difference(scene.scene, gathered, direct_light_only, *direct, progress, {3, runs}));
    return direct;
}

ReferencePicture reference_of_halves(const ReferenceFiles& scene, std::array<RenderedScene, 2> halves) {
    ReferencePicture picture;
    picture.image = mean_picture(halves[0].image, halves[1].image,
                                 scene.emitter_lamps ? common_lamp_error(*scene.emitter_lamps) : 0,
                                 picture.half_difference);
    for (std::size_t set = 0; set < 2; ++set) picture.run[set] = std::move(halves[set].run);
    return picture;
}

Result<ReferencePicture> rendered_reference(const ReferenceFiles& scene, const PovrayOptions& options,
                                            const Progress& progress) {
    std::array<RenderedScene, 2> halves;
    for (std::size_t set = 0; set < 2; ++set) {
        HF_TRY(halves[set], rendered_half(scene, set, options, part_of(progress, set, 2)));
    }
    return reference_of_halves(scene, std::move(halves));
}

std::string reference_warning(double relative_error) {
    if (relative_error < large_reference_error) return {};
    return fmt::format(
        "the reference itself has a relative error of {:.1f} %: smaller differences from it say nothing "
        "about a bake; increase --lights to reduce the error",
        100 * relative_error);
}

Result<RenderedScene> radiosity_picture(const std::filesystem::path& scene, const PovrayOptions& options,
                                        const Progress& progress) {
    // The background is the light and cannot be left out. It is subtracted by coverage afterwards.
    PovrayOptions unlit = options;
    unlit.antialiasing_threshold = 0;  // the same rays in all pictures
    unlit.declarations.insert(unlit.declarations.end(), {first_dome_only, second_dome_only});
    PovrayOptions lit = unlit, behind = unlit;
    lit.declarations.push_back(by_radiosity);
    behind.declarations.emplace_back(background_only);
    unlit.declarations.emplace_back(without_background);
    Result<RenderedScene> picture = rendered_scene(scene, lit, progress);
    if (!picture) return picture;
    const Progress silent{{}, progress.stop};
    HF_TRY(const RenderedScene covered, rendered_scene(scene, unlit, silent));
    HF_TRY(const RenderedScene background, rendered_scene(scene, behind, silent));
    picture->image.coverage = covered.image.coverage;
    for (std::size_t i = 0; i < picture->image.pixels.size(); ++i)
        picture->image.pixels[i] -= background.image.pixels[i] * (1 - picture->image.coverage[i]);
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
