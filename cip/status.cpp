#include "cip/status.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace servobus::cip {
namespace {

using ByteText = std::pair<std::uint8_t, std::string_view>;
using WordText = std::pair<std::uint16_t, std::string_view>;

constexpr auto general_texts = std::to_array<ByteText>({
    {0x00, "success"},
    {0x01, "connection failure"},
    {0x02, "resource unavailable"},
    {0x03, "invalid parameter value"},
    {0x04, "path segment error"},
    {0x05, "path destination unknown"},
    {0x06, "partial transfer"},
    {0x07, "connection lost"},
    {0x08, "service not supported"},
    {0x09, "invalid attribute value"},
    {0x0A, "attribute list error"},
    {0x0B, "already in requested mode or state"},
    {0x0C, "object state conflict"},
    {0x0D, "object already exists"},
    {0x0E, "attribute not settable"},
    {0x0F, "privilege violation"},
    {0x10, "device state conflict"},
    {0x11, "reply data too large"},
    {0x12, "fragmentation of a primitive value"},
    {0x13, "not enough data"},
    {0x14, "attribute not supported"},
    {0x15, "too much data"},
    {0x16, "object does not exist"},
    {0x17, "no fragmentation sequence in progress"},
    {0x18, "no stored attribute data"},
    {0x19, "store operation failure"},
    {0x1A, "routing failure, request packet too large"},
    {0x1B, "routing failure, reply packet too large"},
    {0x1C, "missing attribute list entry data"},
    {0x1D, "invalid attribute value list"},
    {0x1E, "embedded service error"},
    {0x1F, "vendor specific error"},
    {0x20, "invalid parameter"},
    {0x21, "write-once value already written"},
    {0x22, "invalid reply received"},
    {0x23, "buffer overflow"},
    {0x24, "invalid message format"},
    {0x25, "key failure in path"},
    {0x26, "path size invalid"},
    {0x27, "unexpected attribute in list"},
    {0x28, "invalid member id"},
    {0x29, "member not settable"},
    {0x2A, "group 2 only server general failure"},
    {0x2B, "unknown Modbus error"},
    {0x2C, "attribute not gettable"},
    {0x2D, "instance not deletable"},
    {0x2E, "service not supported for the specified path"},
});

constexpr auto connection_texts = std::to_array<WordText>({
    {0x0100, "connection in use or duplicate Forward_Open"},
    {0x0103, "transport class and trigger combination not supported"},
    {0x0106, "ownership conflict"},
    {0x0107, "target connection not found"},
    {0x0108, "invalid network connection parameter"},
    {0x0109, "invalid connection size"},
    {0x0110, "target for connection not configured"},
    {0x0111, "RPI not supported"},
    {0x0112, "RPI values not acceptable"},
    {0x0113, "out of connections"},
    {0x0114, "vendor id or product code mismatch"},
    {0x0115, "device type mismatch"},
    {0x0116, "revision mismatch"},
    {0x0117, "invalid produced or consumed application path"},
    {0x0118, "invalid or inconsistent configuration application path"},
    {0x0119, "non-listen-only connection not opened"},
    {0x011A, "target object out of connections"},
    {0x011B, "RPI smaller than the production inhibit time"},
    {0x011C, "transport class not supported"},
    {0x011D, "production trigger not supported"},
    {0x011E, "direction not supported"},
    {0x011F, "invalid O->T fixed or variable flag"},
    {0x0120, "invalid T->O fixed or variable flag"},
    {0x0121, "invalid O->T priority"},
    {0x0122, "invalid T->O priority"},
    {0x0123, "invalid O->T connection type"},
    {0x0124, "invalid T->O connection type"},
    {0x0125, "invalid O->T redundant owner flag"},
    {0x0126, "invalid configuration size"},
    {0x0127, "invalid O->T size"},
    {0x0128, "invalid T->O size"},
    {0x0129, "invalid configuration application path"},
    {0x012A, "invalid consuming application path"},
    {0x012B, "invalid producing application path"},
    {0x012C, "configuration symbol does not exist"},
    {0x012D, "consuming symbol does not exist"},
    {0x012E, "producing symbol does not exist"},
    {0x012F, "inconsistent application path combination"},
    {0x0130, "inconsistent consume data format"},
    {0x0131, "inconsistent produce data format"},
    {0x0132, "null Forward_Open not supported"},
    {0x0133, "connection timeout multiplier not acceptable"},
    {0x0134, "mismatched T->O size with the running producer"},
    {0x0135, "mismatched T->O fixed or variable flag with the running producer"},
    {0x0136, "mismatched T->O priority with the running producer"},
    {0x0137, "mismatched transport class with the running producer"},
    {0x0138, "mismatched T->O production trigger with the running producer"},
    {0x0139, "mismatched T->O production inhibit time with the running producer"},
    {0x0203, "connection timed out"},
    {0x0204, "unconnected request timed out"},
    {0x0205, "parameter error in unconnected request"},
    {0x0206, "message too large for unconnected send"},
    {0x0207, "unconnected acknowledged without reply"},
    {0x0301, "no buffer memory available"},
    {0x0302, "network bandwidth not available for data"},
    {0x0303, "no consumed connection id filter available"},
    {0x0304, "not configured to send scheduled priority data"},
    {0x0305, "schedule signature mismatch"},
    {0x0306, "schedule signature validation not possible"},
    {0x0311, "port not available"},
    {0x0312, "link address not valid"},
    {0x0315, "invalid segment in connection path"},
    {0x0316, "Forward_Close connection path mismatch"},
    {0x0317, "scheduling not specified"},
    {0x0318, "link address to self invalid"},
    {0x0319, "secondary resource unavailable"},
    {0x031A, "rack connection already established"},
    {0x031B, "module connection already established"},
    {0x031C, "miscellaneous"},
    {0x031D, "redundant connection mismatch"},
    {0x031E, "no more user-configurable link consumer resources in the producing module"},
    {0x031F, "no user-configurable link consumer resources configured in the producing module"},
    {0x0800, "network link offline"},
    {0x0801, "incompatible multicast RPI"},
    {0x0810, "no target application data available"},
    {0x0811, "no originator application data available"},
    {0x0812, "node address has changed since the network was scheduled"},
    {0x0813, "not configured for off-subnet multicast"},
    {0x0814, "invalid produce or consume data format"},
});

static_assert(std::ranges::is_sorted(general_texts, {}, &ByteText::first));
static_assert(std::ranges::is_sorted(connection_texts, {}, &WordText::first));

template <class Entry, class Code>
std::string_view find_text(std::span<const Entry> table, Code code) {
    const auto found = std::ranges::lower_bound(table, code, {}, &Entry::first);
    return found != table.end() && found->first == code ? found->second : std::string_view{};
}

}  // namespace

std::string_view text(GeneralStatus code) {
    const auto value = static_cast<std::uint8_t>(code);
    const auto known = find_text(std::span<const ByteText>(general_texts), value);
    if (!known.empty()) return known;
    return value >= 0xD0 ? "object class specific error" : "reserved";
}

std::string_view extended_text(GeneralStatus general, std::uint16_t word) {
    if (general == GeneralStatus::connection_failure) {
        const auto known = find_text(std::span<const WordText>(connection_texts), word);
        // The rest of this range is CIP Safety's, which nothing here speaks.
        return known.empty() && word > 0x0801 && word < 0x0810 ? "safety connection error" : known;
    }
    if (general == GeneralStatus::vendor_specific && word == drive_refuses) {
        return "the drive does not allow this access in its present configuration";
    }
    return {};
}

std::string describe(const Status& status) {
    auto line = fmt::format("0x{:02X} {}", static_cast<unsigned>(status.general), text(status.general));
    if (status.extended.empty()) return line;
    const auto known = extended_text(status.general, status.extended.front());
    line += known.empty() ? fmt::format(", extended 0x{:04X}", status.extended.front())
                          : fmt::format(", 0x{:04X} {}", status.extended.front(), known);
    for (std::size_t i = 1; i < status.extended.size(); ++i) line += fmt::format(" 0x{:04X}", status.extended[i]);
    return line;
}

}  // namespace servobus::cip
