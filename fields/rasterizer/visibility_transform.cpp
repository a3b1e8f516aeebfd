#include "fields/rasterizer/visibility_transform.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <optional>

#include "fields/rasterizer/visibility_rasterizer.h"

namespace haarfield {
namespace {

/// The mean of a square without texels above the horizon.
constexpr float empty = -1;
/// The count of a texel below the horizon.
constexpr std::uint8_t empty_texel = 255;

constexpr std::size_t block_size = 8;  // texels

/// A square of a face at one level.
struct Square {
    float mean = 0;  ///< Mean visibility, or `empty`.
    std::array<float, 3> wavelet{};
    bool varies = false;  ///< True if it or a square below it has a non-zero wavelet.
};

/// A square that varies, stored in the order of Quadtree::nodes.
struct VaryingSquare {
    std::array<float, 3> wavelet;
    std::uint32_t parent;  ///< Its index; the root's parent is itself.
    std::uint16_t x, y;
    std::uint8_t level, quadrant;
    bool kept = false;          ///< True if it has a node.
    std::uint8_t children = 0;  ///< Mask of the quadrants with a node.
};

/// A wavelet and its contribution to the squared L2 norm of its face.
struct Candidate {
    float energy;
    std::uint32_t index;  ///< 3 * varying square + kind.

    /// Orders by importance. Ties go to the smaller face, the coarser level, the smaller index.
    bool operator<(const Candidate& other) const {
        return energy != other.energy ? energy > other.energy : index < other.index;
    }
};

/// 4^-level: the fraction of a face that a square of that level covers.
constexpr std::array<float, 8> level_share = [] {
    std::array<float, 8> share{1};
    for (std::size_t level = 1; level < share.size(); ++level) share[level] = share[level - 1] / 4;
    return share;
}();

/// The directions above a horizon on a face: at + along_u u + along_v v > 0.
struct FaceHorizon {
    float at, along_u, along_v;

    FaceHorizon(const Vec3f& normal, int face)
        : at(cubemap_direction<Vec3f>(face, 0, 0).dot(normal)),
          along_u(cubemap_direction<Vec3f>(face, 1, 0).dot(normal) - at),
          along_v(cubemap_direction<Vec3f>(face, 0, 1).dot(normal) - at) {}

    bool is_above(float u, float v) const { return at + along_u * u + along_v * v > 0; }
};

/// Fills the one to three empty quadrants of a square with values that need the fewest wavelets. A single one
/// gets the value without a diagonal wavelet; otherwise, each copies a neighbour.
void fill_quadrants(std::array<float, 4>& mean) {
    std::array<bool, 4> is_empty;
    for (std::size_t q = 0; q < 4; ++q) is_empty[q] = mean[q] == empty;
    const bool is_one = is_empty[0] + is_empty[1] + is_empty[2] + is_empty[3] == 1;
    for (std::size_t q = 0; q < 4; ++q) {
        if (!is_empty[q]) continue;
        const std::size_t beside = q ^ 1u, across = q ^ 2u, opposite = q ^ 3u;
        mean[q] = is_one ? std::clamp(mean[beside] + mean[across] - mean[opposite], 0.0f, 1.0f)
                         : mean[!is_empty[beside]   ? beside
                                : !is_empty[across] ? across
                                                    : opposite];
    }
}

/// Returns the square of four quadrants.
Square joined(std::array<float, 4> mean, bool varies) {
    if (mean[0] == mean[1] && mean[1] == mean[2] && mean[2] == mean[3]) return {mean[0], {}, varies};
    if (std::min({mean[0], mean[1], mean[2], mean[3]}) == empty) fill_quadrants(mean);
    const float top = mean[0] + mean[1], bottom = mean[2] + mean[3];
    const float step_on_top = mean[0] - mean[1], step_below = mean[2] - mean[3];
    Square square{
        (top + bottom) * 0.25f,
        {(step_on_top + step_below) * 0.25f, (top - bottom) * 0.25f, (step_on_top - step_below) * 0.25f},
        varies};
    for (const float wavelet : square.wavelet) square.varies |= wavelet != 0;
    return square;
}

/// Returns the least important candidate to keep, so that all less important ones have at most `allowed`
/// energy; nothing if none need be kept. May reorder the candidates. O(count).
std::optional<Candidate> least_kept(std::span<Candidate> candidates, double allowed) {
    // A histogram over energies in quarter octaves: drop whole bins until one does not fit.
    const auto bin_of = [](const Candidate& c) { return std::bit_cast<std::uint32_t>(c.energy) >> 21; };
    std::array<double, 1024> bins{};
    for (const Candidate& candidate : candidates) bins[bin_of(candidate)] += double(candidate.energy);
    std::size_t bin = 0;
    while (bin < bins.size() && bins[bin] <= allowed) allowed -= bins[bin++];
    if (bin == bins.size()) return std::nullopt;
    const auto in_bin = std::partition(candidates.begin(), candidates.end(),
                                       [&](const Candidate& c) { return bin_of(c) != bin; });
    std::sort(in_bin, candidates.end());
    auto least = candidates.end() - 1;
    while (least != in_bin && double(least->energy) <= allowed) allowed -= double((least--)->energy);
    return *least;
}

}  // namespace

struct VisibilityTransform::Buffers {
    int face_size, levels;
    std::vector<Square> squares;  ///< Of one face: level l from (4^l - 1) / 3, in row-major order.
    std::array<float, cubemap_faces> mean{};
    std::vector<VaryingSquare> varying;  ///< Squares of all faces, face by face.
    std::array<std::uint32_t, cubemap_faces + 1> first_varying{};
    std::vector<Candidate> candidates;
    std::uint64_t open_squared = 0;  ///< Sum of the squared counts above the horizon.
    std::vector<float> centres;      ///< u of the centres of texels by column, and v by row.

    explicit Buffers(int size) : face_size(size), levels(std::countr_zero(unsigned(size))) {
        squares.resize(((std::size_t(1) << (2 * levels)) - 1) / 3);
        for (int i = 0; i < size; ++i)
            centres.push_back((2 * static_cast<float>(i) + 1) / static_cast<float>(size) - 1);
    }

    Square* level(int l) { return squares.data() + ((std::size_t(1) << (2 * l)) - 1) / 3; }

    void join_children(int l, std::size_t x, std::size_t y) {
        const std::size_t side = std::size_t(1) << l;
        const Square *top = level(l + 1) + 4 * y * side + 2 * x, *bottom = top + 2 * side;
        level(l)[y * side + x] =
            joined({top[0].mean, top[1].mean, bottom[0].mean, bottom[1].mean},
                   top[0].varies || top[1].varies || bottom[0].varies || bottom[1].varies);
    }

    /// Computes the squares of a block of texels, whose rows are `stride` apart.
    void transform_block(const std::uint8_t* texels, std::size_t stride, std::size_t block_x,
                         std::size_t block_y) {
        const auto visibility = [](std::uint8_t count) {
            return count == empty_texel ? empty : static_cast<float>(count) * (1.0f / samples_per_texel);
        };
        for (std::size_t y = 0; y < block_size; ++y)
            for (std::size_t x = 0; x < block_size; ++x) {
                const std::uint32_t count = texels[y * stride + x];
                open_squared += count == empty_texel ? 0 : count * count;
            }
        const std::size_t side = std::size_t(face_size) / 2;
        for (std::size_t y = 0; y < block_size / 2; ++y) {
            Square* square = level(levels - 1) + (4 * block_y + y) * side + 4 * block_x;
            const std::uint8_t *top = texels + 2 * y * stride, *bottom = top + stride;
            for (std::size_t x = 0; x < block_size; x += 2, ++square) {
                if (top[x] == top[x + 1] && top[x] == bottom[x] && top[x] == bottom[x + 1])
                    *square = {visibility(top[x]), {}, false};
                else
                    *square = joined({visibility(top[x]), visibility(top[x + 1]), visibility(bottom[x]),
                                      visibility(bottom[x + 1])},
                                     false);
            }
        }
        for (std::size_t y = 0; y < 2; ++y)
            for (std::size_t x = 0; x < 2; ++x) join_children(levels - 2, 2 * block_x + x, 2 * block_y + y);
        join_children(levels - 3, block_x, block_y);
    }

    /// Transforms a block that the horizon may cut.
    void transform_block_above(const FaceHorizon& horizon, const std::uint8_t* texels, std::size_t block_x,
                               std::size_t block_y) {
        std::array<std::uint8_t, block_size * block_size> above;
        for (std::size_t y = 0; y < block_size; ++y) {
            const float v = centres[block_size * block_y + y];
            for (std::size_t x = 0; x < block_size; ++x)
                above[block_size * y + x] = horizon.is_above(centres[block_size * block_x + x], v)
                                                ? texels[y * std::size_t(face_size) + x]
                                                : empty_texel;
        }
        transform_block(above.data(), block_size, block_x, block_y);
    }

    /// True if all texels of a block are equal.
    bool is_uniform(const std::uint8_t* texels) const {
        std::uint64_t difference = 0;
        const std::uint64_t all = 0x0101010101010101u * texels[0];
        for (std::size_t y = 0; y < block_size; ++y) {
            std::uint64_t row;
            std::memcpy(&row, texels + y * std::size_t(face_size), sizeof row);
            difference |= row ^ all;
        }
        return difference == 0;
    }

    /// Returns the number of corner texels of a square of texels that are above the horizon. 4: all texels
    /// are; 0: none.
    int corners_above(const FaceHorizon& horizon, std::size_t x, std::size_t y, std::size_t side) const {
        const float left = centres[x], right = centres[x + side - 1];
        const float top = centres[y], bottom = centres[y + side - 1];
        return horizon.is_above(left, top) + horizon.is_above(right, top) + horizon.is_above(left, bottom) +
               horizon.is_above(right, bottom);
    }

    void add_open(std::uint64_t count, std::uint64_t texels) { open_squared += texels * count * count; }

    /// Returns the number of texels of a square of texels that are above the horizon.
    std::uint64_t texels_above(const FaceHorizon& horizon, std::size_t x, std::size_t y,
                               std::size_t side) const {
        std::uint64_t count = 0;
        const std::span columns = std::span(centres).subspan(x, side);
        for (const float v : std::span(centres).subspan(y, side)) {
            // Along a row, the horizon is crossed once at most.
            const bool first = horizon.is_above(columns.front(), v);
            const auto same = [&](float u) { return horizon.is_above(u, v) == first; };
            const auto crossing = std::ranges::partition_point(columns, same);
            count += std::uint64_t(first ? crossing - columns.begin() : columns.end() - crossing);
        }
        return count;
    }

    /// Fills `squares` for a face that is at least partly above the horizon.
    void transform_face(const std::uint8_t* open, const FaceHorizon* horizon) {
        const auto side = std::size_t(face_size);
        if (std::memcmp(open, open + 1, side * side - 1) == 0) {
            add_open(open[0], horizon ? texels_above(*horizon, 0, 0, side) : side * side);
            *level(0) = {static_cast<float>(open[0]) / samples_per_texel, {}, false};
            return;
        }
        const std::size_t blocks = side / block_size;
        for (std::size_t y = 0; y < blocks; ++y)
            for (std::size_t x = 0; x < blocks; ++x) {
                const std::uint8_t* texels = open + block_size * (y * side + x);
                Square& block = level(levels - 3)[y * blocks + x];
                const int above =
                    horizon ? corners_above(*horizon, block_size * x, block_size * y, block_size) : 4;
                if (above == 0)
                    block = {empty, {}, false};
                else if (is_uniform(texels)) {
                    block = {static_cast<float>(texels[0]) / samples_per_texel, {}, false};
                    add_open(texels[0],
                             above == 4 ? block_size * block_size
                                        : texels_above(*horizon, block_size * x, block_size * y, block_size));
                } else if (above < 4)
                    transform_block_above(*horizon, texels, x, y);
                else
                    transform_block(texels, std::size_t(face_size), x, y);
            }
        for (int l = levels - 4; l >= 0; --l) {
            const std::size_t squares_across = std::size_t(1) << l;
            for (std::size_t y = 0; y < squares_across; ++y)
                for (std::size_t x = 0; x < squares_across; ++x) join_children(l, x, y);
        }
    }

    /// Appends the varying squares of the current face, level by level.
    void append_varying() {
        const auto root = static_cast<std::uint32_t>(varying.size());
        if (!level(0)->varies) return;
        varying.push_back({level(0)->wavelet, root, 0, 0, 0, 0});
        for (std::uint32_t i = root; i < varying.size(); ++i) {
            const VaryingSquare square = varying[i];
            if (square.level + 1 == levels) continue;
            const Square* children = level(square.level + 1);
            for (unsigned q = 0; q < 4; ++q) {
                const unsigned x = 2u * square.x + (q & 1u), y = 2u * square.y + (q >> 1);
                const Square& child = children[(std::size_t(y) << (square.level + 1)) + x];
                if (!child.varies) continue;
                varying.push_back({child.wavelet, i, static_cast<std::uint16_t>(x),
                                   static_cast<std::uint16_t>(y), static_cast<std::uint8_t>(square.level + 1),
                                   static_cast<std::uint8_t>(q)});
            }
        }
    }

    /// Sets dropped wavelets to zero.
    void truncate(const Truncation& truncation) {
        if (truncation.coefficients <= 0 && truncation.relative_l2_error <= 0) return;
        candidates.clear();
        double norm = 0, dropped = 0;  // norm: squared, of the occlusion
        const auto drop = [&](const Candidate& candidate) {
            varying[candidate.index / 3].wavelet[candidate.index % 3] = 0;
        };
        for (std::size_t face = 0; face < cubemap_faces; ++face) {
            norm += double(1 - mean[face]) * (1 - mean[face]);
            const std::size_t first = candidates.size();
            for (std::uint32_t i = first_varying[face]; i < first_varying[face + 1]; ++i) {
                const float share = level_share[varying[i].level];
                for (std::uint32_t kind = 0; kind < 3; ++kind) {
                    const float wavelet = varying[i].wavelet[kind];
                    if (wavelet == 0) continue;
                    candidates.push_back({wavelet * wavelet * share, 3 * i + kind});
                    norm += double(candidates.back().energy);
                }
            }
            if (truncation.coefficients <= 0) continue;
            const std::size_t limit = first + std::size_t(truncation.coefficients);
            if (candidates.size() <= limit) continue;
            std::nth_element(candidates.begin() + std::ptrdiff_t(first),
                             candidates.begin() + std::ptrdiff_t(limit), candidates.end());
            for (std::size_t i = limit; i < candidates.size(); ++i) {
                dropped += double(candidates[i].energy);
                drop(candidates[i]);
            }
            candidates.resize(limit);
        }
        if (truncation.relative_l2_error <= 0 || candidates.empty()) return;
        constexpr double all_open = samples_per_texel * samples_per_texel;
        norm = std::min(norm, static_cast<double>(open_squared) / (all_open * face_size * face_size));
        const double allowed =
            norm * double(truncation.relative_l2_error) * double(truncation.relative_l2_error) - dropped;
        const std::optional<Candidate> least = least_kept(candidates, std::max(allowed, 0.0));
        for (const Candidate& candidate : candidates)
            if (!least || *least < candidate) drop(candidate);
    }

    /// Writes the tree of a face: the squares that still have a wavelet in them or below them.
    void write_face(std::size_t face, Quadtree& tree) {
        const std::uint32_t first = first_varying[face], last = first_varying[face + 1];
        for (std::uint32_t i = last; i-- > first;) {
            VaryingSquare& square = varying[i];
            square.kept = square.children != 0 || square.wavelet[0] != 0 || square.wavelet[1] != 0 ||
                          square.wavelet[2] != 0;
            if (square.kept && i > first)
                varying[square.parent].children |= static_cast<std::uint8_t>(1u << square.quadrant);
        }
        tree.scaling = mean[face];
        tree.nodes.clear();
        std::uint32_t next = 1;
        for (std::uint32_t i = first; i < last; ++i) {
            const VaryingSquare& square = varying[i];
            if (!square.kept) continue;
            tree.nodes.push_back({square.wavelet, square.children == 0 ? 0 : next << 4 | square.children});
            next += quadrant_count(square.children);
        }
    }
};

VisibilityTransform::VisibilityTransform(int face_size) {
    assert(is_face_size(face_size) && std::size_t(face_size) >= block_size);
    buffers_ = std::make_unique<Buffers>(face_size);
}

VisibilityTransform::~VisibilityTransform() = default;

void VisibilityTransform::operator()(std::span<const std::uint8_t> open, const Vec3f* horizon,
                                     const Truncation& truncation, CubemapTree& tree) {
    Buffers& buffers = *buffers_;
    const std::size_t face_texels = std::size_t(buffers.face_size) * std::size_t(buffers.face_size);
    assert(open.size() == cubemap_faces * face_texels);
    buffers.varying.clear();
    buffers.open_squared = 0;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        std::optional<FaceHorizon> cut;  // if the horizon cuts the face
        int above = 4;
        if (horizon) {
            cut.emplace(*horizon, static_cast<int>(face));
            above = buffers.corners_above(*cut, 0, 0, std::size_t(buffers.face_size));
        }
        if (above == 0)
            *buffers.level(0) = {empty, {}, false};
        else
            buffers.transform_face(open.data() + face * face_texels, above < 4 ? &*cut : nullptr);
        const float mean = buffers.level(0)->mean;
        buffers.mean[face] = mean == empty ? 1 : mean;
        buffers.append_varying();
        buffers.first_varying[face + 1] = static_cast<std::uint32_t>(buffers.varying.size());
    }
    buffers.truncate(truncation);
    for (std::size_t face = 0; face < cubemap_faces; ++face) buffers.write_face(face, tree.faces[face]);
}

}  // namespace haarfield
