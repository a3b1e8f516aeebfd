#include "bridge/povray_import/object_filters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "bridge/povray_import/object_lattice.h"
#include "bridge/povray_import/triangle_text.h"

namespace haarfield {
namespace {

constexpr float same_filter = 0.03f;       // Largest difference between the filters of one part.
constexpr std::size_t most_parts = 6;      // Of an object; more colours are a pattern.
constexpr double least_share = 0.005;      // Of an object's crossings, in a part.
constexpr double open_share = 0.1;         // Of lines with an odd number of crossings, in closed parts.
constexpr std::size_t most_rays = 200000;  // Of one run.

float largest_difference(const Rgb& a, const Rgb& b) {
    const Rgb d = a - b;
    return std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
}

/// A place on a surface, in local coordinates.
struct FilterProbe {
    std::size_t surface = 0;
    Vec3d point{0, 0, 0}, normal{0, 0, 1};
};

/// Measures the fraction of light that passes a surface at some places. A small screen behind each place is
/// white in one picture and black in the other.
Result<std::vector<Rgb>> measured_filters(const SceneQueries& queries, const ObjectLattice& lattice,
                                          std::span<const FilterProbe> probes, const Progress& progress) {
    constexpr double distance = 0.01;  // Of a ray's start and of the screen from the surface. [cells]
    constexpr double size = 0.004;     // Of the screens.
    std::vector<Rgb> filters;
    filters.reserve(probes.size());
    for (std::size_t first = 0; first < probes.size(); first += most_rays) {
        const auto part = probes.subspan(first, std::min(most_rays, probes.size() - first));
        std::vector<ProbeRay> rays;
        TriangleText screens;
        for (const FilterProbe& probe : part) {
            rays.push_back({probe.surface, probe.point + probe.normal * distance, -probe.normal});
            const Vec3d& n = probe.normal;
            const Vec3d aside = std::abs(n.x) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0),
                        u = n.cross(aside).normalized() * size, v = n.cross(u),
                        centre = lattice.placed(probe.surface, probe.point - n * distance);
            screens.add({centre + u * 2, centre + v * 1.7 - u, centre - v * 1.7 - u});
        }
        SceneQuery without_screens = lattice.query(rays);
        without_screens.pigments = true;
        const std::string mesh = screens.mesh2();
        std::array<SceneQuery, 2> by_screen{without_screens, without_screens};
        for (const int white : {0, 1})
            by_screen[std::size_t(white)].suffix += fmt::format(
                "{}pigment{{rgb {}}} finish{{ambient 0 diffuse 0 emission HF_E}} no_shadow}}\n", mesh, white);
        HF_TRY(const std::vector<SceneAnswer> answers, queries.answers(by_screen, progress));
        std::array<std::vector<Rgb>, 2> colours;
        for (std::size_t k = 0; k < colours.size(); ++k)
            colours[k] = ObjectLattice::colours(answers[k], rays.size());
        for (std::size_t i = 0; i < rays.size(); ++i) {
            Rgb& filter = filters.emplace_back(colours[1][i] - colours[0][i]);
            for (int c = 0; c < 3; ++c) filter[c] = std::clamp(filter[c], 0.0f, 1.0f);
        }
    }
    return filters;
}

/// Calls `visit(axis, line, crossings)` for all lines of a grid.
template <class Grid, class Visit>
void visit_lines(Grid& grid, const Visit& visit) {
    for (int axis = 0; axis < 3; ++axis)
        for (std::size_t line = 0; line < grid.lines[std::size_t(axis)].size(); ++line)
            visit(axis, line, grid.lines[std::size_t(axis)][line]);
}

/// Returns the places of all crossings.
std::vector<FilterProbe> probes_of(const GridFrame& frame, const CrossedGrid& grid, std::size_t surface) {
    std::vector<FilterProbe> probes;
    visit_lines(grid, [&](int axis, std::size_t line, const std::vector<LineCrossing>& crossings) {
        const auto columns = static_cast<std::size_t>(grid.cells[std::size_t((axis + 2) % 3)] + 1);
        for (const LineCrossing& crossing : crossings) {
            Vec3d point;
            point[axis] = crossing.place;
            point[(axis + 1) % 3] = static_cast<double>(line / columns);
            point[(axis + 2) % 3] = static_cast<double>(line % columns);
            probes.push_back({surface, frame.local_point(frame.scene_point(point)), Vec3d(crossing.normal)});
        }
    });
    return probes;
}

/// The filters of an object's parts, and the part of each crossing.
struct Clusters {
    std::vector<Rgb> filters;
    std::vector<std::size_t> cluster_of;
};

/// Divides crossings by their filters. Returns no clusters if there are too many.
Clusters clusters_of(std::span<const Rgb> filters) {
    struct Group {
        Rgb seed;
        std::size_t count = 0;
    };
    std::vector<Group> groups;
    constexpr std::size_t most_groups = 200;  // Edges of parts have a few other colours.
    for (const Rgb& filter : filters) {
        auto group = std::ranges::find_if(
            groups, [&](const Group& each) { return largest_difference(each.seed, filter) <= same_filter; });
        if (group == groups.end()) {
            if (groups.size() == most_groups) return {};
            group = groups.insert(group, {filter, 0});
        }
        ++group->count;
    }
    Clusters clusters;
    for (const Group& group : groups)
        if (static_cast<double>(group.count) >= least_share * static_cast<double>(filters.size()))
            clusters.filters.push_back(group.seed);
    if (clusters.filters.empty() || clusters.filters.size() > most_parts) return {};
    for (const Rgb& filter : filters) {
        const auto nearest = std::ranges::min_element(
            clusters.filters, {}, [&](const Rgb& each) { return largest_difference(each, filter); });
        clusters.cluster_of.push_back(static_cast<std::size_t>(nearest - clusters.filters.begin()));
    }
    return clusters;
}

/// Returns the crossings of one cluster. A line enters and leaves a closed part in turn.
CrossedGrid part_grid(const CrossedGrid& grid, const Clusters& clusters, std::size_t cluster) {
    CrossedGrid part;
    part.cells = grid.cells;
    std::size_t index = 0, crossed = 0, open = 0;
    for (int axis = 0; axis < 3; ++axis) part.lines[std::size_t(axis)].resize(grid.line_count(axis));
    visit_lines(grid, [&](int axis, std::size_t line, const std::vector<LineCrossing>& crossings) {
        std::vector<LineCrossing>& own = part.lines[std::size_t(axis)][line];
        for (const LineCrossing& crossing : crossings) {
            if (clusters.cluster_of[index++] != cluster) continue;
            own.push_back(crossing);
            own.back().inside_before = own.size() % 2 == 0;
            own.back().inside_after = own.size() % 2 == 1;
        }
        crossed += !own.empty();
        open += own.size() % 2;
    });
    if (static_cast<double>(open) > open_share * static_cast<double>(crossed)) take_for_sheets(part);
    return part;
}

/// Returns a ray's way inside each part of an object, as POV-Ray's absorption counts it: from the last
/// crossing of any surface to each crossing that leaves the part.
std::vector<double> ways_inside(std::span<const FilterPart> parts, const Vec3d& from, const Vec3d& direction,
                                double same) {
    std::vector<std::pair<double, std::size_t>> crossings;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        std::vector<double> places = surface_crossings(parts[p].surface, from, direction);
        std::ranges::sort(places);
        places.erase(
            std::unique(places.begin(), places.end(), [same](double a, double b) { return b - a < same; }),
            places.end());
        for (const double place : places) crossings.emplace_back(place, p);
    }
    std::ranges::sort(crossings);
    std::vector<double> ways(parts.size(), 0);
    std::vector<bool> inside(parts.size(), false);
    double last = 0;
    for (const auto& [place, part] : crossings) {
        if (inside[part]) ways[part] += place - last;
        inside[part] = !inside[part];
        last = place;
    }
    return ways;
}

/// One equation: the sum of each part's way times its coefficient.
struct AbsorptionSample {
    std::vector<double> ways;
    double value;
};

/// Returns coefficients >= 0 with the least absolute errors, by reweighted least squares.
std::vector<double> fitted_absorption(std::span<const AbsorptionSample> samples, std::size_t parts) {
    constexpr int rounds = 12, sweeps = 60;
    constexpr double softest = 1e-3;  // Errors below it count squared.
    std::vector<double> fit(parts, 0), weights(samples.size(), 1);
    const auto error = [&](const AbsorptionSample& sample) {
        double sum = sample.value;
        for (std::size_t p = 0; p < parts; ++p) sum -= fit[p] * sample.ways[p];
        return sum;
    };
    for (int round = 0; round < rounds; ++round) {
        for (int sweep = 0; sweep < sweeps; ++sweep)
            for (std::size_t p = 0; p < parts; ++p) {
                double along = 0, square = 0;
                for (std::size_t i = 0; i < samples.size(); ++i) {
                    const double way = samples[i].ways[p];
                    along += weights[i] * way * (error(samples[i]) + fit[p] * way);
                    square += weights[i] * way * way;
                }
                if (square > 0) fit[p] = std::max(0.0, along / square);
            }
        for (std::size_t i = 0; i < samples.size(); ++i)
            weights[i] = 1 / std::max(softest, std::abs(error(samples[i])));
    }
    return fit;
}

/// Measures the absorption in the parts of one object, by rays with and without its interiors.
Result<Done> measure_absorption(const SceneQueries& queries, const GridRequest& request,
                                const ObjectSurface& measured, std::span<FilterPart> parts,
                                const Progress& progress) {
    constexpr std::size_t most = 150;
    constexpr double least_passed = 0.002, least_bright = 1e-4, least_value = 0.003;
    // Absorption depends on the object's size.
    const ObjectLattice lattice({&request, 1}, {&measured, 1}, /*is_original=*/true);
    const GridFrame &frame = lattice.frame(0), cells = grid_frame(request);
    const double cell = frame.scale.x / std::max({cells.scale.x, cells.scale.y, cells.scale.z});
    std::vector<ProbeRay> rays;
    std::vector<std::vector<double>> ways;
    const std::size_t count = measured.positions.size(), step = std::max<std::size_t>(1, count / most);
    for (std::size_t v = step / 2; v < count && rays.size() < most; v += step) {
        const Vec3d normal = frame.local_normal(Vec3d(measured.normals[v])),
                    start = frame.local_point(Vec3d(measured.positions[v])) +
                            normal * (ObjectLattice::start_distance * cell);
        rays.push_back({0, start, -normal});
        const Vec3d from = (start - frame.shift) / frame.scale + frame.centre;
        ways.push_back(ways_inside(parts, from, -normal / frame.scale, 0.02 * cell));
    }
    std::vector<SceneQuery> questions(4,
                                      lattice.query(rays));  // Dark and bright, without and with interiors.
    for (std::size_t k = 0; k < questions.size(); ++k) {
        questions[k].pigments = true;
        questions[k].extras = k >= 2;
        if (k % 2 == 1) questions[k].suffix += "background{rgb HF_E}\n";
    }
    HF_TRY(const std::vector<SceneAnswer> answers, queries.answers(questions, progress));
    std::array<std::vector<Rgb>, 4> pictures;
    for (std::size_t k = 0; k < pictures.size(); ++k)
        pictures[k] = ObjectLattice::colours(answers[k], rays.size());
    for (int c = 0; c < 3; ++c) {
        std::vector<AbsorptionSample> samples;
        double largest = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const auto before = double(pictures[1][i][c] - pictures[0][i][c]),
                       after = double(pictures[3][i][c] - pictures[2][i][c]);
            if (before < least_passed) continue;
            samples.push_back({ways[i], std::max(0.0, std::log(before / std::max(after, least_bright)))});
            largest = std::max(largest, samples.back().value);
        }
        if (samples.empty() || largest < least_value) continue;
        const std::vector<double> fit = fitted_absorption(samples, parts.size());
        for (std::size_t p = 0; p < parts.size(); ++p)
            parts[p].absorption[c] = static_cast<float>(fit[p] * frame.scale.x);
    }
    return Done{};
}

/// Returns an object as one part.
FilterPart whole_part(const ObjectSurface& measured, ObjectSurface surface) {
    return {std::move(surface), measured.filter, measured.absorption, false};
}

}  // namespace

Result<std::vector<FilterPart>> filter_parts(const SceneQueries& queries,
                                             std::span<const GridRequest> requests,
                                             std::span<const ObjectSurface> measured, double object_seconds,
                                             const Progress& progress) {
    assert(requests.size() == measured.size());
    std::vector<FilterPart> parts;
    // Objects that take too long remain as they are.
    Result<TracedLines> finer = traced_lines(queries, requests, object_seconds, progress);
    if (progress.stop.stop_requested()) return interruption();
    TracedLines traced{std::vector<std::string>(requests.size()), {}};
    if (finer) traced = *std::move(finer);
    const ObjectLattice lattice(requests, measured);
    for (std::size_t i = 0; i < requests.size(); ++i) {
        const GridFrame frame = grid_frame(requests[i]);
        std::optional<CrossedGrid> grid = crossed_grid(frame, traced.lines[i]);
        traced.lines[i] = {};
        if (!grid) {
            parts.push_back(whole_part(measured[i], measured[i]));
            continue;
        }
        ObjectSurface surface = closed_or_open_surface(frame, *grid, requests[i].object);
        if (surface.triangles.empty()) surface = measured[i];
        if (requests[i].is_cut) {
            parts.push_back(whole_part(measured[i], std::move(surface)));
            continue;
        }
        const std::vector<FilterProbe> probes = probes_of(frame, *grid, i);
        // Most objects have one colour, which a few places show.
        std::vector<FilterProbe> some;
        constexpr std::size_t few = 500;
        for (std::size_t k = 0; k < probes.size(); k += std::max<std::size_t>(1, probes.size() / few))
            some.push_back(probes[k]);
        if (some.empty()) continue;
        HF_TRY(const std::vector<Rgb> glimpse, measured_filters(queries, lattice, some, progress));
        std::size_t different = 0;
        for (const Rgb& filter : glimpse)
            different += largest_difference(filter, measured[i].filter) > same_filter;
        if (static_cast<double>(different) < 2 * least_share * static_cast<double>(glimpse.size())) {
            parts.push_back(whole_part(measured[i], std::move(surface)));
            continue;
        }
        HF_TRY(const std::vector<Rgb> filters, measured_filters(queries, lattice, probes, progress));
        const Clusters clusters = clusters_of(filters);
        if (clusters.filters.size() > 1) {
            const std::size_t first = parts.size();
            for (std::size_t k = 0; k < clusters.filters.size(); ++k) {
                FilterPart part{contoured_surface(frame, part_grid(*grid, clusters, k), requests[i].object),
                                clusters.filters[k],
                                {0, 0, 0},
                                false};
                if (!part.surface.triangles.empty()) parts.push_back(std::move(part));
            }
            HF_TRY_DONE(measure_absorption(queries, requests[i], measured[i], std::span(parts).subspan(first),
                                           progress));
            continue;
        }
        FilterPart& part = parts.emplace_back(whole_part(measured[i], std::move(surface)));
        if (clusters.filters.size() == 1) {
            part.filter = clusters.filters.front();
            continue;
        }
        std::vector<FilterProbe> at_vertices;
        for (std::size_t v = 0; v < part.surface.positions.size(); ++v)
            at_vertices.push_back({i, frame.local_point(Vec3d(part.surface.positions[v])),
                                   frame.local_normal(Vec3d(part.surface.normals[v]))});
        HF_TRY(part.surface.colours, measured_filters(queries, lattice, at_vertices, progress));
        part.filter = Rgb(1.0f);
        part.vertex_colours = true;
    }
    return parts;
}

}  // namespace haarfield
