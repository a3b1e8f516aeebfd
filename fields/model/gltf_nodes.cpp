#include "fields/model/gltf_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <vector>

namespace haarfield {
namespace {

constexpr std::size_t deepest_value = 1000, longest_path = 100000, most_instances = 1000000;
constexpr std::size_t many = std::size_t{1} << 40;  // saturation value for counts of instances

/// The child lists of all nodes, concatenated.
struct Hierarchy {
    /// Node n has child[first[n]] to child[first[n + 1] - 1], or for the last node, all remaining ones.
    std::vector<std::size_t> first;
    std::vector<std::uint32_t> child;
    std::size_t nesting = 0;  ///< Nesting depth of the whole text.

    std::size_t size() const { return first.size(); }
    std::size_t end_of(std::size_t node) const { return node + 1 < size() ? first[node + 1] : child.size(); }
};

/// Collects root.nodes[n].children from JSON.
class HierarchyScanner {
public:
    Hierarchy scan(std::string_view json) {
        for (std::size_t i = 0; i < json.size(); ++i) {
            const char c = json[i];
            if (c == '"') {
                const std::size_t end = end_of_string(json, i);
                text_ = json.substr(i + 1, end - i - 1);
                i = end;
            } else if (c == ':') {
                if (depth_ == 1) root_key_ = text_;
                if (depth_ == 3) node_key_ = text_;
            } else if (c == '{' || c == '[') {
                open(c);
            } else if (c == '}' || c == ']') {
                depth_ -= std::min<std::size_t>(depth_, 1);
                if (depth_ <= 1) in_nodes_ = false;
                if (depth_ <= 3) in_children_ = false;
            } else if (c >= '0' && c <= '9' && in_children_ && depth_ == 4) {
                i = add_child(json, i);
            }
        }
        return std::move(found_);
    }

private:
    /// Returns the position of the closing quotation mark of a string.
    static std::size_t end_of_string(std::string_view json, std::size_t begin) {
        std::size_t end = begin + 1;
        while (end < json.size() && json[end] != '"') end += json[end] == '\\' ? 2 : 1;
        return std::min(end, json.size());
    }

    void open(char bracket) {
        ++depth_;
        found_.nesting = std::max(found_.nesting, depth_);
        if (depth_ == 2 && bracket == '[') in_nodes_ = root_key_ == "nodes";
        if (depth_ == 3 && bracket == '{' && in_nodes_) {
            found_.first.push_back(found_.child.size());
            node_key_ = {};
        }
        if (depth_ == 4 && bracket == '[') in_children_ = in_nodes_ && node_key_ == "children";
    }

    /// Adds a child and returns the position of its last digit.
    std::size_t add_child(std::string_view json, std::size_t begin) {
        std::uint32_t number = 0;
        const auto [end, failure] = std::from_chars(json.data() + begin, json.data() + json.size(), number);
        if (failure == std::errc()) found_.child.push_back(number);
        return static_cast<std::size_t>(end - json.data()) - 1;
    }

    Hierarchy found_;
    std::size_t depth_ = 0;
    std::string_view text_, root_key_, node_key_;
    bool in_nodes_ = false, in_children_ = false;
};

/// The properties of a node and all its descendants.
struct Subtree {
    std::size_t depth = 0, instances = 0;  ///< Instances saturate at `many`.
};

/// Measures nodes without recursion: visits children before their parents.
class Measurer {
public:
    explicit Measurer(const Hierarchy& hierarchy) : hierarchy_(hierarchy), of_(hierarchy.size()) {}

    /// Measures a node and its descendants. False if a node is its own descendant.
    bool measure(std::uint32_t root) {
        if (of_[root].depth > 0) return true;
        open(root);
        while (!open_.empty()) {
            auto& [node, next] = open_.back();
            if (next == hierarchy_.end_of(node)) {
                close();
                continue;
            }
            const std::uint32_t child = hierarchy_.child[next++];
            if (child >= hierarchy_.size() || of_[child].depth > 0) continue;
            if (of_[child].instances > 0) return false;  // on the current path
            open(child);
        }
        return true;
    }

    const Subtree& operator[](std::size_t node) const { return of_[node]; }

private:
    void open(std::uint32_t node) {
        of_[node].instances = 1;
        open_.emplace_back(node, hierarchy_.first[node]);
    }

    void close() {
        const std::uint32_t node = open_.back().first;
        open_.pop_back();
        Subtree made{1, 1};
        for (std::size_t i = hierarchy_.first[node]; i < hierarchy_.end_of(node); ++i) {
            if (hierarchy_.child[i] >= hierarchy_.size()) continue;
            const Subtree& child = of_[hierarchy_.child[i]];
            made.depth = std::max(made.depth, child.depth + 1);
            made.instances = std::min(made.instances + child.instances, many);
        }
        of_[node] = made;
    }

    const Hierarchy& hierarchy_;
    std::vector<Subtree> of_;  ///< Depth 0: not measured yet; if also 1 instance: on the current path.
    /// The current path: nodes and their next children.
    std::vector<std::pair<std::uint32_t, std::size_t>> open_;
};

}  // namespace

Result<GltfDepth> check_gltf_nodes(std::string_view json) {
    const Hierarchy hierarchy = HierarchyScanner().scan(json);
    if (hierarchy.nesting > deepest_value)
        return Error{"", fmt::format("JSON values are nested {} deep; expected at most {}", hierarchy.nesting,
                                     deepest_value)};
    Measurer measured(hierarchy);
    std::vector<bool> is_child(hierarchy.size(), false);
    for (const std::uint32_t child : hierarchy.child)
        if (child < hierarchy.size()) is_child[child] = true;
    GltfDepth depth;
    std::size_t instances = 0;
    for (std::uint32_t node = 0; node < hierarchy.size(); ++node) {
        if (!measured.measure(node))
            return Error{"",
                         fmt::format("a descendant of node {} is its own ancestor; expected a tree", node)};
        depth.nodes = std::max(depth.nodes, measured[node].depth);
        if (!is_child[node]) instances = std::min(instances + measured[node].instances, many);
    }
    if (depth.nodes > longest_path)
        return Error{
            "", fmt::format("its nodes form a chain of {}; expected at most {}", depth.nodes, longest_path)};
    if (instances > std::max(most_instances, hierarchy.size()))
        return Error{
            "", fmt::format("nodes with several parents make more than {} instances; expected one parent for "
                            "each node",
                            most_instances)};
    return depth;
}

}  // namespace haarfield
