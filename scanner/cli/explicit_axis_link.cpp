#include "scanner/cli/explicit_axis_link.hpp"

#include <fmt/format.h>

#include "scanner/cli/results.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/multiple_service.hpp"

namespace servobus::scanner::cli {
namespace {

/// Values of a packet: their requests and replies stay far below what every device takes, texts included.
constexpr std::size_t packet_values = 16;

std::string without_line_end(std::string text) {
    while (text.ends_with('\n')) text.pop_back();
    return text;
}

}  // namespace

std::optional<Failure> ExplicitAxisLink::read(std::span<const AxisValue> values, AxisState& state) {
    while (packets_ && values.size() > packet_values) {
        if (auto failure = read(values.first(packet_values), state)) return failure;
        values = values.subspan(packet_values);
    }
    if (packets_ && values.size() > 1) {
        std::vector<cip::Request> requests;
        for (const auto which : values) requests.push_back(read_request(row_of(which)));
        const auto reply = link_.call(multiple_service_packet(requests));
        if (!reply && trouble_of(reply.error()) == Trouble::connection) return link_.failure_of(reply.error());
        const auto responses = reply ? multiple_service_responses(requests, *reply)
                                     : boost::system::result<std::vector<cip::Response>>(reply.error());
        packets_ = responses.has_value();
        for (std::size_t i = 0; packets_ && i < values.size(); ++i) {
            if (auto failure = take(values[i], (*responses)[i], state)) return failure;
        }
        if (packets_) return std::nullopt;
    }
    for (const auto which : values) {
        if (auto failure = read_single(which, state)) return failure;
    }
    return std::nullopt;
}

std::optional<Failure> ExplicitAxisLink::look(std::span<const AxisValue>, AxisState& state) {
    return read(followed_values(), state);
}

std::optional<Failure> ExplicitAxisLink::read_single(AxisValue which, AxisState& state) {
    const auto response = link_.call(read_request(row_of(which)));
    if (!response) return link_.failure_of(response.error());
    return take(which, *response, state);
}

std::optional<Failure> ExplicitAxisLink::take(AxisValue which, const cip::Response& response, AxisState& state) {
    auto outcome = read_outcome(row_of(which), response);
    if (!outcome) return link_.failure_of(outcome.error());
    if (outcome->value) {
        state.take(which, std::move(*outcome->value));
    } else if (which == AxisValue::status_word) {
        return Failure{ExitCode::refused,
                       without_line_end(refusal_text({What{&row_of(which)}, outcome->status})) + "; is this a XENAX?",
                       outcome->status};
    }
    return std::nullopt;
}

std::optional<Failure> ExplicitAxisLink::write(const AxisWrite& write) {
    const auto& row = row_of(write.to);
    const auto response = link_.call(write_request(row, drive::Value(write.value)));
    if (!response) return link_.failure_of(response.error());
    if (response->status.ok()) return std::nullopt;
    refused_ = write;
    const auto refusal = without_line_end(refusal_text({What{&row}, response->status}));
    return Failure{ExitCode::refused, fmt::format("{} (value {})", refusal, write.value), response->status};
}

}  // namespace servobus::scanner::cli
