#include "enip/frame_decoder.hpp"

#include <algorithm>

#include "enip/header.hpp"

namespace servobus::enip {
namespace {

cip::ByteView take(cip::ByteView& bytes, std::size_t count) {
    const auto front = bytes.first(std::min(count, bytes.size()));
    bytes = bytes.subspan(front.size());
    return front;
}

}  // namespace

// Most come in one piece.
bool FrameDecoder::read_header(cip::ByteView& bytes) {
    if (head_.empty() && bytes.size() >= header_bytes) {
        begin(take(bytes, header_bytes));
        return true;
    }
    const auto octets = take(bytes, header_bytes - head_.size());
    head_.insert(head_.end(), octets.begin(), octets.end());
    if (head_.size() < header_bytes) return false;
    begin(head_);
    head_.clear();
    return true;
}

void FrameDecoder::begin(cip::ByteView header) {
    cip::Reader reader(header);
    std::uint16_t length = 0;
    describe_header(reader, message_.frame, length);
    message_.frame.data.clear();
    message_.oversize = length > max_data_;
    body_missing_ = length;
    in_body_ = true;
}

void FrameDecoder::read_body(cip::ByteView& bytes) {
    const auto octets = take(bytes, body_missing_);
    body_missing_ -= octets.size();
    if (!message_.oversize) message_.frame.data.insert(message_.frame.data.end(), octets.begin(), octets.end());
}

FrameDecoder::Result* FrameDecoder::next(cip::ByteView& bytes) {
    if (!in_body_ && !read_header(bytes)) return nullptr;
    read_body(bytes);
    if (body_missing_ > 0) return nullptr;
    in_body_ = false;
    return &message_;
}

}  // namespace servobus::enip
