#include "fields/field/field_precompute.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>
#include <xxhash.h>

#include <algorithm>
#include <cassert>
#include <memory>

#include "fields/field/field_error.h"
#include "fields/rasterizer/visibility_rasterizer.h"
#include "fields/rasterizer/visibility_transform.h"

namespace haarfield {
namespace {

/// Raised whenever the same mesh and settings would give another field.
constexpr std::uint32_t field_version = 12;

/// The occluders that samples are taken around.
struct SampledOccluder {
    const Occluder& around;
    const std::function<bool(const Vec3f&)>& is_inside;

    /// @name For local samples. @{
    const Occluder* own = nullptr;
    std::span<const Vec3f> points, normals;
    std::span<const std::uint8_t> buried;
    /// @}
};

/// Computes the samples of a field, numbered in the order planar, spherical, local. Thread-safe.
class FieldSampler {
public:
    FieldSampler(const VisibilityField& field, const SampledOccluder& occluder,
                 std::span<const SampleRun> known)
        : field_(field), occluder_(occluder), known_(known), threads_(field.settings) {
        pack_trees(CubemapTree(), closed_);
    }

    std::uint64_t local_begin() const {
        return std::uint64_t(field_.planar.sample_count()) + field_.spherical.sample_count();
    }
    std::uint64_t count() const { return local_begin() + occluder_.points.size(); }

    void sample(std::uint64_t index, PackedTrees& trees) {
        const auto after = std::ranges::upper_bound(known_, index, {}, &SampleRun::first);
        if (after != known_.begin() && index - (after - 1)->first < (after - 1)->handles.size()) {
            const SampleRun& run = *(after - 1);
            take_trees(run.pool, run.handles[static_cast<std::size_t>(index - run.first)], trees);
        } else if (index < local_begin())
            sample_around(static_cast<std::uint32_t>(index), trees);
        else
            sample_local(static_cast<std::size_t>(index - local_begin()), trees);
    }

private:
    /// The buffers of one thread.
    struct Thread {
        VisibilityRasterizer rasterizer;
        VisibilityTransform transform;
        CubemapTree tree;

        explicit Thread(const FieldSettings& settings)
            : rasterizer(settings.face_size), transform(settings.face_size) {}
    };

    void sample_around(std::uint32_t index, PackedTrees& trees) {
        const std::uint32_t planar = field_.planar.sample_count();
        const Vec3f point = index < planar ? field_.planar.sample_position(index) + planar_lift(field_)
                                           : field_.spherical.sample_position(index - planar);
        if (occluder_.is_inside(point))
            trees = closed_;
        else
            make_trees(occluder_.around, point, nullptr, trees);
    }

    void sample_local(std::size_t vertex, PackedTrees& trees) {
        if (occluder_.buried[vertex])
            trees = closed_;
        else
            make_trees(*occluder_.own, occluder_.points[vertex], &occluder_.normals[vertex], trees);
    }

    void make_trees(const Occluder& occluder, const Vec3f& point, const Vec3f* horizon, PackedTrees& trees) {
        auto& [rasterizer, transform, tree] = threads_.local();
        transform(rasterizer.open_samples(occluder, point, horizon), horizon,
                  {field_.settings.coefficients, field_.settings.relative_l2_error}, tree);
        pack_trees(tree, trees);
    }

    const VisibilityField& field_;
    const SampledOccluder& occluder_;
    const std::span<const SampleRun> known_;
    tbb::enumerable_thread_specific<Thread> threads_;
    PackedTrees closed_;
};

/// Consecutive samples on their way to the pool.
struct Chunk {
    std::uint64_t first = 0;
    std::vector<PackedTrees> samples;
};

/// Initialises a field's samplers.
void set_samplers(VisibilityField& field, const Bounds& bounds, const FieldSettings& settings) {
    field.settings = settings;
    field.bounds = bounds;
    const Vec3f centre = field.bounds.centre();
    const float radius = field.bounds.radius();
    const Vec3f ground_centre(centre.x, field.bounds.lower.y, centre.z);
    field.planar = planar_sampler(ground_centre, radius, settings.planar_samples);
    field.spherical = spherical_sampler(centre, radius, settings.spherical_samples);
}

/// Computes the samples [begin, end).
Result<SampleRun> made_samples(const std::string& entity, const FieldSettings& settings,
                               FieldSampler& sampler, std::uint64_t begin, std::uint64_t end,
                               const Progress& progress) {
    if (sampler.count() > 0x7fffffff) return Error{entity, "more than 2^31 samples"};
    // Chunks are computed in parallel and added to the pool in order, a few at a time. So memory is bounded
    // and the pool does not depend on the number of threads.
    constexpr std::uint64_t chunk_size = 64;
    std::vector<Chunk> chunks(4 * std::size_t(tbb::this_task_arena::max_concurrency()));
    QuadtreePoolBuilder pool(settings.face_size);
    SampleRun run{begin, {}, {}};
    std::uint64_t next = begin;
    std::size_t chunk_index = 0;
    const auto next_chunk = [&](tbb::flow_control& control) -> Chunk* {
        if (next >= end || progress.stop.stop_requested()) {
            control.stop();
            return nullptr;
        }
        Chunk& chunk = chunks[chunk_index++ % chunks.size()];
        chunk.first = next;
        chunk.samples.resize(std::min(chunk_size, end - next));
        next += chunk_size;
        return &chunk;
    };
    const auto make_chunk = [&](Chunk* chunk) {
        for (std::size_t i = 0; i < chunk->samples.size() && !progress.stop.stop_requested(); ++i)
            sampler.sample(chunk->first + i, chunk->samples[i]);
        return chunk;
    };
    const auto add_samples = [&](const Chunk* chunk) {
        if (progress.stop.stop_requested() || pool.is_full()) return;
        for (const PackedTrees& trees : chunk->samples) run.handles.push_back(pool.add(trees));
        if (progress.report) progress.report("visibility of " + entity, run.handles.size(), end - begin);
    };
    using tbb::filter_mode;
    tbb::parallel_pipeline(chunks.size(),
                           tbb::make_filter<void, Chunk*>(filter_mode::serial_in_order, next_chunk) &
                               tbb::make_filter<Chunk*, Chunk*>(filter_mode::parallel, make_chunk) &
                               tbb::make_filter<Chunk*, void>(filter_mode::serial_in_order, add_samples));
    if (progress.stop.stop_requested()) return interruption(entity);
    if (pool.is_full()) return Error{entity, "more than 2^32 distinct faces of cubemaps"};
    run.pool = std::move(pool).finish();
    return run;
}

/// Computes all samples of a field whose samplers are set.
Result<Done> make_samples(VisibilityField& field, const SampledOccluder& occluder,
                          std::span<const SampleRun> known, const Progress& progress) {
    FieldSampler sampler(field, occluder, known);
    HF_TRY(SampleRun made, made_samples(field.entity, field.settings, sampler, 0, sampler.count(), progress));
    const std::vector<std::int32_t>& handles = made.handles;
    const auto local = handles.begin() + std::ptrdiff_t(sampler.local_begin()),
               spherical = local - std::ptrdiff_t(field.spherical.sample_count());
    field.planar_handles.assign(handles.begin(), spherical);
    field.spherical_handles.assign(spherical, local);
    field.local_handles.assign(local, handles.end());
    field.pool = std::move(made.pool);
    return Done{};
}

/// Returns the occluders of an entity's field. `is_inside` and the mesh must outlive the result.
SampledOccluder sampled_occluder(const PreparedMesh& mesh, const EntityOcclusion& occlusion,
                                 const std::function<bool(const Vec3f&)>& is_inside) {
    return {occlusion.coarse(),         is_inside,         &occlusion.own(),
            occlusion.samples().points, mesh.fine.normals, occlusion.samples().buried};
}

class ContentHasher {
public:
    ContentHasher() : state_(XXH3_createState(), &XXH3_freeState) {
        XXH3_128bits_reset(state_.get());
        add(field_version);
    }
    template <class T>
    void add(const T& value) {
        static_assert(std::has_unique_object_representations_v<T> || std::is_same_v<T, float>);
        XXH3_128bits_update(state_.get(), &value, sizeof value);
    }
    void add(const Mesh& mesh) {
        add_values(mesh.positions);
        add_values(mesh.normals);
        add_values(mesh.triangles);
    }
    ContentHash hash() const {
        const XXH128_hash_t hash = XXH3_128bits_digest(state_.get());
        return {hash.low64, hash.high64};
    }

private:
    template <class T>
    void add_values(const std::vector<T>& values) {
        add(std::uint64_t(values.size()));
        XXH3_128bits_update(state_.get(), values.data(), values.size() * sizeof(T));
    }

    std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_;
};

/// Returns the keys of a field whose vertices are those of `fine`.
FieldKeys keys_of(const PreparedMesh& mesh, const Mesh& fine, const FieldSettings& settings) {
    ContentHasher surroundings;
    surroundings.add(mesh.original);
    surroundings.add(mesh.coarse);
    if (mesh.opaque) surroundings.add(*mesh.opaque);
    const Bounds bounds = mesh_bounds(mesh.fine);
    for (const Vec3f& corner : {bounds.lower, bounds.upper})
        for (int axis = 0; axis < 3; ++axis) surroundings.add(corner[axis]);
    surroundings.add(std::array<std::int64_t, 4>{settings.face_size, settings.coefficients,
                                                 settings.planar_samples, settings.spherical_samples});
    surroundings.add(settings.relative_l2_error);
    FieldKeys keys{surroundings.hash(), {}};
    ContentHasher whole;
    whole.add(keys.surroundings);
    whole.add(fine);
    keys.whole = whole.hash();
    return keys;
}

/// Returns a field with samplers, but without keys and samples.
VisibilityField named_field(std::string entity, const PreparedMesh& mesh, const FieldSettings& settings) {
    VisibilityField field;
    field.entity = std::move(entity);
    set_samplers(field, mesh_bounds(mesh.fine), settings);
    return field;
}

/// Computes the samples and the error of a field whose keys and samplers are set.
Result<VisibilityField> computed_field(VisibilityField field, const PreparedMesh& mesh,
                                       const EntityOcclusion& occlusion, bool has_local,
                                       const Progress& progress, const PrecomputedSamples& known) {
    const std::function<bool(const Vec3f&)> is_inside = std::cref(occlusion.in_original());
    const SampledOccluder sampled = has_local
                                        ? sampled_occluder(mesh, occlusion, is_inside)
                                        : SampledOccluder{occlusion.coarse(), is_inside, nullptr, {}, {}, {}};
    HF_TRY_DONE(make_samples(field, sampled, known.runs, progress));
    field.error = known.error ? *known.error : field_error(field, occlusion, progress.stop);
    if (progress.stop.stop_requested()) return interruption(field.entity);
    return field;
}

}  // namespace

FieldKeys field_keys(const PreparedMesh& mesh, const FieldSettings& settings) {
    return keys_of(mesh, mesh.fine, settings);
}

FieldKeys surroundings_keys(const PreparedMesh& mesh, const FieldSettings& settings) {
    return keys_of(mesh, Mesh(), settings);
}

SampleRun surrounding_samples(const VisibilityField& field) {
    SampleRun run{0, field.planar_handles, field.pool};
    run.handles.insert(run.handles.end(), field.spherical_handles.begin(), field.spherical_handles.end());
    return run;
}

std::uint64_t sample_count(const PreparedMesh& mesh, const FieldSettings& settings) {
    VisibilityField field;
    set_samplers(field, mesh_bounds(mesh.fine), settings);
    return std::uint64_t(field.planar.sample_count()) + field.spherical.sample_count() +
           mesh.fine.positions.size();
}

Result<SampleRun> field_samples(const std::string& entity, const PreparedMesh& mesh,
                                const EntityOcclusion& occlusion, const FieldSettings& settings,
                                std::uint64_t begin, std::uint64_t end, const Progress& progress) {
    VisibilityField field;
    set_samplers(field, mesh_bounds(mesh.fine), settings);
    const std::function<bool(const Vec3f&)> is_inside = std::cref(occlusion.in_original());
    const SampledOccluder occluder = sampled_occluder(mesh, occlusion, is_inside);
    FieldSampler sampler(field, occluder, {});
    assert(begin <= end && end <= sampler.count());
    return made_samples(entity, settings, sampler, begin, end, progress);
}

Result<VisibilityField> precompute_field(std::string entity, const PreparedMesh& mesh,
                                         const EntityOcclusion& occlusion, const FieldSettings& settings,
                                         const Progress& progress, const PrecomputedSamples& known) {
    VisibilityField field = named_field(std::move(entity), mesh, settings);
    field.keys = field_keys(mesh, settings);
    return computed_field(std::move(field), mesh, occlusion, true, progress, known);
}

Result<VisibilityField> precompute_surroundings(std::string entity, const PreparedMesh& mesh,
                                                const EntityOcclusion& occlusion,
                                                const FieldSettings& settings, const Progress& progress,
                                                const PrecomputedSamples& known) {
    VisibilityField field = named_field(std::move(entity), mesh, settings);
    field.keys = surroundings_keys(mesh, settings);
    return computed_field(std::move(field), mesh, occlusion, false, progress, known);
}

VisibilityField empty_field(std::string entity, const PreparedMesh& mesh, const FieldSettings& settings) {
    return named_field(std::move(entity), mesh, settings);
}

Result<VisibilityField> precompute_surroundings(std::string entity, const Occluder& occluder,
                                                const std::function<bool(const Vec3f&)>& is_inside,
                                                const FieldSettings& settings, const Progress& progress) {
    VisibilityField field;
    field.entity = std::move(entity);
    set_samplers(field, occluder.bounds(), settings);
    const SampledOccluder sampled{occluder, is_inside, nullptr, {}, {}, {}};
    HF_TRY_DONE(make_samples(field, sampled, {}, progress));
    return field;
}

}  // namespace haarfield
