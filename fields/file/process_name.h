#pragma once
/// Which process something in a shared folder belongs to, as processes of this and of other machines can read
/// it.

#include <string>
#include <string_view>

namespace haarfield {

/// `PLACE-PID-START`: twelve hexadecimal digits for the machine since it was started, with its name and its
/// space of process numbers; the process's number there; when it was started. No other process has the same.
std::string process_name();

/// What can be known of a process.
enum class Liveness {
    alive,
    ended,
    unknown,  ///< It is another machine's, or the name is none.
};

/// Whether the process of that name still runs.
Liveness process_liveness(std::string_view name);

}  // namespace haarfield
