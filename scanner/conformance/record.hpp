// What went over the wire in one case, for whoever has to believe the outcome.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cip/bytes.hpp"

namespace servobus::scanner::conformance {

struct Step {
    enum class Kind : std::uint8_t { sent, came, note };

    Kind kind = Kind::note;
    std::string words{};   ///< what it is, as far as it can be read
    cip::Bytes octets{};   ///< the first of them, at most Record::kept_octets
    std::size_t size = 0;  ///< how many there were
};

[[nodiscard]] std::string_view name(Step::Kind kind);

class Record {
public:
    /// More steps than these are counted only; a flood has hundreds.
    static constexpr std::size_t max_steps = 48;
    static constexpr std::size_t kept_octets = 640;

    void add(Step::Kind kind, std::string words, cip::ByteView octets = {});

    [[nodiscard]] const std::vector<Step>& steps() const { return steps_; }
    [[nodiscard]] std::size_t left_out() const { return left_out_; }

private:
    std::vector<Step> steps_;
    std::size_t left_out_ = 0;
};

// Octets in words: `SendRRData: Get_Attribute_Single to class 0x01, instance 0x01, attribute 0x01`. What cannot be read is
// counted.
[[nodiscard]] std::string describe_request(cip::ByteView octets);
[[nodiscard]] std::string describe_reply(cip::ByteView octets);
[[nodiscard]] std::string describe_datagram(cip::ByteView octets);

}  // namespace servobus::scanner::conformance
