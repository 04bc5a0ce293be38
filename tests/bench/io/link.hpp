// A class 1 connection 103/100 to the adapter, opened with a Forward_Open that is put together by hand.
#pragma once

#include <cstdint>
#include <string>

#include "tests/bench/io/explicit_client.hpp"
#include "tests/bench/io/io_run.hpp"

namespace servobus::bench {

struct LinkSettings {
    enip::Endpoint target;            ///< its TCP port
    std::uint32_t local_address = 0;  ///< T->O comes to UDP 2222 there
    std::uint32_t interval_us = 1000;
    std::uint8_t trigger = 0;  ///< 0 cyclic, 1 change of state
    std::uint8_t multiplier_code = 2;
};

class Link {
public:
    explicit Link(const LinkSettings& settings);
    Link(const Link&) = delete;
    Link& operator=(const Link&) = delete;
    /// Forward_Close.
    ~Link();

    [[nodiscard]] const Outlet& outlet() const { return outlet_; }
    [[nodiscard]] std::uint32_t t_to_o_id() const { return t_to_o_id_; }
    /// The granted interval of T->O.
    [[nodiscard]] double interval_us() const { return interval_us_; }
    [[nodiscard]] ExplicitClient& client() { return client_; }

private:
    ExplicitClient client_;
    cip::ForwardOpen request_;
    Outlet outlet_;
    std::uint32_t t_to_o_id_ = 0;
    double interval_us_ = 0;
};

}  // namespace servobus::bench
