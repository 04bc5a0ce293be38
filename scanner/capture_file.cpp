#include "scanner/capture_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

#include "cip/wire.hpp"

namespace servobus::scanner {
namespace {

// First words of files, read as little-endian.
constexpr std::uint32_t section_header = 0x0A0D0D0A;
constexpr std::uint32_t pcap_microseconds = 0xA1B2C3D4;
constexpr std::uint32_t pcap_nanoseconds = 0xA1B23C4D;
constexpr std::uint16_t gzip = 0x8B1F;

constexpr std::uint32_t byte_order_magic = 0x1A2B3C4D;
constexpr std::uint32_t interface_description = 1;
constexpr std::uint32_t old_packet = 2;
constexpr std::uint32_t simple_packet = 3;
constexpr std::uint32_t enhanced_packet = 6;
constexpr std::uint16_t option_end = 0;
constexpr std::uint16_t option_time_resolution = 9;
constexpr std::uint16_t option_time_offset = 14;

constexpr std::size_t block_overhead = 12;
constexpr std::int64_t nanoseconds_per_second = 1'000'000'000;

/// Integers in the byte order of a file.
class Numbers {
public:
    Numbers(cip::ByteView octets, bool big) : reader_(octets), big_(big) {}

    std::uint16_t u16() { return big_ ? reader_.big<std::uint16_t>() : reader_.u16(); }
    std::uint32_t u32() { return big_ ? reader_.big<std::uint32_t>() : reader_.u32(); }
    std::uint64_t u64() { return big_ ? reader_.big<std::uint64_t>() : reader_.u64(); }
    cip::ByteView take(std::size_t count) { return reader_.take(count); }
    [[nodiscard]] cip::ByteView rest() const { return reader_.rest(); }
    [[nodiscard]] bool ok() const { return reader_.ok(); }

private:
    cip::Reader reader_;
    bool big_;
};

/// Units of a time stamp: 10^-n, or 2^-n with bit 7 set.
struct Resolution {
    std::uint8_t code = 6;

    [[nodiscard]] std::int64_t nanoseconds(std::uint64_t units) const {
        const unsigned exponent = code & 0x7FU;
        if ((code & 0x80) != 0) {
            if (exponent >= 64) return 0;
            const auto seconds = units >> exponent;
            auto fraction = exponent == 0 ? 0 : units << (64 - exponent) >> 32;
            fraction = fraction * static_cast<std::uint64_t>(nanoseconds_per_second) >> 32;
            return static_cast<std::int64_t>(seconds * static_cast<std::uint64_t>(nanoseconds_per_second) + fraction);
        }
        for (unsigned i = exponent; i < 9; ++i) units *= 10;
        for (unsigned i = 9; i < exponent; ++i) units /= 10;
        return static_cast<std::int64_t>(units);
    }
};

struct Interface {
    LinkType link = LinkType::ethernet;
    std::uint32_t snap_length = 0;
    Resolution resolution{};
    std::int64_t offset_seconds = 0;
};

/// What a damaged file says is kept within 0 and 146 years, so that differences of times can be taken.
CaptureTime time_from(std::int64_t nanoseconds, std::int64_t seconds) {
    constexpr std::int64_t latest = std::int64_t{1} << 62;
    constexpr auto second = static_cast<double>(nanoseconds_per_second);
    const auto sum = static_cast<double>(nanoseconds) + static_cast<double>(seconds) * second;
    if (sum < 0) return CaptureTime{};
    if (nanoseconds < 0 || sum >= static_cast<double>(latest)) return CaptureTime(std::chrono::nanoseconds(latest));
    return CaptureTime(std::chrono::nanoseconds(nanoseconds) + std::chrono::seconds(seconds));
}

class CaptureReader {
public:
    CaptureReader(std::istream& file, const std::function<void(const CapturedPacket&)>& each)
        : file_(file), each_(each) {}

    CaptureSummary read() {
        std::array<std::uint8_t, 4> magic{};
        if (!fill(magic)) {
            damage(got_ == 0 ? "the file is empty" : "the file is too short for a capture");
            return std::move(summary_);
        }
        const auto little = cip::Reader(magic).u32();
        const auto big = cip::Reader(magic).big<std::uint32_t>();
        if (little == section_header) {
            read_blocks(magic);
        } else if (little == pcap_microseconds || little == pcap_nanoseconds) {
            read_pcap(false, little == pcap_nanoseconds);
        } else if (big == pcap_microseconds || big == pcap_nanoseconds) {
            read_pcap(true, big == pcap_nanoseconds);
        } else {
            damage((little & 0xFFFF) == gzip ? "the file is compressed; unpack it with gunzip first"
                                             : "the file is neither pcapng nor pcap");
        }
        return std::move(summary_);
    }

private:
    // --- octets

    /// False when the file ends before `into` is full; got_ then says how much there was.
    bool fill(std::span<std::uint8_t> into) {
        file_.read(reinterpret_cast<char*>(into.data()), static_cast<std::streamsize>(into.size()));
        got_ = static_cast<std::size_t>(file_.gcount());
        offset_ += got_;
        return got_ == into.size();
    }
    bool damage(std::string text) {
        summary_.damage = CaptureDamage{start_, std::move(text)};
        return false;
    }

    // --- pcapng

    void read_blocks(std::span<const std::uint8_t> first_type) {
        std::array<std::uint8_t, 8> head{};
        std::ranges::copy(first_type, head.begin());
        if (!fill(std::span(head).subspan(4))) {
            damage("the file ends in its first block");
            return;
        }
        while (read_block(head)) {
            start_ = offset_;
            if (!fill(head)) {
                if (got_ > 0) damage("the file ends in the header of a block");
                return;
            }
        }
    }

    /// Type and length are in `head`. False when there is damage.
    bool read_block(cip::ByteView head) {
        if (cip::Reader(head).u32() == section_header && !read_byte_order()) return false;
        Numbers numbers(head, big_);
        const auto type = numbers.u32();
        const std::size_t length = numbers.u32();
        const std::size_t already = type == section_header ? 4 : 0;
        if (length < block_overhead + already || length % 4 != 0 || length > max_block_octets) {
            return damage(fmt::format("a block of {} octets cannot be", length));
        }
        block_.resize(length - head.size() - already);
        if (!fill(block_)) return damage("the file ends in the middle of a block");
        const auto body = cip::ByteView(block_).first(block_.size() - 4);
        if (Numbers(cip::ByteView(block_).last(4), big_).u32() != length) {
            return damage("the two lengths of a block differ");
        }
        return dispatch(type, body);
    }

    bool read_byte_order() {
        std::array<std::uint8_t, 4> magic{};
        if (!fill(magic)) return damage("the file ends in a section header");
        if (cip::Reader(magic).u32() == byte_order_magic) {
            big_ = false;
        } else if (cip::Reader(magic).big<std::uint32_t>() == byte_order_magic) {
            big_ = true;
        } else {
            return damage("a section header has no byte order");
        }
        return true;
    }

    bool dispatch(std::uint32_t type, cip::ByteView body) {
        switch (type) {
            case section_header:
                interfaces_.clear();
                if (Numbers(body, big_).u16() != 1) return damage("the section has a version that is not known");
                return true;
            case interface_description:
                return add_interface(body);
            case enhanced_packet:
                return read_enhanced(body);
            case simple_packet:
                return read_simple(body);
            case old_packet:
                return read_old(body);
            default:
                return true;  // statistics, names and what others have invented
        }
    }

    bool add_interface(cip::ByteView body) {
        if (interfaces_.size() >= max_interfaces) return damage("a section has too many interfaces");
        Numbers numbers(body, big_);
        Interface interface;
        interface.link = static_cast<LinkType>(numbers.u16());
        numbers.u16();
        interface.snap_length = numbers.u32();
        if (!numbers.ok()) return damage("an interface description is too short");
        while (numbers.rest().size() >= 4) {
            const auto code = numbers.u16();
            const std::size_t size = numbers.u16();
            if (code == option_end) break;
            const auto value = numbers.take((size + 3) / 4 * 4);
            if (!numbers.ok()) return damage("an option of an interface description is longer than its block");
            if (code == option_time_resolution && size >= 1) interface.resolution.code = value[0];
            if (code == option_time_offset && size >= 8) {
                interface.offset_seconds = static_cast<std::int64_t>(Numbers(value, big_).u64());
            }
        }
        interfaces_.push_back(interface);
        return true;
    }

    const Interface* interface_at(std::uint32_t index) {
        if (index < interfaces_.size()) return &interfaces_[index];
        damage(fmt::format("a packet names interface {}, which is not described", index));
        return nullptr;
    }

    bool read_enhanced(cip::ByteView body) {
        Numbers numbers(body, big_);
        return read_stamped(numbers, numbers.u32());
    }
    /// The form before the enhanced one: 16 bits of interface, 16 of packets that were dropped.
    bool read_old(cip::ByteView body) {
        Numbers numbers(body, big_);
        const auto index = numbers.u16();
        numbers.u16();
        return read_stamped(numbers, index);
    }
    bool read_stamped(Numbers& numbers, std::uint32_t index) {
        const auto* interface = interface_at(index);
        if (interface == nullptr) return false;
        const auto high = std::uint64_t{numbers.u32()};
        const auto units = high << 32 | numbers.u32();
        const std::size_t captured = numbers.u32();
        const auto original = numbers.u32();
        const auto frame = numbers.take(captured);
        if (!numbers.ok()) return damage("a packet is longer than its block");
        take(interface->link, frame, original,
             time_from(interface->resolution.nanoseconds(units), interface->offset_seconds));
        return true;
    }
    /// Without a time stamp; as long as the interface lets it be.
    bool read_simple(cip::ByteView body) {
        const auto* interface = interface_at(0);
        if (interface == nullptr) return false;
        Numbers numbers(body, big_);
        const std::size_t original = numbers.u32();
        const std::size_t limit = interface->snap_length == 0 ? original : interface->snap_length;
        const auto frame = numbers.take(std::min(original, limit));
        if (!numbers.ok()) return damage("a packet is longer than its block");
        take(interface->link, frame, original, summary_.last.value_or(CaptureTime{}));
        return true;
    }

    // --- pcap

    void read_pcap(bool big, bool nanoseconds) {
        std::array<std::uint8_t, 20> header{};
        if (!fill(header)) {
            damage("the file ends in its header");
            return;
        }
        Numbers numbers(header, big);
        numbers.take(16);
        // The upper half says whether there is a frame check sequence.
        const auto link = static_cast<LinkType>(numbers.u32() & 0xFFFF);
        std::array<std::uint8_t, 16> record{};
        for (;;) {
            start_ = offset_;
            if (!fill(record)) {
                if (got_ > 0) damage("the file ends in the header of a packet");
                return;
            }
            if (!read_record(Numbers(record, big), link, nanoseconds)) return;
        }
    }

    bool read_record(Numbers numbers, LinkType link, bool nanoseconds) {
        const std::int64_t seconds = numbers.u32();
        const std::int64_t fraction = numbers.u32();
        const std::size_t captured = numbers.u32();
        const auto original = numbers.u32();
        if (captured > max_packet_octets) return damage(fmt::format("a packet of {} octets cannot be", captured));
        block_.resize(captured);
        if (!fill(block_)) return damage("the file ends in the middle of a packet");
        take(link, block_, original, time_from(nanoseconds ? fraction : fraction * 1000, seconds));
        return true;
    }

    // --- frames

    void take(LinkType link, cip::ByteView frame, std::size_t original, CaptureTime time) {
        ++summary_.packets;
        if (!summary_.first) summary_.first = time;
        summary_.last = std::max(summary_.last.value_or(time), time);
        if (!is_known(link)) {
            ++summary_.unknown_link;
            return;
        }
        CapturedPacket packet;
        packet.time = time;
        switch (read_frame(link, frame, original, packet)) {
            case FrameFault::none:
                each_(packet);
                return;
            case FrameFault::foreign:
                ++summary_.foreign;
                return;
            case FrameFault::fragment:
                ++summary_.fragments;
                return;
            case FrameFault::cut:
                ++summary_.cut;
                return;
            case FrameFault::malformed:
                ++summary_.malformed;
                return;
        }
    }

    std::istream& file_;
    const std::function<void(const CapturedPacket&)>& each_;
    CaptureSummary summary_;
    std::uint64_t start_ = 0;   ///< of the block or record that is being read
    std::uint64_t offset_ = 0;  ///< how much has been read
    std::size_t got_ = 0;
    bool big_ = false;
    std::vector<Interface> interfaces_;
    cip::Bytes block_;
};

}  // namespace

CaptureSummary read_capture(std::istream& file, const std::function<void(const CapturedPacket&)>& each) {
    return CaptureReader(file, each).read();
}

}  // namespace servobus::scanner
