// Attributes of an object as cases look at them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "scanner/conformance/bench.hpp"

namespace servobus::scanner::conformance {

/// Where a value stands.
struct Place {
    std::uint16_t class_id = 0;
    std::uint16_t instance = 1;
    std::uint16_t attribute = 0;
};

enum class Presence : std::uint8_t {
    required,
    optional,  ///< the case is skipped where it is not there
};

[[nodiscard]] cip::Bytes get_request(const Place& place);
[[nodiscard]] cip::Bytes set_request(const Place& place, cip::ByteView value);

/// The value, or nullopt: the object or the attribute is not there, which is held against the device or skips the case.
[[nodiscard]] std::optional<cip::Bytes> read(Session& session, const Place& place, Presence presence);
/// The value or nullopt, and nothing said about it.
[[nodiscard]] std::optional<cip::Bytes> peek(Session& session, const Place& place);

/// A value of exactly so many octets that `judge` finds nothing wrong with: it returns what is wrong, or nothing.
using Judge = std::function<std::string(cip::Reader&)>;
void check_value(Bench& bench, const Place& place, Presence presence, std::size_t octets, const Judge& judge = {});
/// A value of any length that `judge` reads to its end.
void check_whole(Bench& bench, const Place& place, Presence presence, const Judge& judge);

/// The class attributes 1 to 3, 6 and 7, as far as they are there, and that they fit each other.
void check_class(Bench& bench, std::uint16_t class_id, std::uint16_t lowest_revision, std::uint16_t highest_revision,
                 Presence presence);

/// Get_Attributes_All begins with these attributes one after the other. Those that cannot be read alone end the comparison.
void check_all(Bench& bench, std::uint16_t class_id, std::uint16_t instance, std::uint16_t last, Presence presence);

/// A write that must be refused.
void check_refused_set(Bench& bench, const Place& place, cip::ByteView value, std::initializer_list<Code> right,
                       std::initializer_list<Code> tolerated = {}, Weight weight = Weight::any);
/// Writes what has just been read; it stays.
void check_write_back(Bench& bench, const Place& place);

/// Whether there is such an instance, by an attribute that it must have.
[[nodiscard]] bool has_instance(Session& session, std::uint16_t class_id, std::uint16_t instance);

}  // namespace servobus::scanner::conformance
