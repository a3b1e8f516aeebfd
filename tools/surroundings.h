#pragma once
/// Normalizes the environment in which the process starts.

namespace haarfield {

/// Turns signals of closed pipes and of the file size limit into write errors. Opens closed stdin, stdout and
/// stderr as /dev/null, so that no other file gets their descriptors. Must be called at the beginning of
/// main.
void tidy_surroundings();

}  // namespace haarfield
