#include "scanner/cli/link.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "scanner/client.hpp"

namespace servobus::scanner::cli {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

ClientOptions client_options(const Settings& settings) {
    ClientOptions options;
    options.timeout = settings.timeout;
    options.route = settings.route;
    // One request at a time: some devices lose the second of two messages that come together.
    options.outstanding = 1;
    return options;
}

/// Runs a context until an operation is done. Every operation has a timeout, so this ends.
template <class Value>
class Waiting {
public:
    explicit Waiting(net::io_context& context) : context_(context) {}

    auto token() {
        return [this](error_code error, Value value) {
            error_ = error;
            value_ = std::move(value);
            done_ = true;
        };
    }

    boost::system::result<Value> wait() {
        context_.restart();
        while (!done_ && context_.run_one() > 0) {
        }
        if (error_) return error_;
        return std::move(value_);
    }

private:
    net::io_context& context_;
    error_code error_ = net::error::operation_aborted;
    Value value_{};
    bool done_ = false;
};

}  // namespace

ExitCode exit_code_of(const error_code& error) {
    switch (trouble_of(error)) {
        case Trouble::usage:
            return ExitCode::usage;
        case Trouble::connection:
            return ExitCode::no_connection;
        case Trouble::refusal:
            return ExitCode::refused;
        case Trouble::nonsense:
            return ExitCode::nonsense;
    }
    return ExitCode::fault;
}

std::string words(const error_code& error) {
    if (error == net::error::host_not_found || error == net::error::host_not_found_try_again ||
        error == net::error::no_data) {
        return "there is no host of that name";
    }
    if (error == net::error::connection_refused) return "nothing listens there (connection refused)";
    return error.message();
}

Failure failure_of(const error_code& error, const Host& host, milliseconds timeout) {
    const auto code = exit_code_of(error);
    const auto where = to_string(host);
    if (error == make_error_code(Error::timeout) || error == net::error::timed_out) {
        const double seconds = static_cast<double>(timeout.count()) / 1000;
        return {code, fmt::format("{} did not answer within {} s", where, seconds)};
    }
    if (code == ExitCode::no_connection) return {code, fmt::format("no connection to {}: {}", where, words(error))};
    return {code, fmt::format("{}: {}", where, words(error))};
}

class Link::Io {
public:
    explicit Io(const Settings& settings)
        : client(std::make_unique<Client>(context.get_executor(), client_options(settings))) {}

    net::io_context context{1};
    std::unique_ptr<Client> client;

    error_code connect(const Host& host) {
        bool done = false;
        error_code result;
        client->async_connect(host.name, host.port, [&](error_code error) {
            result = error;
            done = true;
        });
        run_until(done);
        return result;
    }

    void close(bool lost) {
        bool done = lost;
        if (!lost) client->async_close([&](error_code) { done = true; });
        run_until(done);
        client.reset();
        context.restart();
        context.run_for(milliseconds(100));
    }

    void run_until(const bool& done) {
        context.restart();
        while (!done && context.run_one() > 0) {
        }
    }
};

Failure Link::failure_of(const error_code& error) const { return cli::failure_of(error, host_, settings_.timeout); }

Link::Link(Settings settings, Host host)
    : settings_(std::move(settings)),
      host_(std::move(host)),
      io_(std::make_unique<Io>(settings_)),
      deadline_(steady_clock::now() + settings_.timeout) {}

Link::~Link() { io_->close(lost_); }

void Link::note(const error_code& error) {
    if (trouble_of(error) == Trouble::connection) lost_ = true;
}

milliseconds Link::remaining() const {
    const auto left = std::chrono::duration_cast<milliseconds>(deadline_ - steady_clock::now());
    return std::max(left, milliseconds(1));
}

std::optional<Failure> Link::open() {
    deadline_ = steady_clock::now() + settings_.timeout;
    if (const auto error = io_->connect(host_)) {
        lost_ = true;
        return failure_of(error);
    }
    if (!settings_.connected) return std::nullopt;
    Waiting<cip::Response> waiting(io_->context);
    io_->client->async_open_connection(waiting.token());
    const auto response = waiting.wait();
    if (!response) {
        note(response.error());
        return failure_of(response.error());
    }
    if (response->status.ok()) return std::nullopt;
    return Failure{ExitCode::refused,
                   fmt::format("{} refused the connection: {}", to_string(host_), cip::describe(response->status)),
                   response->status};
}

boost::system::result<cip::Response> Link::call(const cip::Request& request) {
    Waiting<cip::Response> waiting(io_->context);
    io_->client->async_call(request, CallOptions{remaining()}, waiting.token());
    auto response = waiting.wait();
    // It was there after open(), so the device has closed it while nobody asked anything.
    if (!response && response.error() == make_error_code(Error::not_connected))
        response = make_error_code(Error::closed);
    if (!response) note(response.error());
    if (per_answer_ && response) deadline_ = steady_clock::now() + settings_.timeout;
    return response;
}

boost::system::result<ReadOutcome> Link::read(const drive::Parameter& row) {
    const auto response = call(read_request(row));
    if (!response) return response.error();
    return read_outcome(row, *response);
}

boost::system::result<UploadOutcome> Link::upload(FileUploadOptions options,
                                                  std::function<void(std::size_t, std::uint32_t)> progress) {
    Waiting<UploadOutcome> waiting(io_->context);
    async_upload_file(*io_->client, options, UploadManners{settings_.timeout, std::move(progress)}, waiting.token());
    auto outcome = waiting.wait();
    if (!outcome) note(outcome.error());
    deadline_ = steady_clock::now() + settings_.timeout;
    return outcome;
}

void Link::wait_until(steady_clock::time_point when) {
    net::steady_timer timer(io_->context, when);
    bool over = false;
    timer.async_wait([&over](error_code) { over = true; });
    io_->run_until(over);
    if (per_answer_) deadline_ = std::max(deadline_, steady_clock::now() + settings_.timeout);
}

net::any_io_executor Link::executor() { return io_->context.get_executor(); }

void Link::run_until(const std::function<bool()>& done) {
    io_->context.restart();
    while (!done() && io_->context.run_one() > 0) {
    }
    if (per_answer_) deadline_ = std::max(deadline_, steady_clock::now() + settings_.timeout);
}

void Link::keep_alive() { io_->client->keep_alive(); }

boost::system::result<enip::asio::FoundDevices> broadcast(enip::asio::BroadcastOptions options) {
    net::io_context context(1);
    Waiting<enip::asio::FoundDevices> waiting(context);
    enip::asio::async_discover(context.get_executor(), options, waiting.token());
    return waiting.wait();
}

boost::system::result<enip::asio::FoundDevices> probe(enip::asio::ProbeOptions options) {
    net::io_context context(1);
    Waiting<enip::asio::FoundDevices> waiting(context);
    enip::asio::async_probe(context.get_executor(), std::move(options), waiting.token());
    return waiting.wait();
}

}  // namespace servobus::scanner::cli
