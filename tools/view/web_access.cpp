#include "tools/view/web_access.h"

#include <fmt/format.h>

#include <random>

namespace haarfield {
namespace {

bool is_same_token(std::string_view given, std::string_view token) {
    // Constant time, independent of where the tokens differ.
    unsigned difference = given.size() == token.size() ? 0 : 1;
    for (std::size_t i = 0; i < token.size(); ++i)
        difference |= static_cast<unsigned char>(token[i]) ^
                      static_cast<unsigned char>(i < given.size() ? given[i] : '\0');
    return difference == 0;
}

/// True for the names under which a browser may reach this server, which cannot be those of another host.
bool is_own_host(const WebAccess& access, std::string_view given) {
    const std::string end = fmt::format(":{}", access.port);
    if (!given.ends_with(end)) return false;
    given.remove_suffix(end.size());
    return given == access.host ||
           (access.is_loopback && (given == "localhost" || given == "127.0.0.1" || given == "[::1]"));
}

bool is_own_origin(const WebAccess& access, std::string_view origin) {
    constexpr std::string_view scheme = "http://";
    return origin.starts_with(scheme) && is_own_host(access, origin.substr(scheme.size()));
}

/// Decodes `%41` and similar sequences; returns nothing if they are invalid.
std::optional<std::string> decoded(std::string_view text) {
    std::string result;
    const auto digit = [](char c) {
        return c >= '0' && c <= '9'   ? c - '0'
               : c >= 'a' && c <= 'f' ? c - 'a' + 10
               : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                      : -1;
    };
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            result += text[i];
            continue;
        }
        if (i + 2 >= text.size() || digit(text[i + 1]) < 0 || digit(text[i + 2]) < 0) return std::nullopt;
        result += static_cast<char>(16 * digit(text[i + 1]) + digit(text[i + 2]));
        i += 2;
    }
    return result;
}

}  // namespace

std::optional<std::string> refusal(const WebAccess& access, std::string_view host,
                                   std::optional<std::string_view> origin, std::string_view target) {
    if (!is_own_host(access, host)) return "The request names another host.";
    if (origin && !is_own_origin(access, *origin)) return "The request comes from a page of another origin.";
    const std::string& token = access.token;
    if (target.size() < token.size() + 2 || target.front() != '/' ||
        !is_same_token(target.substr(1, token.size()), token) || target[token.size() + 1] != '/')
        return "The address lacks the token: use the address that haarfield view prints.";
    return std::nullopt;
}

std::string_view below_token(const WebAccess& access, std::string_view target) {
    return target.substr(access.token.size() + 2);
}

std::optional<std::string> asked_path(const WebAccess& access, std::string_view target) {
    const std::string_view below = below_token(access, target);
    return decoded(below.substr(0, below.find('?')));
}

std::string random_token() {
    std::random_device random;  // of the system
    std::string token;
    for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", random());
    return token;
}

}  // namespace haarfield
