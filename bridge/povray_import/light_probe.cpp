#include "bridge/povray_import/light_probe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fields/wavelets/cubemap.h"
#include "scenes/scene_import.h"
#include "shading/scene/lamp.h"

namespace haarfield {
namespace {

/// Returns the pixel of POV-Ray's spherical camera in a direction of the file.
Rgb spherical_pixel(const Image& image, const Vec3d& d) {
    const double x = std::atan2(d.x, d.z) / (2 * pi) + 0.5,
                 y = 0.5 - std::asin(std::clamp(d.y, -1.0, 1.0)) / pi;
    const int column = std::clamp(static_cast<int>(x * image.width), 0, image.width - 1),
              row = std::clamp(static_cast<int>(y * image.height), 0, image.height - 1);
    Rgb pixel = image.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                             static_cast<std::size_t>(column)];
    for (int c = 0; c < 3; ++c)
        pixel[c] = std::isfinite(pixel[c]) ? std::clamp(pixel[c], 0.0f, 65000.0f) : 0.0f;
    return pixel;
}

/// Returns a disc that has the irradiance of a light at a place; empty if the light does not reach it.
std::string light_disc(const ModelLight& light, const Vec3d& place) {
    constexpr double radius = pi / 180;  // [rad]
    const SceneLamp lamp = scene_lamp(light, AffineMap(), 1);
    const LampLight at = lamp_light(lamp, place);
    if (!(at.share > 0)) return {};
    const double solid_angle = 2 * pi * (1 - std::cos(radius)),
                 distance = at.distance > 0 ? at.distance : 1e5;
    const Vec3d centre = place + at.direction * distance,
                radiance = Vec3d(lamp.colour) * (pi * at.share / solid_angle);
    return fmt::format(
        "sphere{{<{:.12g},{:.12g},{:.12g}>,{:.12g} pigment{{rgb<{:.9g},{:.9g},{:.9g}>}} "
        "finish{{ambient 0 diffuse 0 emission 1}} no_shadow no_radiosity}}\n",
        centre.x, centre.y, centre.z, distance * std::sin(radius), radiance.x, radiance.y, radiance.z);
}

}  // namespace

Result<Image> rendered_light(const SceneQueries& queries, SceneQuery query, const Vec3d& place,
                             const AffineMap& frame, int width, bool is_legacy, const Progress& progress) {
    assert(width >= 2 && width % 2 == 0);
    const int height = width / 2;
    query.camera = false;
    query.width = width;
    query.height = height;
    query.arguments = {"+A0.05", "+AM1", "+R3", "-J"};
    query.suffix += fmt::format(
        "\ncamera{{spherical location <{:.12g},{:.12g},{:.12g}> up y right x "
        "direction z angle 360 180}}\n",
        place.x, place.y, place.z);
    Image spherical;
    if (is_legacy) {
        HF_TRY(SceneAnswer answer, queries.answer(query, progress));
        spherical = {width, height, std::move(answer.pixels), {}};
    } else {
        HF_TRY(const std::filesystem::path exr, queries.rendered_exr(query, progress));
        HF_TRY(spherical, read_image(exr));
    }
    Image light{width, height, {}, {}};
    light.pixels.reserve(spherical.pixels.size());
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column) {
            const Vec3d d = lat_long_direction((column + 0.5) / width, (row + 0.5) / height);
            // The inverse of a rotation or reflection is its transpose.
            const Vec3d file(frame.axes[0].dot(d), frame.axes[1].dot(d), frame.axes[2].dot(d));
            light.pixels.push_back(spherical_pixel(spherical, file.normalized()));
        }
    return light;
}

Result<ProbedLight> probed_light(const std::filesystem::path& file, const LightProbe& probe,
                                 const Progress& progress) {
    HF_TRY(const SceneQueries queries, SceneQueries::create(file, probe.queries));
    const std::vector<SceneStatement>& statements = queries.scene().statements;
    std::string condition;
    for (const std::string& name : probe.without) {
        bool is_found = false;
        for (std::size_t s = 0; s < statements.size(); ++s) {
            if (statements[s].name != name && statements[s].keyword != name) continue;
            condition += fmt::format(" & HF_I!={}", s);
            is_found = true;
        }
        if (!is_found)
            return Error{file.string(),
                         fmt::format("places no object {} at its top level; expected the name of a "
                                     "declared object, a macro or a keyword",
                                     name)};
    }
    HF_TRY(const SceneSurvey survey, scene_survey(queries, progress));
    ProbedLight probed;
    probed.frame = scene_frame(survey.camera);
    SceneQuery query;
    query.lights = query.sky = query.extras = true;
    query.put = fmt::format("#if(1{}) object{{HF_A[HF_N]}} #end", condition);
    query.suffix = "\n#version 3.7;\n";
    for (const ModelLight& light : survey.lights)
        if (const std::string disc = light_disc(light, probe.place); !disc.empty()) {
            query.suffix += disc;
            ++probed.lights;
        }
    HF_TRY(probed.light, rendered_light(queries, query, probe.place, probed.frame, probe.width,
                                        /*is_legacy=*/false, progress));
    return probed;
}

}  // namespace haarfield
