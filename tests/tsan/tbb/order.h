#pragma once
/// For ThreadSanitizer: what oneTBB orders. Debian's library of it is not instrumented, so that the order of
/// what is done before a loop, in it, and after it has to be told.
///
/// The headers beside this one are found before oneTBB's own, in the preset tsan alone, and put annotations
/// round what haarfield calls. Bodies of one loop are not ordered among each other: races between them are
/// found.

extern "C" {
void __tsan_acquire(void* address);
void __tsan_release(void* address);
}

namespace tsan_order {

/// What any loop's threads see first: the body, which says whose it is, can only be read thereafter.
inline char any_fork = 0;

/// One loop's.
struct ForkAndJoin {
    char join = 0;

    ForkAndJoin() = default;
    /// Once its bodies are made.
    void begin() { __tsan_release(&any_fork); }
    ~ForkAndJoin() { __tsan_acquire(&join); }
    ForkAndJoin(const ForkAndJoin&) = delete;
    ForkAndJoin& operator=(const ForkAndJoin&) = delete;
};

/// First in a body. The loop is named after that.
struct InLoop {
    ForkAndJoin* loop = nullptr;

    InLoop() { __tsan_acquire(&any_fork); }
    ~InLoop() { __tsan_release(&loop->join); }
    InLoop(const InLoop&) = delete;
    InLoop& operator=(const InLoop&) = delete;
};

}  // namespace tsan_order
