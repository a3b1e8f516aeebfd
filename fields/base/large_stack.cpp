#include "fields/base/large_stack.h"

#include <pthread.h>

#include <exception>
#include <new>

namespace haarfield {
namespace {

struct Call {
    const std::function<void()>& act;
    std::exception_ptr thrown;
};

void* run(void* argument) {
    Call& call = *static_cast<Call*>(argument);
    try {
        call.act();
    } catch (...) {
        call.thrown = std::current_exception();
    }
    return nullptr;
}

}  // namespace

void call_with_stack(std::size_t bytes, const std::function<void()>& act) {
    Call call{act, nullptr};
    pthread_attr_t attributes;
    if (pthread_attr_init(&attributes) != 0) throw std::bad_alloc();
    pthread_t thread{};
    const bool started = pthread_attr_setstacksize(&attributes, bytes) == 0 &&
                         pthread_create(&thread, &attributes, run, &call) == 0;
    pthread_attr_destroy(&attributes);
    if (!started) throw std::bad_alloc();
    pthread_join(thread, nullptr);
    if (call.thrown) std::rethrow_exception(call.thrown);
}

}  // namespace haarfield
