#pragma once
// See order.h.

#include_next <tbb/parallel_pipeline.h>

#include <type_traits>
#include <utility>

#include "order.h"

namespace tbb {

/// The order of all pipelines: the end of a filter's work is ordered before any later begin in another
/// filter.
inline tsan_order::ForkAndJoin& all_pipelines() {
    static tsan_order::ForkAndJoin pipelines;
    return pipelines;
}

template <class In, class Out, class Body>
auto ordered_filter(filter_mode mode, const Body& body) {
    const auto step = [&body](auto&& in) -> Out {
        tsan_order::InLoop inside;
        inside.loop = &all_pipelines();
        __tsan_acquire(&all_pipelines().join);
        return body(std::forward<decltype(in)>(in));
    };
    if constexpr (std::is_void_v<In>)
        return tbb::make_filter<In, Out>(mode,
                                         [step](flow_control& control) -> Out { return step(control); });
    else
        return tbb::make_filter<In, Out>(mode, [step](In in) -> Out { return step(in); });
}

template <class... Arguments>
void ordered_pipeline(Arguments&&... arguments) {
    all_pipelines().begin();
    tbb::parallel_pipeline(std::forward<Arguments>(arguments)...);
    __tsan_acquire(&all_pipelines().join);
}

}  // namespace tbb

#define make_filter ordered_filter
#define parallel_pipeline ordered_pipeline
