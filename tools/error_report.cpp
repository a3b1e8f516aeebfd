#include "tools/error_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace haarfield {

std::string error_line(const BakeError& error, std::string_view where) {
    return fmt::format(
        "error  {:.2f} % ({:.2f} to {:.2f} %){}: {:.2f} % between vertices, {:.2f} % at vertices, {:.2f} % "
        "indirect light",
        100 * error.total, 100 * error.low, 100 * error.high, where, 100 * error.between,
        100 * error.at_vertices, 100 * error.indirect);
}

nlohmann::json error_report(const BakeError& error) {
    return {{"reached", error.total},
            {"low", error.low},
            {"high", error.high},
            {"between_vertices", error.between},
            {"at_vertices", error.at_vertices},
            {"indirect_light", error.indirect}};
}

}  // namespace haarfield
