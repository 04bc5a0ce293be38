// A real server in a thread of the test, and a plain blocking socket client that shares no code with it but the frame.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "adapter/adapter.hpp"
#include "drive/device.hpp"
#include "drive/xenax.hpp"
#include "enip/asio/target_server.hpp"
#include "enip/encapsulation.hpp"

namespace servobus::test {

/// Long enough for a loaded machine; nothing waits for it unless something is wrong.
inline constexpr std::chrono::milliseconds patience{5000};

/// Serves a device at 127.0.0.1 and a free port until it is destroyed. The device belongs to the server's thread.
class RunningServer {
public:
    explicit RunningServer(adapter::Limits limits = {},
                           drive::Device device = drive::Device(drive::xenax_models().front()));
    ~RunningServer();
    RunningServer(const RunningServer&) = delete;
    RunningServer& operator=(const RunningServer&) = delete;

    std::uint16_t port() const { return port_; }

private:
    drive::Device device_;
    adapter::Adapter adapter_;
    enip::asio::TargetServer server_;
    std::uint16_t port_ = 0;
    std::thread thread_;
};

/// One TCP connection to 127.0.0.1, or another address of this machine. What does not come in time, comes not at all.
class TcpClient {
public:
    /// `receive_buffer`: SO_RCVBUF, 0 for the system's choice.
    explicit TcpClient(std::uint16_t port, int receive_buffer = 0, std::uint32_t address = 0x7F000001);
    ~TcpClient();
    TcpClient(TcpClient&& other) noexcept;
    TcpClient& operator=(TcpClient&& other) noexcept;
    TcpClient(const TcpClient&) = delete;
    TcpClient& operator=(const TcpClient&) = delete;

    bool connected() const { return descriptor_ >= 0; }
    std::uint32_t session() const { return session_; }

    /// False when the peer has closed, or takes nothing.
    bool send(cip::ByteView octets) const;
    /// As much as the system takes without waiting.
    std::size_t send_some(cip::ByteView octets) const;
    /// The next frame; nullopt when it does not come.
    std::optional<enip::Frame> receive(std::chrono::milliseconds limit = patience) const;
    /// True when the peer has closed its end, in order or not; octets before that are thrown away.
    bool closed_by_peer(std::chrono::milliseconds limit = patience) const;
    void close();
    /// Closes with a reset.
    void reset();

    bool register_session();
    /// A message router request by SendRRData, and the response's octets; empty when none came.
    cip::Bytes call(cip::ByteView message) const;
    /// Opens a class 3 connection; later requests by SendUnitData.
    bool open_class3();
    cip::Bytes connected_call(cip::ByteView message);

private:
    bool receive_exactly(std::uint8_t* octets, std::size_t count, std::chrono::steady_clock::time_point end) const;

    int descriptor_ = -1;
    std::uint32_t session_ = 0;
    std::uint32_t connection_ = 0;
    std::uint16_t sequence_ = 0;
};

}  // namespace servobus::test
