#pragma once
/// What a process finds when it starts, made such that the rest need not think of it.

namespace haarfield {

/// A closed pipe, and a file larger than the process may write, are errors of those who write, not signals;
/// stdin, stdout and stderr are something, if nothing, so that no file takes their numbers. At the beginning
/// of main.
void tidy_surroundings();

}  // namespace haarfield
