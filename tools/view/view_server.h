#pragma once
/// HTTP and WebSocket for pages: the one place that knows Boost.Beast. PROTOCOL.md has the addresses.

#include "fields/base/progress.h"
#include "fields/base/result.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace haarfield {

/// What is sent for an address.
struct WebAnswer {
    unsigned status = 200;
    std::string type;  ///< Of its content, such as `text/html`.
    std::string bytes;
    std::string file_name{};  ///< If it is to be saved: under which name.
};

/// What the server is asked, and what it passes on. `get` and `upload` may take long, and are called from a
/// thread of their own; all others at once, from the server's.
struct WebSite {
    std::function<WebAnswer(std::string_view path)> get;  ///< Below the token, without it.
    std::function<WebAnswer(std::string_view name, std::string_view bytes)> upload;
    std::function<void(std::uint64_t page)> joined, left;
    std::function<void(std::uint64_t page, std::string_view text)> received;
};

struct WebLimits {
    std::size_t message_bytes = 1 << 16;
    std::size_t upload_bytes = std::size_t(64) << 20;
    std::size_t pages = 16;  ///< At a time.
    std::size_t waiting_bytes = std::size_t(8)
                                << 20;  ///< Of texts that a page has not taken; then it is cut off.
};

/// Serves one site. All calls but run() may come from any thread.
class ViewServer {
public:
    /// Listens at an address. With port 0 the system chooses one.
    ///
    /// token   pages have it in their address; without it everything is refused.
    /// errors  what the system says.
    static Result<std::unique_ptr<ViewServer>> listen(const std::string& address, std::uint16_t port,
                                                      std::string token, const WebLimits& limits);
    ~ViewServer();

    std::string url() const;  ///< Where the page is, with the token.

    void run(WebSite site, const std::stop_token& stop);  ///< Returns when a stop is requested.

    void tell(std::uint64_t page, std::string text);
    void tell_all(std::string text);
    /// A frame. Of those that wait for a page only the last is kept; a page has at most two that it has not
    /// said to have shown.
    void show(std::uint64_t page, std::shared_ptr<const std::string> frame);
    void show_all(std::shared_ptr<const std::string> frame);
    void shown(std::uint64_t page);  ///< The page has said so.

private:
    struct Inside;
    explicit ViewServer(std::unique_ptr<Inside> inside);
    std::unique_ptr<Inside> inside_;
};

}  // namespace haarfield
