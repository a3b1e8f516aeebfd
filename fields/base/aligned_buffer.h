#pragma once
/// Memory for vectors.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

namespace haarfield {

/// Elements of the widest vector of any target. So many more than there are have room where whole vectors are
/// read or written past the last one.
template <class T>
inline constexpr std::size_t widest_vector = 64 / sizeof(T);

/// Plain numbers in memory that starts a cache line, so that no vector straddles two.
template <class T>
class AlignedBuffer {
public:
    /// At least this many elements; they are zeros after growth, and otherwise what they were.
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
