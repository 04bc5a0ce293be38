// Whether an interface of this machine has its link, and when it loses it or has it again. Needs no privilege.
#pragma once

#include <array>
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/system/error_code.hpp>
#include <cstdint>
#include <optional>

namespace servobus::enip::asio {

class LinkWatch {
public:
    explicit LinkWatch(const boost::asio::any_io_executor& executor) : descriptor_(executor) {}

    /// After an error it is closed.
    [[nodiscard]] boost::system::error_code open(unsigned interface_index);
    void close();
    /// To wait for news with.
    [[nodiscard]] boost::asio::posix::stream_descriptor& descriptor() { return descriptor_; }

    /// The MAC address; nullopt when it is no Ethernet interface.
    [[nodiscard]] std::optional<std::array<std::uint8_t, 6>> mac() const;
    /// As it is now; false also when there is no such interface any more.
    [[nodiscard]] bool has_link() const;
    /// What the news that wait end with; nullopt when there are none of this interface.
    [[nodiscard]] std::optional<bool> news();

private:
    boost::asio::posix::stream_descriptor descriptor_;
    unsigned interface_index_ = 0;
};

}  // namespace servobus::enip::asio
