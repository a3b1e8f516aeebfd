#pragma once
/// Tables that are read where they lie, such as in a mapped file.

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

namespace haarfield {

/// A read-only array that its copies share, with whatever keeps its memory alive: a vector, or the mapping of
/// a file. Copying costs a reference count, whatever the size.
template <class T>
class SharedArray {
public:
    SharedArray() = default;

    /// Takes the vector over.
    SharedArray(std::vector<T> values) {
        const auto owner = std::make_shared<const std::vector<T>>(std::move(values));
        elements_ = *owner;
        owner_ = owner;
    }

    /// Elements that stay where they are, unchanged, while `owner` lives.
    SharedArray(std::span<const T> elements, std::shared_ptr<const void> owner)
        : elements_(elements), owner_(std::move(owner)) {}

    std::size_t size() const { return elements_.size(); }              ///< Elements.
    bool empty() const { return elements_.empty(); }                   ///< Whether it has none.
    const T* data() const { return elements_.data(); }                 ///< The first element.
    const T& operator[](std::size_t i) const { return elements_[i]; }  ///< An element; i < size().
    auto begin() const { return elements_.begin(); }                   ///< The first element.
    auto end() const { return elements_.end(); }                       ///< Past the last one.

    /// Equal elements, whoever owns them.
    bool operator==(const SharedArray& other) const {
        return std::equal(begin(), end(), other.begin(), other.end());
    }

private:
    std::span<const T> elements_;
    std::shared_ptr<const void> owner_;
};

}  // namespace haarfield
