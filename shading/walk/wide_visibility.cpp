#include "shading/walk/wide_visibility.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

namespace haarfield {
namespace {

/// Half of the resolution of a byte: smaller differences are ignored.
constexpr float negligible = 1.0f / 512;

/// Returns the distinct faces of all samples, by first use.
std::vector<std::uint32_t> faces_in_use(const VisibilityField& field, std::span<const std::uint32_t> order) {
    std::vector<std::uint32_t> faces;
    std::vector<bool> seen(field.pool.faces.size());
    const auto use = [&](std::int32_t handle) {
        for (const std::uint32_t face : field.pool.cubemaps[std::size_t(handle)])
            if (!seen[face]) {
                seen[face] = true;
                faces.push_back(face);
            }
    };
    if (!field.local_handles.empty())
        for (const std::uint32_t vertex : order) use(field.local_handles[vertex]);
    for (const std::int32_t handle : field.planar_handles) use(handle);
    for (const std::int32_t handle : field.spherical_handles) use(handle);
    return faces;
}

struct CellRange {
    float mean, least, most;
};

/// Clamps the cells to [0, 1] and returns their mean, minimum and maximum. Four accumulators avoid a chain of
/// dependent operations.
CellRange clamped(std::array<float, wide_cells>& value) {
    std::array<float, 4> sum{}, least{1, 1, 1, 1}, most{};
    for (std::size_t cell = 0; cell < wide_cells; cell += 4)
        for (std::size_t k = 0; k < 4; ++k) {
            const float v = std::min(std::max(value[cell + k], 0.0f), 1.0f);
            value[cell + k] = v;
            sum[k] += v;
            least[k] = std::min(least[k], v);
            most[k] = std::max(most[k], v);
        }
    return {((sum[0] + sum[1]) + (sum[2] + sum[3])) / wide_cells,
            std::min(std::min(least[0], least[1]), std::min(least[2], least[3])),
            std::max(std::max(most[0], most[1]), std::max(most[2], most[3]))};
}

}  // namespace

float VisibilityConverter::append(const Quadtree& tree, std::vector<WideNode<std::uint8_t>>& nodes) {
    squares_.clear();
    children_.clear();
    if (tree.nodes.empty()) return std::clamp(tree.scaling, 0.0f, 1.0f);
    const Built root = build(tree, 0, tree.scaling);
    if (root.square != no_node) {
        nodes.emplace_back();
        write(std::size_t(root.square), nodes.size() - 1, nodes);
    }
    return root.mean;
}

VisibilityConverter::Built VisibilityConverter::build(const Quadtree& tree, std::int32_t index, float mean) {
    const Quadtree::Node& node = tree.nodes[std::size_t(index)];
    std::array<float, wide_cells> value;
    std::array<std::int32_t, wide_cells> child;
    Square square{};
    for (unsigned quadrant = 0; quadrant < 4; ++quadrant) {
        const std::int32_t inner_index = child_of(node, quadrant);
        const float quadrant_value = quadrant_mean(mean, node.wavelet, quadrant);
        float* cells = &value[4 * std::size_t(quadrant)];
        if (inner_index == no_node) {
            std::fill_n(cells, 4, quadrant_value);
            continue;
        }
        const Quadtree::Node& inner = tree.nodes[std::size_t(inner_index)];
        for (unsigned k = 0; k < 4; ++k) cells[k] = quadrant_mean(quadrant_value, inner.wavelet, k);
        if ((inner.children & 15u) == 0) continue;
        for (unsigned k = 0; k < 4; ++k)
            if (const std::int32_t below = child_of(inner, k); below != no_node) {
                const Built built = build(tree, below, cells[k]);
                cells[k] = built.mean;
                if (built.square == no_node) continue;
                square.varying |= static_cast<std::uint16_t>(1u << (4 * quadrant + k));
                child[square.child_count++] = built.square;
            }
    }
    const CellRange range = clamped(value);
    if (square.varying == 0 && range.most - range.least < negligible) return {range.mean, no_node};
    for (std::size_t cell = 0; cell < wide_cells; ++cell) square.mean[cell] = in_bytes(value[cell]);
    square.first_child = static_cast<std::uint32_t>(children_.size());
    children_.insert(children_.end(), child.begin(), child.begin() + square.child_count);
    squares_.push_back(square);
    return {range.mean, static_cast<std::int32_t>(squares_.size() - 1)};
}

void VisibilityConverter::write(std::size_t index, std::size_t place,
                                std::vector<WideNode<std::uint8_t>>& nodes) const {
    const Square& square = squares_[index];
    const std::size_t first = nodes.size();
    nodes[place] = {square.mean, static_cast<std::uint32_t>(first - place), square.varying};
    nodes.resize(first + square.child_count);
    for (std::size_t k = 0; k < square.child_count; ++k)
        write(std::size_t(children_[square.first_child + k]), first + k, nodes);
}

Result<WideVisibility> WideVisibility::make(const VisibilityField& field,
                                            std::span<const std::uint32_t> order, std::stop_token stop) {
    constexpr std::size_t chunk_faces = 1024, constant = std::numeric_limits<std::size_t>::max();
    const std::vector<std::uint32_t> faces = faces_in_use(field, order);
    const std::size_t chunks = (faces.size() + chunk_faces - 1) / chunk_faces;
    WideVisibility result;
    result.nodes_.resize(chunks);
    std::vector<WideFace<std::uint8_t>> wide(field.pool.faces.size());
    tbb::parallel_for(std::size_t(0), chunks, [&](std::size_t chunk) {
        if (stop.stop_requested()) return;
        auto& nodes = result.nodes_[chunk];
        VisibilityConverter converter;
        Quadtree tree;
        std::array<std::size_t, chunk_faces> root;
        const std::size_t first = chunk * chunk_faces, count = std::min(chunk_faces, faces.size() - first);
        for (std::size_t i = 0; i < count; ++i) {
            root[i] = nodes.size();
            unpack_face(field.pool, faces[first + i], tree);
            wide[faces[first + i]].mean = converter.append(tree, nodes);
            if (nodes.size() == root[i]) root[i] = constant;
        }
        nodes.shrink_to_fit();
        for (std::size_t i = 0; i < count; ++i)
            if (root[i] != constant) wide[faces[first + i]].root = &nodes[root[i]];
    });
    if (stop.stop_requested()) return interruption();
    const auto cubemaps = [&](const std::vector<std::int32_t>& handles) {
        std::vector<WideCubemap<std::uint8_t>> by_sample(handles.size());
        for (std::size_t i = 0; i < handles.size(); ++i)
            for (std::size_t face = 0; face < cubemap_faces; ++face)
                by_sample[i][face] = wide[field.pool.cubemaps[std::size_t(handles[i])][face]];
        return by_sample;
    };
    result.planar_ = cubemaps(field.planar_handles);
    result.spherical_ = cubemaps(field.spherical_handles);
    result.local_ = cubemaps(field.local_handles);
    return result;
}

std::size_t WideVisibility::memory() const {
    std::size_t bytes =
        (planar_.size() + spherical_.size() + local_.size()) * sizeof(WideCubemap<std::uint8_t>);
    for (const auto& chunk : nodes_) bytes += chunk.size() * sizeof(chunk[0]);
    return bytes;
}

}  // namespace haarfield
