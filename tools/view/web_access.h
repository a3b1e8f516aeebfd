#pragma once
/// Who may ask the server for something, and for what: PROTOCOL.md has it in words.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace haarfield {

/// What whoever asks has to know, and under which names a browser reaches the server.
struct WebAccess {
    std::string token;
    std::string host;  ///< The address that is listened at, in numbers; of IPv6 in brackets.
    std::uint16_t port = 0;
    bool is_loopback = true;  ///< Then it has the names of the loopback interface, too.
};

/// Why a request is refused; none if it is not.
///
/// host    as the request names the server, with the port.
/// origin  of the page that asks; none if no page does.
/// target  the path with the token: `/TOKEN/...`.
std::optional<std::string> refusal(const WebAccess& access, std::string_view host,
                                   std::optional<std::string_view> origin, std::string_view target);

/// What a request that is not refused asks for, as it is written: its target behind `/TOKEN/`.
std::string_view below_token(const WebAccess& access, std::string_view target);

/// The same as a path: without what follows a `?`, and `%41` is an A; none if that is broken.
std::optional<std::string> asked_path(const WebAccess& access, std::string_view target);

/// 128 random bits, as a word for addresses.
std::string random_token();

}  // namespace haarfield
