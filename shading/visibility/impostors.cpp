#include "shading/visibility/impostors.h"

#include <algorithm>
#include <cassert>
#include <memory>

#include "fields/base/parallel_loop.h"
#include "fields/rasterizer/visibility_rasterizer.h"
#include "fields/wavelets/cubemap.h"

namespace haarfield {
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

/// A range [begin, end) of texels along an edge whose centres may lie in the image of a sphere.
struct TexelRange {
    int begin, end;
};

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

    void make(const Viewpoint& viewpoint, float distance, std::span<std::uint8_t> mask) {
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
                for (int k = 0; k < 4; ++k) {
                    const Vec3f at = viewpoint.axes.across * place(2 * column + k % 2) +
                                     viewpoint.axes.up * place(2 * row + k / 2);
                    blocked += samples_per_texel - open[texel(at - to_viewer)];
                }
                mask[index(levels[0], column, row)] = static_cast<std::uint8_t>(
                    (blocked * 255 + 2 * samples_per_texel) / (4 * samples_per_texel));
            }
        for (std::size_t k = 1; k < levels.size(); ++k)
            for (int row = 0; row < levels[k].size; ++row)
                for (int column = 0; column < levels[k].size; ++column) {
                    unsigned sum = 2;
                    for (int quarter = 0; quarter < 4; ++quarter)
                        sum += mask[index(levels[k - 1], 2 * column + quarter % 2, 2 * row + quarter / 2)];
                    mask[index(levels[k], column, row)] = static_cast<std::uint8_t>(sum / 4);
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
    made.masks_.assign(directions * distances.size() * mask_bytes, 0);
    HF_TRY_DONE(parallel_loop({directions * distances.size()},
                              [&]() -> LoopBody {
                                  return [&, maker = std::make_shared<Maker>(made, occluder)](std::size_t k) {
                                      maker->make(viewpoints()[k / distances.size()],
                                                  distances[k % distances.size()],
                                                  std::span(made.masks_).subspan(k * mask_bytes, mask_bytes));
                                  };
                              },
                              "impostors", {{}, stop}));
    return made;
}

/// Interpolates bilinearly between cell centres.
///
/// x, y  in cells, from the centre of the first cell of the border.
float Impostors::Picture::opacity(float x, float y) const {
    if (!(x >= 0 && y >= 0 && x < float(size + 1) && y < float(size + 1))) return 0;
    const int column = int(x), row = int(y), stride = size + 2, at = row * stride + column;
    const float right = x - float(column), below = y - float(row);
    const auto mean = [&](const std::uint8_t* mask) {
        const float upper = float(mask[at]) + right * (float(mask[at + 1]) - float(mask[at])),
                    lower = float(mask[at + stride]) +
                            right * (float(mask[at + stride + 1]) - float(mask[at + stride]));
        return upper + below * (lower - upper);
    };
    return (near_weight > 0 ? near_weight * mean(near) : 0) + (far_weight > 0 ? far_weight * mean(far) : 0);
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
    const std::uint8_t* masks = masks_.data() + number * distances.size() * mask_bytes + levels[level].offset;
    const Picture picture{masks, masks + mask_bytes, strength * (1 - far_share) / 255,
                          strength * far_share / 255, levels[level].size};
    const float cells = float(picture.size), sphere = width * (1 + 2 / cells),
                scale = 0.5f * cells * distance / width, offset = 0.5f * (cells + 1);
    constexpr float diagonal = 1.4142136f;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const FaceFrame& frame = face_frames()[face];
        const float right = middle.dot(frame.right), down = middle.dot(frame.down),
                    depth = middle.dot(frame.axis);
        // Skips the face if the sphere lies outside a plane of the face's frustum.
        if (std::max(std::abs(right), std::abs(down)) - depth > diagonal * sphere) continue;
        const TexelRange columns = image_of_sphere(right, depth, sphere, face_size_),
                         rows = image_of_sphere(down, depth, sphere, face_size_);
        const Vec3f of_axis(axis.dot(frame.right), axis.dot(frame.down), axis.dot(frame.axis)),
            of_across(across.dot(frame.right), across.dot(frame.down), across.dot(frame.axis)),
            of_up(up.dot(frame.right), up.dot(frame.down), up.dot(frame.axis));
        const float step = 2 / float(face_size_);
        for (int row = rows.begin; row < rows.end; ++row) {
            const float v = (float(row) + 0.5f) * step - 1;
            const float towards = -(of_axis.z + of_axis.y * v), x = of_across.z + of_across.y * v,
                        y = of_up.z + of_up.y * v;
            std::uint8_t* texels =
                &open[(face * std::size_t(face_size_) + std::size_t(row)) * std::size_t(face_size_)];
            for (int column = columns.begin; column < columns.end; ++column) {
                const float u = (float(column) + 0.5f) * step - 1, along = towards - of_axis.x * u;
                if (!(along > 0)) continue;
                const float magnified = scale / along,
                            hidden = picture.opacity((x + of_across.x * u) * magnified + offset,
                                                     (y + of_up.x * u) * magnified + offset);
                texels[column] = static_cast<std::uint8_t>(float(texels[column]) * (1 - hidden) + 0.5f);
            }
        }
    }
}

}  // namespace haarfield
