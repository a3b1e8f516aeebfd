#include "fields/field_precompute.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <xxhash.h>

#include <algorithm>
#include <memory>

#include "fields/visibility_rasterizer.h"

namespace haarfield {
namespace {

/// Raised whenever the same mesh and settings would give another field.
constexpr std::uint32_t field_version = 4;

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

/// Gives texels below the horizon what needs fewest wavelets: the mean of the nearest block that has texels
/// above it. They are multiplied by zero later.
class HorizonFill {
public:
    explicit HorizonFill(int face_size) : face_size_(face_size), directions_(texel_directions(face_size)) {}

    void operator()(std::span<float> texels, const Vec3f& normal) {
        // A texel counts if its centre lies above: of those on the horizon the cosine leaves next to nothing.
        const std::size_t face_texels = std::size_t(face_size_) * std::size_t(face_size_);
        for (std::size_t face = 0; face < cubemap_faces; ++face) {
            levels_.assign(1, {});
            Level& finest = levels_.front();
            bool any_below = false;
            for (std::size_t i = 0; i < face_texels; ++i) {
                const bool above = directions_[face * face_texels + i].dot(normal) > 0;
                any_below |= !above;
                finest.push_back(above ? Block{texels[face * face_texels + i], 1} : Block{0, 0});
            }
            if (!any_below) continue;
            fill_face(texels.subspan(face * face_texels, face_texels));
        }
    }

private:
    struct Block {
        float mean, weight;
    };
    using Level = std::vector<Block>;

    void fill_face(std::span<float> texels) {
        for (std::size_t side = std::size_t(face_size_) / 2; side >= 1; side /= 2) {
            const Level& fine = levels_.back();
            Level coarse(side * side);
            for (std::size_t y = 0; y < side; ++y)
                for (std::size_t x = 0; x < side; ++x) {
                    float weight = 0, sum = 0;
                    for (std::size_t q = 0; q < 4; ++q) {
                        const Block& block = fine[(2 * y + q / 2) * 2 * side + 2 * x + q % 2];
                        weight += block.weight;
                        sum += block.mean * block.weight;
                    }
                    coarse[y * side + x] = weight > 0 ? Block{sum / weight, weight} : Block{0, 0};
                }
            levels_.push_back(std::move(coarse));
        }
        if (levels_.back()[0].weight == 0) levels_.back()[0].mean = 1;
        std::size_t side = 1;
        for (std::size_t l = levels_.size() - 1; l-- > 0;) {
            side *= 2;
            for (std::size_t y = 0; y < side; ++y)
                for (std::size_t x = 0; x < side; ++x) {
                    Block& block = levels_[l][y * side + x];
                    if (block.weight == 0) block.mean = levels_[l + 1][y / 2 * (side / 2) + x / 2].mean;
                }
        }
        for (std::size_t i = 0; i < texels.size(); ++i) texels[i] = levels_[0][i].mean;
    }

    int face_size_;
    std::vector<Vec3f> directions_;
    std::vector<Level> levels_;
};

CubemapTree constant_cubemap(float value) {
    CubemapTree cubemap;
    for (Quadtree& face : cubemap.faces) face.scaling = value;
    return cubemap;
}

}  // namespace

CubemapTree visibility_tree(std::span<const float> visibility, int face_size, const Truncation& truncation) {
    const std::size_t face_texels = std::size_t(face_size) * std::size_t(face_size);
    CubemapTree cubemap;
    std::vector<float> occlusion(face_texels);
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const std::span<const float> texels = visibility.subspan(face * face_texels, face_texels);
        Quadtree& tree = cubemap.faces[face];
        std::transform(texels.begin(), texels.end(), occlusion.begin(), [](float v) { return 1 - v; });
        tree = haar_quadtree<float>(occlusion, face_size, truncation);
        tree.scaling = 1 - tree.scaling;
        for (Quadtree::Node& node : tree.nodes)
            for (float& wavelet : node.wavelet) wavelet = 0 - wavelet;
    }
    return cubemap;
}

namespace {

/// One thread's buffers.
struct Worker {
    VisibilityRasterizer rasterizer;
    HorizonFill fill;
    std::vector<float> texels;

    explicit Worker(int face_size) : rasterizer(face_size), fill(face_size) {}

    CubemapTree sample(const Occluder& occluder, const Vec3f& point, const Vec3f* normal,
                       const FieldSettings& settings) {
        const std::span<const std::uint8_t> open = rasterizer.open_samples(occluder, point, normal);
        texels.resize(open.size());
        std::transform(open.begin(), open.end(), texels.begin(),
                       [](std::uint8_t count) { return static_cast<float>(count) / samples_per_texel; });
        if (normal) fill(texels, *normal);
        return visibility_tree(texels, settings.face_size,
                               {settings.coefficients, settings.relative_l2_error});
    }
};

}  // namespace

ContentHash field_key(const PreparedMesh& mesh, const FieldSettings& settings) {
    const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> owned(XXH3_createState(), &XXH3_freeState);
    XXH3_state_t& state = *owned;
    XXH3_128bits_reset(&state);
    XXH3_128bits_update(&state, &field_version, sizeof field_version);
    hash_mesh(state, mesh.original);
    hash_mesh(state, mesh.fine);
    hash_mesh(state, mesh.coarse);
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
    field.settings = settings;
    field.bounds = mesh_bounds(mesh.fine);
    const Vec3f centre = field.bounds.centre();
    const float radius = field.bounds.radius();
    const Vec3f ground_centre(centre.x, field.bounds.lower.y, centre.z);
    field.planar = planar_sampler(ground_centre, radius, settings.planar_samples);
    field.spherical = spherical_sampler(centre, radius, settings.spherical_samples);

    const LocalSamples& local = occlusion.samples();

    const std::uint64_t planar_count = field.planar.sample_count(),
                        spherical_count = field.spherical.sample_count();
    const std::uint64_t total = planar_count + spherical_count + local.points.size();
    if (total > 0x7fffffff) return Error{field.entity, "more than 2^31 samples"};

    tbb::enumerable_thread_specific<Worker> workers([&] { return Worker(settings.face_size); });
    const auto sample = [&](std::uint64_t index) -> CubemapTree {
        Worker& worker = workers.local();
        if (index >= planar_count + spherical_count) {
            const auto v = static_cast<std::size_t>(index - planar_count - spherical_count);
            if (local.buried[v]) return constant_cubemap(0);
            return worker.sample(occlusion.own(), local.points[v], &mesh.fine.normals[v], settings);
        }
        Vec3f point;
        if (index < planar_count)
            // Just above the ground, lest what stands on it be seen edge-on.
            point = field.planar.sample_position(static_cast<std::uint32_t>(index)) +
                    Vec3f(0, radius * surface_offset, 0);
        else
            point = field.spherical.sample_position(static_cast<std::uint32_t>(index - planar_count));
        if (occlusion.in_original()(point)) return constant_cubemap(0);
        return worker.sample(occlusion.coarse(), point, nullptr, settings);
    };

    // Trees are made in parallel and packed in order, a chunk at a time, so that memory stays bounded and the
    // pool does not depend on the threads.
    constexpr std::uint64_t chunk = 2048;
    QuadtreePoolBuilder pool(settings.face_size);
    std::vector<CubemapTree> trees;
    for (std::uint64_t first = 0; first < total; first += chunk) {
        const std::uint64_t last = std::min(total, first + chunk);
        trees.resize(static_cast<std::size_t>(last - first));
        tbb::parallel_for(tbb::blocked_range<std::uint64_t>(first, last, 8), [&](const auto& range) {
            for (std::uint64_t i = range.begin(); i != range.end(); ++i) {
                if (progress.stop.stop_requested()) return;
                trees[static_cast<std::size_t>(i - first)] = sample(i);
            }
        });
        if (progress.stop.stop_requested()) return Error{field.entity, interrupted};
        for (std::uint64_t i = first; i < last; ++i) {
            const std::int32_t handle = pool.add(trees[static_cast<std::size_t>(i - first)]);
            (i < planar_count                     ? field.planar_handles
             : i < planar_count + spherical_count ? field.spherical_handles
                                                  : field.local_handles)
                .push_back(handle);
        }
        if (progress.report) progress.report("visibility of " + field.entity, last, total);
    }
    field.pool = std::move(pool).finish();
    return field;
}

}  // namespace haarfield
