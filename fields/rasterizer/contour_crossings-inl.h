/// Crossings of contour lines with the sub-columns of a cubemap face.
/// Included once per instruction set, as Highway requires.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "fields/rasterizer/contour_lines-inl.h"
#include "fields/rasterizer/sample_pattern.h"

#ifndef HAARFIELD_FIELDS_CONTOUR_CROSSINGS_ONCE
#define HAARFIELD_FIELDS_CONTOUR_CROSSINGS_ONCE

namespace haarfield {

/// The number of listed crossings at which a list is applied.
inline constexpr std::size_t crossings_at_a_time = 4096;

/// 2^23 as a float, and its bits. The bits of 2^23 + n are float_offset_bits + n, for an integer n < 2^23.
inline constexpr float float_offset = 0x1p23f;
inline constexpr std::uint32_t float_offset_bits = 0x4b000000;

/// Crossings of lines and sub-columns: indices of counters plus float_offset_bits. A crossing at which the
/// number of layers changes by two is listed twice.
struct CrossingList {
    std::uint32_t* places;
    std::size_t count = 0;

    /// The required capacity: a full list, two lines across all sub-columns or eight across a texel's, and
    /// one vector.
    static constexpr std::size_t room(int face_size) {
        return crossings_at_a_time +
               std::size_t(2 * samples_per_texel) * std::size_t(std::max(face_size, 8)) + 16;
    }

    /// Adds `change` to the counters of all crossings, then empties the list.
    void apply(int change, std::uint8_t* counters) {
        std::for_each(places, places + count, [change, counters](std::uint32_t place) {
            std::uint8_t& counter = counters[place - float_offset_bits];
            counter = static_cast<std::uint8_t>(counter + change);
        });
        count = 0;
    }
};

/// The counters of a face, and changes that have not been applied to them yet.
struct LayerChanges {
    std::uint8_t *counters, *starts;
    CrossingList beginning, ending;  ///< Crossings at which a layer begins, and at which one ends.

    void apply() {
        beginning.apply(1, counters);
        ending.apply(-1, counters);
    }
    /// Must be called often enough that the next crossings always fit.
    void apply_if_full() {
        if (std::max(beginning.count, ending.count) > crossings_at_a_time) apply();
    }
};

}  // namespace haarfield

#endif

#if defined(HAARFIELD_FIELDS_CONTOUR_CROSSINGS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef HAARFIELD_FIELDS_CONTOUR_CROSSINGS_INL_H
#undef HAARFIELD_FIELDS_CONTOUR_CROSSINGS_INL_H
#else
#define HAARFIELD_FIELDS_CONTOUR_CROSSINGS_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Lists the crossings of lines no wider than a texel: one line per lane, one sub-column per step. Stores the
/// numbers of wider lines in `wide` and returns their count.
inline HWY_NOINLINE std::size_t list_narrow(const LineList& list, int face_size, LayerChanges& changes,
                                            std::uint32_t* wide) {
    using ShortFloats = hn::CappedTag<float, 8>;  // longer vectors would wait for the longest of more lines
    using ShortNumbers = hn::RebindToUnsigned<ShortFloats>;
    const ShortFloats d;
    const ShortNumbers du;
    const hn::RebindToSigned<ShortFloats> di;
    const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f), middle = hn::Set(d, 0.5f),
               half_face = hn::Set(d, 0.5f * static_cast<float>(face_size)),
               stride = hn::Set(d, static_cast<float>(samples_per_texel * face_size)),
               per_texel = hn::Set(d, 1.0f / samples_per_texel), most = hn::Set(d, float(samples_per_texel));
    const auto last_sub_row = hn::Set(di, samples_per_texel - 1);
    std::size_t wide_count = 0;
    auto numbers = hn::Iota(du, 0u);
    LayerChanges now = changes;
    for (std::size_t i = 0; i < list.count; i += hn::Lanes(d)) {
        const auto data = [&](LineData k) { return hn::LoadU(d, list.data(k) + i); };
        const auto begin = data(line_begin), end = data(line_end), change = data(line_change);
        const auto valid = hn::FirstN(d, list.count - i), is_narrow = hn::Le(hn::Sub(end, begin), most);
        const ChosenLanes<ShortNumbers> others(du, hn::RebindMask(du, hn::AndNot(is_narrow, valid)));
        others.store(numbers, du, wide + wide_count);
        wide_count += others.count();
        numbers = hn::Add(numbers, hn::Set(du, static_cast<std::uint32_t>(hn::Lanes(d))));

        const auto slope = data(line_slope), constant = data(line_constant), lowest = data(line_lowest),
                   highest = data(line_highest);
        const auto begins = hn::Gt(change, zero);
        const auto on_line = hn::IfThenZeroElse(begins, one),
                   narrow_end = hn::IfThenElseZero(hn::And(valid, is_narrow), end);
        const bool twice = !hn::AllFalse(d, hn::And(valid, hn::Gt(hn::Abs(change), one)));
        // Sub-column k has its sample in sub-row (3 k + 1) mod 8.
        const auto first = hn::ConvertTo(di, begin);
        auto sub_row = hn::Add(hn::Add(first, first), hn::Add(first, hn::Set(di, 1)));
        auto k = begin;
        for (auto crosses = hn::Lt(k, narrow_end); !hn::AllFalse(d, crosses);
             crosses = hn::Lt(k, narrow_end)) {
            sub_row = hn::And(sub_row, last_sub_row);
            const auto offset = hn::Mul(hn::Add(hn::ConvertTo(d, sub_row), middle), per_texel),
                       column = hn::Sub(hn::Mul(hn::Add(k, middle), per_texel), half_face);
            const auto line = hn::Min(hn::Max(hn::Add(hn::Mul(slope, column), constant), lowest), highest);
            const auto above = hn::Sub(line, offset), whole = hn::Floor(above),
                       row = hn::Add(whole, hn::IfThenElse(hn::Eq(whole, above), on_line, one));
            // Integers below 2^24, so exact.
            const auto place =
                hn::BitCast(du, hn::Add(hn::Mul(row, stride), hn::Add(k, hn::Set(d, float_offset))));
            const auto list_those = [&](hn::Mask<ShortFloats> mask, CrossingList& to) {
                const ChosenLanes<ShortNumbers> chosen(du, hn::RebindMask(du, mask));
                chosen.store(place, du, to.places + to.count);
                to.count += chosen.count();
            };
            list_those(hn::And(crosses, begins), now.beginning);
            list_those(hn::AndNot(begins, crosses), now.ending);
            if (twice) {
                const auto again = hn::And(crosses, hn::Gt(hn::Abs(change), one));
                list_those(hn::And(again, begins), now.beginning);
                list_those(hn::AndNot(begins, again), now.ending);
            }
            k = hn::Add(k, one);
            sub_row = hn::Add(sub_row, hn::Set(di, 3));
        }
        now.apply_if_full();
    }
    changes = now;
    return wide_count;
}

/// Lists the crossings of the given lines, one line after the other, with one sub-column per lane.
inline HWY_NOINLINE void list_wide(const LineList& list, const std::uint32_t* numbers, std::size_t count,
                                   int face_size, const float* columns, LayerChanges& changes) {
    const Floats d;
    const hn::RebindToUnsigned<Floats> du;
    const std::size_t lanes = hn::Lanes(d);
    const VF one = hn::Set(d, 1.0f), stride = hn::Set(d, static_cast<float>(samples_per_texel * face_size)),
             lane = hn::Iota(d, float_offset);
    for (std::size_t i = 0; i < count; ++i) {
        const auto data = [&](LineData k) { return list.data(k)[numbers[i]]; };
        const auto begin = static_cast<std::int32_t>(data(line_begin)),
                   end = static_cast<std::int32_t>(data(line_end));
        const VF slope = hn::Set(d, data(line_slope)), constant = hn::Set(d, data(line_constant)),
                 lowest = hn::Set(d, data(line_lowest)), highest = hn::Set(d, data(line_highest));
        const float change = data(line_change);
        const VF on_line = hn::Set(d, change > 0 ? 0.0f : 1.0f);
        CrossingList& crossings = change > 0 ? changes.beginning : changes.ending;
        std::uint32_t* to = crossings.places + crossings.count;
        for (std::int32_t k = begin; k < end; k += static_cast<std::int32_t>(lanes), to += lanes) {
            const VF line = hn::Min(
                hn::Max(hn::Add(hn::Mul(slope, hn::LoadU(d, columns + k)), constant), lowest), highest);
            const VF above = hn::Sub(line, hn::LoadU(d, row_offsets.rows.data() + (k & 7))),
                     whole = hn::Floor(above),
                     row = hn::Add(whole, hn::IfThenElse(hn::Eq(whole, above), on_line, one));
            // Integers below 2^24, so exact.
            const VF place = hn::Add(hn::Mul(row, stride), hn::Add(lane, hn::Set(d, static_cast<float>(k))));
            hn::StoreU(hn::BitCast(du, place), du, to);
        }
        const auto width = static_cast<std::size_t>(end - begin);
        crossings.count += width;
        if (std::abs(change) > 1) {
            std::memcpy(crossings.places + crossings.count, crossings.places + crossings.count - width,
                        width * sizeof(std::uint32_t));
            crossings.count += width;
        }
        changes.apply_if_full();
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#endif
