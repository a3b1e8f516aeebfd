#pragma once
/// Memory that a C library has given, or not.

#include <new>

namespace haarfield {

/// The same as a T; std::bad_alloc if it is null, as Embree's buffers are when there is no memory.
template <class T>
T* allocated(void* memory) {
    if (!memory) throw std::bad_alloc();
    return static_cast<T*>(memory);
}

}  // namespace haarfield
