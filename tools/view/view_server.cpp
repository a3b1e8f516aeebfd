#include "tools/view/view_server.h"

#include <fmt/format.h>

// Asio's coroutines take it for granted.
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

#include <nlohmann/json.hpp>

#include <array>
#include <deque>
#include <map>
#include <random>

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
constexpr int most_unshown = 2;  ///< Frames that a page has been sent and has not shown.

/// What a page's file may do: nothing but talk to where it comes from.
constexpr const char* content_policy =
    "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; connect-src 'self' "
    "ws: wss:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

bool is_same_token(std::string_view given, std::string_view token) {
    // In a time that does not depend on where they differ.
    unsigned difference = given.size() == token.size() ? 0 : 1;
    for (std::size_t i = 0; i < token.size(); ++i)
        difference |= static_cast<unsigned char>(token[i]) ^
                      static_cast<unsigned char>(i < given.size() ? given[i] : '\0');
    return difference == 0;
}

/// `%41` and the like; nothing if they are broken.
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

/// A page's connection: what waits to be sent to it. Of the server's thread.
struct PageLine {
    std::uint64_t id;
    websocket::stream<beast::tcp_stream> socket;
    asio::steady_timer wake;  ///< Cancelled when there is something to send.
    std::deque<std::string> texts{};
    std::size_t text_bytes = 0;
    Bytes frame{};
    int unshown = 0;
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
    asio::thread_pool slow{1};  ///< For answers that take long.
    std::string token, host;
    WebLimits limits;
    WebSite site;
    std::map<std::uint64_t, std::shared_ptr<PageLine>> pages;
    std::uint64_t next_page = 1;
    std::uint16_t port = 0;
    bool is_loopback = true;

    asio::awaitable<void> accept_all();
    asio::awaitable<void> serve(tcp::socket socket);
    asio::awaitable<void> talk(beast::tcp_stream stream, Request request);
    asio::awaitable<void> send_all(std::shared_ptr<PageLine> page);
    asio::awaitable<WebAnswer> slowly(std::function<WebAnswer()> answer);
    bool is_own_host(std::string_view host) const;
    bool is_own_origin(std::string_view origin) const;
    std::optional<WebAnswer> refusal(const Request& request) const;
    asio::awaitable<WebAnswer> answer(const Request& request);
    void queue(PageLine& page, std::string text);
};

/// The names under which a browser may reach this server: those that can not be another's.
bool ViewServer::Inside::is_own_host(std::string_view given) const {
    const std::string end = fmt::format(":{}", port);
    if (!given.ends_with(end)) return false;
    given.remove_suffix(end.size());
    return given == host ||
           (is_loopback && (given == "localhost" || given == "127.0.0.1" || given == "[::1]"));
}

bool ViewServer::Inside::is_own_origin(std::string_view origin) const {
    constexpr std::string_view scheme = "http://";
    return origin.starts_with(scheme) && is_own_host(origin.substr(scheme.size()));
}

/// Why a request is refused, if it is: by host, origin or token.
std::optional<WebAnswer> ViewServer::Inside::refusal(const Request& request) const {
    const auto text = [](boost::beast::string_view view) {
        return std::string_view(view.data(), view.size());
    };
    const auto refuse = [](unsigned status, const char* why) {
        return WebAnswer{status, "text/plain", std::string(why) + "\n"};
    };
    if (!is_own_host(text(request[http::field::host]))) return refuse(403, "Not the name of this server.");
    if (request.find(http::field::origin) != request.end() &&
        !is_own_origin(text(request[http::field::origin])))
        return refuse(403, "Not for pages of another origin.");
    const std::string_view target = text(request.target());
    if (target.size() < token.size() + 2 || target.front() != '/' ||
        !is_same_token(target.substr(1, token.size()), token) || target[token.size() + 1] != '/')
        return refuse(403, "The address lacks its token: take the one that haarfield view prints.");
    return std::nullopt;
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
    const std::string_view target(request.target().data(), request.target().size());
    const std::string_view below = target.substr(token.size() + 2);
    const std::optional<std::string> path = decoded(below.substr(0, below.find('?')));
    if (!path) co_return WebAnswer{400, "text/plain", "The address is broken.\n"};
    if (request.method() == http::verb::get) {
        std::function<WebAnswer()> get = [&] { return site.get(*path); };
        WebAnswer got = co_await slowly(std::move(get));
        co_return got;
    }
    constexpr std::string_view lights = "lights/";
    if (request.method() == http::verb::post && path->starts_with(lights)) {
        // A browser sends its origin with every POST; what sends none is no page.
        std::function<WebAnswer()> upload = [&] {
            return site.upload(std::string_view(*path).substr(lights.size()), request.body());
        };
        WebAnswer got = co_await slowly(std::move(upload));
        co_return got;
    }
    co_return WebAnswer{405, "text/plain", "Not done here.\n"};
}

asio::awaitable<void> ViewServer::Inside::accept_all() {
    for (;;) {
        Failure failure;
        tcp::socket socket =
            co_await acceptor.async_accept(asio::redirect_error(asio::use_awaitable, failure));
        if (failure == asio::error::operation_aborted) co_return;
        if (failure) {  // such as too many open files
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
        // Who may not ask is not listened to.
        const std::optional<WebAnswer> refused = refusal(parser.get());
        if (!refused && websocket::is_upgrade(parser.get())) {
            co_await talk(std::move(stream), parser.release());
            co_return;
        }
        WebAnswer sent;
        const WebAnswer too_large{413, "text/plain",
                                  fmt::format("Too large; wanted at most {} bytes.\n", limits.upload_bytes)};
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
    // What is still on its way is taken, for a while: otherwise the answer might be lost with it.
    std::array<char, 4096> rest;
    stream.expires_after(std::chrono::seconds(2));
    while (!failure)
        co_await stream.async_read_some(asio::buffer(rest),
                                        asio::redirect_error(asio::use_awaitable, failure));
}

asio::awaitable<void> ViewServer::Inside::talk(beast::tcp_stream stream, Request request) {
    stream.expires_never();
    const std::string_view target(request.target().data(), request.target().size());
    if (target.substr(token.size() + 2) != "session" || pages.size() >= limits.pages) co_return;
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
            queue(*page, R"({"type":"error","message":"pages send texts only"})");
        buffer.consume(buffer.size());
    }
    pages.erase(page->id);
    page->close();
    site.left(page->id);
}

void ViewServer::Inside::queue(PageLine& page, std::string text) {
    page.text_bytes += text.size();
    page.texts.push_back(std::move(text));
    if (page.text_bytes > limits.waiting_bytes) return page.close();
    page.wake.cancel();
}

asio::awaitable<void> ViewServer::Inside::send_all(std::shared_ptr<PageLine> page) {
    Failure failure;
    while (!page->closed) {
        if (!page->texts.empty()) {
            const std::string text = std::move(page->texts.front());
            page->texts.pop_front();
            page->text_bytes -= text.size();
            page->socket.text(true);
            co_await page->socket.async_write(asio::buffer(text),
                                              asio::redirect_error(asio::use_awaitable, failure));
        } else if (page->frame && page->unshown < most_unshown) {
            const Bytes frame = std::exchange(page->frame, nullptr);
            ++page->unshown;
            page->socket.binary(true);
            co_await page->socket.async_write(asio::buffer(*frame),
                                              asio::redirect_error(asio::use_awaitable, failure));
        } else {
            page->wake.expires_at(asio::steady_timer::time_point::max());
            co_await page->wake.async_wait(asio::redirect_error(asio::use_awaitable, failure));
            continue;
        }
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
    if (failure) return Error{address, "is no address of this machine; wanted one in numbers"};
    const tcp::endpoint endpoint(ip, port);
    tcp::acceptor& acceptor = inside->acceptor;
    acceptor.open(endpoint.protocol(), failure);
    if (!failure) acceptor.set_option(tcp::acceptor::reuse_address(true), failure);
    if (!failure) acceptor.bind(endpoint, failure);
    if (!failure) acceptor.listen(asio::socket_base::max_listen_connections, failure);
    if (failure) return Error{fmt::format("{}:{}", address, port), failure.message()};
    inside->port = acceptor.local_endpoint().port();
    inside->is_loopback = ip.is_loopback();
    inside->host = ip.is_v6() ? "[" + ip.to_string() + "]" : ip.to_string();
    inside->token = std::move(token);
    inside->limits = limits;
    return std::unique_ptr<ViewServer>(new ViewServer(std::move(inside)));
}

std::string ViewServer::url() const {
    return fmt::format("http://{}:{}/{}/", inside_->host, inside_->port, inside_->token);
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
        known->second->frame = std::move(frame);
        known->second->wake.cancel();
    });
}

void ViewServer::show_all(Bytes frame) {
    asio::post(inside_->context, [this, frame = std::move(frame)] {
        for (const auto& [id, page] : inside_->pages) {
            page->frame = frame;
            page->wake.cancel();
        }
    });
}

void ViewServer::shown(std::uint64_t page) {
    asio::post(inside_->context, [this, page] {
        const auto known = inside_->pages.find(page);
        if (known == inside_->pages.end()) return;
        known->second->unshown = std::max(0, known->second->unshown - 1);
        known->second->wake.cancel();
    });
}

std::string random_token() {
    std::random_device random;  // the system's
    std::string token;
    for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", random());
    return token;
}

}  // namespace haarfield
