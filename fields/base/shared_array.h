#pragma once
/// Tables that are read in place, such as in a mapped file.

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

namespace haarfield {

/// A read-only array that shares its elements between copies, together with the owner of their memory: a
/// vector, or the mapping of a file. A copy costs one reference count, independent of the size.
template <class T>
class SharedArray {
public:
    SharedArray() = default;

    /// Takes ownership of the vector.
    SharedArray(std::vector<T> values) {
        const auto owner = std::make_shared<const std::vector<T>>(std::move(values));
        elements_ = *owner;
        owner_ = owner;
    }

    /// Refers to elements that `owner` keeps alive and unchanged.
    SharedArray(std::span<const T> elements, std::shared_ptr<const void> owner)
        : elements_(elements), owner_(std::move(owner)) {}

    std::size_t size() const { return elements_.size(); }              ///< Elements.
    bool empty() const { return elements_.empty(); }                   ///< True if there are no elements.
    const T* data() const { return elements_.data(); }                 ///< The first element.
    const T& operator[](std::size_t i) const { return elements_[i]; }  ///< An element; i < size().
    auto begin() const { return elements_.begin(); }                   ///< The first element.
    auto end() const { return elements_.end(); }                       ///< Past the last one.

    /// Compares the elements, not their owners.
    bool operator==(const SharedArray& other) const {
        return std::equal(begin(), end(), other.begin(), other.end());
    }

private:
    std::span<const T> elements_;
    std::shared_ptr<const void> owner_;
};

}  // namespace haarfield
