#pragma once
/// Serves pages over HTTP and WebSocket. Only this file uses Boost.Beast. PROTOCOL.md describes the
/// addresses.

#include "fields/base/progress.h"
#include "fields/base/result.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace haarfield {

/// The answer to a request.
struct WebAnswer {
    unsigned status = 200;
    std::string type;  ///< Content type, such as `text/html`.
    std::string bytes;
    std::string file_name{};  ///< Suggested file name of a download; empty: no download.
};

/// The functions that answer requests. `get` and `upload` may be slow and run on a separate thread; the
/// others must return at once and run on the server's thread.
struct WebSite {
    std::function<WebAnswer(std::string_view path)> get;  ///< The path below the token.
    std::function<WebAnswer(std::string_view name, std::string_view bytes)> upload;
    std::function<void(std::uint64_t page)> joined, left;
    std::function<void(std::uint64_t page, std::string_view text)> received;
};

struct WebLimits {
    std::size_t message_bytes = 1 << 16;
    std::size_t upload_bytes = std::size_t(64) << 20;
    std::size_t pages = 16;  ///< Connected at the same time.
    /// Limit of the texts that a page has not received; above it, the connection is closed.
    std::size_t waiting_bytes = std::size_t(8) << 20;
};

/// Serves one site. All functions except run() are thread-safe.
class ViewServer {
public:
    /// Listens at an address. With port 0 the system chooses a port.
    ///
    /// token   a secret part of the pages' address. Requests without it are refused.
    /// errors  I/O errors.
    static Result<std::unique_ptr<ViewServer>> listen(const std::string& address, std::uint16_t port,
                                                      std::string token, const WebLimits& limits);
    ~ViewServer();

    std::string url() const;  ///< The address of the page, with the token.

    void run(WebSite site, const std::stop_token& stop);  ///< Returns when a stop is requested.

    void tell(std::uint64_t page, std::string text);
    void tell_all(std::string text);
    /// Sends a frame. Only the newest waiting frame is kept, and a page has at most two frames that it has
    /// not confirmed as displayed.
    void show(std::uint64_t page, std::shared_ptr<const std::string> frame);
    void show_all(std::shared_ptr<const std::string> frame);
    void shown(std::uint64_t page);  ///< The page has displayed a frame.

private:
    struct Inside;
    explicit ViewServer(std::unique_ptr<Inside> inside);
    std::unique_ptr<Inside> inside_;
};

}  // namespace haarfield
