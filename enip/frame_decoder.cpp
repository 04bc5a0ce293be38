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

bool FrameDecoder::read_header(cip::ByteView& bytes) {
    const auto octets = take(bytes, header_bytes - head_.size());
    head_.insert(head_.end(), octets.begin(), octets.end());
    if (head_.size() < header_bytes) return false;
    cip::Reader reader(head_);
    message_ = {};
    std::uint16_t length = 0;
    describe_header(reader, message_.frame, length);
    head_.clear();
    message_.oversize = length > max_data_;
    body_missing_ = length;
    in_body_ = true;
    return true;
}

void FrameDecoder::read_body(cip::ByteView& bytes) {
    const auto octets = take(bytes, body_missing_);
    body_missing_ -= octets.size();
    if (!message_.oversize) message_.frame.data.insert(message_.frame.data.end(), octets.begin(), octets.end());
}

std::optional<FrameDecoder::Result> FrameDecoder::next(cip::ByteView& bytes) {
    if (!in_body_ && !read_header(bytes)) return std::nullopt;
    read_body(bytes);
    if (body_missing_ > 0) return std::nullopt;
    in_body_ = false;
    return std::move(message_);
}

}  // namespace servobus::enip
