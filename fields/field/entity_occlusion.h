#pragma once
/// The occluders of an entity, for other objects and for itself, built once per prepared mesh for precompute
/// and shading.

#include "fields/occluder/occluder.h"
#include "fields/preparation/local_samples.h"
#include "fields/preparation/mesh_preparation.h"
#include "fields/preparation/mesh_simplification.h"

#include <mutex>

namespace haarfield {

/// Results of an earlier EntityOcclusion of the same mesh.
struct KnownOcclusion {
    std::optional<LocalSamples> samples{};
    std::optional<std::vector<CoarserMesh>> coarser{};
};

/// Safe to share between threads. Members refer to each other, so that it can be neither copied nor moved.
///
/// cost  two occluders, two inside tests, and one inside query per triangle of the fine mesh.
class EntityOcclusion {
public:
    /// Builds the occluders. The mesh is not referred to afterwards.
    ///
    /// known  is not computed again.
    /// stop   after a stop request, returns soon with an unusable result.
    explicit EntityOcclusion(const PreparedMesh& mesh, KnownOcclusion known = {},
                             const std::stop_token& stop = {});
    EntityOcclusion(const EntityOcclusion&) = delete;
    EntityOcclusion& operator=(const EntityOcclusion&) = delete;

    /// The occluder of the coarse mesh, which blocks light for other objects.
    const Occluder& coarse() const { return coarse_; }

    /// The occluder by which the entity occludes its own vertices: that of the coarse or the original mesh.
    ///
    /// The original mesh is used in two cases, if it has at most 100,000 triangles:
    /// - It is two-sided. A simplified surface would pass over some vertices and darken them.
    /// - It has at most twice the triangles of the coarse mesh. Simplification opens crevices, such as that
    ///   below a cushion.
    const Occluder& own() const { return own_; }

    /// The occluder of the original mesh, without the areas that images cut out. It can be rasterized only if
    /// it is own().
    const Occluder& original() const { return original_; }

    /// Tests whether a point is inside the coarse mesh.
    const InsideTest& in_coarse() const { return in_coarse_; }
    /// Tests whether a point is inside the original mesh.
    const InsideTest& in_original() const { return in_original_; }

    /// One sample point per vertex of the fine mesh, for visibility around own().
    const LocalSamples& samples() const { return samples_; }

    /// Places samples at points that are not vertices of the fine mesh.
    const LocalSampler& sampler() const { return sampler_; }

    /// Simplifications of coarse(), for distant points; none if it has less than 1,000 triangles. Made when
    /// first needed. Throws Interrupted.
    const std::vector<CoarserMesh>& coarser(const Progress& progress = {}) const;

private:
    const Occluder coarse_, original_;
    const Occluder& own_;
    const InsideTest in_coarse_, in_original_;
    const LocalSampler sampler_;
    const LocalSamples samples_;
    mutable std::once_flag coarser_made_;
    mutable std::optional<std::vector<CoarserMesh>> coarser_;
};

}  // namespace haarfield
