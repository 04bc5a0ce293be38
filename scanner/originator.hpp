// The originator of class 1 connections: any number of them, to any number of devices, over one UDP port.
//
//     Originator originator(context.get_executor());
//     auto& io = originator.add({.host = "192.168.2.100", .plan = plan_of(*assemblies::find_connection("standard"))},
//                               {.input = [](const IoInput& input) { ... },
//                                .output = [](std::span<std::uint8_t> data) { ...; return true; }});
//     io.open();
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "enip/asio/asio.hpp"
#include "enip/encapsulation.hpp"
#include "enip/io_stream.hpp"
#include "scanner/io_events.hpp"
#include "scanner/io_plan.hpp"

namespace servobus::scanner {

struct OriginatorOptions {
    std::uint16_t vendor = 0xFFFF;          ///< of the triad (R-SCN-2); 0xFFFF is nobody's
    std::optional<std::uint64_t> seed{};    ///< of serial numbers and connection ids; random when left out
    std::uint16_t io_port = enip::io_port;  ///< where T->O is wanted; another one is taken when it is in use
};

/// Datagrams that fitted no connection (R-IO-7), of the whole originator.
struct StrayCounters {
    std::uint64_t malformed = 0;
    std::uint64_t unknown_id = 0;
    std::uint64_t wrong_source = 0;
};

/// One connection. It lives as long as its originator.
class IoConnection {
public:
    virtual ~IoConnection() = default;

    virtual void open() = 0;
    /// Forward_Close, in good manners; `closed` tells when it is done.
    virtual void close() = 0;
    [[nodiscard]] virtual IoState state() const = 0;
    [[nodiscard]] virtual const enip::IoConsumer::Counters& received() const = 0;
    [[nodiscard]] virtual const enip::IoProducer::Counters& sent() const = 0;
    /// For change of state and application triggers: the output may have changed, look now.
    virtual void trigger() = 0;

protected:
    IoConnection() = default;
    IoConnection(const IoConnection&) = default;
    IoConnection& operator=(const IoConnection&) = default;
};

/// All calls come from its executor, which is a context with one thread, or a strand. The executor outlives it.
class Originator {
public:
    explicit Originator(net::any_io_executor executor, OriginatorOptions options = {});
    Originator(const Originator&) = delete;
    Originator& operator=(const Originator&) = delete;
    /// Everything ends at once; targets notice by their timeout. close() the connections before.
    ~Originator();

    /// The connection is idle until open() is called. Connections to one host and port share a session.
    IoConnection& add(IoOptions options, IoEvents events);
    [[nodiscard]] const StrayCounters& strays() const;
    /// O->T datagrams that the system did not take.
    [[nodiscard]] std::uint64_t unsent() const;

private:
    class Impl;
    std::shared_ptr<Impl> impl_;
};

}  // namespace servobus::scanner
