#pragma once
/// What an entity hides of the world, and of itself: made once per prepared mesh, for precompute and shading.

#include "fields/occluder/occluder.h"
#include "fields/preparation/local_samples.h"
#include "fields/preparation/mesh_preparation.h"

namespace haarfield {

/// Safe to share between threads. Its parts refer to each other: it can be neither copied nor moved.
///
/// cost  some two occluders and inside tests, and one inside query per triangle of the fine mesh.
class EntityOcclusion {
public:
    /// The mesh is not referred to afterwards.
    ///
    /// stop  when it is requested, returns soon, and the result is of no use.
    explicit EntityOcclusion(const PreparedMesh& mesh, const std::stop_token& stop = {});
    EntityOcclusion(const EntityOcclusion&) = delete;
    EntityOcclusion& operator=(const EntityOcclusion&) = delete;

    /// Of the coarse mesh: what others see of the entity.
    const Occluder& coarse() const { return coarse_; }

    /// The occluder that the vertices of the fine mesh see of their own entity: the coarse or the original one.
    ///
    /// It is the original one, of up to 100,000 triangles, in two cases. A simplified two-sided surface passes
    /// over some vertices of the original surface and would darken them. Simplification also opens crevices,
    /// such as that below a cushion. The original avoids both where it has at most twice the triangles of the
    /// coarse mesh.
    const Occluder& own() const { return own_; }

    /// Of the mesh as it was read, without what images cut out.
    const Occluder& original() const { return original_; }

    /// Whether a point is inside the coarse mesh.
    const InsideTest& in_coarse() const { return in_coarse_; }
    /// Whether a point is inside the original mesh.
    const InsideTest& in_original() const { return in_original_; }

    /// One sample per vertex of the fine mesh; each sees `own`.
    const LocalSamples& samples() const { return samples_; }

    /// For points that are no vertices of the fine mesh.
    const LocalSampler& sampler() const { return sampler_; }

private:
    const Occluder coarse_, original_;
    const Occluder& own_;
    const InsideTest in_coarse_, in_original_;
    const LocalSampler sampler_;
    const LocalSamples samples_;
};

}  // namespace haarfield
