#pragma once
/// Ctrl-C: asks the work to stop, and ends the process if it does not.

#include <stop_token>

namespace haarfield {

/// Takes SIGINT and SIGTERM away from the threads of this process, of which there must be one yet, and
/// gives them to a thread that waits for them. The first one requests a stop from the source. The process
/// ends with exit code 130 at the second one, or if its work goes on for another second of processor time,
/// or for ten seconds by the clock.
void stop_on_interrupt(std::stop_source source);

}  // namespace haarfield
