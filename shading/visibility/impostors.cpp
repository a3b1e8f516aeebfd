#include "shading/visibility/impostors.h"

#include <algorithm>
#include <cassert>
#include <memory>

#include "fields/base/parallel_loop.h"
#include "fields/rasterizer/visibility_rasterizer.h"
#include "fields/wavelets/cubemap.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/visibility/impostors.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef HAARFIELD_IMPOSTORS_ONCE
#define HAARFIELD_IMPOSTORS_ONCE

namespace haarfield {

/// One level of the masks of a direction, and the weights of the nearer and the farther mask.
struct MaskLevel {
    const std::uint8_t* cells;      ///< Opacity in the nearer and the farther mask, by cell. [1/255]
    int size;                       ///< Cells along an edge, without the border.
    float near_weight, far_weight;  ///< Together at most 1/255.
};

/// The plane of a mask, projected onto a face. A number a u + b v + c is stored as (a, b, c).
struct MaskOnFace {
    Vec3f along, across, up;  ///< Components of a texel's direction, towards the mask and along its edges.
    float scale, offset;      ///< A cell's number along an edge is scale * across / along + offset.
};

/// A range [begin, end) of texels along an edge whose centres may lie in the image of a sphere.
struct TexelRange {
    int begin, end;
};

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 16>;
using Numbers = hn::RebindToSigned<Floats>;
using VF = hn::Vec<Floats>;
using VI = hn::Vec<Numbers>;

/// Returns the opacity of two adjacent cells, loaded as four bytes, interpolated by the second's weight.
HWY_INLINE VF opacity_between(const MaskLevel& level, VI cells, VF weight) {
    const Floats d;
    const hn::RebindToUnsigned<Numbers> du;
    const auto bytes = hn::BitCast(du, cells);
    const auto number = [&](auto shifted) {
        return hn::ConvertTo(d, hn::BitCast(Numbers(), hn::And(shifted, hn::Set(du, 255u))));
    };
    const auto cell = [&](auto near, auto far) {
        return hn::Add(hn::Mul(hn::Set(d, level.near_weight), number(near)),
                       hn::Mul(hn::Set(d, level.far_weight), number(far)));
    };
    const VF first = cell(bytes, hn::ShiftRight<8>(bytes)),
             second = cell(hn::ShiftRight<16>(bytes), hn::ShiftRight<24>(bytes));
    return hn::Add(first, hn::Mul(weight, hn::Sub(second, first)));
}

/// Returns opacity, interpolated bilinearly between cell centres. Positions are in cells, from the centre of
/// the first cell of the border; 0 outside the mask and where not `wanted`.
HWY_INLINE VF opacity_at(const MaskLevel& level, VF x, VF y, hn::Mask<Floats> wanted) {
    const Floats d;
    const Numbers di;
    const VF zero = hn::Zero(d), end = hn::Set(d, static_cast<float>(level.size + 1));
    const auto inside = hn::And(
        wanted, hn::And(hn::And(hn::Ge(x, zero), hn::Lt(x, end)), hn::And(hn::Ge(y, zero), hn::Lt(y, end))));
    if (hn::AllFalse(d, inside)) return zero;
    const VF at_x = hn::IfThenElseZero(inside, x), at_y = hn::IfThenElseZero(inside, y);
    const VI column = hn::ConvertTo(di, at_x), row = hn::ConvertTo(di, at_y);
    const std::int32_t stride = 2 * (level.size + 2);
    const VI upper = hn::Add(hn::Mul(row, hn::Set(di, stride)), hn::Add(column, column));
    const auto* bytes = reinterpret_cast<const std::int32_t*>(level.cells);
    const auto row_of = [&](VI offsets) {
        return opacity_between(level, hn::GatherOffset(di, bytes, offsets),
                               hn::Sub(at_x, hn::ConvertTo(d, column)));
    };
    const VF above = row_of(upper), below = row_of(hn::Add(upper, hn::Set(di, stride)));
    const VF weight = hn::Sub(at_y, hn::ConvertTo(d, row));
    return hn::IfThenElseZero(inside, hn::Add(above, hn::Mul(weight, hn::Sub(below, above))));
}

/// Multiplies the visibility of a row of texels by the transparency of a mask.
///
/// length  of the row, at least a vector.
/// lane    numbers of the lanes: 0, 1, 2, ... They are slow to compute.
HWY_INLINE void hide_in_row(const MaskLevel& level, const MaskOnFace& on, TexelRange columns, float v,
                            float step, int length, VF lane, std::uint8_t* texels) {
    const Floats d;
    const Numbers di;
    const hn::Rebind<std::uint8_t, Floats> bytes;
    const int lanes = static_cast<int>(hn::Lanes(d));
    const auto at = [&](const Vec3f& component, VF u) {
        return hn::Add(hn::Set(d, component.z + component.y * v), hn::Mul(hn::Set(d, component.x), u));
    };
    for (int column = columns.begin; column < columns.end; column += lanes) {
        // The last vector ends with the row, and may overlap the one before it.
        const int first = std::min(column, length - lanes);
        const VF number = hn::Add(lane, hn::Set(d, static_cast<float>(first)));
        const VF u = hn::Sub(hn::Mul(hn::Add(number, hn::Set(d, 0.5f)), hn::Set(d, step)), hn::Set(d, 1.0f));
        const VF along = at(on.along, u), magnified = hn::Div(hn::Set(d, on.scale), along),
                 offset = hn::Set(d, on.offset);
        const auto wanted =
            hn::And(hn::Gt(along, hn::Zero(d)), hn::Ge(number, hn::Set(d, static_cast<float>(column))));
        const VF hidden = opacity_at(level, hn::Add(hn::Mul(at(on.across, u), magnified), offset),
                                     hn::Add(hn::Mul(at(on.up, u), magnified), offset), wanted);
        const VF open = hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(bytes, texels + first)));
        const VF rest = hn::Add(hn::Mul(open, hn::Sub(hn::Set(d, 1.0f), hidden)), hn::Set(d, 0.5f));
        hn::StoreU(hn::DemoteTo(bytes, hn::ConvertTo(di, rest)), bytes, texels + first);
    }
}

void hide_on_face(const MaskLevel& level, const MaskOnFace& on, TexelRange columns, TexelRange rows,
                  int face_size, std::uint8_t* face) {
    const float step = 2 / static_cast<float>(face_size);
    const int lanes = static_cast<int>(hn::Lanes(Floats()));
    const VF lane = hn::Iota(Floats(), 0);
    for (int row = rows.begin; row < rows.end; ++row) {
        const float v = (static_cast<float>(row) + 0.5f) * step - 1;
        std::uint8_t* texels = face + std::size_t(row) * std::size_t(face_size);
        if (face_size >= lanes) {
            hide_in_row(level, on, columns, v, step, face_size, lane, texels);
        } else {
            std::uint8_t widened[16] = {};
            std::copy_n(texels, face_size, widened);
            hide_in_row(level, on, columns, v, step, lanes, lane, widened);
            std::copy_n(widened, face_size, texels);
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(hide_on_face);

namespace {

// Directions are the cells of an octahedral map: the octahedron |x| + |y| + |z| = 1 viewed from above, with
// its lower half folded outwards to the corners of the square.

constexpr int map_size = 24;
constexpr std::size_t directions = std::size_t(map_size) * map_size;

/// A viewing direction with its horizontal and vertical axes.
struct Viewpoint {
    Vec3f direction;
    Axes<Vec3f> axes;
};

float with_sign_of(float value, float sign) {
    return sign < 0 ? -value : value;
}

Viewpoint viewpoint(std::size_t number) {
    const float x = (2.0f * float(number % map_size) + 1) / map_size - 1,
                z = (2.0f * float(number / map_size) + 1) / map_size - 1, y = 1 - std::abs(x) - std::abs(z);
    const Vec3f direction =
        y >= 0 ? Vec3f(x, y, z)
               : Vec3f(with_sign_of(1 - std::abs(z), x), y, with_sign_of(1 - std::abs(x), z));
    const Vec3f unit = direction.normalized();
    return {unit, axes_across(unit)};
}

const std::vector<Viewpoint>& viewpoints() {
    static const std::vector<Viewpoint> made = [] {
        std::vector<Viewpoint> list;
        for (std::size_t k = 0; k < directions; ++k) list.push_back(viewpoint(k));
        return list;
    }();
    return made;
}

/// Returns the index of the viewpoint whose cell contains a direction.
std::size_t nearest_viewpoint(const Vec3f& direction) {
    const float sum = std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z);
    float x = direction.x / sum, z = direction.z / sum;
    if (direction.y < 0) {
        const float folded = with_sign_of(1 - std::abs(z), x);
        z = with_sign_of(1 - std::abs(x), z);
        x = folded;
    }
    const auto cell = [](float coordinate) {
        return static_cast<std::size_t>(
            std::clamp((coordinate + 1) * (map_size / 2.0f), 0.0f, map_size - 1.0f));
    };
    return cell(z) * map_size + cell(x);
}

/// The axes of a face in the world.
struct FaceFrame {
    Vec3f right, down, axis;
};

const std::array<FaceFrame, cubemap_faces>& face_frames() {
    static const std::array<FaceFrame, cubemap_faces> frames = [] {
        std::array<FaceFrame, cubemap_faces> made;
        for (int face = 0; face < cubemap_faces; ++face) {
            const auto axis = cubemap_direction<Vec3f>(face, 0, 0);
            made[std::size_t(face)] = {cubemap_direction<Vec3f>(face, 1, 0) - axis,
                                       cubemap_direction<Vec3f>(face, 0, 1) - axis, axis};
        }
        return made;
    }();
    return frames;
}

/// Returns the texels along an edge whose centres may lie in the image of a sphere.
///
/// middle, depth  position of the sphere along the edge and along the face's axis.
TexelRange image_of_sphere(float middle, float depth, float radius, int size) {
    // The image is unbounded if the sphere surrounds the viewer, or almost does.
    if (!(depth > 1.01f * radius)) return {0, size};
    const float root = radius * std::sqrt(middle * middle + depth * depth - radius * radius),
                scale = 1 / (depth * depth - radius * radius), half = 0.5f * float(size);
    const auto texel = [&](float slope) {
        return static_cast<int>(std::ceil(std::clamp((slope + 1) * half - 0.5f, 0.0f, float(size))));
    };
    return {texel((middle * depth - root) * scale), texel((middle * depth + root) * scale)};
}

/// The texels of a face whose centres may lie in an image.
struct FaceArea {
    TexelRange columns, rows;

    bool is_empty() const { return columns.begin >= columns.end || rows.begin >= rows.end; }
};

/// Returns the part of an area that a quadrilateral covers. If a corner is behind the face, returns the area.
FaceArea image_of_quadrilateral(const std::array<Vec3f, 4>& corners, const FaceFrame& frame,
                                const FaceArea& area, int size) {
    float left = INFINITY, right = -INFINITY, top = INFINITY, bottom = -INFINITY;
    for (const Vec3f& corner : corners) {
        const float depth = corner.dot(frame.axis);
        if (!(depth > 1e-3f * corner.length())) return area;
        const float u = corner.dot(frame.right) / depth, v = corner.dot(frame.down) / depth;
        left = std::min(left, u);
        right = std::max(right, u);
        top = std::min(top, v);
        bottom = std::max(bottom, v);
    }
    const auto part = [&](const TexelRange& range, float begin, float end) {
        // Wider by a texel against rounding.
        const float half = 0.5f * static_cast<float>(size), edge = static_cast<float>(size);
        return TexelRange{
            std::max(range.begin, static_cast<int>(std::clamp((begin + 1) * half - 1.5f, 0.0f, edge))),
            std::min(range.end, static_cast<int>(std::clamp((end + 1) * half + 1.5f, 0.0f, edge)))};
    };
    return {part(area.columns, left, right), part(area.rows, top, bottom)};
}

}  // namespace

/// Makes masks on one thread.
struct Impostors::Maker {
    const Impostors& made;
    const Occluder& occluder;
    const int face_size;
    VisibilityRasterizer rasterizer;

    Maker(const Impostors& impostors, const Occluder& seen)
        : made(impostors),
          occluder(seen),
          // A finer cubemap than the one that uses the mask.
          face_size(std::min(2 * impostors.face_size_, 256)),
          rasterizer(face_size) {}

    /// masks  of the direction. k: the number of the distance, which is the place of its mask in each cell.
    void make(const Viewpoint& viewpoint, std::size_t k, std::uint8_t* masks) {
        const float distance = distances[k];
        const auto cell_of = [&](const Level& level, int column, int row) -> std::uint8_t& {
            return masks[distances.size() * index(level, column, row) + k];
        };
        const Vec3f to_viewer = viewpoint.direction * (distance * made.radius_);
        const std::span<const std::uint8_t> open =
            rasterizer.open_samples(occluder, made.centre_ + to_viewer);
        const float cell = 2 * half_width * made.radius_ / finest;
        // Samples each cell by four rays.
        const auto place = [&](int sub_cell) {
            return ((float(sub_cell) + 0.5f) * 0.5f - finest / 2) * cell;
        };
        for (int row = 0; row < finest; ++row)
            for (int column = 0; column < finest; ++column) {
                int blocked = 0;
                for (int quarter = 0; quarter < 4; ++quarter) {
                    const Vec3f at = viewpoint.axes.across * place(2 * column + quarter % 2) +
                                     viewpoint.axes.up * place(2 * row + quarter / 2);
                    blocked += samples_per_texel - open[texel(at - to_viewer)];
                }
                cell_of(levels[0], column, row) = static_cast<std::uint8_t>(
                    (blocked * 255 + 2 * samples_per_texel) / (4 * samples_per_texel));
            }
        for (std::size_t l = 1; l < levels.size(); ++l)
            for (int row = 0; row < levels[l].size; ++row)
                for (int column = 0; column < levels[l].size; ++column) {
                    unsigned sum = 2;
                    for (int quarter = 0; quarter < 4; ++quarter)
                        sum += cell_of(levels[l - 1], 2 * column + quarter % 2, 2 * row + quarter / 2);
                    cell_of(levels[l], column, row) = static_cast<std::uint8_t>(sum / 4);
                }
    }

private:
    static std::size_t index(const Level& level, int column, int row) {
        return level.offset + std::size_t((row + 1) * (level.size + 2) + column + 1);
    }
    std::size_t texel(const Vec3f& direction) const {
        const CubemapPoint at = cubemap_point(Vec3d(direction));
        const auto number = [&](double coordinate) {
            return std::min(static_cast<int>((coordinate + 1) * 0.5 * face_size), face_size - 1);
        };
        return std::size_t((at.face * face_size + number(at.v)) * face_size + number(at.u));
    }
};

Result<Impostors> Impostors::make(const Occluder& occluder, int face_size, const std::stop_token& stop) {
    Impostors made;
    made.face_size_ = face_size;
    made.centre_ = occluder.bounds().centre();
    made.radius_ = occluder.bounds().radius();
    made.masks_.assign(directions * mask_bytes, 0);
    made.extents_.resize(directions);
    HF_TRY_DONE(parallel_loop({directions * distances.size()},
                              [&]() -> LoopBody {
                                  return [&, maker = std::make_shared<Maker>(made, occluder)](std::size_t k) {
                                      const std::size_t direction = k / distances.size();
                                      maker->make(viewpoints()[direction], k % distances.size(),
                                                  &made.masks_[direction * mask_bytes]);
                                  };
                              },
                              "impostors", {{}, stop}));
    for (std::size_t k = 0; k < directions; ++k) made.extents_[k] = made.extent_of(k);
    return made;
}

Impostors::Extent Impostors::extent_of(std::size_t direction) const {
    Extent extent;
    const std::uint8_t* masks = &masks_[direction * mask_bytes];
    for (std::uint8_t row = 0; row < finest; ++row)
        for (std::uint8_t column = 0; column < finest; ++column) {
            const std::size_t cell = std::size_t((row + 1) * (finest + 2) + column + 1);
            if (masks[distances.size() * cell] == 0 && masks[distances.size() * cell + 1] == 0) continue;
            extent.left = std::min(extent.left, column);
            extent.right = std::max<std::uint8_t>(extent.right, column + 1);
            extent.bottom = std::min(extent.bottom, row);
            extent.top = std::max<std::uint8_t>(extent.top, row + 1);
        }
    return extent;
}

void Impostors::hide(const Placement& placement, const Vec3f& point, std::span<std::uint8_t> open) const {
    assert(open.size() == std::size_t(cubemap_faces * face_size_ * face_size_));
    const Vec3f to_viewer = point - placement.point_to_world(centre_), middle = -to_viewer;
    const float distance = to_viewer.length(), radius = radius_ * placement.scale;
    if (!(distance > radius)) return;
    const Vec3f axis = to_viewer / distance;
    const std::size_t number = nearest_viewpoint(placement.direction_to_object(axis));
    Vec3f across = placement.direction_to_world(viewpoints()[number].axes.across);
    across = (across - axis * axis.dot(across)).normalized();
    const Vec3f up = axis.cross(across);

    // Cells are not much smaller than a texel: otherwise lookups at texel centres would miss some of them.
    // They are never smaller than a texel, in which case the mask is enlarged and its opacity reduced.
    constexpr float least_cell = 0.7f;  // texels
    const float texel = 2 * distance / float(face_size_), true_width = half_width * radius;
    std::size_t level = 0;
    while (level + 1 < levels.size() && 2 * true_width < least_cell * texel * float(levels[level].size))
        ++level;
    const float width = std::max(true_width, 0.5f * texel),
                strength = (true_width / width) * (true_width / width);
    const float far_share = std::clamp(
        (1 / distances[0] - radius / distance) / (1 / distances[0] - 1 / distances[1]), 0.0f, 1.0f);
    const MaskLevel masks{masks_.data() + number * mask_bytes + distances.size() * levels[level].offset,
                          levels[level].size, strength * (1 - far_share) / 255, strength * far_share / 255};
    const float cells = float(masks.size), sphere = width * (1 + 2 / cells),
                scale = 0.5f * cells * distance / width, offset = 0.5f * (cells + 1);
    // Interpolation reaches one cell beyond those that are not empty.
    const Extent& extent = extents_[number];
    if (extent.left >= extent.right) return;
    const auto place = [&](int cell, float cells_beyond) {
        return (2 * float(cell) / finest - 1 + 2 * cells_beyond / cells) * width;
    };
    const float left = place(extent.left, -1), right = place(extent.right, 1),
                bottom = place(extent.bottom, -1), top = place(extent.top, 1);
    const std::array<Vec3f, 4> corners{middle + across * left + up * bottom,
                                       middle + across * right + up * bottom,
                                       middle + across * left + up * top, middle + across * right + up * top};
    constexpr float diagonal = 1.4142136f;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const FaceFrame& frame = face_frames()[face];
        const float beside = middle.dot(frame.right), down = middle.dot(frame.down),
                    depth = middle.dot(frame.axis);
        // Skips the face if the sphere lies outside a plane of the face's frustum.
        if (std::max(std::abs(beside), std::abs(down)) - depth > diagonal * sphere) continue;
        const FaceArea area = image_of_quadrilateral(corners, frame,
                                                     {image_of_sphere(beside, depth, sphere, face_size_),
                                                      image_of_sphere(down, depth, sphere, face_size_)},
                                                     face_size_);
        if (area.is_empty()) continue;
        const auto on_face = [&](const Vec3f& direction) {
            return Vec3f(direction.dot(frame.right), direction.dot(frame.down), direction.dot(frame.axis));
        };
        const std::size_t texels = std::size_t(face_size_) * std::size_t(face_size_);
        HWY_DYNAMIC_DISPATCH(hide_on_face)
        (masks, {on_face(-axis), on_face(across), on_face(up), scale, offset}, area.columns, area.rows,
         face_size_, &open[face * texels]);
    }
}

}  // namespace haarfield
#endif
