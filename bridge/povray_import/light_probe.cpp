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

/// Returns a condition on HF_I that is false for objects with some names or keywords.
Result<std::string> left_out(const SceneQueries& queries, const std::vector<std::string>& names) {
    const std::vector<SceneStatement>& statements = queries.scene().statements;
    std::string condition;
    for (const std::string& name : names) {
        bool is_found = false;
        for (std::size_t s = 0; s < statements.size(); ++s) {
            if (statements[s].name != name && statements[s].keyword != name) continue;
            condition += fmt::format(" & HF_I!={}", s);
            is_found = true;
        }
        if (!is_found)
            return Error{queries.file().string(),
                         fmt::format("places no object {} at its top level; expected the name of a "
                                     "declared object, a macro or a keyword",
                                     name)};
    }
    return condition;
}

}  // namespace

Result<Image> rendered_light(const SceneQueries& queries, SceneQuery query, const Vec3d& place,
                             const AffineMap& frame, int width, bool is_legacy, const Progress& progress) {
    assert(width >= 2 && width % 2 == 0);
    const int height = width / 2;
    query.camera = false;
    query.width = width;
    query.height = height;
    query.arguments = {"+A0.3", "+AM1", "+R3", "-J"};
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

Result<double> gamma_of_scene(const SceneQueries& queries, const Progress& progress) {
    SceneQuery query;
    query.width = query.height = 2;
    query.suffix =
        "\n#declare HF_Version=version;\n#version 3.7;\ncamera{location 0 look_at z}\n"
        "sphere{0,1 hollow pigment{rgb .5} finish{emission 1 ambient 0 diffuse 0}}\n#version HF_Version;\n";
    HF_TRY(const std::filesystem::path exr, queries.rendered_exr(query, progress));
    HF_TRY(const Image image, read_image(exr));
    const double half = double(image.pixels.front().y);
    constexpr double equal = 0.01;
    const double gamma = half > 0 && half < 1 ? std::log(half) / std::log(0.5) : 1;
    return std::abs(gamma - 1) < equal ? 1 : gamma;
}

Result<std::vector<Rgb>> light_transmittances(const SceneQueries& queries, const SceneSurvey& survey,
                                              std::span<const LitPlace> samples, double size,
                                              bool without_gamma, const Progress& progress) {
    std::vector<Rgb> fractions(samples.size(), Rgb(0.0f));
    if (samples.empty()) return fractions;
    size = std::max(size, 0.02);             // POV-Ray ignores hits that are too near.
    const double surface_radius = size / 5;  // Small, so that surfaces of one place do not overlap.
    std::vector<Lamp> lamps;
    for (const ModelLight& light : survey.lights) lamps.push_back(scene_lamp(light, AffineMap(), 1));
    SceneQuery query;
    query.lights = query.settings = true;
    query.put = "object{HF_A[HF_N]}";
    if (without_gamma) query.prelude = "global_settings{assumed_gamma 1}\n";
    query.suffix = "\n#version 3.7;\nglobal_settings{adc_bailout 0}\n";
    std::string rays;
    for (const LitPlace& sample : samples) {
        const Vec3d m = lamp_light(lamps[sample.light], sample.place).direction.normalized(),
                    aside = std::abs(m.x) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0),
                    e1 = m.cross(aside).normalized(), e2 = m.cross(e1);
        const auto triangle = [&](const Vec3d& centre, double sign) {
            const auto corner = [&](double x, double y) {
                const Vec3d p = centre + (e1 * x + e2 * (sign * y)) * surface_radius;
                return fmt::format("<{:.12g},{:.12g},{:.12g}>", p.x, p.y, p.z);
            };
            return fmt::format("triangle{{{},{},{}", corner(1, 0), corner(-0.5, 0.866), corner(-0.5, -0.866));
        };
        query.suffix += triangle(sample.place + m * size, 1) +
                        " pigment{rgb 1} finish{ambient 0 diffuse 1} no_shadow no_reflection}\n";
        rays += triangle(sample.place + m * (1.2 * size), -1) + "}\n";
    }
    query.suffix += "camera{mesh_camera{1 0 mesh{\n" + rays + "}} location<0,0,0> direction<0,0,-1>}\n";
    query.width = static_cast<int>(samples.size());
    query.height = 2;  // POV-Ray's first row repeats the second.
    HF_TRY(const std::filesystem::path exr, queries.rendered_exr(query, progress));
    HF_TRY(const Image image, read_image(exr));
    // The surfaces of one place get light from all lights in front of them, which must be divided.
    for (std::size_t first = 0, end = 0; first < samples.size(); first = end) {
        while (end < samples.size() && samples[end].place == samples[first].place) ++end;
        std::vector<LampLight> lights;
        for (std::size_t s = first; s < end; ++s)
            lights.push_back(lamp_light(lamps[samples[s].light], samples[s].place));
        for (int c = 0; c < 3; ++c) {
            std::vector<double> light;  // Of each lamp on a surface that faces it.
            for (std::size_t k = 0; k < lights.size(); ++k)
                light.push_back(lights[k].share * double(lamps[samples[first + k].light].colour[c]));
            std::vector<double> fraction(lights.size(), 1.0);
            constexpr int sweeps = 200;
            for (int sweep = 0; sweep < sweeps; ++sweep)
                for (std::size_t k = 0; k < lights.size(); ++k) {
                    double others = 0;
                    for (std::size_t j = 0; j < lights.size(); ++j)
                        if (j != k)
                            others += fraction[j] * light[j] *
                                      std::max(0.0, lights[k].direction.dot(lights[j].direction));
                    const double own = double(image.pixels[samples.size() + first + k][c]) - others;
                    fraction[k] = light[k] > 0 ? std::clamp(own / light[k], 0.0, 1.0) : 0;
                }
            for (std::size_t k = 0; k < lights.size(); ++k)
                fractions[first + k][c] = static_cast<float>(fraction[k]);
        }
    }
    return fractions;
}

Result<ProbedLight> probed_light(const SceneQueries& queries, const SceneSurvey& survey,
                                 const LightProbe& probe, const Progress& progress) {
    HF_TRY(const std::string condition, left_out(queries, probe.without));
    ProbedLight probed;
    probed.frame = scene_frame(survey.camera, probe.z_up);
    SceneQuery query;
    query.lights = query.sky = query.extras = true;
    query.put = fmt::format("#if(1{}) object{{HF_A[HF_N]}} #end", condition);
    query.suffix = "\n#declare HF_Version=version;\n#version 3.7;\n";
    // The first assumed_gamma counts.
    if (probe.without_gamma) query.prelude += "global_settings{assumed_gamma 1}\n";
    query.suffix += probe.objects;
    if (probe.lights)
        for (const ModelLight& light : survey.lights)
            if (const std::string disc = light_disc(light, probe.place); !disc.empty()) {
                query.suffix += disc;
                ++probed.lights;
            }
    if (probe.keeps_version) query.suffix += "#version HF_Version;\n";
    HF_TRY(probed.light, rendered_light(queries, query, probe.place, probed.frame.map(), probe.width,
                                        /*is_legacy=*/false, progress));
    return probed;
}

Result<ProbedLight> probed_light(const std::filesystem::path& file, const LightProbe& probe,
                                 const Progress& progress) {
    HF_TRY(const SceneQueries queries, SceneQueries::create(file, probe.queries));
    HF_TRY_DONE(left_out(queries, probe.without));
    HF_TRY(const SceneSurvey survey, scene_survey(queries, progress));
    HF_TRY(const double gamma, gamma_of_scene(queries, progress));
    LightProbe whole = probe;
    whole.keeps_version = gamma == 1;
    return probed_light(queries, survey, whole, progress);
}

}  // namespace haarfield
