// A device that several peers speak to at once, with handles and ids that are valid. The input is a script: it opens and loses
// TCP connections, registers sessions, opens class 3 and class 1 connections, sends frames and datagrams that are nearly
// right, and lets time pass. The limits are small, so that they are reached. A handle or an id of somebody else is never
// honoured, and when everybody has left nothing is left open.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

#include "assemblies/connection.hpp"
#include "cip/services.hpp"
#include "enip/io_packet.hpp"
#include "scanner/class3.hpp"
#include "scanner/io_plan.hpp"
#include "tests/fuzz/device_site.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using test::require;

constexpr std::size_t most_steps = 48;

adapter::Limits small_limits() {
    adapter::Limits limits;
    limits.tcp_connections = 4;
    limits.sessions = 3;
    limits.refusals = 1;
    limits.class3_connections = 3;
    limits.listening_connections = 2;
    limits.queued_bytes = 2000;
    limits.messages_per_turn = 3;
    return limits;
}

class Script {
public:
    explicit Script(cip::ByteView octets) : input_(octets) {}

    void run() {
        for (std::size_t count = 0; count < most_steps && !input_.over(); ++count) step();
        site_.leave();
    }

private:
    void step() {
        static constexpr std::array steps{&Script::connect,      &Script::register_session, &Script::send_raw,
                                          &Script::send_frame,   &Script::send_request,     &Script::open_class3,
                                          &Script::send_message, &Script::open_class1,      &Script::send_io,
                                          &Script::close_class1, &Script::send_datagram,    &Script::disconnect,
                                          &Script::pass};
        (this->*steps[input_.below(steps.size())])();
    }

    // --- who

    /// One of the TCP connections; a new one when there is none.
    DeviceSite::Id someone() {
        const auto which = input_.u8();
        const auto ids = site_.open();
        if (!ids.empty()) return ids[which % ids.size()];
        return site_.join(which);
    }
    std::uint32_t handle_for(DeviceSite::Id id, std::uint8_t choice) {
        switch (choice % 4) {
            case 0:
                return input_.u32();
            case 1: {
                const auto ids = site_.open();
                return site_.session(ids[choice / 4 % ids.size()]);
            }
            default:
                return site_.session(id);
        }
    }

    /// Whether every octet that it has sent belongs to a frame that is whole: then the next reply is to the next request.
    [[nodiscard]] bool is_in_step(DeviceSite::Id id) const { return !torn_.contains(id); }

    // --- TCP

    void connect() { (void)site_.connect(input_.u8()); }
    void register_session() {
        const auto id = someone();
        if (is_in_step(id)) (void)site_.register_session(id);
    }
    void disconnect() { site_.disconnect(someone()); }
    void send_raw() {
        const auto id = someone();
        const auto piece = input_.u8() + std::size_t{1};
        torn_.insert(id);
        (void)site_.send(id, input_.long_piece(), piece);
    }

    /// A frame whose header is nearly right.
    void send_frame() {
        static constexpr std::array commands{enip::Command::send_rr_data,     enip::Command::send_unit_data,
                                             enip::Command::register_session, enip::Command::unregister_session,
                                             enip::Command::list_identity,    enip::Command::list_services,
                                             enip::Command::list_interfaces,  enip::Command::nop};
        const auto id = someone();
        enip::Frame frame;
        const auto choice = input_.u8();
        frame.command = (choice & 0x80U) != 0 ? static_cast<enip::Command>(input_.u16()) : commands[choice % 8];
        frame.session = handle_for(id, input_.u8());
        const auto odd = input_.u8();
        if ((odd & 0x0FU) == 1) frame.status = static_cast<enip::EncapsulationStatus>(input_.u32());
        if ((odd & 0x0FU) == 2) frame.options = input_.u32();
        frame.data = input_.piece();
        auto octets = frame.encode();
        if ((odd & 0xF0U) == 0x10) {
            octets[2] = input_.u8();  // the length: the next frames begin somewhere else
            torn_.insert(id);
        }
        const auto own = site_.session(id);
        const auto replies = site_.send(id, octets);
        const bool needs_session =
            frame.command == enip::Command::send_rr_data || frame.command == enip::Command::send_unit_data;
        if (!needs_session || (own != 0 && frame.session == own) || !is_in_step(id)) return;
        if (const auto reply = enip::Frame::parse(replies); reply && reply->command == frame.command) {
            require(reply->status != enip::EncapsulationStatus::success, "a handle of somebody else is refused",
                    octets);
        }
    }

    // --- messages

    cip::Bytes message() {
        const auto choice = input_.u8();
        if ((choice & 1U) != 0) return input_.piece();
        cip::Request request;
        request.service = input_.u8();
        const auto class_id = input_.u8();
        const auto instance = input_.u8();
        request.path =
            (choice & 2U) != 0 ? cip::Path::to(class_id, instance, input_.u8()) : cip::Path::to(class_id, instance);
        request.data = input_.piece();
        return request.encode();
    }

    /// In the middle of a message that somebody has begun, or with replies that wait, a request is not one.
    void send_request() {
        const auto id = someone();
        const auto data = enip::SendData::unconnected(message());
        (void)site_.send(id, enip::Frame{.command = enip::Command::send_rr_data,
                                         .session = handle_for(id, input_.u8()),
                                         .data = data.encode()}
                                 .encode());
    }

    cip::Response ask_connection_manager(DeviceSite::Id id, const cip::Bytes& request) {
        const auto before = site_.adapter().io().size() + site_.adapter().class3_connections();
        const auto data = enip::SendData::unconnected(request);
        const auto replies = site_.send(
            id, enip::Frame{.command = enip::Command::send_rr_data, .session = site_.session(id), .data = data.encode()}
                    .encode());
        require(site_.adapter().io().size() + site_.adapter().class3_connections() <= before + 1,
                "one request opens one connection", request);
        const auto frame = enip::Frame::parse(replies);
        if (!frame || frame->command != enip::Command::send_rr_data)
            return {0, cip::GeneralStatus::not_enough_data, {}};
        const auto answer = enip::SendData::parse(frame->data);
        const auto octets = answer ? enip::unconnected_message(*answer) : cip::DecodeError::truncated;
        const auto response = octets ? cip::Response::parse(*octets) : cip::DecodeError::truncated;
        return response ? *response : cip::Response{0, cip::GeneralStatus::not_enough_data, {}};
    }

    void open_class3() {
        const auto id = someone();
        if (site_.session(id) == 0) return;
        const scanner::Class3Proposal proposal{.large = (input_.u8() & 1U) != 0,
                                               .t_to_o_id = 0x11000000U + serial_,
                                               .triad = {++serial_, 0x004D, 0x11223344},
                                               .path = scanner::class3_path({})};
        const auto response = ask_connection_manager(id, proposal.forward_open().encode());
        if (!response.status.ok()) return;
        if (const auto connection = scanner::class3_connection(proposal, response.data)) {
            class3_.push_back({id, connection->o_to_t_id});
        }
    }

    /// Over a class 3 connection, or what looks like one.
    void send_message() {
        const auto id = someone();
        const auto choice = input_.u8();
        std::uint32_t connection = input_.u16();
        bool is_own = false;
        if (!class3_.empty()) {
            const auto& chosen = class3_[choice % class3_.size()];
            connection = chosen.o_to_t_id;
            is_own = chosen.on == id;
        }
        const auto data = enip::SendData::connected(connection, input_.u16(), message());
        const auto replies = site_.send(
            id,
            enip::Frame{.command = enip::Command::send_unit_data, .session = site_.session(id), .data = data.encode()}
                .encode());
        if (is_own || !is_in_step(id)) return;
        const auto frame = enip::Frame::parse(replies);
        require(!frame || frame->command != enip::Command::send_unit_data ||
                    frame->status != enip::EncapsulationStatus::success,
                "a connection of another TCP connection is not answered", data.encode());
    }

    // --- class 1

    void open_class1() {
        const auto id = someone();
        if (site_.session(id) == 0) return;
        const auto kinds = assemblies::connections();
        auto plan = scanner::plan_of(kinds[input_.below(kinds.size())]);
        const auto choice = input_.u8();
        if ((choice & 1U) != 0) plan.t_to_o.type = cip::ConnectionType::multicast;
        plan.multiplier_code = static_cast<std::uint8_t>(choice >> 5);
        plan.trigger = static_cast<enip::Trigger>((choice >> 1) % 3);
        plan.t_to_o.rpi = std::chrono::microseconds(1000U << ((choice >> 3) & 3U));
        plan.o_to_t.rpi = plan.t_to_o.rpi;
        const cip::ConnectionTriad triad{++serial_, 0x004D, 0x11223344};
        auto request = scanner::open_request(plan.forward_open(0, 0x22000000U + serial_, triad)).encode();
        for (auto changes = input_.below(3); changes > 0; --changes) {
            const auto at = input_.u8() % request.size();
            request[at] = input_.u8();
        }
        (void)ask_connection_manager(id, request);
    }

    void send_io() {
        const auto choice = input_.u8();
        auto data = input_.piece();
        std::uint32_t id = input_.u16();
        const auto all = site_.adapter().io().all();
        if (!all.empty() && (choice & 0x10U) == 0) {
            const auto& connection = *all[choice % all.size()];
            id = connection.o_to_t_id;
            if ((choice & 0x20U) == 0) data.resize(connection.kind->o_to_t_size());
        }
        sequence_ = (choice & 0x40U) != 0 ? input_.u32() : sequence_ + 1;
        cip::Bytes datagram(enip::io_packet_overhead + data.size());
        std::ranges::copy(data, enip::begin_io_packet(datagram, id, sequence_).begin());
        site_.send_io(datagram, choice >> 7);
    }

    void close_class1() {
        const auto id = someone();
        const auto choice = input_.u8();
        const auto all = site_.adapter().io().all();
        if (all.empty() || site_.session(id) == 0) return;
        const auto request = scanner::close_request(all[choice % all.size()]->request).encode();
        (void)ask_connection_manager(id, request);
    }

    // --- the rest

    void send_datagram() {
        const bool broadcast = (input_.u8() & 1U) != 0;
        site_.send_datagram(input_.piece(), broadcast);
    }
    void pass() { site_.advance(std::chrono::microseconds(100) * (1U << input_.below(18))); }

    struct Class3 {
        DeviceSite::Id on;
        std::uint32_t o_to_t_id;
    };

    Input input_;
    DeviceSite site_{small_limits()};
    std::set<DeviceSite::Id> torn_;
    std::vector<Class3> class3_;
    std::uint16_t serial_ = 0;
    std::uint32_t sequence_ = 0;
};

}  // namespace

void session(cip::ByteView octets) { Script(octets).run(); }

}  // namespace servobus::fuzz
