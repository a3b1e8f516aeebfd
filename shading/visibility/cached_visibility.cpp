#include "shading/visibility/cached_visibility.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <iterator>
#include <utility>

namespace haarfield {
namespace {

/// Memory of one thread: chunks of large pages, until a budget shared by all threads is exhausted.
class PagedMemory {
public:
    explicit PagedMemory(std::atomic<std::size_t>& budget) : budget_(budget) {}

    /// Rounds a size up to the largest alignment.
    static constexpr std::size_t aligned(std::size_t bytes) {
        return (bytes + alignof(std::max_align_t) - 1) & ~(alignof(std::max_align_t) - 1);
    }

    /// bytes  aligned. Null: the budget is exhausted.
    std::byte* allocate(std::size_t bytes) {
        is_full_ = bytes > left_ && !add_page(bytes);
        if (is_full_) return nullptr;
        left_ -= bytes;
        return std::exchange(next_, next_ + bytes);
    }

    std::size_t bytes() const { return bytes_; }
    bool is_full() const { return is_full_; }  ///< An allocation failed.

    std::vector<std::unique_ptr<std::byte[]>> pages;

private:
    static constexpr std::size_t page_bytes = std::size_t(1) << 18;

    /// Adds a page, or as much as the budget leaves if that is enough.
    bool add_page(std::size_t least) {
        std::size_t budget = budget_.load(), bytes = 0;
        do {
            bytes = std::min(std::max(least, page_bytes), budget);
            if (bytes < least) return false;
        } while (!budget_.compare_exchange_weak(budget, budget - bytes));
        pages.push_back(std::make_unique_for_overwrite<std::byte[]>(bytes));
        next_ = pages.back().get();
        left_ = bytes;
        bytes_ += bytes;
        return true;
    }

    std::atomic<std::size_t>& budget_;
    std::byte* next_ = nullptr;
    std::size_t left_ = 0, bytes_ = 0;
    bool is_full_ = false;
};

template <class T>
std::size_t room_for(std::span<const T> values) {
    return PagedMemory::aligned(values.size_bytes());
}

/// Copies values to an address and advances it.
template <class T>
std::span<T> copied(std::span<const T> values, std::byte*& place) {
    static_assert(std::is_trivially_destructible_v<T> && alignof(T) <= alignof(std::max_align_t));
    const std::span<T> copy(reinterpret_cast<T*>(place), values.size());
    std::uninitialized_copy(values.begin(), values.end(), copy.begin());
    place += room_for(values);
    return copy;
}

/// The last copy of a tree that several vertices use.
struct SharedTree {
    std::uint64_t number = 0;  ///< VertexVisibility::Made::number
    const WideCubemap<std::uint8_t>* copy = nullptr;
};

std::size_t room_for_tree(const TexelTree& tree) {
    return room_for(std::span(&tree.faces, 1)) + room_for(std::span(tree.nodes));
}

/// Copies a tree to an address and advances it.
const WideCubemap<std::uint8_t>* copied_tree(const TexelTree& tree, std::byte*& place) {
    WideCubemap<std::uint8_t>& faces = copied(std::span(&tree.faces, 1), place)[0];
    const std::span<const WideNode<std::uint8_t>> nodes = copied(std::span(tree.nodes), place);
    for (auto& face : faces)
        if (face.root) face.root = nodes.data() + (face.root - tree.nodes.data());
    return &faces;
}

/// Copies the visibility of a vertex; null: out of memory.
const VisibilityProduct* kept(const VertexVisibility& seen, SharedTree& shared, PagedMemory& memory) {
    const VisibilityProduct looked = seen.visibility();
    const std::span<const VisibilityProduct> visibility(&looked, 1);
    const auto is_kept = [&](const VertexVisibility::Made& made) {
        return made.number != 0 && made.number == shared.number;
    };
    std::size_t bytes = room_for(visibility) + room_for(looked.trees) + room_for(looked.cones.sides) +
                        room_for(looked.cones.end);
    for (const auto& factor : looked.trees) bytes += room_for(factor.parts);
    for (const VertexVisibility::Made& made : seen.made())
        if (!is_kept(made)) bytes += room_for_tree(*made.tree);
    std::byte* place = memory.allocate(bytes);
    if (!place) return nullptr;

    VisibilityProduct& result = copied(visibility, place)[0];
    const auto trees = copied(looked.trees, place);
    result = {trees, {copied(looked.cones.sides, place), copied(looked.cones.end, place)}};
    for (auto& factor : trees) {
        const auto parts = copied(factor.parts, place);
        for (auto& part : parts)
            for (const VertexVisibility::Made& made : seen.made()) {
                if (part.tree != &made.tree->faces) continue;
                part.tree = is_kept(made) ? shared.copy : copied_tree(*made.tree, place);
                if (made.number != 0) shared = {made.number, part.tree};
                break;
            }
        factor.parts = parts;
    }
    return &result;
}

constexpr VisibilityProduct no_visibility{};

}  // namespace

Result<CachedVisibility> CachedVisibility::make(const ShadedScene& scene, const ShadingGeometry& geometry,
                                                std::size_t most_bytes, const Progress& progress) {
    CachedVisibility result;
    for (const ShadedInstance& instance : scene.instances) {
        result.products_.emplace_back(geometry.entities[instance.entity].order.size());
        result.bytes_ += result.products_.back().size() * sizeof(const VisibilityProduct*);
    }
    struct Worker {
        VertexVisibility visibility;
        PagedMemory memory;
        SharedTree shared;
    };
    std::atomic<std::size_t> budget = most_bytes;
    tbb::enumerable_thread_specific<Worker> workers([&] {
        return Worker{{scene, geometry}, PagedMemory(budget), {}};
    });
    HF_TRY_DONE(visit_vertices(
        scene, geometry.orders(),
        [&]() -> VertexVisitor {
            return [&, worker = &workers.local()](std::size_t i, std::uint32_t v) {
                if (worker->memory.is_full()) return;
                const bool sees = worker->visibility.look(i, v, shading_point(scene, scene.instances[i], v));
                result.products_[i][v] =
                    sees ? kept(worker->visibility, worker->shared, worker->memory) : &no_visibility;
            };
        },
        "visibility", progress));
    for (Worker& worker : workers) {
        result.bytes_ += worker.memory.bytes();
        std::move(worker.memory.pages.begin(), worker.memory.pages.end(), std::back_inserter(result.memory_));
    }
    return result;
}

}  // namespace haarfield
