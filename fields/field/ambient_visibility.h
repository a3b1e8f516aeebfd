#pragma once
/// How open an entity leaves the space around it, and which way: volumes for viewers.

#include "fields/field/visibility_field.h"

namespace haarfield {

/// The fraction of all directions, by solid angle, that the entity leaves open, on a grid of cubic voxels
/// around it: 1 far away, 1/2 on a large plane, less in a corner.
struct AmbientVisibility {
    Vec3f origin{0, 0, 0};               ///< Centre of voxel (0, 0, 0). [m]
    float voxel_size = 1;                ///< [m]
    std::array<std::int32_t, 3> size{};  ///< Voxels along x, y, z; at most 41.
    std::vector<float> values;           ///< In [0, 1]; voxel (x, y, z) is (x * size[1] + y) * size[2] + z.
    /// The mean of all directions that are open, in the entity's frame: no unit vector, but the shorter the
    /// more evenly they lie round; 0 where nothing is open, or all. By voxel, too.
    std::vector<Vec3f> directions;
};

/// Of the bounding box, enlarged on all sides by half its radius, from the spherical samples. The field must
/// be without defect.
///
/// cost  one lookup a voxel, and one sum over the nodes of every face in use.
AmbientVisibility ambient_visibility(const VisibilityField& field);

/// Means over all directions, weighted by solid angle, of a cubemap of visibility.
struct DirectionMeans {
    float visibility = 0;
    Vec3f direction{0, 0, 0};  ///< Of visibility times direction.
};

/// Of every cubemap of a pool; by handle.
///
/// accuracy  that of the stored trees; the solid angles of the texels are exact, directions are those of
///           their middles.
std::vector<DirectionMeans> mean_over_directions(const QuadtreePool& pool);

}  // namespace haarfield
