// Lines over a socket of this machine, with the server that serves the bus.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "adapter/adapter.hpp"
#include "drive/xenax.hpp"
#include "enip/asio/line_service.hpp"
#include "enip/asio/target_server.hpp"

namespace servobus::test {
namespace {

using enip::asio::LineService;
using enip::asio::max_line_clients;
using enip::asio::max_line_octets;
using enip::asio::TargetServer;
using testing::HasSubstr;

constexpr int patience_ms = 10'000;

/// A client of the socket. It reads line by line; "" is the end.
class Client {
public:
    explicit Client(const std::string& path) : socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path.copy(address.sun_path, sizeof address.sun_path - 1);
        connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    }
    ~Client() { ::close(socket_); }
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    bool connected() const { return connected_; }
    void send(const std::string& text) const { (void)::send(socket_, text.data(), text.size(), MSG_NOSIGNAL); }
    void end_sending() const { ::shutdown(socket_, SHUT_WR); }
    std::string line() const {
        std::string text;
        for (char c = 0;;) {
            pollfd entry{socket_, POLLIN, 0};
            if (::poll(&entry, 1, patience_ms) <= 0) return "nothing came";
            if (::recv(socket_, &c, 1, 0) != 1 || c == '\n') return text;
            text += c;
        }
    }

private:
    int socket_;
    bool connected_ = false;
};

class LineServer : public testing::Test {
protected:
    void SetUp() override { std::filesystem::create_directories(directory_); }
    void TearDown() override {
        stop();
        std::filesystem::remove_all(directory_);
    }
    /// Listens at the path and serves in a thread; why not, otherwise.
    std::string start() {
        if (const auto place = server_.listen(adapter_, {.port = 0}); !place) return place.error().reason;
        if (const auto error = server_.serve_lines(service_, path_)) return error->reason;
        thread_ = std::thread([this] { server_.run(); });
        return "";
    }
    void stop() {
        if (!thread_.joinable()) return;
        server_.stop();
        thread_.join();
    }

    const std::filesystem::path directory_ =
        std::filesystem::path(testing::TempDir()) /
        ("servobus_lines_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    const std::string path_ = (directory_ / "control").string();
    const LineService service_{.answer = [](std::string_view line, enip::Time) { return fmt::format("<{}>", line); },
                               .too_long = "too long",
                               .too_many = "too many"};
    drive::Device device_{drive::xenax_models().front()};
    adapter::Adapter adapter_{device_, {}, 1};
    TargetServer server_;
    std::thread thread_;
};

TEST_F(LineServer, AnswersEachLineInWhateverPiecesItComes) {
    ASSERT_EQ(start(), "");
    const Client client(path_);
    client.send("one\ntwo\r\n\n  \nth");
    EXPECT_EQ(client.line(), "<one>");
    EXPECT_EQ(client.line(), "<two>");
    client.send("ree");
    client.send("\n");
    EXPECT_EQ(client.line(), "<three>") << "blank lines are not answered";
    client.send("four");
    client.end_sending();
    EXPECT_EQ(client.line(), "<four>") << "the last line may lack its end";
    EXPECT_EQ(client.line(), "");
}

TEST_F(LineServer, ALineThatIsTooLongIsAnsweredAndTheNextCounts) {
    ASSERT_EQ(start(), "");
    const Client client(path_);
    const std::string longest(max_line_octets, 'a');
    client.send(longest + "\r\n" + longest + "b\n" + std::string(3 * max_line_octets, ' ') + "\nnext\n");
    EXPECT_EQ(client.line(), "<" + longest + ">");
    EXPECT_EQ(client.line(), "too long");
    EXPECT_EQ(client.line(), "too long");
    EXPECT_EQ(client.line(), "<next>");
}

TEST_F(LineServer, ServesSoManyClientsAndTellsTheNext) {
    ASSERT_EQ(start(), "");
    std::vector<std::unique_ptr<Client>> clients;
    for (std::size_t i = 0; i < max_line_clients; ++i) {
        clients.push_back(std::make_unique<Client>(path_));
        clients.back()->send("here\n");
        ASSERT_EQ(clients.back()->line(), "<here>");
    }
    const Client surplus(path_);
    EXPECT_EQ(surplus.line(), "too many");
    EXPECT_EQ(surplus.line(), "");
    clients.front()->end_sending();
    EXPECT_EQ(clients.front()->line(), "");
    const Client next(path_);
    next.send("again\n");
    EXPECT_EQ(next.line(), "<again>");
}

TEST_F(LineServer, IsItsOwnersAloneAndLeavesNothingBehind) {
    ASSERT_EQ(start(), "");
    struct stat status {};
    ASSERT_EQ(::stat(path_.c_str(), &status), 0);
    EXPECT_TRUE(S_ISSOCK(status.st_mode));
    EXPECT_EQ(status.st_mode & 0777, 0600U);
    const Client client(path_);
    client.send("here\n");
    EXPECT_EQ(client.line(), "<here>");
    stop();
    EXPECT_EQ(client.line(), "");
    EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(LineServer, TakesThePlaceOfASocketThatNobodyListensAt) {
    const int left = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(left, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::close(left);
    ASSERT_TRUE(std::filesystem::exists(path_));
    ASSERT_EQ(start(), "");
    EXPECT_TRUE(Client(path_).connected());
}

TEST_F(LineServer, LeavesASocketAloneThatSomebodyListensAt) {
    ASSERT_EQ(start(), "");
    TargetServer second;
    const auto error = second.serve_lines(service_, path_);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->reason, "cannot listen at '" + path_ + "': another program listens there");
    const Client client(path_);
    client.send("here\n");
    EXPECT_EQ(client.line(), "<here>");
}

TEST_F(LineServer, OverwritesNoFile) {
    std::ofstream(path_) << "precious";
    EXPECT_EQ(start(), "cannot listen at '" + path_ + "': there is a file that is no socket; it is not overwritten");
    EXPECT_EQ(std::filesystem::file_size(path_), 8U);
}

TEST_F(LineServer, DoesNotRemoveWhatIsNotItsOwn) {
    ASSERT_EQ(start(), "");
    std::filesystem::remove(path_);
    std::ofstream(path_) << "precious";
    stop();
    EXPECT_TRUE(std::filesystem::exists(path_));
}

TEST_F(LineServer, SaysWhyAPathDoesNotDo) {
    const auto reason = [&](const std::string& path) {
        const auto error = server_.serve_lines(service_, path);
        return error ? error->reason : "accepted";
    };
    EXPECT_THAT(reason(std::string(108, 'a')), HasSubstr("the path of a socket has 1 to 107 characters"));
    EXPECT_THAT(reason(""), HasSubstr("the path of a socket has 1 to 107 characters"));
    EXPECT_THAT(reason((directory_ / "none" / "control").string()), HasSubstr("No such file or directory"));
}

}  // namespace
}  // namespace servobus::test
