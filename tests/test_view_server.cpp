#include "tools/view/view_server.h"

#include <gtest/gtest.h>

#include <utility>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <condition_variable>
#include <mutex>
#include <random>
#include <thread>

namespace haarfield {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using tcp = boost::asio::ip::tcp;
using Socket = beast::websocket::stream<tcp::socket>;

constexpr std::size_t upload_limit = 100000;

/// A server whose site records requests.
class Served {
public:
    Served() : server_(listening()), thread_([this](const std::stop_token& stop) { run(stop); }) {
        const std::string url = server_->url();
        const std::size_t colon = url.rfind(':'), slash = url.find('/', colon);
        port_ = static_cast<unsigned short>(std::stoi(url.substr(colon + 1, slash - colon - 1)));
        base_ = url.substr(slash);
    }

    ViewServer& server() { return *server_; }
    std::string host() const { return "127.0.0.1:" + std::to_string(port_); }
    const std::string& base() const { return base_; }

    tcp::socket connection() {
        tcp::socket socket(context_);
        socket.connect({boost::asio::ip::make_address("127.0.0.1"), port_});
        return socket;
    }

    http::response<http::string_body> answer(http::verb verb, const std::string& target,
                                             const std::string& body = "", const std::string& origin = "",
                                             std::string host_name = "") {
        tcp::socket socket = connection();
        http::request<http::string_body> request(verb, target, 11);
        request.set(http::field::host, host_name.empty() ? host() : host_name);
        if (!origin.empty()) request.set(http::field::origin, origin);
        request.body() = body;
        request.prepare_payload();
        boost::system::error_code ignored;
        http::write(socket, request, ignored);
        beast::flat_buffer buffer;
        http::response<http::string_body> response;
        http::read(socket, buffer, response, ignored);
        return response;
    }

    /// Opens a session; null if the server rejects it.
    std::unique_ptr<Socket> session(const std::string& origin, const std::string& path) {
        auto socket = std::make_unique<Socket>(connection());
        socket->set_option(
            beast::websocket::stream_base::decorator([&](beast::websocket::request_type& request) {
                if (!origin.empty()) request.set(http::field::origin, origin);
            }));
        boost::system::error_code failure;
        socket->handshake(host(), path, failure);
        if (failure) return nullptr;
        return socket;
    }

    /// Waits for `count` texts and returns them.
    std::vector<std::string> received(std::size_t count) {
        std::unique_lock lock(mutex_);
        changed_.wait_for(lock, std::chrono::seconds(20), [&] { return texts_.size() >= count; });
        return texts_;
    }
    /// Waits for a page to join. Returns the last one.
    std::uint64_t joined() {
        std::unique_lock lock(mutex_);
        changed_.wait_for(lock, std::chrono::seconds(20), [&] { return page_ != 0; });
        return page_;
    }
    std::size_t uploads() {
        const std::lock_guard lock(mutex_);
        return uploads_;
    }

private:
    static std::unique_ptr<ViewServer> listening() {
        WebLimits limits;
        limits.message_bytes = 1000;
        limits.upload_bytes = upload_limit;
        limits.pages = 3;
        Result<std::unique_ptr<ViewServer>> server = ViewServer::listen("127.0.0.1", 0, "secret", limits);
        return std::move(*server);
    }

    void run(const std::stop_token& stop) {
        server_->run(
            {[](std::string_view path) {
                 return WebAnswer{200, "text/plain", "asked for " + std::string(path)};
             },
             [this](std::string_view name, std::string_view bytes) {
                 const std::lock_guard lock(mutex_);
                 ++uploads_;
                 return WebAnswer{200, "text/plain", std::string(name) + " " + std::to_string(bytes.size())};
             },
             [this](std::uint64_t page) { note([&] { page_ = page; }); }, [](std::uint64_t) {},
             [this](std::uint64_t, std::string_view text) { note([&] { texts_.emplace_back(text); }); }},
            stop);
    }

    template <class Act>
    void note(const Act& act) {
        const std::lock_guard lock(mutex_);
        act();
        changed_.notify_all();
    }

    std::unique_ptr<ViewServer> server_;
    unsigned short port_ = 0;
    std::string base_;
    boost::asio::io_context context_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<std::string> texts_;
    std::uint64_t page_ = 0;
    std::size_t uploads_ = 0;
    std::jthread thread_;
};

std::string text_from(Socket& socket) {
    beast::flat_buffer buffer;
    socket.read(buffer);
    return beast::buffers_to_string(buffer.data());
}

TEST(ViewServer, AnswersRequestsWithTheToken) {
    Served served;
    const auto answer = served.answer(http::verb::get, served.base() + "mesh/1%20a");
    EXPECT_EQ(answer.result_int(), 200u);
    EXPECT_EQ(answer.body(), "asked for mesh/1 a");
    EXPECT_EQ(answer[http::field::cache_control], "no-store");
    EXPECT_NE(answer["Content-Security-Policy"].find("frame-ancestors 'none'"), boost::string_view::npos);
    EXPECT_EQ(served.answer(http::verb::post, served.base() + "lights/a.exr", "12345").body(), "a.exr 5");
}

TEST(ViewServer, RefusesRequestsWithoutTheToken) {
    Served served;
    for (const std::string target :
         {"/", "/mesh/0", "/secre/", "/secret", "/secretx/mesh/0", "//secret/", "/Secret/"})
        EXPECT_EQ(served.answer(http::verb::get, target).result_int(), 403u) << target;
    EXPECT_EQ(served.answer(http::verb::post, "/wrong/lights/a.exr", "12345").result_int(), 403u);
    EXPECT_EQ(served.answer(http::verb::put, served.base() + "mesh/0").result_int(), 405u);
    EXPECT_EQ(served.answer(http::verb::get, served.base() + "%zz").result_int(), 400u);
    EXPECT_EQ(served.uploads(), 0u);
}

TEST(ViewServer, RefusesOtherOriginsAndNames) {
    Served served;
    for (const std::string& origin : std::vector<std::string>{
             "http://evil.example", "null", "http://127.0.0.1", "https://" + served.host(),
             "http://127.0.0.1:1", "http://" + served.host() + ".evil.example"}) {
        EXPECT_EQ(served.answer(http::verb::get, served.base(), "", origin).result_int(), 403u) << origin;
        EXPECT_EQ(served.session(origin, served.base() + "session"), nullptr) << origin;
    }
    const std::string port = served.host().substr(served.host().find(':'));
    for (const std::string& name : std::vector<std::string>{"evil.example" + port, std::string("127.0.0.1"),
                                                            "127.0.0.1.evil.example" + port})
        EXPECT_EQ(served.answer(http::verb::get, served.base(), "", "", name).result_int(), 403u) << name;
    for (const std::string& own :
         std::vector<std::string>{"http://" + served.host(), "http://localhost" + port})
        EXPECT_NE(served.session(own, served.base() + "session"), nullptr) << own;
    EXPECT_EQ(served.session("", "/wrong/session"), nullptr);
    EXPECT_EQ(served.session("", served.base() + "elsewhere"), nullptr);
}

TEST(ViewServer, PassesTextsOnBothWays) {
    Served served;
    const auto socket = served.session("", served.base() + "session");
    ASSERT_NE(socket, nullptr);
    socket->text(true);
    socket->write(boost::asio::buffer(std::string("hello")));
    EXPECT_EQ(served.received(1), std::vector<std::string>{"hello"});
    served.server().tell(served.joined(), "good day");
    EXPECT_EQ(text_from(*socket), "good day");
    EXPECT_TRUE(socket->got_text());
    socket->binary(true);
    socket->write(boost::asio::buffer(std::string("bytes")));
    EXPECT_NE(text_from(*socket).find("error"), std::string::npos);
}

TEST(ViewServer, LimitsMessagesUploadsAndPages) {
    Served served;
    EXPECT_EQ(served.answer(http::verb::post, served.base() + "lights/a.exr", std::string(upload_limit, 'x'))
                  .result_int(),
              200u);
    EXPECT_EQ(
        served.answer(http::verb::post, served.base() + "lights/a.exr", std::string(upload_limit + 1, 'x'))
            .result_int(),
        413u);
    EXPECT_EQ(served.uploads(), 1u);
    std::vector<std::unique_ptr<Socket>> sockets;
    for (int i = 0; i < 3; ++i) {
        sockets.push_back(served.session("", served.base() + "session"));
        ASSERT_NE(sockets.back(), nullptr);
    }
    EXPECT_EQ(served.session("", served.base() + "session"), nullptr);
    // A message that is too long closes the connection, which allows another page to connect.
    sockets[0]->write(boost::asio::buffer(std::string(1001, 'x')));
    beast::flat_buffer buffer;
    boost::system::error_code failure;
    sockets[0]->read(buffer, failure);
    EXPECT_TRUE(failure);
    EXPECT_TRUE(served.received(0).empty());
}

TEST(ViewServer, ASlowPageGetsFewerFramesAndTheNewest) {
    Served served;
    const auto socket = served.session("", served.base() + "session");
    ASSERT_NE(socket, nullptr);
    const std::uint64_t page = served.joined();
    const auto show = [&](int number) {
        served.server().show_all(std::make_shared<const std::string>("frame " + std::to_string(number)));
    };
    show(1);
    EXPECT_EQ(text_from(*socket), "frame 1");
    EXPECT_TRUE(socket->got_binary());
    show(2);
    EXPECT_EQ(text_from(*socket), "frame 2");
    for (int number = 3; number <= 100; ++number) show(number);
    // The text follows all frames that may be sent.
    served.server().tell(page, "end");
    EXPECT_EQ(text_from(*socket), "end");
    served.server().shown(page);
    EXPECT_EQ(text_from(*socket), "frame 100");
}

TEST(ViewServer, SurvivesBytesThatAreNoRequests) {
    Served served;
    std::mt19937 random(19);
    for (int i = 0; i < 300; ++i) {
        std::string bytes = "GET " + served.base() + "session HTTP/1.1\r\nHost: " + served.host() +
                            "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nContent-Length: 5\r\n\r\n12345";
        for (int times = 0; times < 1 + i % 5; ++times)
            bytes[random() % bytes.size()] = static_cast<char>(random() % 256);
        bytes.erase(bytes.size() - random() % (1 + bytes.size() / 2));
        tcp::socket socket = served.connection();
        boost::system::error_code ignored;
        boost::asio::write(socket, boost::asio::buffer(bytes), ignored);
    }
    EXPECT_EQ(served.answer(http::verb::get, served.base()).result_int(), 200u);
}

TEST(ViewServer, ListensOnAddressesOfThisMachineOnly) {
    EXPECT_FALSE(bool(ViewServer::listen("192.0.2.1", 0, "secret", {})));
    EXPECT_FALSE(bool(ViewServer::listen("nowhere", 0, "secret", {})));
}

}  // namespace
}  // namespace haarfield
