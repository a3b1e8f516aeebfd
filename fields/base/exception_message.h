#pragma once
/// Exceptions of libraries as messages for users.

#include <exception>
#include <string>

namespace haarfield {

/// Describes an exception in words. Failed allocations, whose own texts are names of C++ types, become "not
/// enough memory". The prefix of nlohmann::json ("[json.exception.parse_error.101] ") is removed.
std::string exception_message(const std::exception& exception);

}  // namespace haarfield
