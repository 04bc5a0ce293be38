#include "enip/asio/line_server.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <system_error>
#include <utility>

namespace servobus::enip::asio {
namespace {

namespace net = boost::asio;
using boost::system::error_code;
using net::local::stream_protocol;
using namespace std::chrono_literals;

constexpr auto awaited = net::as_tuple(net::use_awaitable);

constexpr std::size_t read_buffer_octets = 4096;
constexpr std::size_t max_path = sizeof(sockaddr_un::sun_path) - 1;
constexpr mode_t nobody_else = 0177;
/// After accept() failed for want of a resource.
constexpr auto accept_pause = 100ms;

std::string reason_of(int number) { return std::generic_category().message(number); }

// A descriptor of our own for a standard stream. Reading without waiting is a property of what was opened, not of the
// descriptor, and a terminal is shared with the shell that started us; so a terminal or pipe is opened once more.
int own_descriptor(int stream, int direction) {
    struct stat status {};
    if (::fstat(stream, &status) != 0) return -1;
    if (S_ISFIFO(status.st_mode) || S_ISCHR(status.st_mode)) {
        const auto name = fmt::format("/proc/self/fd/{}", stream);
        const int opened = ::open(name.c_str(), direction | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
        if (opened >= 0) return opened;
    }
    return ::fcntl(stream, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
}

}  // namespace

// Makes lines of octets that come in pieces of any size.
class LineServer::Splitter {
public:
    struct Line {
        std::string text;
        bool too_long = false;
    };

    void put(std::string_view octets) { waiting_ = octets; }

    /// The next whole line of what was put in.
    std::optional<Line> next() {
        const auto end = waiting_.find('\n');
        const auto part = waiting_.substr(0, end);
        const auto room = max_line_octets + 1 - line_.text.size();  // one more, for a carriage return
        line_.too_long = line_.too_long || part.size() > room;
        line_.text.append(part.substr(0, room));
        if (end == std::string_view::npos) {
            waiting_ = {};
            return std::nullopt;
        }
        waiting_.remove_prefix(end + 1);
        return finish();
    }

private:
    Line finish() {
        auto line = std::exchange(line_, {});
        if (line.text.ends_with('\r')) line.text.pop_back();
        line.too_long = line.too_long || line.text.size() > max_line_octets;
        return line;
    }

    std::string_view waiting_;
    Line line_;
};

LineServer::LineServer(net::any_io_executor executor, LineService service, std::function<void()> after_line,
                       std::function<void(const std::string&)> problem)
    : executor_(std::move(executor)),
      service_(std::move(service)),
      after_line_(std::move(after_line)),
      problem_(std::move(problem)),
      acceptor_(executor_),
      input_(executor_),
      output_(executor_) {}

LineServer::~LineServer() { remove_path(); }

std::optional<std::string> LineServer::listen(const std::string& path) {
    const auto fail = [&](const std::string& reason) { return fmt::format("cannot listen at '{}': {}", path, reason); };
    if (path.empty() || path.size() > max_path) {
        return fail(fmt::format("the path of a socket has 1 to {} characters", max_path));
    }
    if (const auto reason = make_way(path)) return fail(*reason);
    error_code error;
    acceptor_.open(stream_protocol(), error);
    const auto before = ::umask(nobody_else);
    if (!error) acceptor_.bind(stream_protocol::endpoint(path), error);
    ::umask(before);
    if (error) return fail(error.message());
    path_ = path;
    struct stat status {};
    if (::lstat(path.c_str(), &status) == 0) {
        device_ = status.st_dev;
        inode_ = status.st_ino;
    }
    acceptor_.listen(net::socket_base::max_listen_connections, error);
    if (error) return fail(error.message());
    return std::nullopt;
}

// Why something at the path has to stay; nullopt when there is nothing, or nothing any more.
std::optional<std::string> LineServer::make_way(const std::string& path) {
    struct stat status {};
    if (::lstat(path.c_str(), &status) != 0) {
        return errno == ENOENT ? std::nullopt : std::optional(reason_of(errno));
    }
    if (!S_ISSOCK(status.st_mode)) return "there is a file that is no socket; it is not overwritten";
    error_code error;
    Socket probe(executor_);
    probe.open(stream_protocol(), error);
    if (!error) probe.non_blocking(true, error);
    if (!error) probe.connect(stream_protocol::endpoint(path), error);
    if (error == net::error::access_denied) return error.message();
    if (error != net::error::connection_refused) return "another program listens there";
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) return reason_of(errno);
    return std::nullopt;
}

// Only if it is still ours.
void LineServer::remove_path() {
    const auto path = std::exchange(path_, {});
    struct stat status {};
    if (path.empty() || ::lstat(path.c_str(), &status) != 0) return;
    if (status.st_dev == device_ && status.st_ino == inode_) ::unlink(path.c_str());
}

std::optional<std::string> LineServer::use_standard_streams() {
    static_cast<void>(std::signal(SIGPIPE, SIG_IGN));
    const int input = own_descriptor(STDIN_FILENO, O_RDONLY);
    if (input < 0) return fmt::format("standard input cannot be read: {}", reason_of(errno));
    const int output = own_descriptor(STDOUT_FILENO, O_WRONLY);
    if (output < 0) {
        ::close(input);
        return fmt::format("standard output cannot be written: {}", reason_of(errno));
    }
    error_code error;
    input_.assign(input, error);
    if (error) ::close(input);
    error_code output_error;
    output_.assign(output, output_error);
    if (output_error) ::close(output);
    if (error || output_error) return (error ? error : output_error).message();
    return std::nullopt;
}

void LineServer::start() {
    if (acceptor_.is_open()) net::co_spawn(executor_, accept(), net::detached);
    if (input_.is_open()) net::co_spawn(executor_, serve_standard_streams(), net::detached);
}

void LineServer::stop() {
    stopped_ = true;
    error_code ignored;
    acceptor_.close(ignored);
    input_.close(ignored);
    output_.close(ignored);
    for (auto* client : clients_) {
        client->shutdown(Socket::shutdown_both, ignored);
        client->cancel(ignored);
    }
    remove_path();
}

net::awaitable<void> LineServer::accept() {
    while (acceptor_.is_open()) {
        auto [error, socket] = co_await acceptor_.async_accept(awaited);
        if (error == net::error::operation_aborted) co_return;
        if (error) {
            if (problem_) problem_(fmt::format("a control connection could not be accepted: {}", error.message()));
            net::steady_timer pause(executor_, accept_pause);
            co_await pause.async_wait(awaited);
            continue;
        }
        net::co_spawn(executor_, serve_client(std::move(socket)), net::detached);
    }
}

net::awaitable<void> LineServer::serve_client(Socket socket) {
    if (stopped_) co_return;
    if (clients_.size() >= max_line_clients) {
        const auto line = service_.too_many + '\n';  // an empty socket takes it at once
        error_code ignored;
        socket.non_blocking(true, ignored);
        socket.write_some(net::buffer(line), ignored);
        co_return;
    }
    clients_.insert(&socket);
    co_await serve(socket, socket);
    clients_.erase(&socket);
}

net::awaitable<void> LineServer::serve_standard_streams() { co_await serve(input_, output_); }

// gcc 12 inlines one of the two functions of Asio that allocate and free a coroutine's frame, and not the other.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"

// While nobody takes the answers, no more lines are read. Where they cannot be written at all, lines still count.
template <class In, class Out>
net::awaitable<void> LineServer::serve(In& in, Out& out) {
    std::array<char, read_buffer_octets> buffer;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    Splitter lines;
    bool heard = true;
    for (bool more = true; more && !stopped_;) {
        const auto [error, size] = co_await in.async_read_some(net::buffer(buffer), awaited);
        if (stopped_) co_return;
        more = !error;
        lines.put({buffer.data(), size});
        auto answers = answer(lines);
        if (!more) {
            lines.put("\n");  // a last line may lack its end
            answers += answer(lines);
        }
        if (answers.empty() || !heard) continue;
        const auto [failed, written] = co_await net::async_write(out, net::buffer(answers), awaited);
        heard = !failed;
    }
}

#pragma GCC diagnostic pop

std::string LineServer::answer(Splitter& lines) {
    std::string answers;
    while (const auto line = lines.next()) {
        if (!line->too_long && line->text.find_first_not_of(" \t") == std::string::npos) continue;
        answers += line->too_long ? service_.too_long : service_.answer(line->text, std::chrono::steady_clock::now());
        answers += '\n';
        after_line_();
    }
    return answers;
}

}  // namespace servobus::enip::asio
