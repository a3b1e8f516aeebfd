#include "fields/field/field_precompute.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>
#include <xxhash.h>

#include <algorithm>
#include <memory>

#include "fields/field/field_error.h"
#include "fields/rasterizer/visibility_rasterizer.h"
#include "fields/rasterizer/visibility_transform.h"

namespace haarfield {
namespace {

/// Raised whenever the same mesh and settings would give another field.
constexpr std::uint32_t field_version = 9;

template <class T>
void hash_vector(XXH3_state_t& state, const std::vector<T>& values) {
    const std::uint64_t count = values.size();
    XXH3_128bits_update(&state, &count, sizeof count);
    XXH3_128bits_update(&state, values.data(), values.size() * sizeof(T));
}

void hash_mesh(XXH3_state_t& state, const Mesh& mesh) {
    hash_vector(state, mesh.positions);
    hash_vector(state, mesh.normals);
    hash_vector(state, mesh.triangles);
}

/// What samples see.
struct SampledOccluder {
    const Occluder& around;
    const std::function<bool(const Vec3f&)>& is_inside;

    /// @name Of local samples. @{
    const Occluder* own = nullptr;
    std::span<const Vec3f> points, normals;
    std::span<const std::uint8_t> buried;
    /// @}
};

/// Makes the samples of a field, numbered in the order planar, spherical, local. From any thread.
class FieldSampler {
public:
    FieldSampler(const VisibilityField& field, const SampledOccluder& occluder)
        : field_(field), occluder_(occluder), threads_(field.settings) {
        pack_trees(CubemapTree(), closed_);
    }

    std::uint64_t local_begin() const {
        return std::uint64_t(field_.planar.sample_count()) + field_.spherical.sample_count();
    }
    std::uint64_t count() const { return local_begin() + occluder_.points.size(); }

    void sample(std::uint64_t index, PackedTrees& trees) {
        if (index < local_begin())
            sample_around(static_cast<std::uint32_t>(index), trees);
        else
            sample_local(static_cast<std::size_t>(index - local_begin()), trees);
    }

private:
    /// One thread's buffers.
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
    tbb::enumerable_thread_specific<Thread> threads_;
    PackedTrees closed_;
};

/// Neighbouring samples on their way to the pool.
struct Chunk {
    std::uint64_t first = 0;
    std::vector<PackedTrees> samples;
};

/// Sets up a field's samplers and makes its samples.
Result<Done> make_samples(VisibilityField& field, const SampledOccluder& occluder, const Bounds& bounds,
                          const FieldSettings& settings, const Progress& progress) {
    field.settings = settings;
    field.bounds = bounds;
    const Vec3f centre = field.bounds.centre();
    const float radius = field.bounds.radius();
    const Vec3f ground_centre(centre.x, field.bounds.lower.y, centre.z);
    field.planar = planar_sampler(ground_centre, radius, settings.planar_samples);
    field.spherical = spherical_sampler(centre, radius, settings.spherical_samples);

    FieldSampler sampler(field, occluder);
    const std::uint64_t total = sampler.count();
    if (total > 0x7fffffff) return Error{field.entity, "more than 2^31 samples"};

    // Chunks are made in parallel and put into the pool in order, a few at a time, so that memory stays
    // bounded and the pool does not depend on the threads.
    constexpr std::uint64_t chunk_size = 64;
    std::vector<Chunk> chunks(4 * std::size_t(tbb::this_task_arena::max_concurrency()));
    QuadtreePoolBuilder pool(settings.face_size);
    std::vector<std::int32_t> handles;
    std::uint64_t next = 0;
    const auto next_chunk = [&](tbb::flow_control& control) -> Chunk* {
        if (next >= total || progress.stop.stop_requested()) {
            control.stop();
            return nullptr;
        }
        Chunk& chunk = chunks[next / chunk_size % chunks.size()];
        chunk.first = next;
        chunk.samples.resize(std::min(chunk_size, total - next));
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
        for (const PackedTrees& trees : chunk->samples) handles.push_back(pool.add(trees));
        if (progress.report) progress.report("visibility of " + field.entity, handles.size(), total);
    };
    using tbb::filter_mode;
    tbb::parallel_pipeline(chunks.size(),
                           tbb::make_filter<void, Chunk*>(filter_mode::serial_in_order, next_chunk) &
                               tbb::make_filter<Chunk*, Chunk*>(filter_mode::parallel, make_chunk) &
                               tbb::make_filter<Chunk*, void>(filter_mode::serial_in_order, add_samples));
    if (progress.stop.stop_requested()) return Error{field.entity, interrupted};
    if (pool.is_full()) return Error{field.entity, "more than 4 GiB of quadtree nodes"};

    const auto local = handles.begin() + std::ptrdiff_t(sampler.local_begin()),
               spherical = local - std::ptrdiff_t(field.spherical.sample_count());
    field.planar_handles.assign(handles.begin(), spherical);
    field.spherical_handles.assign(spherical, local);
    field.local_handles.assign(local, handles.end());
    field.pool = std::move(pool).finish();
    return Done{};
}

}  // namespace

ContentHash field_key(const PreparedMesh& mesh, const FieldSettings& settings) {
    const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> owned(XXH3_createState(), &XXH3_freeState);
    XXH3_state_t& state = *owned;
    XXH3_128bits_reset(&state);
    XXH3_128bits_update(&state, &field_version, sizeof field_version);
    hash_mesh(state, mesh.original);
    hash_mesh(state, mesh.fine);
    hash_mesh(state, mesh.coarse);
    if (mesh.opaque) hash_mesh(state, *mesh.opaque);
    const std::array<std::int64_t, 4> counts{settings.face_size, settings.coefficients,
                                             settings.planar_samples, settings.spherical_samples};
    XXH3_128bits_update(&state, counts.data(), sizeof counts);
    XXH3_128bits_update(&state, &settings.relative_l2_error, sizeof settings.relative_l2_error);
    const XXH128_hash_t hash = XXH3_128bits_digest(&state);
    return {hash.low64, hash.high64};
}

Result<VisibilityField> precompute_field(std::string entity, const PreparedMesh& mesh,
                                         const EntityOcclusion& occlusion, const FieldSettings& settings,
                                         const Progress& progress) {
    VisibilityField field;
    field.entity = std::move(entity);
    field.key = field_key(mesh, settings);
    const std::function<bool(const Vec3f&)> is_inside = std::cref(occlusion.in_original());
    const SampledOccluder occluder{occlusion.coarse(),         is_inside,         &occlusion.own(),
                                   occlusion.samples().points, mesh.fine.normals, occlusion.samples().buried};
    if (const Result<Done> made = make_samples(field, occluder, mesh_bounds(mesh.fine), settings, progress);
        !made)
        return made.error();
    field.error = field_error(field, occlusion, progress.stop);
    if (progress.stop.stop_requested()) return Error{field.entity, interrupted};
    return field;
}

Result<VisibilityField> precompute_surroundings(std::string entity, const Occluder& occluder,
                                                const std::function<bool(const Vec3f&)>& is_inside,
                                                const FieldSettings& settings, const Progress& progress) {
    VisibilityField field;
    field.entity = std::move(entity);
    const SampledOccluder sampled{occluder, is_inside, nullptr, {}, {}, {}};
    if (const Result<Done> made = make_samples(field, sampled, occluder.bounds(), settings, progress); !made)
        return made.error();
    return field;
}

}  // namespace haarfield
