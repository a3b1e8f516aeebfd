#pragma once
// See order.h.

#include_next <tbb/parallel_reduce.h>

#include "order.h"

namespace tbb {

/// Annotates reductions with functions. The form with a body object, as in other libraries, is forwarded.
template <class Range, class Value, class Body, class Join>
Value ordered_reduce(const Range& range, const Value& identity, const Body& body, const Join& join) {
    tsan_order::ForkAndJoin loop;
    const auto ordered_body = [&](const Range& part, const Value& value) {
        tsan_order::InLoop inside;
        inside.loop = &loop;
        return body(part, value);
    };
    const auto ordered_join = [&](const Value& a, const Value& b) {
        tsan_order::InLoop inside;
        inside.loop = &loop;
        __tsan_acquire(&loop.join);
        return join(a, b);
    };
    loop.begin();
    return tbb::parallel_reduce(range, identity, ordered_body, ordered_join);
}

template <class Range, class Body>
void ordered_reduce(const Range& range, Body& body) {
    tbb::parallel_reduce(range, body);
}

}  // namespace tbb

#define parallel_reduce ordered_reduce
