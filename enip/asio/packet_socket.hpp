// Whole Ethernet frames of one interface: AF_PACKET. Needs CAP_NET_RAW.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/system/error_code.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "cip/bytes.hpp"
#include "enip/link_user.hpp"

namespace servobus::enip::asio {

/// The longest frame that is heard whole, its VLAN tag included; a longer one is not heard.
inline constexpr std::size_t max_link_frame = 2048;

/// Which frames a socket hears; the kernel drops all others.
enum class Traffic : std::uint8_t {
    addressing,  ///< ARP, and datagrams to a DHCP client
    ring,        ///< Device Level Ring, and its multicast addresses
};

class PacketSocket {
public:
    explicit PacketSocket(const boost::asio::any_io_executor& executor) : descriptor_(executor) {}

    /// After an error it is closed. What is sent here is not heard here.
    [[nodiscard]] boost::system::error_code open(unsigned interface_index, Traffic traffic);
    void close();
    /// To wait for frames with.
    [[nodiscard]] boost::asio::posix::stream_descriptor& descriptor() { return descriptor_; }

    /// The next frame, or nullopt when none waits. The VLAN tag that the kernel or the hardware has taken off is in it.
    [[nodiscard]] std::optional<HeardFrame> receive(std::span<std::uint8_t, max_link_frame> buffer);
    /// At once or not at all: a frame that the interface cannot take is lost, as frames are.
    void send(cip::ByteView frame);

private:
    boost::asio::posix::stream_descriptor descriptor_;
};

}  // namespace servobus::enip::asio
