// Datagrams of a Unix-domain socket: who is asked, who is heard, and what happens when nobody is there.
#include "enip/asio/local_exchange.hpp"

#include <gtest/gtest.h>
#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/local/datagram_protocol.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace servobus::enip::asio {
namespace {

using namespace std::chrono_literals;
using boost::asio::local::datagram_protocol;

constexpr auto patience = 20s;

/// Asks the same again and again, and keeps what is answered.
class Asker final : public MessageUser {
public:
    void on_message(cip::ByteView octets, Time) override {
        heard.emplace_back(octets.begin(), octets.end());
        on_heard();
    }
    void on_timer(Time now) override {
        ++timers;
        deadline = now + 5ms;
        waiting.push_back({1, 2, 3});
        on_asked();
    }
    std::optional<Time> next_deadline() const override { return deadline; }
    std::vector<cip::Bytes> take_messages() override { return std::exchange(waiting, {}); }

    std::vector<cip::Bytes> heard;
    std::vector<cip::Bytes> waiting;
    std::optional<Time> deadline{};
    int timers = 0;
    std::function<void()> on_heard = [] {};
    std::function<void()> on_asked = [] {};
};

class LocalExchangeTest : public testing::Test {
protected:
    LocalExchangeTest() {
        std::string name = (std::filesystem::temp_directory_path() / "servobus-XXXXXX").string();
        directory_ = ::mkdtemp(name.data());
        path_ = (directory_ / "node").string();
    }
    ~LocalExchangeTest() override { std::filesystem::remove_all(directory_); }

    /// Until somebody stops it.
    bool run() {
        context_.restart();
        context_.run_for(patience);
        return context_.stopped();
    }

    std::filesystem::path directory_;
    std::string path_;
    boost::asio::io_context context_;
    Asker asker_;
    LocalExchange exchange_{context_, asker_};
};

TEST_F(LocalExchangeTest, AsksAndHearsTheAnswer) {
    datagram_protocol::socket node(context_, datagram_protocol::endpoint(path_));
    ASSERT_EQ(exchange_.open(path_), std::nullopt);
    std::array<std::uint8_t, 16> question{};
    datagram_protocol::endpoint from;
    node.async_receive_from(boost::asio::buffer(question), from, [&](auto error, std::size_t size) {
        EXPECT_FALSE(error);
        EXPECT_EQ(size, 3U);
        const cip::Bytes answer{9, 8};
        node.send_to(boost::asio::buffer(answer), from);
    });
    asker_.on_heard = [&] { context_.stop(); };
    exchange_.start();
    ASSERT_TRUE(run());
    EXPECT_EQ(asker_.heard, (std::vector<cip::Bytes>{{9, 8}}));
    EXPECT_EQ(question[2], 3);
    exchange_.shut_down();
    EXPECT_TRUE(run()) << "nothing goes on afterwards";
}

TEST_F(LocalExchangeTest, NobodyElseIsHeard) {
    datagram_protocol::socket node(context_, datagram_protocol::endpoint(path_));
    datagram_protocol::socket stranger(context_, datagram_protocol::endpoint(path_ + "-stranger"));
    ASSERT_EQ(exchange_.open(path_), std::nullopt);
    std::array<std::uint8_t, 16> question{};
    datagram_protocol::endpoint from;
    node.async_receive_from(boost::asio::buffer(question), from, [&](auto, std::size_t) {
        stranger.send_to(boost::asio::buffer(cip::Bytes{6, 6, 6}), from);
        node.send_to(boost::asio::buffer(cip::Bytes{1}), from);
    });
    asker_.on_heard = [&] { context_.stop(); };
    exchange_.start();
    ASSERT_TRUE(run());
    EXPECT_EQ(asker_.heard, (std::vector<cip::Bytes>{{1}}));
}

TEST_F(LocalExchangeTest, GoesOnAskingUntilSomebodyIsThere) {
    ASSERT_EQ(exchange_.open(path_), std::nullopt);
    asker_.on_asked = [&] {
        if (asker_.timers == 5) context_.stop();
    };
    exchange_.start();
    ASSERT_TRUE(run());
    datagram_protocol::socket node(context_, datagram_protocol::endpoint(path_));
    std::array<std::uint8_t, 16> question{};
    datagram_protocol::endpoint from;
    node.async_receive_from(boost::asio::buffer(question), from, [&](auto error, std::size_t) {
        EXPECT_FALSE(error);
        context_.stop();
    });
    asker_.on_asked = [] {};
    ASSERT_TRUE(run());
    EXPECT_EQ(question[0], 1);
}

TEST_F(LocalExchangeTest, APathHasTheLengthThatASocketMayHave) {
    constexpr std::size_t longest = sizeof(sockaddr_un::sun_path) - 1;
    EXPECT_NE(exchange_.open(""), std::nullopt);
    EXPECT_NE(exchange_.open(std::string(longest + 1, 'x')), std::nullopt);
    EXPECT_EQ(exchange_.open(std::string(longest, 'x')), std::nullopt);
}

}  // namespace
}  // namespace servobus::enip::asio
