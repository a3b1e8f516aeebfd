#include "fields/file/this_process.h"

namespace haarfield {

std::filesystem::path running_program() {
    return "haarfield";
}

void end_with_parent() {}

}  // namespace haarfield
