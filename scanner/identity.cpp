#include "scanner/identity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "cip/strings.hpp"
#include "cip/wire.hpp"

namespace servobus::scanner {
namespace {

using Named = std::pair<std::uint16_t, std::string_view>;

constexpr auto vendors = std::to_array<Named>({
    {1, "Rockwell Automation"},
    {5, "Rockwell Automation"},
    {7, "SMC"},
    {8, "Molex"},
    {26, "Festo"},
    {40, "WAGO"},
    {44, "Yaskawa"},
    {47, "Omron"},
    {48, "Turck"},
    {68, "Eaton"},
    {90, "HMS Networks"},
    {108, "Beckhoff"},
    {243, "Schneider Electric"},
    {256, "Turck"},
    {283, "Hilscher"},
    {367, "Keyence"},
    {562, "Phoenix Contact"},
    {678, "Cognex"},
    {808, "SICK"},
    {1389, "Jenny Science AG"},
});

constexpr auto device_types = std::to_array<Named>({
    {0x00, "generic device"},
    {0x02, "AC drive"},
    {0x03, "motor overload"},
    {0x06, "photoelectric sensor"},
    {0x07, "general purpose discrete I/O"},
    {0x0C, "communications adapter"},
    {0x0E, "programmable logic controller"},
    {0x10, "position controller"},
    {0x13, "DC drive"},
    {0x16, "motor starter"},
    {0x17, "soft start"},
    {0x18, "human-machine interface"},
    {0x1A, "mass flow controller"},
    {0x1B, "pneumatic valve"},
    {0x22, "encoder"},
    {0x23, "safety discrete I/O"},
    {0x25, "CIP motion drive"},
    {0x2B, "generic device"},
    {0x2C, "managed Ethernet switch"},
    {0x2D, "CIP motion safety drive"},
    {0x2E, "safety drive"},
    {0x2F, "CIP motion encoder"},
    {0x31, "CIP motion I/O"},
    {0xC8, "embedded component"},
});

std::string_view find_name(std::span<const Named> names, std::uint16_t number) {
    const auto found = std::ranges::find(names, number, &Named::first);
    return found != names.end() ? found->second : std::string_view{};
}

/// Bits 4 to 7 of the status (R-ID-4).
constexpr std::array<std::string_view, 8> extended_statuses{
    "self test or unknown",
    "firmware update",
    "an I/O connection has timed out",
    "no I/O connection",
    "configuration lost",
    "major fault",
    "I/O runs",
    "I/O idle",
};

constexpr std::array<std::string_view, 6> states{
    "non-existent", "self testing", "standby", "operational", "major recoverable fault", "major unrecoverable fault",
};

void read_attribute(cip::Reader& reader, Identity& identity, std::uint32_t attribute) {
    switch (attribute) {
        case 1:
            reader.field(identity.vendor);
            break;
        case 2:
            reader.field(identity.device_type);
            break;
        case 3:
            reader.field(identity.product_code);
            break;
        case 4:
            reader.field(identity.major_revision);
            reader.field(identity.minor_revision);
            break;
        case 5:
            reader.field(identity.status);
            break;
        case 6:
            reader.field(identity.serial_number);
            break;
        case 7:
            identity.product_name = cip::read_short_string(reader);
            break;
        case 8:
            identity.state = reader.u8();
            break;
        default:
            break;
    }
}

std::string named(std::uint16_t number, std::string_view name) {
    return name.empty() ? fmt::format("{}", number) : fmt::format("{} ({})", number, name);
}

}  // namespace

Identity identity_of(const enip::IdentityItem& item) {
    constexpr std::uint8_t not_implemented = 0xFF;
    Identity identity{.vendor = item.vendor,
                      .device_type = item.device_type,
                      .product_code = item.product_code,
                      .major_revision = item.major_revision,
                      .minor_revision = item.minor_revision,
                      .status = item.status,
                      .serial_number = item.serial_number,
                      .product_name = item.product_name};
    if (item.state != not_implemented) identity.state = item.state;
    return identity;
}

bool set_attribute(Identity& identity, std::uint32_t attribute, cip::ByteView value) {
    if (attribute < first_identity_attribute || attribute > identity_state_attribute) return false;
    cip::Reader reader(value);
    auto changed = identity;
    read_attribute(reader, changed, attribute);
    if (reader.ok()) identity = std::move(changed);
    return reader.ok();
}

std::optional<Identity> read_identity(cip::ByteView attributes_all) {
    cip::Reader reader(attributes_all);
    Identity identity;
    for (std::uint32_t id = first_identity_attribute; id <= last_required_identity_attribute; ++id) {
        read_attribute(reader, identity, id);
    }
    if (!reader.ok()) return std::nullopt;
    if (reader.remaining() > 0) read_attribute(reader, identity, identity_state_attribute);
    return identity;
}

std::string describe_identity_attribute(std::uint32_t attribute, cip::ByteView value) {
    Identity identity;
    if (!set_attribute(identity, attribute, value)) return {};
    switch (attribute) {
        case 1:
            return "vendor " + named(identity.vendor, vendor_name(identity.vendor));
        case 2:
            return "device type " + named(identity.device_type, device_type_name(identity.device_type));
        case 3:
            return fmt::format("product code {} (0x{:04X})", identity.product_code, identity.product_code);
        case 4:
            return fmt::format("revision {}.{}", identity.major_revision, identity.minor_revision);
        case 5:
            return fmt::format("status 0x{:04X} ({})", identity.status, status_text(identity.status));
        case 6:
            return fmt::format("serial number 0x{:08X}", identity.serial_number);
        case 7:
            return fmt::format("product name {}", identity.product_name);
        default:
            return fmt::format("state {} ({})", *identity.state, state_text(*identity.state));
    }
}

std::string_view vendor_name(std::uint16_t vendor) { return find_name(vendors, vendor); }

std::string_view device_type_name(std::uint16_t device_type) { return find_name(device_types, device_type); }

std::string status_text(std::uint16_t status) {
    static constexpr auto bits = std::to_array<Named>({
        {0x0001, "owned"},
        {0x0004, "configured"},
        {0x0100, "minor recoverable fault"},
        {0x0200, "minor unrecoverable fault"},
        {0x0400, "major recoverable fault"},
        {0x0800, "major unrecoverable fault"},
    });
    std::string text;
    for (const auto& [bit, name] : bits) {
        if ((status & bit) != 0) text += std::string(name) + ", ";
    }
    const auto extended = static_cast<std::size_t>(status >> 4 & 0x0F);
    return text + (extended < extended_statuses.size() ? std::string(extended_statuses[extended])
                                                       : fmt::format("vendor's status {}", extended));
}

std::string_view state_text(std::uint8_t state) { return state < states.size() ? states[state] : "unknown"; }

}  // namespace servobus::scanner
