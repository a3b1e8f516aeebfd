#include "fields/base/exception_message.h"

#include <new>
#include <stdexcept>

namespace haarfield {

std::string exception_message(const std::exception& exception) {
    const bool is_memory = dynamic_cast<const std::bad_alloc*>(&exception) != nullptr ||
                           dynamic_cast<const std::length_error*>(&exception) != nullptr;
    if (is_memory) return "not enough memory";
    std::string text = exception.what();
    if (text.starts_with("[json.exception."))
        if (const std::size_t end = text.find("] "); end != std::string::npos) text.erase(0, end + 2);
    return text;
}

}  // namespace haarfield
