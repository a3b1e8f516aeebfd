#pragma once
// See order.h.

#include_next <tbb/parallel_for.h>

#include <concepts>
#include <utility>

#include "order.h"

namespace tbb {

/// Annotates loops whose last argument is a function. Loops with other body objects, as in other libraries,
/// are forwarded.
template <class Space, class... Rest>
void ordered_for(const Space& space, Rest&&... rest) {
    if constexpr (std::integral<Space> && sizeof...(rest) == 2) {
        tsan_order::ForkAndJoin loop;
        const auto over = [&](Space end, const auto& body) {
            const auto ordered = [&](Space i) {
                tsan_order::InLoop inside;
                inside.loop = &loop;
                body(i);
            };
            loop.begin();
            tbb::parallel_for(space, end, ordered);
        };
        over(std::forward<Rest>(rest)...);
    } else if constexpr (sizeof...(rest) == 1 && (std::invocable<Rest, const Space&> && ...)) {
        tsan_order::ForkAndJoin loop;
        const auto over = [&](const auto& body) {
            const auto ordered = [&](const Space& part) {
                tsan_order::InLoop inside;
                inside.loop = &loop;
                body(part);
            };
            loop.begin();
            tbb::parallel_for(space, ordered);
        };
        over(std::forward<Rest>(rest)...);
    } else {
        tbb::parallel_for(space, std::forward<Rest>(rest)...);
    }
}

}  // namespace tbb

#define parallel_for ordered_for
