#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <set>

#include "bridge/povray_import/object_lattice.h"

namespace haarfield {
namespace {

/// Returns points near the vertices, in local coordinates. Vertices on sharp edges are moved into their face,
/// where a ray cannot miss the surface.
std::vector<Vec3d> points_in_faces(const GridFrame& frame, const ObjectSurface& surface) {
    constexpr double inwards = 0.15;  // Of the way to the middle of the triangles around.
    std::vector<Vec3d> points, sums(surface.positions.size(), Vec3d(0, 0, 0));
    std::vector<double> counts(surface.positions.size(), 0);
    for (const Vec3f& position : surface.positions) points.push_back(frame.local_point(Vec3d(position)));
    for (const auto& triangle : surface.triangles) {
        const Vec3d middle = (points[triangle[0]] + points[triangle[1]] + points[triangle[2]]) / 3;
        for (const std::uint32_t corner : triangle) {
            sums[corner] += middle;
            counts[corner] += 1;
        }
    }
    for (std::size_t v = 0; v < points.size(); ++v)
        if (counts[v] > 0) points[v] += (sums[v] / counts[v] - points[v]) * inwards;
    return points;
}

ProbeRay inward_ray(const ObjectLattice& lattice, const ObjectSurface& surface, std::size_t index,
                    std::size_t vertex, const Vec3d& point) {
    const Vec3d normal = lattice.frame(index).local_normal(Vec3d(surface.normals[vertex]));
    return {index, point + normal * ObjectLattice::start_distance, -normal};
}

/// The way of an inward ray through an object.
struct InwardWay {
    int surfaces = 1;   ///< That it crosses, with the one at its start.
    double inside = 0;  ///< Its length inside the object, in the frame's local coordinates.
};

/// cell  edge of a cell, in the frame's local coordinates.
InwardWay inward_way(const GridFrame& frame, double cell, const ObjectSurface& surface, std::size_t vertex) {
    const double own = 0.3 * cell;  // Crossings nearer than this belong to the vertex's own triangles.
    const Vec3d direction = -frame.local_normal(Vec3d(surface.normals[vertex])) / frame.scale;
    std::vector<double> places = surface_crossings(surface, Vec3d(surface.positions[vertex]), direction);
    std::erase_if(places, [own](double place) { return place <= own; });
    places.push_back(0);
    std::ranges::sort(places);
    // A ray through an edge hits two triangles.
    const auto is_same = [cell](double a, double b) { return b - a < 0.01 * cell; };
    places.erase(std::unique(places.begin(), places.end(), is_same), places.end());
    InwardWay way{static_cast<int>(places.size()), 0};
    for (std::size_t k = 1; k < places.size(); k += 2) way.inside += places[k] - places[k - 1];
    return way;
}

/// Returns up to `most` vertices, evenly spaced.
std::vector<std::size_t> some_vertices(const ObjectSurface& surface, std::size_t most) {
    const std::size_t count = surface.positions.size(), step = std::max<std::size_t>(1, count / most);
    std::vector<std::size_t> vertices;
    for (std::size_t v = step / 2; v < count && vertices.size() < most; v += step) vertices.push_back(v);
    return vertices;
}

double mean_of(const Rgb& colour) {
    return double(colour.x + colour.y + colour.z) / 3;
}

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// One measurement of a finish.
struct Sighting {
    std::size_t surface;
    int light;        ///< 0 or 1.
    double cosine;    ///< Between normal and light.
    double mirror;    ///< Cosine between the view and the mirrored light.
    double half;      ///< Cosine between the normal and the half vector.
    bool is_diffuse;  ///< Far from the mirror direction.
};

/// The difference between two views of a point that differ in specular light: `value` is
/// weight * (cosine^exponent - share * base^exponent).
struct LobeSample {
    double cosine, base, share, value;
};

/// A specular lobe: weight * cosine^exponent.
struct FittedLobe {
    double weight = 0, exponent = 1, residual = INFINITY;
};

FittedLobe lobe_with(std::span<const LobeSample> samples, double exponent) {
    double along = 0, square = 0, values = 0;
    const auto shape = [&](const LobeSample& sample) {
        return std::pow(std::max(0.0, sample.cosine), exponent) -
               sample.share * std::pow(std::max(0.0, sample.base), exponent);
    };
    for (const LobeSample& sample : samples) {
        const double f = shape(sample);
        along += f * sample.value;
        square += f * f;
        values += sample.value * sample.value;
    }
    FittedLobe lobe{square > 0 ? std::max(0.0, along / square) : 0, exponent, 0};
    lobe.residual = values - lobe.weight * (2 * along - lobe.weight * square);
    return lobe;
}

/// Returns the lobe with the least squares of errors; exponents from 1 to `largest`.
FittedLobe fitted_lobe(std::span<const LobeSample> samples, double largest) {
    constexpr int steps = 60, halvings = 24;
    const double ratio = std::pow(largest, 1.0 / steps);
    FittedLobe best;
    const auto try_exponent = [&](double exponent) {
        const FittedLobe lobe = lobe_with(samples, std::clamp(exponent, 1.0, largest));
        if (lobe.residual < best.residual) best = lobe;
    };
    for (int step = 0; step <= steps; ++step) try_exponent(std::pow(ratio, step));
    double reach = ratio;
    for (int k = 0; k < halvings; ++k) {
        const double middle = best.exponent;
        reach = std::sqrt(reach);
        try_exponent(middle / reach);
        try_exponent(middle * reach);
    }
    return best;
}

/// Measures the pigments of the vertices.
Result<Done> measure_pigments(const SceneQueries& queries, const ObjectLattice& lattice,
                              std::vector<ObjectSurface>& surfaces, const Progress& progress) {
    constexpr std::size_t most_rays = 400000;
    std::vector<ProbeRay> rays;
    std::vector<Rgb*> targets;
    const auto measure = [&]() -> Result<Done> {
        if (rays.empty()) return Done{};
        SceneQuery query = lattice.query(rays);
        query.pigments = true;
        HF_TRY(const SceneAnswer answer, queries.answer(query, progress));
        const std::vector<Rgb> colours = ObjectLattice::colours(answer, rays.size());
        for (std::size_t i = 0; i < rays.size(); ++i) *targets[i] = colours[i];
        rays.clear();
        targets.clear();
        return Done{};
    };
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        surfaces[s].colours.resize(surfaces[s].positions.size(), Rgb(0.5f));
        const std::vector<Vec3d> points = points_in_faces(lattice.frame(s), surfaces[s]);
        for (std::size_t v = 0; v < surfaces[s].positions.size(); ++v) {
            rays.push_back(inward_ray(lattice, surfaces[s], s, v, points[v]));
            targets.push_back(&surfaces[s].colours[v]);
            if (rays.size() == most_rays) HF_TRY_DONE(measure());
        }
    }
    return measure();
}

/// Samples of a colour.
struct ColourSamples {
    std::array<std::vector<double>, 3> channels;

    Rgb median_colour() const {
        return Rgb(static_cast<float>(median(channels[0])), static_cast<float>(median(channels[1])),
                   static_cast<float>(median(channels[2])));
    }
};

/// Returns the colours of rays before a white background.
Result<std::vector<Rgb>> before_white(const SceneQueries& queries, const ObjectLattice& lattice,
                                      std::span<const ProbeRay> rays, bool extras, const Progress& progress) {
    SceneQuery query = lattice.query(rays);
    query.pigments = true;
    query.extras = extras;
    query.suffix += "background{rgb HF_E}\n";
    HF_TRY(const SceneAnswer answer, queries.answer(query, progress));
    return ObjectLattice::colours(answer, rays.size());
}

/// The light that an inward ray lets through, without absorption.
struct PassedLight {
    std::size_t surface, vertex;
    Rgb passed;
};

/// Measures transmittances and filters. Returns samples of transparent surfaces.
Result<std::vector<PassedLight>> measure_filters(const SceneQueries& queries, const ObjectLattice& lattice,
                                                 std::vector<ObjectSurface>& surfaces,
                                                 const Progress& progress) {
    std::vector<ProbeRay> rays;
    std::vector<PassedLight> samples;
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        const std::vector<Vec3d> points = points_in_faces(lattice.frame(s), surfaces[s]);
        for (const std::size_t v : some_vertices(surfaces[s], 24)) {
            samples.push_back({s, v, Rgb(0.0f)});
            rays.push_back(inward_ray(lattice, surfaces[s], s, v, points[v]));
        }
    }
    HF_TRY(const std::vector<Rgb> bright, before_white(queries, lattice, rays, /*extras=*/false, progress));
    std::vector<double> sums(surfaces.size(), 0), counts(surfaces.size(), 0);
    std::vector<ColourSamples> filters(surfaces.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        auto& [s, v, passed] = samples[i];
        passed = bright[i] - surfaces[s].colours[v];
        for (int c = 0; c < 3; ++c) passed[c] = std::clamp(passed[c], 0.0f, 1.0f);
        sums[s] += mean_of(passed);
        counts[s] += 1;
        const int count = passed == Rgb(0.0f) ? 1 : inward_way(lattice.frame(s), 1, surfaces[s], v).surfaces;
        for (int c = 0; c < 3; ++c)
            filters[s].channels[std::size_t(c)].push_back(std::pow(double(passed[c]), 1.0 / count));
    }
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        surfaces[s].transmittance = static_cast<float>(sums[s] / std::max(1.0, counts[s]));
        surfaces[s].filter = filters[s].median_colour();
    }
    std::erase_if(samples, [](const PassedLight& sample) { return sample.passed == Rgb(0.0f); });
    return samples;
}

/// Measures absorption coefficients of transparent surfaces: the same rays, now with interiors. Objects have
/// their original size, since absorption depends on it.
Result<Done> measure_absorption(const SceneQueries& queries, std::span<const GridRequest> requests,
                                const ObjectLattice& lattice, std::span<const PassedLight> samples,
                                std::vector<ObjectSurface>& surfaces, const Progress& progress) {
    const ObjectLattice original(requests, surfaces, /*is_original=*/true);
    std::vector<ProbeRay> rays;
    std::vector<double> inside;
    for (const auto& [s, v, passed] : samples) {
        const GridFrame& frame = original.frame(s);
        const Vec3d& scale = lattice.frame(s).scale;
        const double cell = frame.scale.x / std::max({scale.x, scale.y, scale.z});
        const Vec3d normal = frame.local_normal(Vec3d(surfaces[s].normals[v])),
                    point = frame.local_point(Vec3d(surfaces[s].positions[v]));
        rays.push_back({s, point + normal * (ObjectLattice::start_distance * cell), -normal});
        inside.push_back(inward_way(frame, cell, surfaces[s], v).inside);
    }
    HF_TRY(const std::vector<Rgb> bright, before_white(queries, original, rays, /*extras=*/true, progress));
    constexpr double least_passed = 0.01, least_bright = 1e-4;
    std::vector<ColourSamples> coefficients(surfaces.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const auto& [s, v, passed] = samples[i];
        for (int c = 0; c < 3; ++c) {
            const double after =
                std::clamp(double(bright[i][c] - surfaces[s].colours[v][c]), least_bright, 1.0);
            if (double(passed[c]) > least_passed && inside[i] > 0)
                coefficients[s].channels[std::size_t(c)].push_back(
                    std::max(0.0, std::log(double(passed[c]) / after) / inside[i]));
        }
    }
    constexpr float least_absorption = 1e-4f;  // Rounding of the pictures.
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        const Rgb absorption =
            coefficients[s].median_colour() * static_cast<float>(original.frame(s).scale.x);
        for (int c = 0; c < 3; ++c)
            if (absorption[c] > least_absorption) surfaces[s].absorption[c] = absorption[c];
    }
    return Done{};
}

const std::array<Vec3d, 2>& light_directions() {
    static const std::array<Vec3d, 2> directions{Vec3d(0.5, 0.62, -0.605).normalized(),
                                                 -Vec3d(0.5, 0.62, -0.605).normalized()};
    return directions;
}

/// A place on a surface in local coordinates that one of the two lights illuminates.
struct ProbedPlace {
    std::size_t surface;
    int light;
    Vec3d point, normal;
};

/// Chooses up to eight places per surface and light, with POV-Ray's normals: those of the mesh differ by some
/// degrees, which is too much for narrow highlights.
Result<std::vector<ProbedPlace>> lit_places(const SceneQueries& queries, const ObjectLattice& lattice,
                                            std::span<const ObjectSurface> surfaces,
                                            const Progress& progress) {
    std::vector<ProbedPlace> places;
    std::vector<ProbeRay> rays;
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        std::array<int, 2> chosen{0, 0};
        const std::vector<Vec3d> points = points_in_faces(lattice.frame(s), surfaces[s]);
        for (const std::size_t v : some_vertices(surfaces[s], 400)) {
            const Vec3d normal = lattice.frame(s).local_normal(Vec3d(surfaces[s].normals[v]));
            for (int light = 0; light < 2; ++light) {
                const double cosine = normal.dot(light_directions()[std::size_t(light)]);
                if (cosine < 0.35 || cosine > 0.97 || chosen[std::size_t(light)] >= 8) continue;
                ++chosen[std::size_t(light)];
                places.push_back({s, light, points[v], normal});
                rays.push_back({s, points[v] + normal * ObjectLattice::start_distance, -normal});
            }
        }
    }
    HF_TRY(const std::vector<TracedPoint> traced, lattice.traced(queries, rays, 0, progress));
    constexpr double most_differing = 0.94;  // Cosine; other normals are those of other faces.
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (!(traced[i].normal.length() > 0.5)) continue;
        Vec3d normal = traced[i].normal.normalized();
        if (normal.dot(places[i].normal) < 0) normal = -normal;
        if (normal.dot(places[i].normal) < most_differing) continue;
        places[i].point = traced[i].point;
        places[i].normal = normal;
    }
    return places;
}

}  // namespace

Result<Done> add_pigments(const SceneQueries& queries, std::span<const GridRequest> requests,
                          std::vector<ObjectSurface>& surfaces, const Progress& progress) {
    if (surfaces.empty()) return Done{};
    const ObjectLattice lattice(requests, surfaces);
    HF_TRY_DONE(measure_pigments(queries, lattice, surfaces, progress));
    HF_TRY(const std::vector<PassedLight> samples, measure_filters(queries, lattice, surfaces, progress));
    if (samples.empty()) return Done{};
    return measure_absorption(queries, requests, lattice, samples, surfaces, progress);
}

Result<std::vector<MeasuredFinish>> measured_finishes(const SceneQueries& queries,
                                                      std::span<const GridRequest> requests,
                                                      std::span<const ObjectSurface> surfaces, bool ambient,
                                                      const Progress& progress) {
    std::vector<MeasuredFinish> finishes(surfaces.size());
    if (surfaces.empty()) return finishes;
    constexpr float brightness = 0.4f;  // Of the lights; sums above 1 would be cut off.
    const ObjectLattice lattice(requests, surfaces);
    HF_TRY(const std::vector<ProbedPlace> places, lit_places(queries, lattice, surfaces, progress));
    std::vector<ProbeRay> rays;
    std::vector<Sighting> sightings;
    for (const auto& [s, light, place, normal] : places) {
        const Vec3d& towards = light_directions()[std::size_t(light)];
        const double cosine = normal.dot(towards);
        const Vec3d mirror = normal * (2 * cosine) - towards,
                    aside = (normal - mirror * normal.dot(mirror)).normalized();
        for (const double degrees : {0.0, 1.5, 3.0, 5.0, 8.0, 12.0, 18.0, 26.0, 40.0, 58.0, 75.0}) {
            const double angle = degrees * pi / 180;
            const Vec3d view = mirror * std::cos(angle) + aside * std::sin(angle);
            rays.push_back(
                {s, place + view * (ObjectLattice::start_distance / std::max(0.2, view.dot(normal))), -view});
            const Vec3d half = (view + towards).normalized();
            sightings.push_back({s, light, cosine, std::cos(angle), normal.dot(half), degrees > 70});
        }
    }
    if (rays.empty()) return finishes;
    // Two permutations of the colours of both lights and the sky, so that saturated pigments reflect one.
    constexpr std::array<std::array<int, 3>, 2> permutations{{{0, 1, 2}, {2, 0, 1}}};
    constexpr std::size_t dark = 2;  // Index of the colours without lights.
    std::vector<SceneQuery> questions(3, lattice.query(rays, ambient));
    for (std::size_t k = 0; k < dark; ++k) {
        const auto colour = [&](int channel, float value) {
            Rgb rgb(0.0f);
            rgb[channel] = value;
            return fmt::format("rgb<{},{},{}>", rgb.x, rgb.y, rgb.z);
        };
        questions[k].suffix += fmt::format("background{{{}}}\n", colour(permutations[k][2], 1));
        for (std::size_t light = 0; light < 2; ++light) {
            const Vec3d place = light_directions()[light] * 1e5;
            questions[k].suffix += fmt::format("light_source{{<{},{},{}> {} parallel point_at 0}}\n", place.x,
                                               place.y, place.z, colour(permutations[k][light], brightness));
        }
    }
    // The pigments that these rays see: fine patterns differ between neighbouring points.
    questions.push_back(lattice.query(rays));
    questions.back().pigments = true;
    HF_TRY(const std::vector<SceneAnswer> answers, queries.answers(questions, progress));
    std::array<std::vector<Rgb>, 3> colours;
    for (std::size_t k = 0; k < colours.size(); ++k)
        colours[k] = ObjectLattice::colours(answers[k], rays.size());
    const std::vector<Rgb> pigments = ObjectLattice::colours(answers.back(), rays.size());
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        struct DiffuseView {
            double value, pigment, cosine, mirror, half;
        };
        std::vector<double> emission;
        std::vector<DiffuseView> from_light;
        std::vector<std::array<double, 2>> from_sky;  // With the pigment of the sky's channel.
        std::vector<LobeSample> about_mirror, about_half;
        std::vector<double> peaks;
        DiffuseView base{};
        for (std::size_t i = sightings.size(); i-- > 0;) {
            const Sighting& sighting = sightings[i];
            if (sighting.surface != s) continue;
            const Rgb& pigment = pigments[i];
            // The permutation in which the pigment is brighter in the light's channel.
            const auto light = std::size_t(sighting.light);
            const std::size_t k = pigment[permutations[0][light]] >= pigment[permutations[1][light]] ? 0 : 1;
            const int channel = permutations[k][light];
            const double value = double(colours[k][i][channel]) / double(brightness);
            if (sighting.is_diffuse) {
                base = {value, double(pigment[channel]), sighting.cosine, sighting.mirror, sighting.half};
                if (pigment[channel] > 0.02f) from_light.push_back(base);
                const int brightest =
                    static_cast<int>(std::max_element(&pigment.x, &pigment.x + 3) - &pigment.x);
                if (pigment[brightest] > 0.02f)
                    emission.push_back(double(colours[dark][i][brightest] / pigment[brightest]));
                const int sky = permutations[k][2];
                from_sky.push_back({double(colours[k][i][sky]), double(pigment[sky])});
            } else {
                // Fine patterns differ between the points that neighbouring rays meet.
                const double share = base.pigment > 0.02 ? double(pigment[channel]) / base.pigment : 1,
                             difference = value - base.value * share;
                about_mirror.push_back({sighting.mirror, base.mirror, share, difference});
                about_half.push_back({sighting.half, base.half, share, difference});
                if (sighting.mirror > 0.99999) peaks.push_back(difference);
            }
        }
        MeasuredFinish& finish = finishes[s];
        finish.emission = static_cast<float>(median(emission));
        if (finish.emission < 0.004f) finish.emission = 0;
        std::vector<double> reflection;
        for (const auto& [value, pigment] : from_sky)
            reflection.push_back(value - double(finish.emission) * pigment);
        finish.reflection = static_cast<float>(std::max(0.0, median(reflection)));
        constexpr double least_peak = 0.005;
        const bool is_dull = median(peaks) < least_peak;
        const FittedLobe phong = is_dull ? FittedLobe() : fitted_lobe(about_mirror, 1000),
                         specular = is_dull ? FittedLobe() : fitted_lobe(about_half, 2000);
        const bool is_phong = phong.residual <= specular.residual;
        std::vector<double> diffuse;
        for (const DiffuseView& view : from_light) {
            const double light =
                is_phong ? phong.weight * std::pow(std::max(0.0, view.mirror), phong.exponent)
                         : specular.weight * std::pow(std::max(0.0, view.half), specular.exponent);
            diffuse.push_back(
                ((view.value - light) / view.pigment - double(finish.emission) / double(brightness)) /
                view.cosine);
        }
        finish.diffuse = static_cast<float>(std::clamp(median(diffuse), 0.0, 1.0));
        if (is_dull) continue;
        if (is_phong) {
            finish.phong = static_cast<float>(std::min(phong.weight, 100.0));
            finish.phong_size = static_cast<float>(phong.exponent);
        } else {
            finish.specular = static_cast<float>(std::min(specular.weight, 100.0));
            finish.roughness = static_cast<float>(1 / specular.exponent);
        }
    }
    return finishes;
}

}  // namespace haarfield
