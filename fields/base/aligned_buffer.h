#pragma once
/// Aligned memory for vector instructions.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

namespace haarfield {

/// Elements of the widest vector of any instruction set. Arrays are padded by this number of elements so that
/// the last elements can be loaded and stored as a whole vector.
template <class T>
inline constexpr std::size_t widest_vector = 64 / sizeof(T);

/// A buffer of numbers that is aligned to cache lines, so that no aligned vector crosses a cache line.
template <class T>
class AlignedBuffer {
public:
    /// Allocates at least `count` elements. If the buffer grows, all elements become zero; otherwise they are
    /// unchanged.
    void reserve(std::size_t count) {
        if (count <= count_) return;
        values_.reset(static_cast<T*>(::operator new(count * sizeof(T), alignment)));
        std::fill_n(values_.get(), count, T(0));
        count_ = count;
    }
    T* data() { return values_.get(); }              ///< The first element.
    const T* data() const { return values_.get(); }  ///< The first element.

private:
    static constexpr std::align_val_t alignment{64};
    struct Free {
        void operator()(T* values) const { ::operator delete(values, alignment); }
    };
    std::unique_ptr<T, Free> values_;
    std::size_t count_ = 0;
};

}  // namespace haarfield
