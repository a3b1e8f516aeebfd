#include "shading/bounces/coarse_transport.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <numeric>
#include <random>

#include "shading/bounces/light_transport.h"

namespace haarfield {

namespace {

constexpr float widest = 0.25f;  ///< Largest radius of a group / distance to the hit surfaces.
constexpr int least_grouped = 4, most_grouped = 16;  // Rows.
/// Number of entries that groups have together, and that each may have at least.
constexpr std::size_t many_entries = 1 << 21, few_entries = 32;

}  // namespace

std::vector<std::uint32_t> LightTransport::find_groups(std::vector<std::uint32_t>& group) const {
    constexpr std::uint32_t none = 0xffffffff;
    group.assign(nearness_.size(), none);
    std::vector<std::uint32_t> sizes;
    std::vector<std::size_t> members;  // Places of the rows of one group.
    for (const Run& run : runs_) {
        const Neighbours& near = neighbours_[run.entity];
        // Returns the largest size of a group around a row: the number of rows that are near it, compared
        // with other surfaces. A row in a narrow fold, or a hidden one, is alone.
        const auto most_members = [&](std::size_t place) {
            const float nearness = nearness_[run.first + place],
                        square = near.square_distance[place] * run.square_scale * nearness * nearness;
            if (!(square > 0) || square > 1 || hidden_[run.first + place]) return 1.0f;
            return std::clamp(float(pi) * widest * widest / square, float(least_grouped),
                              float(most_grouped));
        };
        const auto is_free = [&](std::size_t place) {
            return group[run.first + place] == none && most_members(place) > 1;
        };
        for (std::size_t first = 0; first < near.end.size(); ++first) {
            const std::size_t row = run.first + first;
            if (group[row] != none) continue;
            const float most = most_members(first);
            const std::span<const std::uint32_t> beside = near.of(first);
            // Rows that groups have left over join one of them.
            if (most > 1 && std::ranges::count_if(beside, is_free) < 2) {
                const auto joined = std::ranges::find_if(beside, [&](std::uint32_t place) {
                    return group[run.first + place] != none && most_members(place) > 1;
                });
                if (joined != beside.end()) {
                    group[row] = group[run.first + *joined];
                    ++sizes[group[row]];
                    continue;
                }
            }
            group[row] = static_cast<std::uint32_t>(sizes.size());
            members.assign(1, first);
            for (std::size_t m = 0; m < members.size(); ++m)
                for (const std::uint32_t place : near.of(members[m]))
                    if (static_cast<float>(members.size()) < most && is_free(place)) {
                        group[run.first + place] = group[row];
                        members.push_back(place);
                    }
            sizes.push_back(static_cast<std::uint32_t>(members.size()));
        }
    }
    return sizes;
}

CoarseTransport LightTransport::coarse() const {
    CoarseTransport made;
    const std::vector<std::uint32_t> sizes = find_groups(made.group);
    // Rows by group.
    std::vector<std::uint32_t> first(sizes.size() + 1, 0), rows(made.group.size());
    std::partial_sum(sizes.begin(), sizes.end(), first.begin() + 1);
    std::vector<std::uint32_t> filled(first.begin(), first.end() - 1);
    for (std::uint32_t row = 0; row < rows.size(); ++row) rows[filled[made.group[row]]++] = row;
    const std::size_t most_entries =
        std::max(few_entries, many_entries / std::max<std::size_t>(1, sizes.size()));
    std::vector<std::uint32_t> hits;
    std::mt19937 random(2006);
    for (std::size_t group = 0; group < sizes.size(); ++group) {
        hits.clear();
        double directions = 0;
        for (std::uint32_t k = first[group]; k < first[group + 1]; ++k) {
            const std::size_t row = rows[k];
            const std::span<const std::uint32_t> of_row = blocks_[row / block_rows].of(row % block_rows);
            hits.insert(hits.end(), of_row.begin(), of_row.end());
            directions += directions_[row];
        }
        // One of each equal part, at random: regular parts of a row's sequence of rays lack directions.
        const std::size_t kept = std::min(hits.size(), most_entries);
        for (std::size_t n = 0; n < kept; ++n) {
            const std::size_t begin = n * hits.size() / kept, end = (n + 1) * hits.size() / kept;
            made.sources.push_back(made.group[hits[begin + ((end - begin) * std::uint64_t(random()) >> 32)]]);
        }
        made.end.push_back(static_cast<std::uint32_t>(made.sources.size()));
        made.factor.push_back(
            kept == 0 ? 0 : static_cast<float>(pi * double(hits.size()) / (double(kept) * directions)));
        made.share.push_back(1 / static_cast<float>(sizes[group]));
    }
    return made;
}

std::vector<Rgb> CoarseTransport::means(std::span<const Rgb> values) const {
    assert(values.size() == group.size());
    std::vector<Rgb> result(share.size(), Rgb(0.0f));
    for (std::size_t k = 0; k < values.size(); ++k) result[group[k]] += values[k];
    for (std::size_t g = 0; g < result.size(); ++g) result[g] *= share[g];
    return result;
}

std::vector<Rgb> CoarseTransport::irradiance(std::span<const Rgb> radiance) const {
    assert(radiance.size() == share.size());
    std::vector<Rgb> result(radiance.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, share.size(), 256), [&](const auto& range) {
        for (std::size_t g = range.begin(); g != range.end(); ++g) {
            Rgb sum(0.0f);
            for (std::uint32_t n = g == 0 ? 0 : end[g - 1]; n < end[g]; ++n) sum += radiance[sources[n]];
            result[g] = sum * factor[g];
        }
    });
    return result;
}

std::size_t CoarseTransport::bytes() const {
    return (group.size() + sources.size() + end.size()) * sizeof(std::uint32_t) +
           (share.size() + factor.size()) * sizeof(float);
}

}  // namespace haarfield
