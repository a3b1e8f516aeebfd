#pragma once
/// Rendering the reference, and how far it can be trusted itself.

#include "bridge/povray/povray_process.h"
#include "bridge/povray/reference_scene.h"

namespace haarfield {

/// A reference, and how far it can be trusted.
struct ReferencePicture {
    Image image;                       ///< The objects, with coverage and relative_error.
    std::vector<Rgb> half_difference;  ///< Of the two pictures, by pixel; as large as the mean's error.
    std::array<PovrayRun, 2> run;      ///< One for each set of lights.
};

/// Renders the objects of a scene that write_reference_scene wrote, once with each of its two sets of lights;
/// the image is the mean.
///
/// relative_error    RMS of half the difference of the two pictures / RMS of their mean, where the objects
///                   cover half a pixel or more: as the sets are independent and equally good, the mean's
///                   error is as large as that. The squared common_lamp_error is added: close to emitters
///                   both sets err alike. Not in it: POV-Ray's own
///                   tolerances, or the width of a lamp that is one light in either: with highlights of
///                   shininess 200 and 256 lights the error was 0.8 to 1.5 times the stated one, in five
///                   pictures against ones of 4,000 and 6,000 lights.
/// scene             its file. If it has bounces, they are gathered under few_lights_of_bounces: radiosity
///                   takes time for each light, and what bounces is smooth. That takes three runs a set: the
///                   direct light of all, and with and without bounces that of the few.
/// emitters          Lamps close to a surface light it in small spots, which radiosity's fixed directions hit
///                   or miss in both sets alike. Therefore the bounces of emitters are gathered under lamps
///                   in the first half, and from the emitting surfaces themselves, without lamps, in the
///                   second (two more runs). Radiosity errs where emitters are small instead. Direct light is
///                   from lamps in both halves.
/// progress, errors  those of run_povray.
Result<ReferencePicture> rendered_reference(const ReferenceFiles& scene, const PovrayOptions& options = {},
                                            const Progress& progress = {});

/// One of its two pictures.
///
/// set               0 or 1: the lights.
/// progress, errors  those of run_povray.
Result<RenderedScene> rendered_half(const ReferenceFiles& scene, std::size_t set,
                                    const PovrayOptions& options = {}, const Progress& progress = {});

/// The reference of both pictures of a scene: their mean.
ReferencePicture reference_of_halves(const ReferenceFiles& scene, std::array<RenderedScene, 2> halves);

/// A relative error from which on a reference does not tell how good a bake is.
inline constexpr double large_reference_error = 0.05;

/// What to say of a reference with such an error; empty: nothing.
std::string reference_warning(double relative_error);

/// A second opinion, without any lights: POV-Ray's radiosity gathers the background's light.
///
/// accuracy          for smooth skies, 0.6 % RMS; concentrated light is biased. Diffuse terms only:
///                   highlights are missing. Not the same from run to run with several threads.
/// progress, errors  those of run_povray.
Result<RenderedScene> radiosity_picture(const std::filesystem::path& scene, const PovrayOptions& options = {},
                                        const Progress& progress = {});

/// How many lights bring the reference's relative error down to a wanted one.
struct LightEstimate {
    int lights = 0;             ///< At most most_reference_lights.
    double relative_error = 0;  ///< Expected with so many. Above the wanted one only if the most do not do.
};
inline constexpr int most_reference_lights = 16384;  ///< More than these are never asked for.

/// From the errors that two numbers of lights have, the second larger: errors fall with a power of the number
/// between -1/2 and -3/2, which they tell; a tenth more lights are taken for safety.
LightEstimate estimated_lights(int fewer, double error_of_fewer, int more, double error_of_more,
                               double wanted);

}  // namespace haarfield
