#pragma once
/// Ctrl-C: requests a stop, and ends the process if the work continues.

#include <stop_token>

namespace haarfield {

/// Blocks SIGINT and SIGTERM in this process and handles them in a separate thread. The process must have
/// only one thread yet. The first signal requests a stop from the source. The process ends with exit code 130
/// at the second signal, or if its work continues for one second of processor time or for ten seconds of wall
/// time.
void stop_on_interrupt(std::stop_source source);

}  // namespace haarfield
