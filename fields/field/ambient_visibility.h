#pragma once
/// How open an entity leaves the space around it: a volume for viewers.

#include "fields/field/visibility_field.h"

namespace haarfield {

/// The fraction of all directions, by solid angle, that the entity leaves open, on a grid of cubic voxels
/// around it: 1 far away, 1/2 on a large plane, less in a corner.
struct AmbientVisibility {
    Vec3f origin{0, 0, 0};               ///< Centre of voxel (0, 0, 0). [m]
    float voxel_size = 1;                ///< [m]
    std::array<std::int32_t, 3> size{};  ///< Voxels along x, y, z; at most 41.
    std::vector<float> values;           ///< In [0, 1]; voxel (x, y, z) is (x * size[1] + y) * size[2] + z.
};

/// Of the bounding box, enlarged on all sides by half its radius, from the spherical samples. The field must
/// be without defect.
///
/// cost  one lookup a voxel, and one sum over the nodes of every face in use.
AmbientVisibility ambient_visibility(const VisibilityField& field);

/// Mean of every cubemap of a pool over all directions, weighted by solid angle. By handle.
///
/// accuracy  that of the stored trees; the solid angles of the texels are exact.
std::vector<float> mean_over_directions(const QuadtreePool& pool);

}  // namespace haarfield
