// Takes an input apart from its front: choices, numbers and pieces of octets. An input that is over says zero and nothing,
// so that every input means something.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "cip/bytes.hpp"
#include "cip/wire.hpp"

namespace servobus::fuzz {

class Input {
public:
    explicit Input(cip::ByteView octets) : reader_(octets) {}

    [[nodiscard]] bool over() const { return reader_.remaining() == 0; }
    std::uint8_t u8() { return reader_.u8(); }
    std::uint16_t u16() { return reader_.u16(); }
    std::uint32_t u32() { return reader_.u32(); }
    /// 0 to count - 1.
    std::size_t below(std::size_t count) { return u8() % count; }
    /// An octet that says how many, and as many octets as there are of them, in a buffer of exactly their size.
    cip::Bytes piece() { return take(u8()); }
    /// The same with two octets of length.
    cip::Bytes long_piece() { return take(u16()); }
    cip::Bytes rest() { return take(reader_.remaining()); }

private:
    cip::Bytes take(std::size_t wanted) {
        const auto octets = reader_.take(std::min(wanted, reader_.remaining()));
        return {octets.begin(), octets.end()};
    }

    cip::Reader reader_;
};

}  // namespace servobus::fuzz
