// One device, asked one thing after the other, as a command line does: blocking, and never beyond its time.
#pragma once

#include <boost/system/result.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "cip/message.hpp"
#include "cip/path.hpp"
#include "drive/parameter.hpp"
#include "drive/store.hpp"
#include "enip/asio/asio.hpp"
#include "enip/asio/discovery.hpp"
#include "scanner/cli/exit_code.hpp"
#include "scanner/error.hpp"
#include "scanner/host.hpp"
#include "scanner/reading.hpp"
#include "scanner/upload_file.hpp"

namespace servobus::scanner::cli {

/// What goes with every verb.
struct Settings {
    std::chrono::milliseconds timeout{5000};
    cip::Path route{};
    bool connected = false;  ///< a class 3 connection instead of unconnected messages
    bool json = false;
};

/// Why a verb could not do its work at all.
struct Failure {
    ExitCode code = ExitCode::fault;
    std::string text;
    std::optional<cip::Status> status{};  ///< the device's word, when that is the reason
};

[[nodiscard]] ExitCode exit_code_of(const error_code& error);
/// `no connection to HOST: Connection refused`.
[[nodiscard]] Failure failure_of(const error_code& error, const Host& host, std::chrono::milliseconds timeout);
/// The words for an error while a device is being asked: "the device did not answer in time".
[[nodiscard]] std::string words(const error_code& error);

class Link {
public:
    Link(Settings settings, Host host);
    Link(const Link&) = delete;
    Link& operator=(const Link&) = delete;
    /// Takes leave of the device, unless that has stopped answering.
    ~Link();

    /// Connects, and opens the class 3 connection if the settings say so.
    [[nodiscard]] std::optional<Failure> open();

    // Everything until the first answer that does not come is bounded by one timeout, however the device dawdles.
    [[nodiscard]] boost::system::result<cip::Response> call(const cip::Request& request);
    [[nodiscard]] boost::system::result<ReadOutcome> read(const drive::Parameter& row);

    /// A file from the File object. Each of its requests has the timeout for itself.
    [[nodiscard]] boost::system::result<UploadOutcome> upload(FileUploadOptions options,
                                                              std::function<void(std::size_t, std::uint32_t)> progress);

    /// Does nothing until then, but keeps the connection.
    void wait_until(std::chrono::steady_clock::time_point when);

    /// Where everything runs that goes on meanwhile: in call(), wait_until() and run_until(), and at no other time.
    [[nodiscard]] net::any_io_executor executor();
    /// Runs that until `done` says so; it is asked after everything that happens.
    void run_until(const std::function<bool()>& done);
    /// A session that nobody uses for long is closed by the device; this is a message that asks for nothing.
    void keep_alive();

    /// For verbs with hundreds of requests: from now on the time counts from the last answer.
    void count_from_last_answer() { per_answer_ = true; }

    [[nodiscard]] const Settings& settings() const { return settings_; }
    /// Why a verb ends, when an answer did not come.
    [[nodiscard]] Failure failure_of(const error_code& error) const;

private:
    class Io;
    [[nodiscard]] std::chrono::milliseconds remaining() const;
    void note(const error_code& error);

    Settings settings_;
    Host host_;
    std::unique_ptr<Io> io_;
    std::chrono::steady_clock::time_point deadline_;
    bool per_answer_ = false;
    bool lost_ = false;  ///< the device went away or answers no more
};

/// Discovery without a coroutine in sight.
[[nodiscard]] boost::system::result<enip::asio::FoundDevices> broadcast(enip::asio::BroadcastOptions options);
[[nodiscard]] boost::system::result<enip::asio::FoundDevices> probe(enip::asio::ProbeOptions options);

}  // namespace servobus::scanner::cli
