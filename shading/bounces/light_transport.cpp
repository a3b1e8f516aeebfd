#include "shading/bounces/light_transport.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <bit>
#include <cassert>
#include <numeric>

#include "fields/base/parallel_loop.h"
#include "shading/bounces/cosine_directions.h"
#include "shading/bounces/hidden_rows.h"

namespace haarfield {
namespace {

constexpr std::size_t most_neighbours = 8;
constexpr float smoothed_share = 0.07f;  ///< Smoothing radius / distance to the hit surfaces.
constexpr float same_surface = 0.95f;    ///< Minimum cosine between the normals of neighbours.
constexpr double wanted_certainty = 0.02;
constexpr int most_directions = 4096;

/// Returns a pseudo-random number in [0, 1), a hash of x.
///
/// source  the finalizer of MurmurHash3, by Austin Appleby.
float scattered(std::uint64_t x) {
    x ^= x >> 33;
    x *= 0xff51afd7ed558ccdULL;
    x ^= x >> 33;
    x *= 0xc4ceb9fe1a85ec53ULL;
    x ^= x >> 33;
    return float(x >> 40) / float(1 << 24);
}

/// Chooses a corner that is not hidden by its weight; any corner if all are hidden.
///
/// corners  their rows.
/// number   in [0, 1).
std::size_t drawn_corner(const SurfaceHit& hit, const std::array<std::uint32_t, 3>& corners,
                         std::span<const std::uint8_t> hidden, float number) {
    const auto sum = [](const std::array<float, 3>& weights) { return weights[0] + weights[1] + weights[2]; };
    std::array<float, 3> weights = open_weights(hit, corners, hidden);
    if (!(sum(weights) > 0)) weights = hit.weights();
    const float drawn = number * sum(weights);
    return drawn < weights[1] ? 1 : drawn < weights[1] + weights[2] || weights[0] <= 0 ? 2 : 0;
}

}  // namespace

LightTransport::Neighbours LightTransport::neighbours(const ShadedEntity& entity,
                                                      std::span<const std::uint32_t> order) {
    const Mesh& mesh = *entity.mesh;
    const std::vector<std::uint8_t>& buried = entity.occlusion->samples().buried;
    // A site is a position. It has several vertices where materials or normals differ. Sites are sorted by
    // position.
    std::vector<std::uint32_t> by_position(order.size());
    std::iota(by_position.begin(), by_position.end(), 0u);
    const auto place_of = [&](std::uint32_t v) {
        const Vec3f& p = mesh.positions[v];
        return std::array{p.x, p.y, p.z};
    };
    std::ranges::sort(by_position, [&](std::uint32_t a, std::uint32_t b) {
        return std::pair(place_of(a), a) < std::pair(place_of(b), b);
    });
    std::vector<std::uint32_t> site(order.size()), first_of_site;
    for (std::uint32_t k = 0; k < by_position.size(); ++k) {
        if (k == 0 || place_of(by_position[k]) != place_of(by_position[k - 1])) first_of_site.push_back(k);
        site[by_position[k]] = static_cast<std::uint32_t>(first_of_site.size()) - 1;
    }
    const std::size_t sites = first_of_site.size();
    first_of_site.push_back(static_cast<std::uint32_t>(order.size()));
    std::vector<std::uint32_t> end_with(sites + 1, 0), beside(6 * mesh.triangles.size());
    for (const auto& triangle : mesh.triangles)
        for (const std::uint32_t v : triangle) end_with[site[v] + 1] += 2;
    std::partial_sum(end_with.begin(), end_with.end(), end_with.begin());
    std::vector<std::uint32_t> filled(end_with.begin(), end_with.end() - 1);
    for (const auto& triangle : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            for (const std::size_t other : {(k + 1) % 3, (k + 2) % 3})
                beside[filled[site[triangle[k]]]++] = site[triangle[other]];
    std::vector<std::uint32_t> place(order.size());
    for (std::uint32_t k = 0; k < order.size(); ++k) place[order[k]] = k;

    Neighbours result;
    result.end.reserve(order.size());
    std::vector<std::pair<float, std::uint32_t>> near;
    for (const std::uint32_t v : order) {
        near.clear();
        const auto add = [&](std::uint32_t s) {
            for (std::uint32_t k = first_of_site[s]; k < first_of_site[s + 1]; ++k) {
                const std::uint32_t other = by_position[k];
                if (other != v && !buried[other] && mesh.normals[other].dot(mesh.normals[v]) > same_surface)
                    near.emplace_back((mesh.positions[other] - mesh.positions[v]).length2(), place[other]);
            }
        };
        if (!buried[v]) {
            add(site[v]);
            for (std::uint32_t k = end_with[site[v]]; k < end_with[site[v] + 1]; ++k) add(beside[k]);
            std::ranges::sort(near);
            near.erase(std::unique(near.begin(), near.end()), near.end());
            near.resize(std::min(near.size(), most_neighbours));
        }
        float sum = 0;
        for (const auto& [square, other] : near) {
            result.place.push_back(other);
            sum += square;
        }
        result.square_distance.push_back(near.empty() ? 0 : sum / static_cast<float>(near.size()));
        result.end.push_back(static_cast<std::uint32_t>(result.place.size()));
    }
    return result;
}

Result<Done> LightTransport::shoot(const ShadedScene& scene, const ShadingGeometry& geometry,
                                   const FineSurface& surface, std::span<const std::uint16_t> directions,
                                   const Progress& progress) {
    const VertexRows rows(scene, geometry);
    const std::vector<std::vector<std::uint32_t>> place = row_places(scene, geometry);
    // Traces the rays of a row and appends its entries to `sources`.
    const auto shoot_row = [&](std::size_t row, std::uint32_t count, std::vector<std::uint32_t>& sources) {
        nearness_[row] = 0;
        if (hidden_[row]) return;
        const InstanceVertex at = rows[row];
        const ShadedInstance& instance = scene.instances[at.instance];
        const ShadedEntity& entity = scene.entities[instance.entity];
        const Vec3f normal = instance.placement.direction_to_world(entity.mesh->normals[at.vertex]),
                    from = instance.placement.point_to_world(entity.occlusion->samples().points[at.vertex]);
        const Axes<Vec3f> axes = axes_across(normal);
        // Numbers start at each instance, so that its directions do not depend on the other instances.
        const std::uint64_t first_number = (row - rows.first(at.instance)) * count;
        double nearness = 0;
        const auto add = [&](const SurfaceHit& hit, std::uint64_t number) {
            nearness += 1 / double(std::max(hit.distance, 1e-12f));
            if (hit.is_back) return;
            const std::size_t met = scene.instances[hit.instance].entity;
            std::array<std::uint32_t, 3> corners{};
            for (std::size_t c = 0; c < 3; ++c)
                corners[c] = static_cast<std::uint32_t>(
                    rows.first(hit.instance) +
                    place[met][scene.entities[met].mesh->triangles[hit.triangle][c]]);
            sources.push_back(corners[drawn_corner(hit, corners, hidden_, scattered(number))]);
        };
        std::array<Vec3f, FineSurface::packet> ways;
        for (std::uint32_t k = 0; k < count; k += FineSurface::packet) {
            const std::size_t rays = std::min<std::size_t>(FineSurface::packet, count - k);
            for (std::size_t r = 0; r < rays; ++r)
                ways[r] = cosine_direction(sobol_point(static_cast<std::uint32_t>(first_number + k + r)),
                                           normal, axes);
            const FineSurface::Hits hits = surface.first_hits(scene, from, std::span(ways).first(rays));
            for (std::size_t r = 0; r < rays; ++r)
                if (hits[r]) add(*hits[r], first_number + k + r);
        }
        nearness_[row] = static_cast<float>(nearness / count);
    };
    return parallel_loop(
        {blocks_.size()},
        [&]() -> LoopBody {
            return [&](std::size_t b) {
                Block& block = blocks_[b];
                const std::size_t first = b * block_rows, end = std::min(rows.count(), first + block_rows);
                const auto same = std::span(directions_).subspan(first, end - first);
                if (std::ranges::equal(same, directions.subspan(first, end - first))) return;
                Block made;
                std::uint32_t begin = 0;
                for (std::size_t row = first; row < end; ++row) {
                    const std::uint32_t stop = block.end[row - first];
                    if (directions[row] == directions_[row])
                        made.sources.insert(made.sources.end(), block.sources.begin() + begin,
                                            block.sources.begin() + stop);
                    else
                        shoot_row(row, directions[row], made.sources);
                    begin = stop;
                    directions_[row] = directions[row];
                    made.end[row - first] = static_cast<std::uint32_t>(made.sources.size());
                }
                made.sources.shrink_to_fit();
                block = std::move(made);
            };
        },
        "bounces", counted_by(block_rows, rows.count(), progress));
}

Result<LightTransport> LightTransport::make(const ShadedScene& scene, const ShadingGeometry& geometry,
                                            const FineSurface& surface, int directions,
                                            const Progress& progress) {
    assert(directions > 0 && directions <= most_directions && std::has_single_bit(unsigned(directions)));
    LightTransport made;
    const std::size_t rows = VertexRows(scene, geometry).count();
    made.nearness_.assign(rows, 0.0f);
    made.directions_.assign(rows, 0);
    made.blocks_.resize((rows + block_rows - 1) / block_rows);
    made.hidden_ = hidden_rows(scene, geometry);
    const std::vector<std::uint16_t> all(rows, static_cast<std::uint16_t>(directions));
    HF_TRY_DONE(made.shoot(scene, geometry, surface, all, progress));
    made.neighbours_.resize(scene.entities.size());
    HF_TRY_DONE(parallel_loop(
        {scene.entities.size()},
        [&]() -> LoopBody {
            return [&](std::size_t e) {
                made.neighbours_[e] = neighbours(scene.entities[e], geometry.entities[e].order);
            };
        },
        "neighbours", progress));
    const VertexRows numbers(scene, geometry);
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        made.runs_.push_back({numbers.first(i), scene.instances[i].entity,
                              scene.instances[i].placement.scale * scene.instances[i].placement.scale});
    made.find_steps();
    return made;
}

void LightTransport::find_steps() {
    steps_.resize(nearness_.size());
    for (const Run& run : runs_) {
        const std::vector<float>& squares = neighbours_[run.entity].square_distance;
        for (std::size_t place = 0; place < squares.size(); ++place) {
            // A step spreads light with half of the squared distance to the neighbours as its variance, and
            // variances of steps add up.
            const float nearness = nearness_[run.first + place],
                        square = squares[place] * run.square_scale * nearness * nearness;
            steps_[run.first + place] =
                static_cast<std::uint8_t>(square > 0 ? std::min(float(most_smoothing_steps),
                                                                2 * smoothed_share * smoothed_share / square)
                                                     : 0);
        }
    }
}

std::vector<std::uint16_t> LightTransport::wanted_directions(std::span<const Rgb> radiance,
                                                             std::span<const Rgb> reflectance) const {
    // Required directions of each row, divided by its present directions.
    std::vector<float> lacking(directions_.size(), 0.0f);
    for (const Run& run : runs_)
        tbb::parallel_for(std::size_t(0), neighbours_[run.entity].end.size(), [&](std::size_t k) {
            const std::size_t row = run.first + k, b = row / block_rows, place = row % block_rows;
            const Block& block = blocks_[b];
            double sum = 0, squares = 0;
            for (const std::uint32_t source : block.of(place)) {
                const auto value = double(luminance(radiance[source]));
                sum += value;
                squares += value * value;
            }
            const double count = directions_[row], mean = sum / count,
                         variance = std::max(0.0, squares / count - mean * mean) / count,
                         share = pi * double(luminance(reflectance[row])),
                         whole = double(luminance(radiance[row]));
            // Smoothing averages over a disc, whose area is proportional to the number of steps.
            const double averaged = 1 + 2.0 * steps_[row];
            if (whole > 0)
                lacking[row] =
                    static_cast<float>(variance * share * share /
                                       (averaged * whole * whole * wanted_certainty * wanted_certainty));
        });
    const auto directions_for = [&](std::size_t row, float scale) {
        const double wanted = double(directions_[row]) * double(lacking[row] * scale);
        int count = directions_[row];
        while (count < most_directions && count < wanted) count *= 2;
        return static_cast<std::uint16_t>(count);
    };
    double before = 0;
    for (const std::uint16_t count : directions_) before += count;
    std::vector<std::uint16_t> result(directions_.size());
    for (float scale = 1;; scale *= 0.5f) {
        double added = 0;
        for (std::size_t row = 0; row < result.size(); ++row) {
            result[row] = directions_for(row, scale);
            added += result[row] == directions_[row] ? 0 : result[row];
        }
        if (added <= before) return result;
    }
}

Result<Done> LightTransport::refine(const ShadedScene& scene, const ShadingGeometry& geometry,
                                    const FineSurface& surface, std::span<const Rgb> radiance,
                                    std::span<const Rgb> reflectance, const Progress& progress) {
    const Result<Done> shot =
        shoot(scene, geometry, surface, wanted_directions(radiance, reflectance), progress);
    if (shot) find_steps();
    return shot;
}

void LightTransport::gather(std::span<const Rgb> radiance, std::size_t first, std::size_t stride,
                            std::span<Rgb> irradiance) const {
    assert(radiance.size() == nearness_.size() && irradiance.size() == radiance.size());
    tbb::parallel_for(std::size_t(0), blocks_.size(), [&](std::size_t b) {
        const Block& block = blocks_[b];
        const std::size_t begin = b * block_rows, end = std::min(radiance.size(), begin + block_rows);
        for (std::size_t row = begin + first; row < end; row += stride) {
            Rgb sum(0.0f);
            for (const std::uint32_t source : block.of(row - begin)) sum += radiance[source];
            irradiance[row] = sum * static_cast<float>(pi / directions_[row]);
        }
    });
}

std::vector<Rgb> LightTransport::irradiance(std::span<const Rgb> radiance) const {
    std::vector<Rgb> result(radiance.size());
    gather(radiance, 0, 1, result);
    return result;
}

void LightTransport::update_irradiance(std::span<const Rgb> radiance, std::size_t first,
                                       std::span<Rgb> irradiance) const {
    assert(first < 2);
    gather(radiance, first, 2, irradiance);
}

void LightTransport::smooth(std::vector<Rgb>& irradiance, int most_steps) const {
    tbb::parallel_for(std::size_t(0), runs_.size(), [&](std::size_t r) {
        const Run& run = runs_[r];
        const Neighbours& near = neighbours_[run.entity];
        const std::span<Rgb> values = std::span(irradiance).subspan(run.first, near.end.size());
        const auto steps = std::span(steps_).subspan(run.first, values.size());
        const int most = steps.empty() ? 0 : std::min<int>(most_steps, *std::ranges::max_element(steps));
        std::vector<Rgb> other(values.begin(), values.end());
        std::span<const Rgb> before = values;
        std::span<Rgb> after = other;
        for (int step = 0; step < most; ++step) {
            tbb::parallel_for(tbb::blocked_range<std::size_t>(0, steps.size(), 1024), [&](const auto& range) {
                for (std::size_t k = range.begin(); k != range.end(); ++k) {
                    if (steps[k] < step) continue;
                    after[k] = before[k];
                    // Afterwards both arrays have the final value of the row.
                    if (steps[k] == step) continue;
                    Rgb sum(0.0f);
                    std::uint32_t count = 0;
                    for (const std::uint32_t place : near.of(k)) {
                        if (hidden_[run.first + place]) continue;
                        sum += before[place];
                        ++count;
                    }
                    if (count > 0) after[k] = (before[k] + sum / static_cast<float>(count)) * 0.5f;
                }
            });
            before = after;
            after = step % 2 == 0 ? values : std::span<Rgb>(other);
        }
        if (most % 2 == 1) std::ranges::copy(other, values.begin());
    });
}

std::size_t LightTransport::bytes() const {
    std::size_t sum = nearness_.size() * (sizeof nearness_[0] + sizeof directions_[0] + sizeof steps_[0] +
                                          sizeof hidden_[0]) +
                      blocks_.size() * sizeof blocks_[0];
    for (const Block& block : blocks_) sum += block.sources.capacity() * sizeof block.sources[0];
    for (const Neighbours& near : neighbours_)
        sum += near.end.size() * (sizeof near.end[0] + sizeof near.square_distance[0]) +
               near.place.size() * sizeof near.place[0];
    return sum;
}

}  // namespace haarfield
