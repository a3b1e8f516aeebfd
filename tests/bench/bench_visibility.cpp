/// Benchmarks of visibility cubemaps: the rasterizer, Embree's packets and the plain loop, in one run.

#include <benchmark/benchmark.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>
#include <map>
#include <string>

#include "fields/base/embree_rays.h"
#include "fields/field/entity_occlusion.h"
#include "fields/field/samplers.h"
#include "fields/preparation/mesh_preparation.h"
#include "fields/rasterizer/visibility_rasterizer.h"
#include "scenes/furniture/furniture.h"
#include "tests/oracles/embree_oracle.h"
#include "tests/oracles/plain_rasterizer.h"

namespace haarfield {
namespace {

constexpr int face_size = 64;
constexpr std::size_t texel_count = std::size_t(cubemap_faces) * face_size * face_size;

/// Embree's packets of sixteen rays. A packet has the samples of two neighbouring texels, so that its rays
/// are as coherent as possible.
class EmbreePackets {
public:
    EmbreePackets(const Occluder& occluder, const char* device_settings)
        : oracle_(occluder, device_settings) {
        for (int face = 0; face < cubemap_faces; ++face)
            for (int row = 0; row < face_size; ++row)
                for (int column = 0; column < face_size; ++column)
                    for (int s = 0; s < samples_per_texel; ++s)
                        directions_.emplace_back(sub_sample_direction(face, column, row, s, face_size));
        open_.resize(texel_count);
    }

    std::span<const std::uint8_t> open_samples(const Vec3f& origin) {
        alignas(64) std::int32_t valid[16];
        std::fill(std::begin(valid), std::end(valid), -1);
        alignas(64) RTCRay16 rays{};
        for (std::size_t i = 0; i < directions_.size(); i += 16) {
            for (std::size_t k = 0; k < 16; ++k) {
                rays.org_x[k] = origin.x;
                rays.org_y[k] = origin.y;
                rays.org_z[k] = origin.z;
                rays.dir_x[k] = directions_[i + k].x;
                rays.dir_y[k] = directions_[i + k].y;
                rays.dir_z[k] = directions_[i + k].z;
                rays.tnear[k] = 0;
                rays.tfar[k] = INFINITY;
                rays.mask[k] = ~0u;
                rays.flags[k] = 0;
            }
            test_occlusion(static_cast<RTCScene>(oracle_.scene()), valid, rays, Coherence::high);
            for (std::size_t texel = 0; texel < 2; ++texel) {
                int open = 0;
                for (std::size_t s = 0; s < 8; ++s) open += rays.tfar[8 * texel + s] > 0;
                open_[i / 8 + texel] = static_cast<std::uint8_t>(open);
            }
        }
        return open_;
    }

private:
    EmbreeOracle oracle_;
    std::vector<Vec3f> directions_;
    std::vector<std::uint8_t> open_;
};

struct ViewPoint {
    Vec3f point;
    const Vec3f* horizon;
};

/// A piece of the shipped furniture as an occluder, with view points.
struct Subject {
    PreparedMesh mesh;
    Occluder closed, soup;  ///< One-sided for closed pieces; all triangles two-sided.
    std::map<std::string, std::vector<ViewPoint>> points;
};

const Subject& subject(const std::string& name) {
    static std::map<std::string, Subject> made;
    const auto [entry, is_new] = made.try_emplace(name);
    Subject& found = entry->second;
    if (!is_new) return found;
    const bool is_table = name == "table";
    found.mesh = *prepare_mesh({is_table ? table_mesh() : chair_mesh(), {}},
                               {is_table ? 25000u : 30000u, is_table ? 4500u : 5000u});
    found.closed = make_occluder(found.mesh.coarse);
    OccluderTriangles soup = found.closed.source();
    soup.one_sided = 0;
    found.soup = Occluder(std::move(soup));

    constexpr std::uint32_t wanted = 60;
    const Bounds bounds = mesh_bounds(found.mesh.fine);
    const Vec3f centre = bounds.centre(), ground(centre.x, bounds.lower.y, centre.z);
    const float radius = bounds.radius();
    const InsideTest is_inside(found.closed);
    const auto add = [&](const char* kind, const Vec3f& point, const Vec3f* horizon) {
        if (!is_inside(point)) found.points[kind].push_back({point, horizon});
    };
    const PlanarSampler planar = planar_sampler(ground, radius, 20000);
    for (std::uint32_t i = 0; i < wanted; ++i)
        add("planar",
            planar.sample_position(planar.sample_count() / wanted * i) + Vec3f(0, radius * surface_offset, 0),
            nullptr);
    const SphericalSampler spherical = spherical_sampler(centre, radius, 10000);
    for (std::uint32_t i = 0; i < wanted; ++i)
        add("spherical", spherical.sample_position(spherical.sample_count() / wanted * i), nullptr);
    const LocalSamples local = EntityOcclusion(found.mesh).samples();
    for (std::size_t i = 0; i < wanted; ++i) {
        const std::size_t v = local.points.size() / wanted * i;
        if (!local.buried[v]) add("local", local.points[v], &found.mesh.fine.normals[v]);
    }
    return found;
}

/// Returns the processor time of this thread, which excludes other programs. [s]
double cpu_seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// The time of the last call of `work`, and the minimum over all calls. [s]
struct Stopwatch {
    double least = INFINITY, last = 0;

    template <class Work>
    void time(Work&& work) {
        const double start = cpu_seconds();
        work();
        last = cpu_seconds() - start;
        least = std::min(least, last);
    }
};

/// Returns the number of samples in which the rasterizer and Embree differ, or -1 if a texel differs by more
/// than one sample. Counts only texels above the horizon if there is one.
std::int64_t differing_samples(std::span<const std::uint8_t> found, std::span<const std::uint8_t> wanted,
                               const Vec3f* horizon) {
    std::int64_t differing = 0;
    for (std::size_t i = 0; i < texel_count; ++i) {
        const int texel = static_cast<int>(i), face = texel / (face_size * face_size);
        const Vec3f direction =
            texel_direction(face, texel % face_size, texel / face_size % face_size, face_size);
        if (horizon && horizon->dot(direction) < 2.0f / face_size) continue;
        const int difference = std::abs(int(found[i]) - int(wanted[i]));
        if (difference > 1) return -1;
        differing += difference;
    }
    return differing;
}

/// Restricts the rasterizer to one instruction set.
class OneTarget {
public:
    explicit OneTarget(std::int64_t target) { choose(target); }
    ~OneTarget() { choose(0); }
    OneTarget(const OneTarget&) = delete;
    OneTarget& operator=(const OneTarget&) = delete;

private:
    static void choose(std::int64_t target) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
};

/// Measures one subject. Embree is restricted to AVX2 if the rasterizer is.
void visibility(benchmark::State& state, const std::string& name, const std::string& kind, bool closed,
                std::int64_t target) {
    const OneTarget only(target);
    const Subject& of = subject(name);
    const Occluder& occluder = closed ? of.closed : of.soup;
    const std::vector<ViewPoint>& points = of.points.at(kind);
    VisibilityRasterizer rasterizer(face_size);
    PlainRasterizer plain(face_size);
    EmbreePackets embree(occluder, target == HWY_AVX2 ? "isa=avx2" : nullptr);

    std::int64_t differing = 0;
    for (const auto& [point, horizon] : points) {
        const std::int64_t here = differing_samples(rasterizer.open_samples(occluder, point, horizon),
                                                    embree.open_samples(point), horizon);
        if (here < 0) return state.SkipWithError("a texel is wrong, so not timed");
        differing += here;
    }
    const double samples = double(points.size()) * texel_count * samples_per_texel;
    if (double(differing) > 1e-5 * samples) return state.SkipWithError("too much is wrong, so not timed");

    // The three alternate, so that disturbances affect all of them. Embree and the plain loop are slow and
    // vary little, so that an eighth of the points is sufficient.
    Stopwatch raster, packets, loop;
    double slow_points = 0;
    for (std::size_t i = 0; i < points.size(); i += 8) ++slow_points;
    for (auto _ : state) {
        packets.time([&] {
            for (std::size_t i = 0; i < points.size(); i += 8)
                benchmark::DoNotOptimize(embree.open_samples(points[i].point).data());
        });
        loop.time([&] {
            for (std::size_t i = 0; i < points.size(); i += 8)
                benchmark::DoNotOptimize(
                    plain.open_samples(occluder, points[i].point, points[i].horizon).data());
        });
        for (int repeat = 0; repeat < 5; ++repeat)
            raster.time([&] {
                for (const auto& [point, horizon] : points)
                    benchmark::DoNotOptimize(rasterizer.open_samples(occluder, point, horizon).data());
            });
        state.SetIterationTime(raster.last);
    }
    const double ours = raster.least / double(points.size());
    state.counters["us"] = 1e6 * ours;
    state.counters["embree16_us"] = 1e6 * packets.least / slow_points;
    state.counters["plain_us"] = 1e6 * loop.least / slow_points;
    state.counters["times_embree16"] = packets.least / slow_points / ours;
    state.counters["times_plain"] = loop.least / slow_points / ours;
    state.counters["differing_ppm"] = 1e6 * double(differing) / samples;
    state.SetItemsProcessed(state.iterations() * std::int64_t(points.size()));  // items: cubemaps
}

/// The best instruction set of this machine, and AVX2.
std::vector<std::int64_t> compared_targets() {
    const std::vector<std::int64_t> all = hwy::SupportedAndGeneratedTargets();  // the best one first
    std::vector<std::int64_t> compared{all.front()};
    if (all.front() != HWY_AVX2 && std::find(all.begin(), all.end(), HWY_AVX2) != all.end())
        compared.push_back(HWY_AVX2);
    return compared;
}

const bool registered = [] {
    for (const std::int64_t target : compared_targets())
        for (const char* name : {"table", "chair"})
            for (const char* kind : {"planar", "spherical", "local"})
                for (const bool closed : {true, false})
                    benchmark::RegisterBenchmark((std::string("visibility/") + name + "/" + kind +
                                                  (closed ? "/closed/" : "/soup/") + hwy::TargetName(target))
                                                     .c_str(),
                                                 visibility, name, kind, closed, target)
                        ->UseManualTime()
                        ->Unit(benchmark::kMillisecond);
    return true;
}();

}  // namespace
}  // namespace haarfield
