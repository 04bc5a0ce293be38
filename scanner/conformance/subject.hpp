// The device that is put to the test, and what the user has allowed.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "cip/forward_open.hpp"
#include "enip/endpoint.hpp"
#include "scanner/conformance/candidate.hpp"
#include "scanner/host.hpp"
#include "scanner/identity.hpp"
#include "scanner/io_numbers.hpp"

namespace servobus::scanner::conformance {

struct SubjectOptions {
    Host host{};
    std::chrono::milliseconds timeout{5000};  ///< for an answer
    bool writes = false;
    std::vector<Candidate> candidates{};
    std::uint64_t seed = 0;  ///< of serial numbers, ids, contexts and what is malformed at random
};

class Subject {
public:
    explicit Subject(SubjectOptions options)
        : options_(std::move(options)), numbers_(originator_vendor, options_.seed), context_(options_.seed) {}

    [[nodiscard]] const SubjectOptions& options() const { return options_; }
    [[nodiscard]] bool writes() const { return options_.writes; }
    /// What is known once the device has said who it is.
    void set_candidates(std::vector<Candidate> candidates) { options_.candidates = std::move(candidates); }

    /// Of the connections that it has, the first of a kind; nullptr when there is none.
    [[nodiscard]] const Candidate* find(Kind kind) const;
    /// One that may be opened without leave to write, or with it if there is no other.
    [[nodiscard]] const Candidate* harmless() const;
    /// The same with T->O by multicast, or point-to-point.
    [[nodiscard]] const Candidate* harmless_multicast() const;

    /// Each once.
    [[nodiscard]] cip::ConnectionTriad next_triad() { return numbers_.next_triad(); }
    [[nodiscard]] std::uint32_t next_id() { return numbers_.next_id(); }
    [[nodiscard]] std::uint64_t next_context() { return ++context_; }

    // What the device says about itself, as soon as it has been asked.
    std::optional<Identity> identity{};
    enip::Endpoint address{};  ///< where its TCP port is
    enip::Endpoint own{};      ///< our end

private:
    // Nobody's vendor id.
    static constexpr std::uint16_t originator_vendor = 0xFFFF;

    SubjectOptions options_;
    IoNumbers numbers_;
    std::uint64_t context_;
};

}  // namespace servobus::scanner::conformance
