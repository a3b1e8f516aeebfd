#pragma once
/// Annotations for ThreadSanitizer: the order that oneTBB establishes. Debian's library of oneTBB is not
/// instrumented, so annotations must declare what is ordered before, in and after a loop.
///
/// In the preset tsan only, the headers in this directory are found before oneTBB's. They annotate the
/// functions that haarfield calls. Bodies of one loop are not ordered among each other, so races between them
/// are found.

extern "C" {
void __tsan_acquire(void* address);
void __tsan_release(void* address);
}

namespace tsan_order {

/// The order that threads of any loop see first. The body identifies its loop, and can only be read
/// afterwards.
inline char any_fork = 0;

/// The order of one loop.
struct ForkAndJoin {
    char join = 0;

    ForkAndJoin() = default;
    /// Called once its bodies exist.
    void begin() { __tsan_release(&any_fork); }
    ~ForkAndJoin() { __tsan_acquire(&join); }
    ForkAndJoin(const ForkAndJoin&) = delete;
    ForkAndJoin& operator=(const ForkAndJoin&) = delete;
};

/// Called first in a body. The loop is identified from then on.
struct InLoop {
    ForkAndJoin* loop = nullptr;

    InLoop() { __tsan_acquire(&any_fork); }
    ~InLoop() { __tsan_release(&loop->join); }
    InLoop(const InLoop&) = delete;
    InLoop& operator=(const InLoop&) = delete;
};

}  // namespace tsan_order
