#include "tests/oracles/plain_rasterizer.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace haarfield {
namespace {

/// The axes of a face: direction = axis + u * right + v * down. All are signed unit vectors, so that products
/// with them are exact.
struct FaceAxes {
    Vec3d axis, right, down;
};

FaceAxes face_axes(int face) {
    const auto axis = cubemap_direction<Vec3d>(face, 0, 0);
    return {axis, cubemap_direction<Vec3d>(face, 1, 0) - axis, cubemap_direction<Vec3d>(face, 0, 1) - axis};
}

const std::array<FaceAxes, cubemap_faces> all_face_axes{face_axes(0), face_axes(1), face_axes(2),
                                                        face_axes(3), face_axes(4), face_axes(5)};

/// The bits of the index as bytes.
struct BytesOfBits {
    std::array<std::uint64_t, 256> bytes{};
    constexpr BytesOfBits() {
        for (unsigned value = 0; value < 256; ++value)
            for (unsigned bit = 0; bit < 8; ++bit)
                bytes[value] |= std::uint64_t(value >> bit & 1u) << (8 * bit);
    }
};
constexpr BytesOfBits bytes_of_bits;

/// A side of a triangle's cone on a face: the samples with  along_u * u + along_v * v + constant >= 0.
struct Side {
    double along_u, along_v, constant;
    double slope, crossing;  ///< The line u = slope * v + crossing, if along_u is not zero.
};

void set_bits(std::uint64_t* row, int first, int last) {
    const int first_word = first >> 6, last_word = last >> 6;
    const std::uint64_t head = ~std::uint64_t(0) << (first & 63),
                        tail = ~std::uint64_t(0) >> (63 - (last & 63));
    if (first_word == last_word) {
        row[first_word] |= head & tail;
        return;
    }
    row[first_word] |= head;
    for (int word = first_word + 1; word < last_word; ++word) row[word] = ~std::uint64_t(0);
    row[last_word] |= tail;
}

}  // namespace

PlainRasterizer::PlainRasterizer(int face_size)
    : face_size_(face_size),
      words_per_row_((face_size + 63) / 64),
      blocked_(std::size_t(cubemap_faces * face_size * samples_per_texel) * std::size_t(words_per_row_)),
      open_(std::size_t(cubemap_faces * face_size) * std::size_t(face_size)) {
    assert(is_face_size(face_size));
}

// A direction d lies in the cone of the triangle (a, b, c), viewed from the origin, iff d = αa + βb + γc with
// α, β, γ >= 0. With det = a·(b×c), α = d·(b×c) / det, and so on. These are three half-spaces through the
// origin, whose normals are cross products of two vertices. No clipping is needed, wherever the vertices are.
// The normals of an edge shared by two triangles are bit-identical except for their sign. So both compute the
// same crossing, and every sample is on one side or on both.
void PlainRasterizer::block_triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c, bool both_sides) {
    const Vec3d normals[3] = {a.cross(b), b.cross(c), c.cross(a)};
    const double det = a.dot(normals[1]);
    if (!(both_sides ? det != 0 : det < 0)) return;  // counter-clockwise from outside: det < 0 in front
    const double sign = det < 0 ? -1 : 1;

    const int sub_rows = face_size_ * samples_per_texel;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const FaceAxes& axes = all_face_axes[face];
        // If all vertices are outside of one plane of the face's pyramid, the cone misses the face.
        unsigned outside_all = 15;
        double lowest_v = INFINITY, highest_v = -INFINITY;
        bool behind = false;
        for (const Vec3d* vertex : {&a, &b, &c}) {
            const double x = vertex->dot(axes.right), y = vertex->dot(axes.down), w = vertex->dot(axes.axis);
            outside_all &=
                unsigned(x > w) | unsigned(x < -w) << 1 | unsigned(y > w) << 2 | unsigned(y < -w) << 3;
            behind |= !(w > 0);
            lowest_v = std::min(lowest_v, y / w);
            highest_v = std::max(highest_v, y / w);
        }
        if (outside_all != 0) continue;
        if (behind) {  // the vertices do not bound the projection
            lowest_v = -1;
            highest_v = 1;
        }
        // One row of margin for the rounding of y / w. The sides decide.
        const int first_row =
            std::max(0, static_cast<int>(std::floor((std::max(lowest_v, -1.0) + 1) * 0.5 * sub_rows)) - 1);
        const int last_row = std::min(
            sub_rows - 1, static_cast<int>(std::ceil((std::min(highest_v, 1.0) + 1) * 0.5 * sub_rows)) + 1);

        Side sides[3];
        for (std::size_t k = 0; k < 3; ++k) {
            Side& side = sides[k];
            side.along_u = sign * normals[k].dot(axes.right);
            side.along_v = sign * normals[k].dot(axes.down);
            side.constant = sign * normals[k].dot(axes.axis);
            side.slope = -side.along_v / side.along_u;
            side.crossing = -side.constant / side.along_u;
        }
        std::uint64_t* row = blocked_.data() + (face * std::size_t(sub_rows) + std::size_t(first_row)) *
                                                   std::size_t(words_per_row_);
        for (int sub_row = first_row; sub_row <= last_row; ++sub_row, row += words_per_row_) {
            const double v = (2 * sub_row + 1) / double(sub_rows) - 1;
            double lower = -1, upper = 1;
            for (const Side& side : sides) {
                if (side.along_u == 0) {
                    if (side.along_v * v + side.constant < 0) lower = 2;
                    continue;
                }
                const double u = side.slope * v + side.crossing;
                if (side.along_u > 0) {
                    if (u > lower) lower = u;
                } else {
                    if (u < upper) upper = u;
                }
            }
            if (!(lower <= upper)) continue;
            const double offset = sample_offset(sub_row);
            const int first =
                std::max(0, static_cast<int>(std::ceil((lower + 1) * 0.5 * face_size_ - offset)));
            const int last = std::min(face_size_ - 1,
                                      static_cast<int>(std::floor((upper + 1) * 0.5 * face_size_ - offset)));
            if (first <= last) set_bits(row, first, last);
        }
    }
}

std::span<const std::uint8_t> PlainRasterizer::open_samples(const Occluder& occluder, const Vec3f& view_point,
                                                            const Vec3f* horizon) {
    std::fill(blocked_.begin(), blocked_.end(), 0);
    relative_.resize(occluder.positions().size());
    const Vec3d origin(view_point);
    for (std::size_t v = 0; v < relative_.size(); ++v) relative_[v] = Vec3d(occluder.positions()[v]) - origin;

    const Vec3d normal = horizon ? Vec3d(*horizon) : Vec3d(0.0);
    const double low = 1e-5 * occluder.bounds().radius();
    for (std::size_t t = 0; t < occluder.triangles().size(); ++t) {
        const Vec3d &a = relative_[occluder.triangles()[t][0]], &b = relative_[occluder.triangles()[t][1]],
                    &c = relative_[occluder.triangles()[t][2]];
        if (horizon && normal.dot(a) <= low && normal.dot(b) <= low && normal.dot(c) <= low) continue;
        block_triangle(a, b, c, t >= occluder.one_sided());
    }

    // Eight sub-rows form a texel row. Bytes are added for eight columns at a time.
    const std::uint64_t* row = blocked_.data();
    std::uint8_t* open = open_.data();
    const int columns_per_step = std::min(8, face_size_);
    for (int texel_row = 0; texel_row < cubemap_faces * face_size_;
         ++texel_row, row += samples_per_texel * words_per_row_)
        for (int column = 0; column < face_size_; column += columns_per_step) {
            std::uint64_t blocked = 0;
            for (int s = 0; s < samples_per_texel; ++s)
                blocked += bytes_of_bits.bytes[row[s * words_per_row_ + column / 64] >> (column % 64) & 255u];
            for (int k = 0; k < columns_per_step; ++k)
                *open++ = static_cast<std::uint8_t>(samples_per_texel - (blocked >> (8 * k) & 255u));
        }
    return open_;
}

}  // namespace haarfield
