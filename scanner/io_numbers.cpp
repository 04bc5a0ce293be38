#include "scanner/io_numbers.hpp"

namespace servobus::scanner {
namespace {

// splitmix64: seeds that differ in one bit give numbers that have nothing in common.
std::uint64_t scramble(std::uint64_t value) {
    value += 0x9E3779B97F4A7C15;
    value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9;
    value = (value ^ (value >> 27)) * 0x94D049BB133111EB;
    return value ^ (value >> 31);
}

}  // namespace

IoNumbers::IoNumbers(std::uint16_t vendor, std::uint64_t seed) {
    const auto first = scramble(seed);
    const auto second = scramble(first);
    triad_ = {static_cast<std::uint16_t>(first), vendor, static_cast<std::uint32_t>(first >> 32)};
    id_ = static_cast<std::uint32_t>(second);
}

cip::ConnectionTriad IoNumbers::next_triad() {
    ++triad_.serial_number;
    return triad_;
}

std::uint32_t IoNumbers::next_id() {
    id_ = (id_ & 0xFFFF0000U) | ((id_ + 1) & 0xFFFFU);
    return id_;
}

}  // namespace servobus::scanner
