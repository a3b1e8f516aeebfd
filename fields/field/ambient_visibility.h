#pragma once
/// Ambient visibility around an entity: volumes for other programs.

#include "fields/field/visibility_field.h"

namespace haarfield {

/// The fraction of all directions, by solid angle, that the entity does not block, on a grid of cubic voxels
/// around it: 1 far away, 1/2 on a large plane, less in a corner.
struct AmbientVisibility {
    Vec3f origin{0, 0, 0};               ///< Centre of voxel (0, 0, 0). [m]
    float voxel_size = 1;                ///< [m]
    std::array<std::int32_t, 3> size{};  ///< Voxels along x, y, z; at most 41.
    std::vector<float> values;           ///< In [0, 1]; voxel (x, y, z) is (x * size[1] + y) * size[2] + z.
    /// The mean of all unoccluded directions in the entity's frame, per voxel. Its length decreases as they
    /// become more evenly distributed. 0 if no direction is unoccluded, or all are.
    std::vector<Vec3f> directions;
};

/// Computes the volume of the bounding box, enlarged on all sides by half its radius, from the spherical
/// samples. The field must have no defect.
///
/// cost  one lookup per voxel, and one sum over the nodes of every face in use.
AmbientVisibility ambient_visibility(const VisibilityField& field);

/// Means of a visibility cubemap over all directions, weighted by solid angle.
struct DirectionMeans {
    float visibility = 0;
    Vec3f direction{0, 0, 0};  ///< Mean of visibility times direction.
};

/// Returns the means of every cubemap of a pool, by handle.
///
/// accuracy  that of the stored trees. Solid angles of texels are exact; directions are those of texel
///           centres.
std::vector<DirectionMeans> mean_over_directions(const QuadtreePool& pool);

}  // namespace haarfield
