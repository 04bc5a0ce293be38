#include "scanner/cli/originator_process_data.hpp"

#include <algorithm>
#include <utility>

#include "scanner/cli/io_runner.hpp"

namespace servobus::scanner::cli {
namespace {

/// Devices close a session that is not used for two minutes, if nothing else is set (R-ENC-24).
constexpr std::chrono::seconds keep_alive_interval{30};

}  // namespace

OriginatorProcessData::OriginatorProcessData(Link& link, Host host, const ConnectionTask& task, cip::Bytes outputs)
    : link_(link),
      host_(std::move(host)),
      output_layout_(task.outputs.layout),
      input_layout_(task.inputs),
      outputs_(std::move(outputs)),
      originator_(link.executor()) {
    IoOptions options;
    options.host = host_.name;
    options.port = host_.port;
    options.plan = task.plan;
    options.timeout = link.settings().timeout;
    // An axis that has lost its controller has stopped; to go on is for somebody who looks at it.
    options.reopen = false;
    connection_ = &originator_.add(std::move(options), events());
}

OriginatorProcessData::~OriginatorProcessData() { close(); }

IoEvents OriginatorProcessData::events() {
    IoEvents events;
    events.input = [this](const IoInput& input) {
        if (input.data.size() != input_layout_->size()) return;
        input_.data.assign(input.data.begin(), input.data.end());
        input_.time = input.time;
        ++received_;
        if (listener_) listener_(input_);
    };
    events.output = [this](std::span<std::uint8_t> data) {
        std::copy_n(outputs_.begin(), std::min(outputs_.size(), data.size()), data.begin());
        ++sent_;
        return true;
    };
    events.closed = [this](const IoClosed& closed) { closed_ = closed; };
    return events;
}

std::optional<Failure> OriginatorProcessData::open() {
    connection_->open();
    return run_until([this] { return received_ > 0; });
}

void OriginatorProcessData::close() {
    if (closed_ || connection_->state() == IoState::idle) return;
    connection_->close();
    link_.run_until([this] { return closed_.has_value(); });
}

std::optional<Failure> OriginatorProcessData::run_until(const std::function<bool()>& done) {
    if (Clock::now() - kept_alive_ >= keep_alive_interval) {
        kept_alive_ = Clock::now();
        link_.keep_alive();
    }
    link_.run_until([&] { return closed_.has_value() || done(); });
    // What had been reached before it ended counts.
    if (!closed_ || done()) return std::nullopt;
    return failure_of(*closed_, host_, link_.settings().timeout);
}

}  // namespace servobus::scanner::cli
