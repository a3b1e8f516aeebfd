#pragma once
/// Calls on a larger stack than threads usually have, for recursive functions of libraries.

#include <cstddef>
#include <functional>

namespace haarfield {

/// Calls `act` in a thread with a stack of `bytes` and waits for it. Exceptions of `act` are rethrown here.
///
/// throws  std::bad_alloc if there is no memory for the thread.
void call_with_stack(std::size_t bytes, const std::function<void()>& act);

}  // namespace haarfield
