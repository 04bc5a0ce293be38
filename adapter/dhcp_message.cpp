#include "adapter/dhcp_message.hpp"

#include <algorithm>
#include <array>

#include "cip/wire.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint8_t ethernet = 1;
constexpr std::uint8_t mac_octets = 6;
constexpr std::size_t mac_padding = 10;
constexpr std::size_t name_octets = 64;
constexpr std::size_t file_octets = 128;
constexpr std::uint32_t magic_cookie = 0x63825363;
constexpr std::size_t shortest_message = 300;  // RFC 1542, 2.1

// Option 52 says which of these fields hold options.
constexpr std::uint8_t options_in_file = 1;
constexpr std::uint8_t options_in_name = 2;

void describe_header(auto& io, auto& message) {
    io.big_endian_field(message.transaction);
    io.big_endian_field(message.seconds);
    io.big_endian_field(message.flags);
    io.big_endian_field(message.client_address);
    io.big_endian_field(message.your_address);
    io.big_endian_field(message.server_address);
    io.big_endian_field(message.gateway_address);
    io.field(message.client_mac);
    io.reserved(mac_padding);
}

// Parts of one option are put together (RFC 3396). False: an option is cut off.
bool read_options(cip::ByteView octets, std::map<DhcpOption, cip::Bytes>& options) {
    cip::Reader reader(octets);
    while (reader.remaining() > 0) {
        const auto option = reader.little<DhcpOption>();
        if (option == DhcpOption::end) return true;
        if (option == DhcpOption::pad) continue;
        const auto value = reader.take(reader.u8());
        if (!reader.ok()) return false;
        auto& whole = options[option];
        whole.insert(whole.end(), value.begin(), value.end());
    }
    return true;
}

bool has_its_length(DhcpOption option, std::size_t size) {
    switch (option) {
        case DhcpOption::overload:
        case DhcpOption::message_type:
            return size == 1;
        case DhcpOption::subnet_mask:
        case DhcpOption::requested_address:
        case DhcpOption::lease_time:
        case DhcpOption::server_identifier:
        case DhcpOption::renewal_time:
        case DhcpOption::rebinding_time:
            return size == 4;
        case DhcpOption::router:
        case DhcpOption::name_server:
            return size != 0 && size % 4 == 0;
        default:
            return true;
    }
}

}  // namespace

cip::Bytes DhcpMessage::encode() const {
    cip::Bytes octets;
    cip::Writer writer(octets);
    writer.field(operation);
    writer.u8(ethernet);
    writer.u8(mac_octets);
    writer.u8(0);  // hops
    describe_header(writer, *this);
    writer.zeros(name_octets + file_octets);
    writer.big(magic_cookie);
    // The type first: some servers look for it there.
    const auto write = [&](DhcpOption option, cip::ByteView value) {
        writer.field(option);
        writer.u8(static_cast<std::uint8_t>(value.size()));
        writer.bytes(value);
    };
    const auto first = options.find(DhcpOption::message_type);
    if (first != options.end()) write(first->first, first->second);
    for (const auto& [option, value] : options) {
        if (option != DhcpOption::message_type) write(option, value);
    }
    writer.field(DhcpOption::end);
    if (octets.size() < shortest_message) octets.resize(shortest_message);
    return octets;
}

cip::Decoded<DhcpMessage> DhcpMessage::parse(cip::ByteView octets) {
    if (octets.size() > max_dhcp_octets) return cip::DecodeError::too_many;
    cip::Reader reader(octets);
    DhcpMessage message;
    reader.field(message.operation);
    const bool for_ethernet = reader.u8() == ethernet && reader.u8() == mac_octets;
    reader.u8();
    describe_header(reader, message);
    const auto name = reader.take(name_octets);
    const auto file = reader.take(file_octets);
    if (!reader.ok()) return cip::DecodeError::truncated;
    const bool known = message.operation == Operation::request || message.operation == Operation::reply;
    if (!for_ethernet || !known) return cip::DecodeError::bad_value;
    if (reader.remaining() < sizeof magic_cookie || reader.big<std::uint32_t>() != magic_cookie) return message;
    auto& options = message.options;
    if (!read_options(reader.rest(), options)) return cip::DecodeError::truncated;
    if (const auto overload = options.find(DhcpOption::overload); overload != options.end()) {
        if (overload->second.size() != 1) return cip::DecodeError::bad_length;
        const auto where = overload->second.front();
        if (where == 0 || where > (options_in_file | options_in_name)) return cip::DecodeError::bad_value;
        if ((where & options_in_file) != 0 && !read_options(file, options)) return cip::DecodeError::truncated;
        if ((where & options_in_name) != 0 && !read_options(name, options)) return cip::DecodeError::truncated;
    }
    const auto fits = [](const auto& entry) { return has_its_length(entry.first, entry.second.size()); };
    if (!std::ranges::all_of(options, fits)) return cip::DecodeError::bad_length;
    return message;
}

void DhcpMessage::add(DhcpOption option, std::uint32_t value) {
    cip::Bytes octets;
    cip::Writer(octets).big(value);
    add(option, std::move(octets));
}

void DhcpMessage::add(DhcpOption option, const std::string& text) { add(option, cip::Bytes(text.begin(), text.end())); }

std::optional<DhcpType> DhcpMessage::type() const {
    const auto found = options.find(DhcpOption::message_type);
    if (found == options.end()) return std::nullopt;
    const auto type = static_cast<DhcpType>(found->second.front());
    return type >= DhcpType::discover && type <= DhcpType::inform ? std::optional(type) : std::nullopt;
}

std::optional<std::uint32_t> DhcpMessage::number(DhcpOption option) const {
    const auto all = addresses(option);
    return all.empty() ? std::nullopt : std::optional(all.front());
}

std::vector<std::uint32_t> DhcpMessage::addresses(DhcpOption option) const {
    std::vector<std::uint32_t> all;
    const auto found = options.find(option);
    if (found == options.end()) return all;
    cip::Reader reader(found->second);
    while (reader.remaining() >= sizeof(std::uint32_t)) all.push_back(reader.big<std::uint32_t>());
    return all;
}

std::string DhcpMessage::text(DhcpOption option) const {
    const auto found = options.find(option);
    if (found == options.end()) return {};
    const auto& octets = found->second;
    return {octets.begin(), std::ranges::find(octets, std::uint8_t{0})};
}

}  // namespace servobus::adapter
