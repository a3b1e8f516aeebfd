#pragma once
/// The error of a bake or frame, for the output and for reports.

#include "shading/bake/bake_error.h"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>

namespace haarfield {

/// Returns a line without its end: the error, its interval and its causes.
///
/// where  inserted after the interval, such as " in the last frame".
std::string error_line(const BakeError& error, std::string_view where = {});

/// Returns the keys reached, low, high, between_vertices, at_vertices and indirect_light.
nlohmann::json error_report(const BakeError& error);

}  // namespace haarfield
