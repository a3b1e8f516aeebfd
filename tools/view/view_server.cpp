#include "tools/view/view_server.h"

#include "tools/view/page_outbox.h"
#include "tools/view/web_access.h"

#include <fmt/format.h>

// Required by asio's coroutines.
#include <utility>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <array>
#include <map>

namespace haarfield {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Failure = boost::system::error_code;
using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;
using Bytes = std::shared_ptr<const std::string>;

constexpr auto patience = std::chrono::seconds(60);

/// The page may only communicate with its own origin.
constexpr const char* content_policy =
    "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; connect-src 'self' "
    "ws: wss:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

std::string_view view_of(boost::beast::string_view text) {
    return {text.data(), text.size()};
}

}  // namespace

/// The connection of a page, used by the server's thread alone.
struct PageLine {
    std::uint64_t id;
    websocket::stream<beast::tcp_stream> socket;
    asio::steady_timer wake;  ///< Cancelled when there is data to send.
    PageOutbox outbox{};
    bool closed = false;

    void close() {
        closed = true;
        wake.cancel();
        beast::get_lowest_layer(socket).close();
    }
};

struct ViewServer::Inside {
    asio::io_context context{1};
    tcp::acceptor acceptor{context};
    asio::thread_pool slow{1};  ///< For slow answers.
    WebAccess access;
    WebLimits limits;
    WebSite site;
    std::map<std::uint64_t, std::shared_ptr<PageLine>> pages;
    std::uint64_t next_page = 1;

    asio::awaitable<void> accept_all();
    asio::awaitable<void> serve(tcp::socket socket);
    asio::awaitable<void> talk(beast::tcp_stream stream, Request request);
    asio::awaitable<void> send_all(std::shared_ptr<PageLine> page);
    asio::awaitable<WebAnswer> slowly(std::function<WebAnswer()> answer);
    std::optional<WebAnswer> refusal(const Request& request) const;
    asio::awaitable<WebAnswer> answer(const Request& request);
    void queue(PageLine& page, std::string text);
};

/// Returns the answer to a request that is refused, or none.
std::optional<WebAnswer> ViewServer::Inside::refusal(const Request& request) const {
    std::optional<std::string_view> origin;
    if (request.find(http::field::origin) != request.end()) origin = view_of(request[http::field::origin]);
    const std::optional<std::string> why =
        haarfield::refusal(access, view_of(request[http::field::host]), origin, view_of(request.target()));
    if (!why) return std::nullopt;
    return WebAnswer{403, "text/plain", *why + "\n"};
}

asio::awaitable<WebAnswer> ViewServer::Inside::slowly(std::function<WebAnswer()> answer) {
    WebAnswer result;
    asio::steady_timer done(context, asio::steady_timer::time_point::max());
    asio::post(slow, [&] {
        result = answer();
        asio::post(context, [&] { done.cancel(); });
    });
    Failure ignored;
    co_await done.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
    co_return result;
}

asio::awaitable<WebAnswer> ViewServer::Inside::answer(const Request& request) {
    const std::optional<WebAnswer> refused = refusal(request);
    if (refused) co_return *refused;
    const std::optional<std::string> path = asked_path(access, view_of(request.target()));
    if (!path) co_return WebAnswer{400, "text/plain", "Invalid address.\n"};
    if (request.method() == http::verb::get) {
        std::function<WebAnswer()> get = [&] { return site.get(*path); };
        WebAnswer got = co_await slowly(std::move(get));
        co_return got;
    }
    constexpr std::string_view lights = "lights/";
    if (request.method() == http::verb::post && path->starts_with(lights)) {
        // Browsers send an origin with every POST. Requests without one do not come from a page.
        std::function<WebAnswer()> upload = [&] {
            return site.upload(std::string_view(*path).substr(lights.size()), request.body());
        };
        WebAnswer got = co_await slowly(std::move(upload));
        co_return got;
    }
    co_return WebAnswer{405, "text/plain", "Method not allowed.\n"};
}

asio::awaitable<void> ViewServer::Inside::accept_all() {
    for (;;) {
        Failure failure;
        tcp::socket socket =
            co_await acceptor.async_accept(asio::redirect_error(asio::use_awaitable, failure));
        if (failure == asio::error::operation_aborted) co_return;
        if (failure) {  // for example too many open files
            asio::steady_timer pause(context, std::chrono::milliseconds(100));
            co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, failure));
            continue;
        }
        asio::co_spawn(context, serve(std::move(socket)), asio::detached);
    }
}

asio::awaitable<void> ViewServer::Inside::serve(tcp::socket socket) {
    Failure failure;
    socket.set_option(tcp::no_delay(true), failure);
    beast::tcp_stream stream(std::move(socket));
    beast::flat_buffer buffer;
    for (;;) {
        http::request_parser<http::string_body> parser;
        parser.body_limit(limits.upload_bytes);
        parser.header_limit(16384);
        stream.expires_after(patience);
        co_await http::async_read_header(stream, buffer, parser,
                                         asio::redirect_error(asio::use_awaitable, failure));
        const bool is_too_large = failure == http::error::body_limit;
        if (failure && !is_too_large) co_return;
        // Refused requests are not read further.
        const std::optional<WebAnswer> refused = refusal(parser.get());
        if (!refused && websocket::is_upgrade(parser.get())) {
            co_await talk(std::move(stream), parser.release());
            co_return;
        }
        WebAnswer sent;
        const WebAnswer too_large{
            413, "text/plain", fmt::format("Too large; expected at most {} bytes.\n", limits.upload_bytes)};
        if (refused) {
            sent = *refused;
        } else if (is_too_large) {
            sent = too_large;
        } else {
            co_await http::async_read(stream, buffer, parser,
                                      asio::redirect_error(asio::use_awaitable, failure));
            if (failure == http::error::body_limit)
                sent = too_large;
            else if (failure)
                co_return;
            else {
                stream.expires_never();
                WebAnswer got = co_await answer(parser.get());
                sent = std::move(got);
            }
        }
        const bool goes_on = parser.is_done() && parser.get().keep_alive() && sent.status < 400;
        Response response{http::status(sent.status), 11};
        response.set(http::field::content_type, sent.type);
        response.set(http::field::cache_control, "no-store");
        response.set("X-Content-Type-Options", "nosniff");
        response.set("Referrer-Policy", "no-referrer");
        response.set("Cross-Origin-Resource-Policy", "same-origin");
        response.set("Content-Security-Policy", content_policy);
        if (!sent.file_name.empty())
            response.set(http::field::content_disposition,
                         fmt::format("attachment; filename=\"{}\"", sent.file_name));
        response.keep_alive(goes_on);
        response.body() = std::move(sent.bytes);
        response.prepare_payload();
        stream.expires_after(patience);
        co_await http::async_write(stream, response, asio::redirect_error(asio::use_awaitable, failure));
        if (failure || !goes_on) break;
    }
    stream.socket().shutdown(tcp::socket::shutdown_send, failure);
    // Reads remaining data for a while; otherwise the answer might be lost.
    std::array<char, 4096> rest;
    stream.expires_after(std::chrono::seconds(2));
    while (!failure)
        co_await stream.async_read_some(asio::buffer(rest),
                                        asio::redirect_error(asio::use_awaitable, failure));
}

asio::awaitable<void> ViewServer::Inside::talk(beast::tcp_stream stream, Request request) {
    stream.expires_never();
    if (below_token(access, view_of(request.target())) != "session" || pages.size() >= limits.pages)
        co_return;
    auto page = std::make_shared<PageLine>(
        PageLine{next_page++, websocket::stream<beast::tcp_stream>(std::move(stream)),
                 asio::steady_timer(context, asio::steady_timer::time_point::max())});
    websocket::stream<beast::tcp_stream>& socket = page->socket;
    socket.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    socket.read_message_max(limits.message_bytes);
    socket.auto_fragment(false);
    Failure failure;
    co_await socket.async_accept(request, asio::redirect_error(asio::use_awaitable, failure));
    if (failure) co_return;
    pages[page->id] = page;
    asio::co_spawn(context, send_all(page), asio::detached);
    site.joined(page->id);
    beast::flat_buffer buffer;
    while (!page->closed) {
        co_await socket.async_read(buffer, asio::redirect_error(asio::use_awaitable, failure));
        if (failure) break;
        if (socket.got_text())
            site.received(page->id, {static_cast<const char*>(buffer.data().data()), buffer.data().size()});
        else
            queue(*page, R"({"type":"error","message":"found binary data; expected a text"})");
        buffer.consume(buffer.size());
    }
    pages.erase(page->id);
    page->close();
    site.left(page->id);
}

void ViewServer::Inside::queue(PageLine& page, std::string text) {
    page.outbox.add_text(std::move(text));
    if (page.outbox.text_bytes() > limits.waiting_bytes) return page.close();
    page.wake.cancel();
}

asio::awaitable<void> ViewServer::Inside::send_all(std::shared_ptr<PageLine> page) {
    Failure failure;
    while (!page->closed) {
        const std::optional<PageOutbox::Parcel> next = page->outbox.take();
        if (!next) {
            page->wake.expires_at(asio::steady_timer::time_point::max());
            co_await page->wake.async_wait(asio::redirect_error(asio::use_awaitable, failure));
            continue;
        }
        page->socket.binary(next->is_frame);
        co_await page->socket.async_write(asio::buffer(*next->bytes),
                                          asio::redirect_error(asio::use_awaitable, failure));
        if (failure) co_return page->close();
    }
}

ViewServer::ViewServer(std::unique_ptr<Inside> inside) : inside_(std::move(inside)) {}
ViewServer::~ViewServer() = default;

Result<std::unique_ptr<ViewServer>> ViewServer::listen(const std::string& address, std::uint16_t port,
                                                       std::string token, const WebLimits& limits) {
    auto inside = std::make_unique<Inside>();
    Failure failure;
    const asio::ip::address ip = asio::ip::make_address(address, failure);
    if (failure) return Error{address, "is not a valid address; expected a numeric address of this machine"};
    const tcp::endpoint endpoint(ip, port);
    tcp::acceptor& acceptor = inside->acceptor;
    acceptor.open(endpoint.protocol(), failure);
    if (!failure) acceptor.set_option(tcp::acceptor::reuse_address(true), failure);
    if (!failure) acceptor.bind(endpoint, failure);
    if (!failure) acceptor.listen(asio::socket_base::max_listen_connections, failure);
    if (failure) return Error{fmt::format("{}:{}", address, port), failure.message()};
    inside->access = {.token = std::move(token),
                      .host = ip.is_v6() ? "[" + ip.to_string() + "]" : ip.to_string(),
                      .port = acceptor.local_endpoint().port(),
                      .is_loopback = ip.is_loopback()};
    inside->limits = limits;
    return std::unique_ptr<ViewServer>(new ViewServer(std::move(inside)));
}

std::string ViewServer::url() const {
    const WebAccess& access = inside_->access;
    return fmt::format("http://{}:{}/{}/", access.host, access.port, access.token);
}

void ViewServer::run(WebSite site, const std::stop_token& stop) {
    Inside& inside = *inside_;
    inside.site = std::move(site);
    asio::co_spawn(inside.context, inside.accept_all(), asio::detached);
    const std::stop_callback end(stop, [&inside] { inside.context.stop(); });
    if (!stop.stop_requested()) inside.context.run();
    inside.slow.stop();
    inside.slow.join();
}

void ViewServer::tell(std::uint64_t page, std::string text) {
    asio::post(inside_->context, [this, page, text = std::move(text)]() mutable {
        const auto known = inside_->pages.find(page);
        if (known != inside_->pages.end()) inside_->queue(*known->second, std::move(text));
    });
}

void ViewServer::tell_all(std::string text) {
    asio::post(inside_->context, [this, text = std::move(text)] {
        for (const auto& [id, page] : inside_->pages) inside_->queue(*page, text);
    });
}

void ViewServer::show(std::uint64_t page, Bytes frame) {
    asio::post(inside_->context, [this, page, frame = std::move(frame)]() mutable {
        const auto known = inside_->pages.find(page);
        if (known == inside_->pages.end()) return;
        known->second->outbox.set_frame(std::move(frame));
        known->second->wake.cancel();
    });
}

void ViewServer::show_all(Bytes frame) {
    asio::post(inside_->context, [this, frame = std::move(frame)] {
        for (const auto& [id, page] : inside_->pages) {
            page->outbox.set_frame(frame);
            page->wake.cancel();
        }
    });
}

void ViewServer::shown(std::uint64_t page) {
    asio::post(inside_->context, [this, page] {
        const auto known = inside_->pages.find(page);
        if (known == inside_->pages.end()) return;
        known->second->outbox.shown();
        known->second->wake.cancel();
    });
}

}  // namespace haarfield
