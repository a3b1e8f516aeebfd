#include "fields/field/visibility_field.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>

#include "fields/preparation/local_samples.h"
#include "fields/wavelets/haar_transform.h"

namespace haarfield {

std::string ContentHash::hex() const {
    return fmt::format("{:016x}{:016x}", high, low);
}

ContentHash content_hash(std::string_view bytes) {
    const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
    return {hash.low64, hash.high64};
}

Vec3f planar_lift(const VisibilityField& field) {
    return {0, field.bounds.radius() * surface_offset, 0};
}

CubemapTree interpolated_visibility(const VisibilityField& field, const std::vector<std::int32_t>& handles,
                                    const Interpolation& interpolation) {
    CubemapTree result;
    std::array<Quadtree, 8> corners;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        std::array<const Quadtree*, 8> trees;
        std::array<float, 8> weights;
        std::array<std::uint32_t, 8> faces;
        std::size_t count = 0;
        // Corners that share a face are merged, with the sum of their weights.
        for (int i = 0; i < interpolation.count; ++i) {
            const auto sample = interpolation.sample[std::size_t(i)];
            const std::uint32_t index = field.pool.cubemaps[std::size_t(handles[sample])][face];
            std::size_t slot = 0;
            while (slot < count && faces[slot] != index) ++slot;
            if (slot == count) {
                faces[count] = index;
                weights[count] = 0;
                unpack_face(field.pool, index, corners[count]);
                trees[count] = &corners[count];
                ++count;
            }
            weights[slot] += interpolation.weight[std::size_t(i)];
        }
        if (count > 0)
            result.faces[face] = weighted_sum(std::span<const Quadtree* const>(trees.data(), count),
                                              std::span<const float>(weights.data(), count));
        result.faces[face].scaling += interpolation.open;
    }
    return result;
}

namespace {

std::string handles_defect(const char* name, const std::vector<std::int32_t>& handles,
                           const QuadtreePool& pool) {
    for (std::size_t i = 0; i < handles.size(); ++i)
        if (handles[i] < 0 || std::size_t(handles[i]) >= pool.cubemaps.size())
            return fmt::format("{} handle {} is {}; the pool has {} cubemaps", name, i, handles[i],
                               pool.cubemaps.size());
    return {};
}

bool is_positive(float value) {
    return std::isfinite(value) && value > 0;
}

bool is_error(const SamplerError& error) {
    return std::isfinite(error.relative) && error.relative >= 0 &&
           std::all_of(error.band.begin(), error.band.end(),
                       [](float band) { return band >= 0 && band <= 1; });
}

}  // namespace

std::string field_defect(const VisibilityField& field) {
    constexpr std::int32_t limit = 1 << 24;
    const PlanarSampler& planar = field.planar;
    if (planar.rings < 2 || planar.angles < 3 || planar.rings > limit || planar.angles > limit ||
        std::int64_t(planar.rings) * planar.angles != std::int64_t(field.planar_handles.size()))
        return fmt::format("planar sampler of {} x {} samples with {} handles", planar.rings, planar.angles,
                           field.planar_handles.size());
    const SphericalSampler& spherical = field.spherical;
    if (spherical.shells < 2 || spherical.polar < 3 || spherical.azimuths < 3 || spherical.shells > limit ||
        spherical.polar > limit || spherical.azimuths > limit ||
        std::int64_t(spherical.shells) * spherical.polar > limit ||
        std::int64_t(spherical.shells) * spherical.polar * spherical.azimuths !=
            std::int64_t(field.spherical_handles.size()))
        return fmt::format("spherical sampler of {} x {} x {} samples with {} handles", spherical.shells,
                           spherical.polar, spherical.azimuths, field.spherical_handles.size());
    constexpr float largest_growth = 20;  // beyond it the radii leave the range of floats
    if (!is_positive(planar.outer_radius) || !is_positive(planar.growth) || planar.growth > largest_growth ||
        spherical.growth > largest_growth || !is_positive(spherical.outer_radius) ||
        !is_positive(spherical.growth) || !is_finite(planar.centre) || !is_finite(spherical.centre))
        return "a sampler's radius, growth or centre is not a positive, finite number";
    if (!is_finite(field.bounds.lower) || !is_finite(field.bounds.upper)) return "the bounds are not finite";
    if (!is_error(field.error.planar) || !is_error(field.error.spherical))
        return "an error estimate is out of range";
    if (field.pool.face_size != field.settings.face_size)
        return fmt::format("face size is {} in the pool, {} in the settings", field.pool.face_size,
                           field.settings.face_size);
    for (const auto& [name, handles] :
         {std::pair("planar", &field.planar_handles), std::pair("spherical", &field.spherical_handles),
          std::pair("local", &field.local_handles)})
        if (std::string defect = handles_defect(name, *handles, field.pool); !defect.empty()) return defect;
    return pool_defect(field.pool);
}

}  // namespace haarfield
