// One I/O connection from opening to its end, as a command line runs it: blocking, with those who look on.
#pragma once

#include <boost/system/result.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "cip/bytes.hpp"
#include "enip/asio/asio.hpp"
#include "scanner/cli/io_options.hpp"
#include "scanner/cli/link.hpp"
#include "scanner/host.hpp"
#include "scanner/interval_statistics.hpp"
#include "scanner/originator.hpp"

namespace servobus::scanner::cli {

/// How a connection has run so far, over all its openings.
struct IoReport {
    explicit IoReport(IntervalStatistics::Duration granted) : received(granted) {}

    IntervalStatistics received;
    std::uint64_t sent = 0;
    std::uint64_t wrong_size = 0;  ///< datagrams that had not the size of the connection
    std::uint64_t openings = 0;
    std::chrono::duration<double> open_for{};  ///< from the first opening to the last datagram or the end
    std::optional<std::chrono::duration<double>> first_input{};  ///< from the reply to the first datagram
    bool cyclic = true;                                          ///< otherwise there is no drift to speak of
};

/// Somebody who looks on. All times count from the first opening.
class IoSink {
public:
    virtual ~IoSink() = default;

    virtual void opened(const IoOpened&) {}
    virtual void input(const IoInput&, std::chrono::duration<double>) {}
    virtual void packet(const IoPacketSeen&) {}
    /// `text` says why, for people.
    virtual void closed(const IoClosed&, const std::string& /*text*/) {}
    /// Called every IoRunner::tick.
    virtual void look(const IoReport&) {}

protected:
    IoSink() = default;
    IoSink(const IoSink&) = default;
    IoSink& operator=(const IoSink&) = default;
};

/// Why a connection is not open.
[[nodiscard]] Failure failure_of(const IoClosed& closed, const Host& host, std::chrono::milliseconds timeout);

/// What the outputs of a known connection hold in the device now, so that opening it changes nothing.
[[nodiscard]] boost::system::result<cip::Bytes, Failure> read_outputs(Link& link, const assemblies::Layout& layout);

/// Asks the device what is not known before it is opened: its outputs, and with `--key auto` its identity. Nothing is
/// asked when all is known. The outputs have the changes of the task in them.
[[nodiscard]] boost::system::result<cip::Bytes, Failure> prepare(ConnectionTask& task, const Settings& settings,
                                                                 const Host& host);

class IoRunner {
public:
    /// Between two looks of whoever shows something.
    static constexpr std::chrono::milliseconds tick{50};

    /// `outputs` are what is sent. The sinks outlive this.
    IoRunner(const Settings& settings, Host host, const ConnectionTask& task, cip::Bytes outputs, bool reopen,
             std::vector<IoSink*> sinks);
    IoRunner(const IoRunner&) = delete;
    IoRunner& operator=(const IoRunner&) = delete;
    ~IoRunner();

    /// Opens, and runs until `done` says so or the connection is over for good; `done` is asked after everything that
    /// happens, and at every tick.
    void run(const std::function<bool()>& done);
    /// Forward_Close, in good manners.
    void close();

    /// Why it is over for good, which is not what close() does.
    [[nodiscard]] const std::optional<IoClosed>& over() const { return over_; }
    [[nodiscard]] const IoReport& report();
    [[nodiscard]] bool is_open() const { return connection_->state() == IoState::open; }
    [[nodiscard]] const std::optional<IoOpened>& last_opened() const { return opened_; }

private:
    [[nodiscard]] IoEvents events();
    void on_opened(const IoOpened& opened);
    void on_input(const IoInput& input);
    void on_packet(const IoPacketSeen& seen);
    void on_closed(const IoClosed& event);
    void add_up();

    Host host_;
    std::chrono::milliseconds timeout_;
    bool run_;
    bool reopen_;
    cip::Bytes outputs_;
    std::vector<IoSink*> sinks_;
    IoReport report_;
    std::optional<IoOpened> opened_{};
    std::optional<IoClosed> over_{};
    enip::Time first_opened_{};
    bool closing_ = false;
    bool closed_ = true;
    bool counting_ = false;
    std::uint64_t sent_before_ = 0;
    std::uint64_t wrong_size_before_ = 0;
    net::io_context context_{1};
    Originator originator_;
    IoConnection* connection_ = nullptr;
};

}  // namespace servobus::scanner::cli
