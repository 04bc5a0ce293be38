#include "adapter/ptp_client.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace servobus::adapter {
namespace {

// Of the node itself, in this order; then these two of each port.
constexpr std::array of_node{ManagementId::default_data_set, ManagementId::current_data_set,
                             ManagementId::parent_data_set, ManagementId::time_properties_data_set};
constexpr std::array of_port{ManagementId::port_data_set, ManagementId::clock_description};

// As in the field: 5e88d9.fffe.77a0b1.
std::string words(const ClockIdentity& identity) {
    return fmt::format("{:02x}{:02x}{:02x}.{:02x}{:02x}.{:02x}{:02x}{:02x}", identity[0], identity[1], identity[2],
                       identity[3], identity[4], identity[5], identity[6], identity[7]);
}

template <class T>
bool fill(T& place, std::optional<T> value) {
    if (!value) return false;
    place = *std::move(value);
    return true;
}

}  // namespace

PtpClient::PtpClient(TimeSync& known, std::uint8_t domain, Log log)
    : known_(known), domain_(domain), log_(std::move(log)) {}

void PtpClient::on_timer(enip::Time now) {
    if (now < deadline_) return;
    if (asked_) fail();
    begin_round(now);
}

void PtpClient::begin_round(enip::Time now) {
    round_ = now;
    step_ = 0;
    gathered_ = {};
    ask(now);
}

void PtpClient::ask(enip::Time now) {
    asked_ = question_of(step_);
    if (!asked_) {
        publish();
        wait_for_round(now);
        return;
    }
    asked_->sequence = ++sequence_;
    deadline_ = now + ptp_answer_time;
    messages_.push_back(encode(*asked_));
}

std::size_t PtpClient::asked_ports() const { return std::min<std::size_t>(gathered_.own.ports, max_ptp_ports); }

std::optional<ManagementQuestion> PtpClient::question_of(std::size_t step) const {
    if (step < of_node.size()) return ManagementQuestion{.id = of_node[step], .domain = domain_};
    const auto rest = step - of_node.size();
    const auto port = rest / of_port.size();
    if (port >= asked_ports()) return std::nullopt;
    return ManagementQuestion{
        .id = of_port[rest % of_port.size()], .port = static_cast<std::uint16_t>(port + 1), .domain = domain_};
}

void PtpClient::on_message(cip::ByteView octets, enip::Time now) {
    const auto answer = decode_answer(octets);
    if (!asked_ || !answer || answer->sequence != asked_->sequence || answer->id != asked_->id) return;
    if (!take(*answer)) {
        fail();
        wait_for_round(now);
        return;
    }
    ++step_;
    ask(now);
}

// What a port is like may remain untold; what the node and its time are like may not.
bool PtpClient::take(const ManagementAnswer& answer) {
    if (answer.refused) return answer.id == ManagementId::port_data_set || answer.id == ManagementId::clock_description;
    switch (answer.id) {
        case ManagementId::default_data_set:
            return fill(gathered_.own, decode_default_data_set(answer.data));
        case ManagementId::current_data_set:
            return fill(gathered_.current, decode_current_data_set(answer.data));
        case ManagementId::parent_data_set:
            return fill(gathered_.parent, decode_parent_data_set(answer.data));
        case ManagementId::time_properties_data_set:
            return fill(gathered_.time, decode_time_properties(answer.data));
        case ManagementId::port_data_set: {
            const auto data = decode_port_data_set(answer.data);
            if (data) gathered_.ports.push_back({*data});
            return data.has_value();
        }
        case ManagementId::clock_description: {
            auto description = decode_clock_description(answer.data);
            const bool whole = description.has_value();
            // The port's data set was asked for before, and may have been refused.
            if (!gathered_.ports.empty() && gathered_.ports.back().data.identity.port == asked_->port) {
                gathered_.ports.back().description = std::move(description);
            }
            return whole;
        }
    }
    return false;
}

void PtpClient::publish() {
    failed_ = 0;
    known_.node = std::exchange(gathered_, {});
    // Without a master its time scale goes on: nobody knows a better one, and the time must not jump because of that.
    if (has_master(*known_.node)) {
        const auto& time = known_.node->time;
        known_.utc_offset = std::chrono::seconds((time.flags & ptp_timescale) != 0 ? time.utc_offset : 0);
    }
    tell_change();
}

void PtpClient::fail() {
    asked_.reset();
    if (++failed_ != ptp_failed_rounds) return;
    if (known_.node || master_) log_(LogLevel::warning, "the PTP node of this machine does not answer any more");
    known_.node.reset();
    master_.reset();
}

void PtpClient::wait_for_round(enip::Time now) { deadline_ = std::max(round_ + ptp_round_interval, now); }

void PtpClient::tell_change() {
    const auto master =
        has_master(*known_.node) ? std::optional(known_.node->parent.grandmaster) : std::optional<ClockIdentity>();
    if (master == master_) return;
    master_ = master;
    log_(LogLevel::info, master ? fmt::format("PTP: the clock follows the grandmaster {}", words(*master))
                                : std::string("PTP: the clock follows no master any more"));
}

std::vector<cip::Bytes> PtpClient::take_messages() { return std::exchange(messages_, {}); }

}  // namespace servobus::adapter
