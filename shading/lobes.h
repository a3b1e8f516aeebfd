#pragma once
/// BRDF lobes and the cosine as trees, by the direction that they point to.

#include "fields/haar_transform.h"
#include "fields/progress.h"
#include "fields/result.h"

namespace haarfield {

/// The lobe  f(w) = max(0, d.w)^exponent  for all directions d.
///
/// Tabulated on a grid over the cubemap, equal in angle along each face's edges, borders included, so that
/// bilinear interpolation is continuous over the sphere. (Sun and Mukherjee 2006, section 6.1, BRDF.) With
/// exponent 1 and d the normal it is the clamped cosine; with d the mirror direction, the Phong lobe.
struct LobeTable {
    float exponent = 1;
    int steps = 0;                   ///< Grid cells along a face's edge.
    std::vector<CubemapTree> lobes;  ///< By (face * (steps+1) + row) * (steps+1) + column.
};

/// exponent    0 < exponent <= 1000.
/// size        texels along a face's edge.
/// truncation  per face of each lobe. The mean of a face is kept, so that no energy is lost.
/// accuracy    of interpolation: below 1 % of the peak up to exponent 150, some 6 % at 1000, energy kept.
/// cost        25,000 transforms at full resolution; 10 to 200 MB.
/// errors      interrupted.
Result<LobeTable> lobe_table(float exponent, int size, const Truncation& truncation,
                             const Progress& progress = {});

/// The lobe that points to a unit direction, interpolated from four of the table.
CubemapTree interpolated_lobe(const LobeTable& table, const Vec3f& direction);

/// The mean of max(0, d.w)^exponent over each texel, face by face: what the table is made from.
std::vector<float> lobe_texels(float exponent, const Vec3f& direction, int size);

/// The half space n.w > 0 as trees: each square holds exactly the fraction of it (in face area) that lies
/// above the plane. cost: some 100 nodes per face that the horizon crosses.
CubemapTree half_space_tree(const Vec3f& normal, int size);

}  // namespace haarfield
