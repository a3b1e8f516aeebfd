#include "shading/visibility/buried_fill.h"

#include <algorithm>

namespace haarfield {
namespace {

/// A directed edge of a triangle, ending in a buried vertex.
struct Step {
    std::uint32_t to, from;
};

}  // namespace

std::vector<std::uint8_t> left_out_vertices(const Mesh& mesh, std::span<const std::uint8_t> buried) {
    std::vector<std::uint8_t> marked(mesh.positions.size(), 1);
    for (const auto& [a, b, c] : mesh.triangles)
        if (marked[a] && marked[b] && marked[c]) marked[a] = 0;
    for (std::size_t v = 0; v < marked.size(); ++v) marked[v] |= buried[v];
    return marked;
}

BuriedFill::BuriedFill(const Mesh& mesh, std::span<const std::uint8_t> buried) {
    std::vector<Step> steps;
    for (const auto& triangle : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            if (buried[triangle[k]])
                for (std::size_t next = 1; next < 3; ++next)
                    steps.push_back({triangle[k], triangle[(k + next) % 3]});
    std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) { return a.to < b.to; });

    std::vector<std::uint8_t> is_missing(buried.begin(), buried.end());
    for (std::size_t before = 1; before > 0;) {
        const std::size_t first = filled_.size();
        std::vector<Step> later;
        for (std::size_t i = 0; i < steps.size();) {
            const std::uint32_t vertex = steps[i].to;
            const std::size_t sources = source_.size(), begin = i;
            for (; i < steps.size() && steps[i].to == vertex; ++i)
                if (!is_missing[steps[i].from]) source_.push_back(steps[i].from);
            if (source_.size() > sources)
                filled_.push_back({vertex, static_cast<std::uint32_t>(source_.size())});
            else
                later.insert(later.end(), steps.begin() + static_cast<std::ptrdiff_t>(begin),
                             steps.begin() + static_cast<std::ptrdiff_t>(i));
        }
        // Marks them only after the pass, so that values move inwards by one edge per pass.
        for (std::size_t f = first; f < filled_.size(); ++f) is_missing[filled_[f].vertex] = 0;
        steps = std::move(later);
        before = filled_.size() - first;
    }
}

void BuriedFill::add_sources(std::span<std::uint8_t> is_chosen) const {
    for (std::size_t f = filled_.size(); f-- > 0;) {
        if (!is_chosen[filled_[f].vertex]) continue;
        for (std::size_t i = f > 0 ? filled_[f - 1].end : 0; i < filled_[f].end; ++i)
            is_chosen[source_[i]] = 1;
    }
}

}  // namespace haarfield
