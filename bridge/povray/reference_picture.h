#pragma once
/// Renders the reference and estimates its error.

#include "bridge/povray/povray_process.h"
#include "bridge/povray/reference_scene.h"

namespace haarfield {

/// A reference and its estimated error.
struct ReferencePicture {
    Image image;  ///< The objects, with coverage and relative_error.
    /// Half the difference of the two pictures, by pixel: as large as the mean's error.
    std::vector<Rgb> half_difference;
    std::array<PovrayRun, 2> run;  ///< One for each set of lights.
};

/// Renders the objects of a scene by write_reference_scene, once with each of its two sets of lights. The
/// image is the mean.
///
/// relative_error    RMS of half the difference of the two pictures / RMS of their mean, where the objects
///                   cover half a pixel or more. The sets are independent and equally accurate, so that the
///                   mean's error is as large as half the difference. The squared common_lamp_error is added,
///                   because both sets have similar errors close to emitters. The estimate does not include
///                   POV-Ray's own tolerances, or the width of a light that is represented by one lamp in
///                   both sets: with specular lobes of shininess 200 and 256 lights, the error was 0.8 to 1.5
///                   times the estimate (five pictures compared with pictures of 4,000 and 6,000 lights).
/// scene             the scene file. Bounces are gathered under reduced_lights_of_bounces, because
///                   the cost of radiosity grows with the number of lights and indirect light is smooth. Each
///                   set then requires three runs: the direct light of all lights, and the light of the few
///                   with and without bounces.
/// emitters          Lamps close to a surface light it in small spots. The fixed directions of radiosity hit
///                   or miss the same spots in both sets. Therefore the bounces of emitters are gathered
///                   under lamps in the first half, and from the emitting surfaces themselves, without lamps,
///                   in the second (two more runs). There, radiosity errs for small emitters. Direct light
///                   comes from lamps in both halves.
/// progress, errors  those of run_povray.
Result<ReferencePicture> rendered_reference(const ReferenceFiles& scene, const PovrayOptions& options = {},
                                            const Progress& progress = {});

/// Renders one of the two pictures of a reference.
///
/// set               0 or 1: the set of lights.
/// progress, errors  those of run_povray.
Result<RenderedScene> rendered_half(const ReferenceFiles& scene, std::size_t set,
                                    const PovrayOptions& options = {}, const Progress& progress = {});

/// Combines both pictures of a scene into the reference: their mean.
ReferencePicture reference_of_halves(const ReferenceFiles& scene, std::array<RenderedScene, 2> halves);

/// A relative error of the reference from which on it is too inaccurate to judge a bake.
inline constexpr double large_reference_error = 0.05;

/// Returns a warning about a reference with this relative error; empty: no warning.
std::string reference_warning(double relative_error);

/// Renders a second reference without lights: POV-Ray's radiosity gathers the background's light.
///
/// accuracy          0.6 % RMS for smooth skies; biased for concentrated light. Diffuse terms only, without
///                   specular light. Not deterministic with several threads.
/// progress, errors  those of run_povray.
Result<RenderedScene> radiosity_picture(const std::filesystem::path& scene, const PovrayOptions& options = {},
                                        const Progress& progress = {});

/// The number of lights for a required relative error of the reference.
struct LightEstimate {
    int lights = 0;  ///< At most most_reference_lights.
    /// Expected with this number. Above the required error only if the maximum is too few.
    double relative_error = 0;
};
inline constexpr int most_reference_lights = 16384;  ///< The largest number that is requested.

/// Extrapolates from the errors of two numbers of lights, the second of which is larger. The error falls with
/// a power of the number of lights between -1/2 and -3/2, fitted to the two errors. The result includes a
/// margin of 10 %.
LightEstimate estimated_lights(int fewer, double error_of_fewer, int more, double error_of_more,
                               double wanted);

}  // namespace haarfield
