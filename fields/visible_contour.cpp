#include "fields/visible_contour.h"

#include <array>
#include <bit>
#include <cstring>

#include "fields/view_frame.h"

namespace haarfield {
namespace {

/// Each bit of the index as a byte.
struct BytesOfBits {
    std::array<std::uint64_t, 256> bytes{};
    constexpr BytesOfBits() {
        for (unsigned value = 0; value < 256; ++value)
            for (unsigned bit = 0; bit < 8; ++bit)
                bytes[value] |= std::uint64_t(value >> bit & 1u) << (8 * bit);
    }
};
constexpr BytesOfBits bytes_of_bits;

/// Tells the triangles that count from those that are left to the span rasterizer.
void tell_facing(const Occluder& occluder, const ViewedOccluder& viewed, VisibleContour& contour) {
    const float* vertices = viewed.vertices.data();
    const auto count = static_cast<std::uint32_t>(occluder.triangles.size());
    contour.facing.resize(count + 64);
    contour.left.resize(count / 64 + 1);
    for (std::uint32_t first = 0; first < count; first += 64) {
        const std::size_t w = first / 64;
        const std::uint64_t loose = occluder.contour_edges.loose[w], thin = viewed.thin.data()[w];
        const std::uint64_t counting = ~(loose | thin), two_sided = ~bits_below(occluder.one_sided, first);
        std::uint64_t front = viewed.front.data()[w] & counting,
                      back = viewed.back.data()[w] & counting & two_sided;
        std::uint64_t below = 0;
        for (std::uint64_t rest = viewed.horizon ? front | back : 0; rest != 0; rest &= rest - 1) {
            const int i = std::countr_zero(rest);
            const unsigned common = common_outcode(vertices, occluder.triangles[first + std::size_t(i)]);
            below |= std::uint64_t(common / below_horizon & 1) << i;
        }
        front &= ~below;
        back &= ~below;
        for (std::size_t i = 0; i < 8; ++i) {
            const std::uint64_t bytes =
                bytes_of_bits.bytes[front >> 8 * i & 255] | bytes_of_bits.bytes[back >> 8 * i & 255] * 255;
            std::memcpy(contour.facing.data() + first + 8 * i, &bytes, 8);
        }
        contour.left[w] = loose | thin;
    }
    contour.facing[count] = 0;  // no triangle at all
}

/// Lists the contour edges.
void list_edges(const Occluder& occluder, VisibleContour& contour) {
    const OccluderEdges& all = occluder.contour_edges;
    const std::int8_t* facing = contour.facing.data();
    contour.edges.reserve(all.sides.size() + 1);
    std::uint32_t* to = contour.edges.data();
    // Few are: no branch to guess wrong.
    const auto test = [&, sides = all.sides.data()](std::uint32_t first, std::uint32_t last) {
        for (std::uint32_t e = first; e < last; ++e) {
            *to = e;
            to += facing[sides[e].forward] != facing[sides[e].backward];
        }
    };
    const std::size_t clusters = all.first.size() - 1;
    for (std::size_t c = 0; c < clusters; ++c) {
        const std::int8_t* of = facing + 64 * c;
        std::uint64_t same, different = 0;
        std::memcpy(&same, of, 8);
        for (std::size_t i = 8; i < 64; i += 8) {
            std::uint64_t eight;
            std::memcpy(&eight, of + i, 8);
            different |= eight ^ same;
        }
        if (different != 0 || same != (same & 255) * 0x0101010101010101u)
            test(all.first[c], all.first[c + 1]);
    }
    test(all.first.back(), static_cast<std::uint32_t>(all.sides.size()));
    contour.count = static_cast<std::size_t>(to - contour.edges.data());
}

/// Copies the contour edges' ends and weights.
void gather_edges(const Occluder& occluder, const ViewedOccluder& viewed, VisibleContour& contour) {
    const OccluderEdges& all = occluder.contour_edges;
    contour.ends.reserve(8 * contour.count);
    contour.weights.reserve(contour.count);
    contour.outcodes.reserve(contour.count);
    const float* vertices = viewed.vertices.data();
    for (std::size_t i = 0; i < contour.count; ++i) {
        const EdgeEnds& ends = all.ends[contour.edges.data()[i]];
        const EdgeSides& sides = all.sides[contour.edges.data()[i]];
        const float *low = vertices + 4 * std::size_t(ends.low),
                    *high = vertices + 4 * std::size_t(ends.high);
        std::memcpy(contour.ends.data() + 8 * i, low, 16);
        std::memcpy(contour.ends.data() + 8 * i + 4, high, 16);
        contour.weights.data()[i] =
            static_cast<float>(contour.facing[sides.forward] - contour.facing[sides.backward]);
        contour.outcodes.data()[i] =
            std::bit_cast<std::uint32_t>(low[3]) & std::bit_cast<std::uint32_t>(high[3]);
    }
}

}  // namespace

void find_contour(const Occluder& occluder, const ViewedOccluder& viewed, VisibleContour& contour) {
    tell_facing(occluder, viewed, contour);
    list_edges(occluder, contour);
    gather_edges(occluder, viewed, contour);
}

}  // namespace haarfield
