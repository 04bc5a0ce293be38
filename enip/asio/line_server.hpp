// Lines of text in, lines of text out, beside the bus: over standard input and output, or a socket of this machine.
#pragma once

#include <sys/types.h>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "enip/asio/line_service.hpp"

namespace servobus::enip::asio {

class LineServer {
public:
    /// `after_line` is called when a line has been answered: what it did may have moved a deadline.
    LineServer(boost::asio::any_io_executor executor, LineService service, std::function<void()> after_line,
               std::function<void(const std::string&)> problem);
    ~LineServer();
    LineServer(const LineServer&) = delete;
    LineServer& operator=(const LineServer&) = delete;

    /// Listens at a Unix-domain socket that only its owner may use. A socket that nobody listens at any more is
    /// replaced; anything else at the path stays. Returns why it does not listen.
    [[nodiscard]] std::optional<std::string> listen(const std::string& path);
    /// Speaks through standard input and output instead. The end of the input ends nothing but that. From then on
    /// SIGPIPE is ignored in the whole process: who reads the answers may go away.
    [[nodiscard]] std::optional<std::string> use_standard_streams();

    /// Serves what was opened, as long as the executor runs.
    void start();
    void stop();

private:
    using Socket = boost::asio::local::stream_protocol::socket;
    class Splitter;

    [[nodiscard]] std::optional<std::string> make_way(const std::string& path);
    void remove_path();
    [[nodiscard]] std::string answer(Splitter& lines);
    [[nodiscard]] boost::asio::awaitable<void> accept();
    [[nodiscard]] boost::asio::awaitable<void> serve_client(Socket socket);
    [[nodiscard]] boost::asio::awaitable<void> serve_standard_streams();
    template <class In, class Out>
    [[nodiscard]] boost::asio::awaitable<void> serve(In& in, Out& out);

    boost::asio::any_io_executor executor_;
    LineService service_;
    std::function<void()> after_line_;
    std::function<void(const std::string&)> problem_;
    boost::asio::local::stream_protocol::acceptor acceptor_;
    boost::asio::posix::stream_descriptor input_;
    boost::asio::posix::stream_descriptor output_;
    std::set<Socket*> clients_;
    std::string path_;
    dev_t device_ = 0;  ///< of the socket file, to know it again
    ino_t inode_ = 0;
    bool stopped_ = false;
};

}  // namespace servobus::enip::asio
