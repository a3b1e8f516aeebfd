#include "fields/file/process_time.h"

namespace haarfield {

std::optional<double> processor_seconds(pid_t) {
    return std::nullopt;
}

}  // namespace haarfield
