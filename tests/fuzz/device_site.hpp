// A whole device and those who speak to it, in virtual time. Whatever is sent, it holds that the device takes octets or has
// something to say, that its replies can be read and are no longer than their limit, and that what it keeps is bounded.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "adapter/adapter.hpp"
#include "cip/forward_open.hpp"
#include "cip/message.hpp"
#include "drive/device.hpp"
#include "drive/xenax.hpp"
#include "enip/encapsulation.hpp"
#include "enip/messages.hpp"

namespace servobus::fuzz {

/// The longest datagram of class 1 that this device sends: the longest image behind its sequence count.
inline constexpr std::size_t longest_io_datagram = 18 + 2 + 40;

class DeviceSite {
public:
    using Id = enip::Target::ConnectionId;

    static constexpr enip::Endpoint local{0xC0A80264, enip::tcp_port};
    static constexpr enip::Endpoint io_local{local.address, enip::io_port};
    /// Who speaks: 192.168.2.1 and those behind it.
    static constexpr enip::Endpoint peer(std::size_t number) {
        return {0xC0A80201 + static_cast<std::uint32_t>(number % 4), 50000};
    }
    static constexpr enip::Endpoint io_peer(std::size_t number) { return {peer(number).address, enip::io_port}; }

    explicit DeviceSite(adapter::Limits limits = {}, adapter::DeviceFiles files = {});

    [[nodiscard]] adapter::Adapter& adapter() { return adapter_; }
    [[nodiscard]] enip::Time now() const { return now_; }

    /// A TCP connection; nullopt when the device takes none.
    std::optional<Id> connect(std::size_t peer_number = 0);
    void disconnect(Id id);
    [[nodiscard]] bool is_open(Id id) const { return sessions_.contains(id); }
    [[nodiscard]] std::vector<Id> open() const;
    /// 0: none.
    [[nodiscard]] std::uint32_t session(Id id) const;

    /// Octets of a TCP stream, in pieces; what is answered. The connection may be closed afterwards.
    cip::Bytes send(Id id, cip::ByteView octets, std::size_t piece_octets = 4096);
    /// One frame of which a reply is expected: nullopt when there is none.
    std::optional<enip::Frame> ask(Id id, const enip::Frame& request);
    /// False when the device refuses it.
    bool register_session(Id id);
    /// A message router request as SendRRData in the session. Every request of two octets or more has a reply that can be
    /// read and names the service, which holds; nullopt for a shorter one.
    std::optional<cip::Response> call(Id id, cip::ByteView message);

    /// An open class 3 connection of a TCP connection.
    struct Connected {
        Id on = 0;
        std::uint32_t o_to_t_id = 0;  ///< the device's
        std::uint32_t t_to_o_id = 0;
        std::size_t max_reply = 0;  ///< octets of a message
    };
    /// Nullopt when the device refuses it.
    std::optional<Connected> open_class3(Id id, std::uint16_t serial, bool large);
    /// A message as SendUnitData over that connection, and its answer: which has the connection, the sequence count, a
    /// length that fits, and can be read.
    std::optional<cip::Response> call(const Connected& connection, std::uint16_t sequence, cip::ByteView message);

    /// A datagram at UDP 44818.
    void send_datagram(cip::ByteView octets, bool broadcast);
    /// A datagram at UDP 2222, which opens, closes and answers nothing.
    void send_io(cip::ByteView octets, std::size_t peer_number = 0);

    /// Time passes in one step, as when the timer comes late.
    void advance(std::chrono::microseconds duration);

    /// Closes everything that peers may hold, and looks whether anything is left: neither connection nor session, and a
    /// newcomer is served.
    void leave();

    /// A newcomer with a session, for whom there is room.
    Id join(std::size_t peer_number);

private:
    void check_replies(cip::ByteView octets, cip::ByteView because) const;
    void check_bounds(cip::ByteView because) const;
    void settle();

    drive::Device device_{drive::xenax_models().front()};
    adapter::Adapter adapter_;
    enip::Time now_{std::chrono::hours(1)};
    std::map<Id, std::uint32_t> sessions_;  ///< of each TCP connection; 0: none yet
};

}  // namespace servobus::fuzz
