// The message router with all objects of a whole device. The input is a row of requests, octet by octet or made of service,
// class, instance, attribute and data, alone or packed into others, unconnected or over a class 3 connection. The same
// requests have the same answers, what is protected stays as it was, and whatever they have set or started, the next client is
// served.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cip/multiple_service.hpp"
#include "cip/services.hpp"
#include "cip/unconnected_send.hpp"
#include "tests/fuzz/device_site.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using test::require;

constexpr std::size_t most_requests = 24;

/// The first octet of the input.
enum Whole : std::uint8_t {
    twice = 0x01,
    read_only = 0x02,
    hardened = 0x04,
};

/// The first octet of each request.
enum How : std::uint8_t {
    structured = 0x01,
    with_attribute = 0x02,
    in_unconnected_send = 0x04,
    in_packet = 0x08,
    connected = 0x10,
    again = 0x20,  ///< over the connection: the same sequence count once more
    time_goes_on = 0x40,
};

cip::Bytes plain(Input& input, std::uint8_t how) {
    if ((how & structured) == 0) return input.piece();
    cip::Request request;
    request.service = input.u8();
    const auto class_id = input.u8();
    const auto instance = input.u8();
    request.path =
        (how & with_attribute) != 0 ? cip::Path::to(class_id, instance, input.u8()) : cip::Path::to(class_id, instance);
    request.data = input.piece();
    return request.encode();
}

cip::Bytes message_from(Input& input, std::uint8_t how) {
    auto message = plain(input, how);
    if ((how & in_packet) != 0) {
        const std::array parts{std::move(message), plain(input, how)};
        message = cip::Request{cip::service::multiple_service_packet, cip::Path::to(cip::class_id::message_router, 1),
                               cip::write_parts(parts)}
                      .encode();
    }
    if ((how & in_unconnected_send) != 0) {
        cip::UnconnectedSend send;
        send.message = std::move(message);
        send.route_path = {0x01, 0x00};
        message = cip::Request{cip::service::unconnected_send, cip::Path::to(cip::class_id::connection_manager, 1),
                               send.encode()}
                      .encode();
    }
    return message;
}

class Client {
public:
    explicit Client(adapter::Protection protection) : protection_(protection) {
        site_.adapter().protect(protection);
        come();
    }

    void ask(std::uint8_t how, cip::ByteView message, cip::Bytes& answers) {
        if (!site_.is_open(id_)) come();  // it was a Reset
        const auto response = (how & connected) != 0 ? ask_connected(how, message) : site_.call(id_, message);
        if (response) {
            const auto octets = response->encode();
            answers.insert(answers.end(), octets.begin(), octets.end());
        }
        if ((how & time_goes_on) != 0) site_.advance(std::chrono::milliseconds(20));
    }
    void leave() {
        const auto& drive = site_.adapter();
        if (protection_.read_only) {
            require(drive.kept() == drive.delivered(), "where nothing may be changed nothing is");
            require(drive.io().owner() == nullptr, "where nothing may be changed nobody is the owner");
        }
        if (protection_.harden) {
            require(drive.kept().network == drive.delivered().network, "protected network settings stay");
        }
        site_.leave();
    }

private:
    void come() {
        id_ = site_.join(0);
        connection_ = site_.open_class3(id_, ++serial_, false).value();
        sequence_ = 0;
    }
    std::optional<cip::Response> ask_connected(std::uint8_t how, cip::ByteView message) {
        ++sequence_;
        auto response = site_.call(connection_, sequence_, message);
        require(response.has_value() || message.size() < 2 || site_.adapter().class3_connections() == 0,
                "a request over an open connection is answered", message);
        if (response && (how & again) != 0 && site_.is_open(id_)) {
            const auto second = site_.call(connection_, sequence_, message);
            require(!second || *second == *response, "a repeated request has its first answer", message);  // R-CON-46
        }
        return response;
    }

    adapter::Protection protection_;
    DeviceSite site_;
    DeviceSite::Id id_ = 0;
    DeviceSite::Connected connection_{};
    std::uint16_t serial_ = 0;
    std::uint16_t sequence_ = 0;
};

cip::Bytes run(cip::ByteView octets) {
    Input input(octets);
    const auto whole = input.u8();
    Client client({.read_only = (whole & read_only) != 0, .harden = (whole & hardened) != 0});
    cip::Bytes answers;
    for (std::size_t count = 0; count < most_requests && !input.over(); ++count) {
        const auto how = input.u8();
        client.ask(how, message_from(input, how), answers);
    }
    client.leave();
    return answers;
}

}  // namespace

void message_router(cip::ByteView octets) {
    const auto answers = run(octets);
    // Twice the work, so the input says whether.
    if (!octets.empty() && (octets[0] & twice) != 0)
        require(run(octets) == answers, "the same requests, the same answers");
}

}  // namespace servobus::fuzz
