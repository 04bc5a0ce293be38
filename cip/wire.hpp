// Reading and writing octets. Integers are little-endian unless the name says otherwise (R-TYP-2).
//
// A wire struct is described once, by a function template `describe(io, message)` that hands its fields to `io`;
// Reader and Writer are both such an `io`, so what is read is what is written.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "cip/bytes.hpp"

namespace servobus::cip {

/// An integer or an enumeration over one: what a field of a wire struct is.
template <class T>
concept Field = std::integral<T> || std::is_enum_v<T>;

namespace detail {
template <class T>
struct Raw {
    using type = std::make_unsigned_t<T>;
};
template <class T>
requires std::is_enum_v<T>
struct Raw<T> {
    using type = std::make_unsigned_t<std::underlying_type_t<T>>;
};
template <class T>
using raw_t = typename Raw<std::remove_const_t<T>>::type;
}  // namespace detail

/// Reads from the front of a span. Reading past the end yields zeros and makes ok() false for good, so a struct is
/// read field by field and checked once.
class Reader {
public:
    explicit Reader(ByteView bytes) : bytes_(bytes) {}

    [[nodiscard]] bool ok() const { return ok_; }
    /// True when everything was read and nothing was missing.
    [[nodiscard]] bool done() const { return ok_ && bytes_.empty(); }
    [[nodiscard]] std::size_t remaining() const { return bytes_.size(); }
    /// What has not been read.
    [[nodiscard]] ByteView rest() const { return bytes_; }

    /// The next `count` octets, or an empty span when there are fewer.
    ByteView take(std::size_t count) {
        if (count > bytes_.size()) {
            ok_ = false;
            bytes_ = {};
            return {};
        }
        const auto front = bytes_.first(count);
        bytes_ = bytes_.subspan(count);
        return front;
    }
    ByteView take_rest() { return take(bytes_.size()); }

    template <Field T>
    T little() {
        using Raw = detail::raw_t<T>;
        Raw value = 0;
        const auto octets = take(sizeof(Raw));
        for (std::size_t i = octets.size(); i-- > 0;) value = static_cast<Raw>((std::uint64_t{value} << 8) | octets[i]);
        return static_cast<T>(value);
    }
    template <Field T>
    T big() {
        using Raw = detail::raw_t<T>;
        Raw value = 0;
        for (const auto octet : take(sizeof(Raw))) value = static_cast<Raw>((std::uint64_t{value} << 8) | octet);
        return static_cast<T>(value);
    }

    std::uint8_t u8() { return little<std::uint8_t>(); }
    std::uint16_t u16() { return little<std::uint16_t>(); }
    std::uint32_t u32() { return little<std::uint32_t>(); }
    std::uint64_t u64() { return little<std::uint64_t>(); }

    // As the `io` of describe().
    template <Field T>
    void field(T& value) {
        value = little<T>();
    }
    template <Field T>
    void big_endian_field(T& value) {
        value = big<T>();
    }
    template <std::size_t N>
    void field(std::array<std::uint8_t, N>& octets) {
        const auto bytes = take(N);
        for (std::size_t i = 0; i < bytes.size(); ++i) octets[i] = bytes[i];
    }
    void reserved(std::size_t count) { take(count); }

private:
    ByteView bytes_;
    bool ok_ = true;
};

/// Appends to a byte vector.
class Writer {
public:
    explicit Writer(Bytes& bytes) : bytes_(bytes) {}

    [[nodiscard]] std::size_t size() const { return bytes_.size(); }

    template <Field T>
    void little(T value) {
        auto raw = static_cast<std::uint64_t>(static_cast<detail::raw_t<T>>(value));
        std::array<std::uint8_t, sizeof(T)> octets;  // NOLINT(*-member-init): written before it is read
        for (auto& octet : octets) {
            octet = static_cast<std::uint8_t>(raw);
            raw >>= 8;
        }
        bytes_.insert(bytes_.end(), octets.begin(), octets.end());
    }
    template <Field T>
    void big(T value) {
        const auto raw = static_cast<std::uint64_t>(static_cast<detail::raw_t<T>>(value));
        for (std::size_t i = sizeof(T); i-- > 0;) bytes_.push_back(static_cast<std::uint8_t>(raw >> (8 * i)));
    }

    void u8(std::uint8_t value) { little(value); }
    void u16(std::uint16_t value) { little(value); }
    void u32(std::uint32_t value) { little(value); }
    void u64(std::uint64_t value) { little(value); }
    void bytes(ByteView octets) { bytes_.insert(bytes_.end(), octets.begin(), octets.end()); }
    void zeros(std::size_t count) { bytes_.insert(bytes_.end(), count, std::uint8_t{0}); }

    // As the `io` of describe().
    template <Field T>
    void field(const T& value) {
        little(value);
    }
    template <Field T>
    void big_endian_field(const T& value) {
        big(value);
    }
    template <std::size_t N>
    void field(const std::array<std::uint8_t, N>& octets) {
        bytes(octets);
    }
    void reserved(std::size_t count) { zeros(count); }

private:
    Bytes& bytes_;
};

}  // namespace servobus::cip
