// Cuts a TCP byte stream into encapsulation messages (R-ENC-3).
#pragma once

#include <cstddef>

#include "cip/bytes.hpp"
#include "enip/encapsulation.hpp"

namespace servobus::enip {

/// Holds at most one message of header_bytes + max_data. Feed it octets as they come; it never loses its place:
/// a message that is too long is passed over octet by octet and reported once its end has come.
class FrameDecoder {
public:
    explicit FrameDecoder(std::size_t max_data = max_data_bytes) : max_data_(max_data) {}

    struct Result {
        Frame frame;            ///< without data when `oversize`
        bool oversize = false;  ///< the stated length is above the limit; the data has been skipped
    };

    /// Takes octets from the front of `bytes`, up to the end of the next message, and returns that message, whose room
    /// is that of the one that follows; nullptr when it is not complete yet, and then `bytes` is empty.
    [[nodiscard]] Result* next(cip::ByteView& bytes);

    /// True in the middle of a message: the peer owes the rest.
    [[nodiscard]] bool partial() const { return !head_.empty() || body_missing_ > 0; }

private:
    bool read_header(cip::ByteView& bytes);
    void begin(cip::ByteView header);
    void read_body(cip::ByteView& bytes);

    std::size_t max_data_;
    cip::Bytes head_;
    Result message_;
    bool in_body_ = false;
    std::size_t body_missing_ = 0;
};

}  // namespace servobus::enip
