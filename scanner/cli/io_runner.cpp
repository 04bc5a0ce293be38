#include "scanner/cli/io_runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "cip/status.hpp"
#include "drive/xenax.hpp"
#include "enip/io_packet.hpp"
#include "scanner/axis_state.hpp"
#include "scanner/cli/identify.hpp"
#include "scanner/cli/what.hpp"
#include "scanner/sheet_check.hpp"

namespace servobus::scanner::cli {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

cip::ElectronicKey key_of(const Identity& identity) {
    return {.vendor = identity.vendor,
            .device_type = identity.device_type,
            .product_code = identity.product_code,
            .major_revision = identity.major_revision,
            .minor_revision = identity.minor_revision};
}

/// In Quick stop active the word that the drive was enabled with would enable it again (004 §4.1, transition 16).
std::optional<Failure> keep_stopped(Link& link, const IoFields& fields, cip::Bytes& image) {
    constexpr std::int64_t quick_stop = 0x02;
    const auto answer = link.read(row_of(AxisValue::status_word));
    if (!answer) return link.failure_of(answer.error());
    AxisState state;
    if (answer->value) state.take(AxisValue::status_word, *answer->value);
    if (state.ds402() != drive::Ds402::State::quick_stop_active) return std::nullopt;
    if (const auto change = change_of(fields, row_of(AxisValue::control_word), quick_stop)) put(*change, image);
    return std::nullopt;
}

}  // namespace

Failure failure_of(const IoClosed& closed, const Host& host, milliseconds timeout) {
    const auto where = to_string(host);
    switch (closed.reason) {
        case CloseReason::asked:
            return {ExitCode::done, fmt::format("the connection to {} was closed", where)};
        case CloseReason::unreachable:
            return failure_of(closed.error, host, timeout);
        case CloseReason::refused:
            return {ExitCode::refused,
                    fmt::format("{} refused the connection: {}", where, cip::describe(closed.status)), closed.status};
        case CloseReason::bad_reply:
            return {ExitCode::nonsense,
                    fmt::format("{}: the answer to the Forward_Open makes no sense: {}", where, words(closed.error))};
        case CloseReason::timed_out:
            return {ExitCode::no_connection,
                    fmt::format("the connection to {} was lost: no datagram came in time", where)};
        case CloseReason::no_socket:
            return {ExitCode::no_connection,
                    fmt::format("this machine has no UDP socket for the connection: {}", words(closed.error))};
    }
    return {ExitCode::fault, "unknown reason"};
}

boost::system::result<cip::Bytes, Failure> read_outputs(Link& link, const assemblies::Layout& layout) {
    cip::Bytes image(layout.size(), 0);
    const auto fields = fields_of(layout);
    for (const auto& field : fields) {
        if (field.row == nullptr) continue;
        const auto answer = link.read(*field.row);
        if (!answer) return link.failure_of(answer.error());
        if (!answer->value) {
            return Failure{ExitCode::refused,
                           fmt::format("{}: refused with {}; is this a XENAX? Other devices take --o2t and its numbers",
                                       field.name(), cip::describe(answer->status)),
                           answer->status};
        }
        put(*change_of(fields, *field.row, *answer->value), image);
    }
    if (auto failure = keep_stopped(link, fields, image)) return std::move(*failure);
    return image;
}

namespace {

/// Outputs that are read one by one before a connection opens, at most.
constexpr std::size_t max_read_outputs = 256;

/// The outputs of a data sheet's connection: what the device holds where it lets it be read, otherwise what the sheet
/// proposes.
boost::system::result<cip::Bytes, Failure> read_described_outputs(Link& link, const ConnectionTask& task) {
    auto image = task.start;
    std::size_t asked = 0;
    for (const auto& field : task.outputs.fields) {
        const auto request = field.parameter != nullptr ? read_request(*field.parameter) : std::nullopt;
        if (!request || ++asked > max_read_outputs) continue;
        const auto answer = link.call(*request);
        if (!answer) return link.failure_of(answer.error());
        const bool fits = answer->status.ok() && answer->data.size() >= (field.bits + 7) / 8;
        if (fits) put({field.offset, answer->data, field.first_bit, field.bits}, image);
    }
    if (task.sheet->device.vendor == drive::xenax_models().front().identity.vendor) {
        if (auto failure = keep_stopped(link, task.outputs.fields, image)) return std::move(*failure);
    }
    return image;
}

}  // namespace

boost::system::result<cip::Bytes, Failure> prepare(ConnectionTask& task, const Settings& settings, const Host& host) {
    auto image = task.start;
    image.resize(task.outputs.octets);
    const bool has_rows =
        (task.outputs.layout != nullptr || task.described != nullptr) && task.has_outputs() && task.run;
    if (has_rows || task.key_of_device) {
        Link link(settings, host);
        if (auto failure = link.open()) return std::move(*failure);
        link.count_from_last_answer();
        if (task.key_of_device) {
            const auto identity = ask_identity(link);
            if (!identity) return identity.error();
            task.plan.key = key_of(*identity);
        }
        if (has_rows) {
            auto read = task.described != nullptr ? read_described_outputs(link, task)
                                                  : read_outputs(link, *task.outputs.layout);
            if (!read) return read.error();
            image = std::move(*read);
        }
    }
    for (const auto& change : task.changes) put(change, image);
    return image;
}

IoRunner::IoRunner(const Settings& settings, Host host, const ConnectionTask& task, cip::Bytes outputs, bool reopen,
                   std::vector<IoSink*> sinks)
    : host_(std::move(host)),
      timeout_(settings.timeout),
      run_(task.run),
      reopen_(reopen),
      outputs_(std::move(outputs)),
      sinks_(std::move(sinks)),
      report_(task.plan.t_to_o.rpi),
      originator_(context_.get_executor()) {
    report_.cyclic = task.plan.trigger == enip::Trigger::cyclic;
    IoOptions options;
    options.host = host_.name;
    options.port = host_.port;
    options.plan = task.plan;
    options.timeout = timeout_;
    options.reopen = reopen;
    connection_ = &originator_.add(std::move(options), events());
}

IoRunner::~IoRunner() = default;

IoEvents IoRunner::events() {
    IoEvents events;
    events.opened = [this](const IoOpened& opened) { on_opened(opened); };
    events.input = [this](const IoInput& input) { on_input(input); };
    events.packet = [this](const IoPacketSeen& seen) { on_packet(seen); };
    events.closed = [this](const IoClosed& closed) { on_closed(closed); };
    events.output = [this](std::span<std::uint8_t> data) {
        std::copy_n(outputs_.begin(), std::min(outputs_.size(), data.size()), data.begin());
        return run_;
    };
    return events;
}

void IoRunner::on_opened(const IoOpened& opened) {
    opened_ = opened;
    counting_ = true;
    if (report_.openings++ == 0) first_opened_ = Clock::now();
    report_.received.restart(opened.t_to_o_interval());
    for (auto* sink : sinks_) sink->opened(opened);
}

void IoRunner::on_input(const IoInput& input) {
    // It may have come while the reply was still being read.
    report_.open_for = std::max<std::chrono::duration<double>>(input.time - first_opened_, std::chrono::seconds(0));
    if (!report_.first_input) report_.first_input = report_.open_for;
    for (auto* sink : sinks_) sink->input(input, report_.open_for);
}

void IoRunner::on_packet(const IoPacketSeen& seen) {
    // All that came under the connection's id, and not only what was taken: copies count, too.
    if (!seen.sent && opened_) {
        const auto packet = enip::IoPacket::parse(seen.octets);
        if (packet && packet->connection_id == opened_->reply.t_to_o_id) {
            report_.received.take(packet->sequence, seen.time);
        }
    }
    for (auto* sink : sinks_) sink->packet(seen);
}

void IoRunner::on_closed(const IoClosed& event) {
    add_up();
    // The connection counts from its opening on.
    counting_ = false;
    sent_before_ = report_.sent;
    wrong_size_before_ = report_.wrong_size;
    if (over_) {
        // It has been told already; only its next try was still waiting.
        closed_ = true;
        return;
    }
    auto closed = event;
    // What has never been open is not waited for: somebody sits there who would like to know.
    if (report_.openings == 0 || closing_) closed.next_try.reset();
    const auto failure = cli::failure_of(closed, host_, timeout_);
    for (auto* sink : sinks_) sink->closed(closed, failure.text);
    if (closed.next_try) return;
    closed_ = true;
    if (closed.reason != CloseReason::asked) over_ = closed;
}

void IoRunner::add_up() {
    if (!counting_) return;
    report_.sent = sent_before_ + connection_->sent().sent;
    report_.wrong_size = wrong_size_before_ + connection_->received().wrong_size;
}

const IoReport& IoRunner::report() {
    add_up();
    return report_;
}

void IoRunner::run(const std::function<bool()>& done) {
    closed_ = false;
    connection_->open();
    context_.restart();
    auto next_tick = Clock::now() + tick;
    while (!closed_ && !done()) {
        context_.run_one_until(next_tick);
        context_.restart();
        if (Clock::now() < next_tick) continue;
        next_tick = std::max(next_tick + tick, Clock::now());
        add_up();
        for (auto* sink : sinks_) sink->look(report_);
    }
}

void IoRunner::close() {
    if (closed_) {
        // It may wait for another try.
        closing_ = true;
        if (connection_->state() != IoState::waiting) return;
    }
    closing_ = true;
    closed_ = false;
    connection_->close();
    const auto limit = Clock::now() + timeout_ + milliseconds(100);
    while (!closed_ && Clock::now() < limit) {
        context_.restart();
        context_.run_one_until(limit);
    }
    add_up();
}

}  // namespace servobus::scanner::cli
