#include "scanner/conformance/record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <variant>

#include "cip/forward_open.hpp"
#include "cip/message.hpp"
#include "cip/services.hpp"
#include "enip/encapsulation.hpp"
#include "enip/io_packet.hpp"
#include "enip/messages.hpp"

namespace servobus::scanner::conformance {
namespace {

std::string octets_text(std::size_t count) { return fmt::format("{} octet{}", count, count == 1 ? "" : "s"); }

/// Exactly one message, of any length.
std::optional<enip::Frame> frame_of(cip::ByteView octets) {
    const auto frame = enip::Frame::parse(octets);
    if (!frame || enip::header_bytes + frame->data.size() != octets.size()) return std::nullopt;
    return *frame;
}

std::string service_name(std::uint8_t service, std::uint32_t class_id) {
    const auto name = cip::service::name(service, class_id);
    return name.empty() ? fmt::format("service 0x{:02X}", service) : std::string(name);
}

std::string cip_request_text(cip::ByteView message) {
    const auto request = cip::Request::parse(message);
    if (!request) return fmt::format("a CIP message of {}", octets_text(message.size()));
    std::uint32_t class_id = 0;
    for (const auto& segment : request->path.segments) {
        const auto* logical = std::get_if<cip::LogicalSegment>(&segment);
        if (logical != nullptr && logical->type == cip::LogicalType::class_id) class_id = logical->value;
    }
    const auto data = request->data.empty() ? "" : fmt::format(", {} of data", octets_text(request->data.size()));
    return fmt::format("{} to {}{}", service_name(request->service, class_id),
                       request->path.segments.empty() ? "nowhere" : cip::describe(request->path), data);
}

std::string cip_reply_text(cip::ByteView message) {
    const auto response = cip::Response::parse(message);
    if (!response) return fmt::format("a CIP message of {}", octets_text(message.size()));
    return fmt::format("reply to service 0x{:02X}: {}, {} of data", response->service,
                       response->status.ok() ? "success" : cip::describe(response->status),
                       octets_text(response->data.size()));
}

std::string packet_text(const enip::Frame& frame, bool reply) {
    const auto data = enip::SendData::parse(frame.data);
    if (!data) return fmt::format("{} of data that are no items", octets_text(frame.data.size()));
    const auto text = [&](cip::ByteView message) {
        return reply ? cip_reply_text(message) : cip_request_text(message);
    };
    if (frame.command == enip::Command::send_rr_data) {
        const auto message = enip::unconnected_message(*data);
        if (message) return text(*message);
    } else if (const auto message = enip::connected_message(*data)) {
        return fmt::format("connection 0x{:08X}, sequence count {}, {}", message->connection_id, message->sequence,
                           text(message->message));
    }
    return fmt::format("{} items", data->packet.items.size());
}

std::string message_text(cip::ByteView octets, bool reply) {
    const auto frame = frame_of(octets);
    if (!frame) return octets_text(octets.size());
    auto text = enip::describe(frame->command);
    if (frame->status != enip::EncapsulationStatus::success) text += ", status " + enip::describe(frame->status);
    const bool carries =
        frame->command == enip::Command::send_rr_data || frame->command == enip::Command::send_unit_data;
    if (carries && !frame->data.empty()) return text + ": " + packet_text(*frame, reply);
    return text + fmt::format(", {} of data", octets_text(frame->data.size()));
}

}  // namespace

std::string_view name(Step::Kind kind) {
    switch (kind) {
        case Step::Kind::sent:
            return "sent";
        case Step::Kind::came:
            return "came";
        case Step::Kind::note:
            return "note";
    }
    return "";
}

void Record::add(Step::Kind kind, std::string words, cip::ByteView octets) {
    if (steps_.size() >= max_steps) {
        ++left_out_;
        return;
    }
    const auto kept = octets.first(std::min(octets.size(), kept_octets));
    steps_.push_back({kind, std::move(words), {kept.begin(), kept.end()}, octets.size()});
}

std::string describe_request(cip::ByteView octets) { return message_text(octets, false); }
std::string describe_reply(cip::ByteView octets) { return message_text(octets, true); }

std::string describe_datagram(cip::ByteView octets) {
    const auto packet = enip::IoPacket::parse(octets);
    if (!packet) return fmt::format("I/O port: {}", octets_text(octets.size()));
    return fmt::format("I/O datagram: connection 0x{:08X}, sequence {}, {} in the data item", packet->connection_id,
                       packet->sequence, octets_text(packet->data.size()));
}

}  // namespace servobus::scanner::conformance
