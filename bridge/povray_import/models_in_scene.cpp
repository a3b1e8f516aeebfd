#include "bridge/povray_import/models_in_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bridge/povray/placed_bake.h"
#include "bridge/povray/reference_scene.h"
#include "bridge/povray_import/imported_scene.h"
#include "bridge/povray_import/light_probe.h"
#include "fields/base/names.h"
#include "fields/base/spiral.h"
#include "fields/file/write_file.h"

namespace haarfield {
namespace {

constexpr std::size_t normals = 64;
constexpr int coarse_width = 128;       // Of probes that are only integrated. [pixels]
constexpr double towards_corner = 0.9;  // The corners themselves may lie in a floor.

/// The irradiance at surfaces with these normals.
using Irradiances = std::array<Vec3d, normals>;

Vec3d normal_of(std::size_t k) {
    return spiral_direction(k, 1 - (2.0 * double(k) + 1) / normals);
}

/// Returns the irradiance of a lat-long image at surfaces of many orientations.
Irradiances irradiances(const Image& light) {
    Irradiances sums, normal;
    sums.fill(Vec3d(0, 0, 0));
    for (std::size_t k = 0; k < normals; ++k) normal[k] = normal_of(k);
    for (int row = 0; row < light.height; ++row) {
        const double solid_angle = lat_long_pixel_solid_angle(row, light.width, light.height);
        for (int column = 0; column < light.width; ++column) {
            const Vec3d d = lat_long_direction((column + 0.5) / light.width, (row + 0.5) / light.height),
                        radiance(
                            light.pixels[std::size_t(row) * std::size_t(light.width) + std::size_t(column)]);
            for (std::size_t k = 0; k < normals; ++k) {
                const double cosine = d.dot(normal[k]);
                if (cosine > 0) sums[k] += radiance * (cosine * solid_angle);
            }
        }
    }
    return sums;
}

/// Returns the models in POV-Ray's language, in the coordinates of the surroundings. They cast shadows but
/// are not visible.
Result<std::string> shadow_casters(const Scene& scene, const Progress& progress) {
    HF_TRY(const SceneEntities originals, original_entities(scene, progress));
    std::string text = "union{\n";
    for (const ReferenceInstance& instance : reference_instances(scene, originals)) {
        text += "mesh2{";
        append_povray_vectors(text, "vertex_vectors", instance.mesh->positions);
        append_povray_indices(text, "face_indices", instance.mesh->triangles);
        text += fmt::format("{} scale {:.9g} translate {}}}\n", povray_rotation(instance.placement.rotate),
                            instance.placement.scale, povray_vector(instance.placement.translate));
    }
    // A union of one object is a warning.
    return text + "sphere{0,0.000001} " + matrix_into(*scene.surroundings) +
           "pigment{rgb .5} finish{ambient 0 diffuse 1} no_image no_reflection}\n";
}

double mean_square(const Irradiances& values) {
    double sum = 0;
    for (const Vec3d& value : values) sum += value.length2();
    return sum / normals;
}

constexpr std::size_t centre_place = 8;  // After the corners.
using Places = std::array<Vec3d, centre_place + 1>;

/// Returns points near the corners of a box, and its centre.
Places probed_places(const Vec3d& centre, const Vec3d& half) {
    Places places;
    for (std::size_t k = 0; k < centre_place; ++k)
        places[k] =
            centre + Vec3d(k & 1 ? half.x : -half.x, k & 2 ? half.y : -half.y, k & 4 ? half.z : -half.z) *
                         towards_corner;
    places[centre_place] = centre;
    return places;
}

/// The fractions of the file's lights that reach places.
struct ReachedLight {
    std::vector<LitPlace> samples;
    std::vector<Rgb> fractions;  ///< By sample.
    std::vector<Vec3d> means;    ///< By light, over the places to which it points.
};

Result<ReachedLight> reached_light(const SceneQueries& queries, const SceneSurvey& survey,
                                   std::span<const Lamp> lamps, const Places& places, double size,
                                   bool without_gamma, const Progress& progress) {
    ReachedLight reached;
    for (const Vec3d& at : places)
        for (std::size_t light = 0; light < lamps.size(); ++light)
            if (lamp_light(lamps[light], at).share > 0) reached.samples.push_back({at, light});
    HF_TRY(reached.fractions,
           light_transmittances(queries, survey, reached.samples, size, without_gamma, progress));
    reached.means.assign(lamps.size(), Vec3d(0, 0, 0));
    std::vector<double> count(lamps.size(), 0);
    for (std::size_t s = 0; s < reached.samples.size(); ++s) {
        reached.means[reached.samples[s].light] += Vec3d(reached.fractions[s]);
        count[reached.samples[s].light] += 1;
    }
    for (std::size_t light = 0; light < lamps.size(); ++light)
        if (count[light] > 0) reached.means[light] /= count[light];
    return reached;
}

/// Sets how much the irradiance at the corners differs from that at the centre.
///
/// lamps       the file's lights, in its coordinates.
/// irradiance  by place: that of the surroundings.
void set_corner_difference(std::span<const Lamp> lamps, const ReachedLight& reached, const AffineMap& world,
                           const Places& places, std::span<Irradiances> irradiance, ModelsInScene& result) {
    Irradiances whole = irradiance[centre_place];  // With direct light.
    for (std::size_t s = 0; s < reached.samples.size(); ++s) {
        const LitPlace& sample = reached.samples[s];
        const std::size_t k = std::size_t(std::ranges::find(places, sample.place) - places.begin());
        const Lamp& lamp = lamps[sample.light];
        const LampLight at = lamp_light(lamp, sample.place);
        const Vec3d direction = world.direction(at.direction), facing = Vec3d(lamp.colour) * (pi * at.share),
                    average = reached.means[sample.light];
        for (std::size_t n = 0; n < normals; ++n) {
            const double cosine = std::max(0.0, direction.dot(normal_of(n)));
            irradiance[k][n] += facing * (Vec3d(reached.fractions[s]) - average) * cosine;
            if (k == centre_place) whole[n] += facing * average * cosine;
        }
    }
    const double at_centre = std::max(mean_square(whole), 1e-30);
    double sum = 0;
    for (std::size_t k = 0; k < centre_place; ++k) {
        for (std::size_t n = 0; n < normals; ++n) irradiance[k][n] -= irradiance[centre_place][n];
        const double square = mean_square(irradiance[k]) / at_centre;
        result.largest_corner_difference = std::max(result.largest_corner_difference, std::sqrt(square));
        sum += square / double(centre_place);
    }
    result.corner_difference = std::sqrt(sum);
}

/// Adds the file's lights, each with the mean of the fractions that reach the models.
void add_lamps(const SceneSurvey& survey, std::span<const Vec3d> means, const AffineMap& world,
               const std::string& stem, ModelsInScene& result) {
    constexpr double dimmest = 0.002;
    std::set<std::string> names;
    for (std::size_t k = 0; k < means.size(); ++k) {
        if (std::max({means[k].x, means[k].y, means[k].z}) < dimmest) continue;
        SceneLamp lamp = scene_lamp(survey.lights[k], world, 1);
        lamp.colour *= Rgb(means[k]);
        lamp.name = unique_name(stem + "_light", names);
        result.scene.lamps.push_back(std::move(lamp));
        ++result.lights;
    }
}

}  // namespace

Result<ModelsInScene> models_in_scene(std::span<const std::filesystem::path> files, const PlaceInScene& place,
                                      const std::filesystem::path& environment, const Progress& progress) {
    HF_TRY(const SceneQueries queries, SceneQueries::create(place.file, place.queries));
    HF_TRY(const SceneSurvey survey, scene_survey(queries, progress));
    const SceneFrame frame = scene_frame(survey.camera, place.z_up);
    const AffineMap world = frame.map();
    const auto in_file = [&](const Vec3d& p) {  // The inverse of a rotation or reflection is its transpose.
        return Vec3d(world.axes[0].dot(p), world.axes[1].dot(p), world.axes[2].dot(p));
    };

    SceneImport wanted = place.models;
    wanted.stand_at = world.point(place.at);
    wanted.environment.clear();
    wanted.no_environment = true;
    wanted.floor = false;
    HF_TRY(ImportedScene imported, scene_of_models(files, environment.parent_path(), wanted, progress));
    ModelsInScene result{std::move(imported.scene), std::move(imported.warnings)};
    Scene& scene = result.scene;
    scene.surroundings = Surroundings{place.file, frame.z_up, frame.left_handed};

    const Bounds& box = imported.bounds;
    const Vec3d centre(box.centre()), half = Vec3d(box.upper - box.lower) / 2;
    result.probe = in_file(centre) + Vec3d(0.0);  // No -0.
    LightProbe probe;
    probe.place = result.probe;
    probe.width = place.width;
    HF_TRY(const double gamma, gamma_of_scene(queries, progress));
    probe.without_gamma = gamma != 1;
    if (probe.without_gamma)
        result.warnings.push_back(
            fmt::format("{}: has assumed_gamma {:.3g}; light is baked in its numbers, as POV-Ray computes it",
                        place.file.string(), gamma));
    probe.z_up = place.z_up;
    probe.lights = false;
    probe.keeps_version = true;
    HF_TRY(probe.objects, shadow_casters(scene, progress));
    HF_TRY(const ProbedLight probed, probed_light(queries, survey, probe, progress));
    Places places = probed_places(centre, half);
    std::ranges::transform(places, places.begin(), in_file);
    std::vector<Lamp> lamps;
    for (const ModelLight& light : survey.lights) lamps.push_back(scene_lamp(light, AffineMap(), 1));
    HF_TRY(const ReachedLight reached, reached_light(queries, survey, lamps, places, 0.01 * half.length(),
                                                     probe.without_gamma, progress));
    probe.width = coarse_width;
    std::array<Irradiances, std::tuple_size_v<Places>> irradiance;
    for (std::size_t k = 0; k < places.size(); ++k) {
        if (progress.report) progress.report("probes", k, places.size());
        probe.place = places[k];
        HF_TRY(const ProbedLight nearby, probed_light(queries, survey, probe, {{}, progress.stop}));
        irradiance[k] = irradiances(nearby.light);
    }
    set_corner_difference(lamps, reached, world, places, irradiance, result);
    add_lamps(survey, reached.means, world, place.file.stem().string(), result);

    if (scene.lamps.empty() &&
        std::ranges::all_of(probed.light.pixels, [](const Rgb& pixel) { return pixel == Rgb(0.0f); }))
        return Error{place.file.string(),
                     fmt::format("no light reaches {:.6g},{:.6g},{:.6g}, the centre of the models' box; "
                                 "expected a place outside of the scene's objects",
                                 result.probe.x, result.probe.y, result.probe.z)};

    HF_TRY_DONE(make_folder(environment.parent_path()));
    HF_TRY_DONE(write_image(probed.light, environment));
    scene.environment = {};
    scene.environment.image = environment;
    scene.finds_camera = !survey.camera || !survey.camera->is_perspective;
    if (!scene.finds_camera)
        scene.camera = imported_camera(*survey.camera, world, box, result.warnings);
    else
        result.warnings.push_back(place.file.string() +
                                  ": has no perspective camera; specular light is baked for another camera");
    for (const std::size_t unread : survey.unread_lights) {
        const SceneStatement& at = queries.scene().statements[unread];
        result.warnings.push_back(fmt::format(
            "{}:{}: {} has properties that haarfield does not have; the models get no light from it", at.file,
            at.line, at.keyword));
    }
    return result;
}

}  // namespace haarfield
