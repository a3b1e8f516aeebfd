#pragma once
/// Access control of the server, as described in PROTOCOL.md.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace haarfield {

/// The secret token, and the names under which a browser reaches the server.
struct WebAccess {
    std::string token;
    std::string host;  ///< The numeric address of the server; IPv6 in brackets.
    std::uint16_t port = 0;
    bool is_loopback = true;  ///< True: the names of the loopback interface are valid too.
};

/// Returns the reason why a request is refused; none if it is accepted.
///
/// host    the server's name in the request, with the port.
/// origin  of the requesting page; none without a page.
/// target  the path with the token: `/TOKEN/...`.
std::optional<std::string> refusal(const WebAccess& access, std::string_view host,
                                   std::optional<std::string_view> origin, std::string_view target);

/// Returns the part of an accepted request's target after `/TOKEN/`, without decoding.
std::string_view below_token(const WebAccess& access, std::string_view target);

/// Returns the decoded path after the token, without a query: `%41` becomes A. None if the encoding is
/// invalid.
std::optional<std::string> asked_path(const WebAccess& access, std::string_view target);

/// Returns 128 random bits as a word for addresses.
std::string random_token();

}  // namespace haarfield
