// An I/O connection in the hands of a case: opened as the case wants it, fed or starved, and every datagram seen.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cip/forward_open.hpp"
#include "enip/endpoint.hpp"
#include "enip/time.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/io_reply.hpp"

namespace servobus::scanner::conformance {

/// What a Forward_Open may be changed in before it is sent.
using Change = std::function<void(cip::ForwardOpen&)>;

/// One datagram of T->O.
struct Datagram {
    enip::Time time;  ///< when the kernel took it
    enip::Endpoint peer;
    enip::Endpoint local;
    std::uint8_t ttl = 0;
    std::uint32_t sequence = 0;
    cip::Bytes data;  ///< of the data item
    cip::Bytes octets;

    /// The CIP sequence count in front of the data of class 1.
    [[nodiscard]] std::optional<std::uint16_t> count() const;
};

/// What is asked first: the connection as the device is said to have it, at an interval of about `rpi`, with the longest
/// timeout, so that a busy machine does not lose it. T->O goes point-to-point where that is possible.
[[nodiscard]] IoPlan usual_plan(const Candidate& candidate, std::chrono::microseconds rpi);
[[nodiscard]] IoPlan multicast_plan(const Candidate& candidate, std::chrono::microseconds rpi);

/// Asks, and leaves it at that: a connection that is granted is closed again.
[[nodiscard]] std::optional<Reply> try_open(Session& session, const cip::ForwardOpen& open,
                                            std::vector<enip::Item> items = {});
/// A Forward_Open of a plan with numbers that nobody has had.
[[nodiscard]] cip::ForwardOpen open_of(Session& session, const IoPlan& plan, const Change& change = {});
/// The reply to a Forward_Close.
[[nodiscard]] std::optional<Reply> close_triad(Session& session, const cip::ForwardOpen& open);
/// The refusal says which connection it is about (R-CON-14).
void check_refusal_data(Bench& bench, const std::optional<Reply>& reply, const cip::ForwardOpen& open);

class IoLink {
public:
    /// Opens. A refusal is held against the device unless `may_fail`; that it has no connection left skips the case.
    IoLink(Session& session, const IoPlan& plan, const Change& change = {}, bool may_fail = false);
    IoLink(IoLink&& other) noexcept;
    /// Closes if it is open, by the same session.
    ~IoLink();

    [[nodiscard]] bool is_open() const;
    [[nodiscard]] const std::optional<Reply>& reply() const;
    [[nodiscard]] const cip::ForwardOpen& request() const;
    [[nodiscard]] const IoGrant& grant() const;
    [[nodiscard]] std::chrono::microseconds o_to_t_api() const;
    [[nodiscard]] std::chrono::microseconds t_to_o_api() const;
    [[nodiscard]] std::chrono::microseconds timeout() const;  ///< of O->T: interval times multiplier
    [[nodiscard]] enip::Endpoint receiver() const;            ///< where T->O is expected

    /// Sends O->T at its interval, idle and all zeros where it has data, and takes what comes.
    std::vector<Datagram> run(std::chrono::microseconds time);
    /// The same until as many have come, or the time is over.
    std::vector<Datagram> run(std::size_t datagrams, std::chrono::microseconds longest);
    /// Takes what comes, and sends nothing.
    std::vector<Datagram> listen(std::chrono::microseconds time);
    /// Takes what comes until nothing has come for `quiet`, or the time is over. True: it is quiet.
    bool listen_until_quiet(std::chrono::microseconds quiet, std::chrono::microseconds longest,
                            std::vector<Datagram>& taken);

    /// One datagram of O->T.
    struct Output {
        std::optional<std::uint32_t> connection_id{};
        std::optional<std::uint32_t> sequence{};  ///< of the encapsulation; otherwise the next
        std::optional<std::uint16_t> count{};     ///< of CIP; otherwise the next
        std::optional<cip::Bytes> data{};         ///< behind the count; otherwise as the format has it, idle
        bool run = false;
    };
    void send(const Output& output);
    void send() { send(Output{}); }
    /// When the last one was sent that counts.
    [[nodiscard]] enip::Time last_sent() const;
    [[nodiscard]] std::uint32_t last_sequence() const;
    /// Datagrams that came here and are none of this connection.
    [[nodiscard]] std::size_t strays() const;

    /// Sends a Forward_Close by `session`; nullopt when there is no answer.
    std::optional<Reply> close(Session& session);
    std::optional<Reply> close();
    /// Nothing is to be closed any more: the device has done it.
    void forget();

private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

/// A connection of the device that this case may open; nullptr, and the case is skipped, when there is none.
[[nodiscard]] const Candidate* harmless(Bench& bench);
[[nodiscard]] const Candidate* harmless_multicast(Bench& bench);
/// One of that kind, or skipped.
[[nodiscard]] const Candidate* of_kind(Bench& bench, Kind kind);

/// Some datagrams of T->O come; that they do not is held against the device.
bool flows(IoLink& link, Bench& bench);

/// An interval that a busy machine keeps as well.
inline constexpr std::chrono::milliseconds usual_rpi{20};

/// Attempts of something whose time is measured: a busy machine may spoil one, and an honest device is not blamed for it.
inline constexpr int measuring_attempts = 3;

}  // namespace servobus::scanner::conformance
