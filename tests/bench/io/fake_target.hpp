// A target of one connection over plain sockets: grants what is asked, sends T->O from a bare paced sender, and leaves
// the O->T datagrams to whoever measures.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <thread>

#include "cip/message.hpp"
#include "enip/encapsulation.hpp"
#include "tests/bench/io/child.hpp"
#include "tests/bench/io/sockets.hpp"

namespace servobus::bench {

class FakeTarget {
public:
    explicit FakeTarget(std::uint32_t address);
    FakeTarget(const FakeTarget&) = delete;
    FakeTarget& operator=(const FakeTarget&) = delete;
    ~FakeTarget();

    /// Where O->T datagrams come to.
    [[nodiscard]] Receiver& receiver() { return receiver_; }

private:
    void serve(const Descriptor& peer);
    [[nodiscard]] enip::Frame answer(const enip::Frame& request);
    [[nodiscard]] cip::Response answer(const cip::Request& request);

    std::uint32_t address_;
    Receiver receiver_;
    Descriptor listener_;
    std::atomic<bool> stopped_ = false;
    std::optional<Child> sender_;
    enip::Endpoint originator_;
    std::thread thread_;
};

}  // namespace servobus::bench
