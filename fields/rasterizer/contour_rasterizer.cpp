#include "fields/rasterizer/contour_rasterizer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/rasterizer/contour_rasterizer.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "fields/rasterizer/contour_crossings-inl.h"

// The number of layers along a ray changes where the ray's direction crosses the image of an edge. Each
// facing triangle of the edge changes it by one, up or down, depending on the side of the edge on which it
// lies. At an edge between two triangles that are both front-facing or both back-facing, one is entered as
// the other is left. The remaining edges are contour edges. Each sub-column of a face is traversed from its
// pole, the direction -down, at which the layers are counted once. Each contour edge changes the number of
// layers where it crosses the sub-column. Triangles count by their facing, independent of their winding, so
// the number is never negative.
//
// The ends of an edge alone determine which sub-columns it crosses. So the edges of a closed contour are
// always consistent. An edge with one end behind the face's plane w = 0 leaves through one of the poles. The
// side of the pole is determined by the same exact predicate that counts the layers at the pole.

#ifndef HAARFIELD_CONTOUR_RASTERIZER_ONCE
#define HAARFIELD_CONTOUR_RASTERIZER_ONCE

namespace haarfield {

inline constexpr int most_layers = 255;  ///< The largest value of a counter.

/// Computes the positions of the sub-columns, in texels from the centre of a face.
inline void fill_columns(int face_size, AlignedBuffer<float>& columns) {
    const std::size_t count = std::size_t(samples_per_texel * face_size) + 16;
    columns.reserve(count);
    for (std::size_t k = 0; k < count; ++k)
        columns.data()[k] =
            (static_cast<float>(k) + 0.5f) / samples_per_texel - 0.5f * static_cast<float>(face_size);
}

/// Adds the changes of lines above the first row to `starts`: each at both of its ends.
inline void change_starts(const LineList& list, std::uint8_t* starts) {
    for (std::size_t i = 0; i < list.count; ++i) {
        const auto begin = static_cast<std::size_t>(list.data(line_begin)[i]),
                   end = static_cast<std::size_t>(list.data(line_end)[i]);
        const auto change = static_cast<int>(list.data(line_change)[i]);
        starts[begin] = static_cast<std::uint8_t>(starts[begin] + change);
        starts[end] = static_cast<std::uint8_t>(starts[end] - change);
    }
}

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Replaces the starts by their prefix sums over the sub-columns.
void sum_starts(std::size_t count, std::uint8_t* starts) {
#if HWY_TARGET == HWY_SCALAR
    std::partial_sum(starts, starts + count, starts);
#else
    const hn::FixedTag<std::uint8_t, 16> d;
    auto before = hn::Zero(d);
    for (std::size_t k = 0; k < count; k += 16) {
        auto sum = hn::Load(d, starts + k);
        sum = hn::Add(sum, hn::ShiftLeftBytes<1>(d, sum));
        sum = hn::Add(sum, hn::ShiftLeftBytes<2>(d, sum));
        sum = hn::Add(sum, hn::ShiftLeftBytes<4>(d, sum));
        sum = hn::Add(hn::Add(sum, hn::ShiftLeftBytes<8>(d, sum)), before);
        hn::Store(sum, d, starts + k);
        before = hn::TableLookupBytes(sum, hn::Set(d, 15));
    }
#endif
}

/// Sums the counters from the first row to the last, and clears them. Sets one bit per sample with layers.
void sum_layers(int face_size, int at_pole, const ContourExtent& extent, LayerChanges& changes,
                std::uint8_t* blocked) {
    const auto size = static_cast<std::size_t>(face_size), stride = samples_per_texel * size;
    const auto top = static_cast<std::size_t>(extent.top), left = static_cast<std::size_t>(extent.left),
               right = static_cast<std::size_t>(extent.right);
    std::uint8_t *counters = changes.counters, *starts = changes.starts;
    starts[0] = static_cast<std::uint8_t>(starts[0] + at_pole);
    sum_starts(stride, starts);
    std::memset(blocked, at_pole > 0 ? 255 : 0, size * size);
#if HWY_TARGET == HWY_SCALAR
    for (std::size_t k = left; k < right; ++k) {
        std::uint8_t layers = starts[k];
        for (std::size_t r = top; r < size; ++r) {
            layers = static_cast<std::uint8_t>(layers + counters[r * stride + k]);
            std::uint8_t& bits = blocked[r * size + k / 8];
            bits = static_cast<std::uint8_t>((bits & ~(1u << k % 8)) | unsigned(layers != 0) << k % 8);
            counters[r * stride + k] = 0;
        }
        counters[size * stride + k] = 0;
    }
#else
    const hn::CappedTag<std::uint8_t, 64> d;
    const auto zero = hn::Zero(d);
    const std::size_t lanes = hn::Lanes(d),
                      bottom = std::min(size, static_cast<std::size_t>(extent.bottom) + 2);
    for (std::size_t k = left & ~(lanes - 1); k < right; k += lanes) {
        auto layers = hn::Load(d, starts + k);
        std::uint8_t *from = counters + top * stride + k, *to = blocked + top * size + k / 8;
        for (std::size_t r = top; r < bottom; ++r, from += stride, to += size) {
            layers = hn::Add(layers, hn::Load(d, from));
            hn::Store(zero, d, from);
            hn::StoreMaskBits(d, hn::Ne(layers, zero), to);
        }
        hn::Store(zero, d, from);  // crossings below the last row
        std::uint8_t last[8] = {};
        hn::StoreMaskBits(d, hn::Ne(layers, zero), last);
        for (std::size_t r = bottom; r < size; ++r, to += size) std::memcpy(to, last, lanes / 8);
    }
#endif
    std::memset(starts, 0, stride + 1);
}

/// Calls `visit` with the lines of a face, edges_at_a_time per call. Returns their extent.
template <class Visit>
ContourExtent for_each_face_lines(const VisibleContour& contour, int face, int face_size,
                                  ContourScratch& scratch, Visit&& visit) {
    ContourExtent extent;
    const std::size_t count = contour.of_face[std::size_t(face)].count;
    for (std::size_t first = 0; first < count; first += edges_at_a_time) {
        FaceLines lines(scratch.lines.data());
        set_up_lines(contour, first, std::min(edges_at_a_time, count - first), face, face_size, lines,
                     extent);
        visit(lines);
    }
    return extent;
}

/// Returns the maximum, over the sub-columns of a face, of the number of layers that begin.
int most_beginning(const VisibleContour& contour, int face, int face_size, ContourScratch& scratch) {
    std::vector<int> beginning(std::size_t(samples_per_texel * face_size) + 1, 0);
    const auto add = [&](const LineList& list) {
        for (std::size_t i = 0; i < list.count; ++i) {
            const auto data = [&](LineData k) { return static_cast<int>(list.data(k)[i]); };
            const int change = std::max(0, data(line_change));
            beginning[std::size_t(data(line_begin))] += change;
            beginning[std::size_t(data(line_end))] -= change;
        }
    };
    for_each_face_lines(contour, face, face_size, scratch, [&](const FaceLines& lines) {
        add(lines.in_front);
        add(lines.above);
    });
    std::partial_sum(beginning.begin(), beginning.end(), beginning.begin());
    return *std::max_element(beginning.begin(), beginning.end());
}

/// Draws the edges of a face into the counters. Returns the changed region.
ContourExtent count_changes(const VisibleContour& contour, int face, int face_size, ContourScratch& scratch,
                            LayerChanges& changes) {
    const ContourExtent extent =
        for_each_face_lines(contour, face, face_size, scratch, [&](const FaceLines& lines) {
            change_starts(lines.above, changes.starts);
            const std::size_t wide = list_narrow(lines.in_front, face_size, changes, scratch.wide.data());
            list_wide(lines.in_front, scratch.wide.data(), wide, face_size, scratch.columns.data(), changes);
        });
    changes.apply();
    return extent;
}

bool block_contour(const Occluder& occluder, const ViewedOccluder& viewed, const VisibleContour& contour,
                   ContourScratch& scratch, BlockedSamples& blocked) {
    const int face_size = blocked.face_size;
    LayerChanges changes{scratch.counters.data(),
                         scratch.starts.data(),
                         {scratch.crossings[0].data()},
                         {scratch.crossings[1].data()}};
    int poles[3][2] = {{-1, -1}, {-1, -1}, {-1, -1}};
    for (int face = 0; face < cubemap_faces; ++face) {
        const int axis = all_face_components[face].component[1];
        const bool is_upwards = all_face_components[face].sign[1] < 0;  // the pole is at -v
        int& at_pole = poles[axis][is_upwards];
        if (at_pole < 0)
            at_pole = viewed.is_turned ? scratch.turned_poles.layers[std::size_t(axis)][is_upwards]
                                       : layers_along_axis(occluder, viewed, axis, is_upwards);
        using Contours = BlockedSamples::Contours;
        Contours& contours = blocked.contoured_faces[std::size_t(face)];
        const ContourExtent extent = count_changes(contour, face, face_size, scratch, changes);
        if (!(extent.left < extent.right)) {
            contours = at_pole > 0 ? Contours::block_all : Contours::block_nothing;
            continue;
        }
        sum_layers(face_size, at_pole, extent, changes, blocked.texels(face));
        contours = Contours::vary;
        if (static_cast<float>(at_pole) + extent.beginning > most_layers &&
            at_pole + most_beginning(contour, face, face_size, scratch) > most_layers) {
            blocked.contoured_faces.fill(Contours::block_nothing);
            return false;
        }
    }
    return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(block_contour);

bool block_contour(const Occluder& occluder, const ViewedOccluder& viewed, const VisibleContour& contour,
                   ContourScratch& scratch, BlockedSamples& blocked) {
    const auto size = static_cast<std::size_t>(blocked.face_size), stride = samples_per_texel * size;
    if (size < 8) return false;
    if (scratch.columns.data() == nullptr) fill_columns(blocked.face_size, scratch.columns);
    scratch.lines.reserve(FaceLines::floats);
    scratch.wide.reserve(edges_stride);
    for (AlignedBuffer<std::uint32_t>& places : scratch.crossings)
        places.reserve(CrossingList::room(blocked.face_size));
    scratch.counters.reserve((size + 1) * stride);
    scratch.starts.reserve(stride + 64);
    if (viewed.is_turned) find_turned_poles(occluder, viewed, contour, scratch.turned_poles);
    return HWY_DYNAMIC_DISPATCH(block_contour)(occluder, viewed, contour, scratch, blocked);
}

}  // namespace haarfield
#endif
