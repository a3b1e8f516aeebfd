#pragma once
/// Calls with more stack than a thread usually has, for recursive functions of libraries.

#include <cstddef>
#include <functional>

namespace haarfield {

/// Calls `act` in a thread with a stack of so many bytes, and waits for it. Exceptions of `act` arrive here.
///
/// throws  std::bad_alloc if there is no memory for the thread.
void call_with_stack(std::size_t bytes, const std::function<void()>& act);

}  // namespace haarfield
