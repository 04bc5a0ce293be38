#include "adapter/attribute_names.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "drive/lookup.hpp"
#include "drive/xenax.hpp"

namespace servobus::adapter {
namespace {

struct Name {
    std::uint32_t class_id;
    std::uint32_t attribute;
    std::string_view text;
};

// Those of the standard objects that can be set (R-ASM, R-CM-2, R-TCP, R-ETH, R-QOS-2, R-TSY-1).
constexpr auto names = std::to_array<Name>({
    {0x04, 3, "Assembly.Data"},
    {0x06, 1, "Connection Manager.Open Requests"},
    {0x06, 2, "Connection Manager.Open Format Rejects"},
    {0x06, 3, "Connection Manager.Open Resource Rejects"},
    {0x06, 4, "Connection Manager.Open Other Rejects"},
    {0x06, 5, "Connection Manager.Close Requests"},
    {0x06, 6, "Connection Manager.Close Format Requests"},
    {0x06, 7, "Connection Manager.Close Other Requests"},
    {0x06, 8, "Connection Manager.Connection Timeouts"},
    {0x43, 1, "Time Sync.PTPEnable"},
    {0x43, 6, "Time Sync.MaxOffsetFromMaster"},
    {0x48, 1, "QoS.802.1Q Tag Enable"},
    {0x48, 2, "QoS.DSCP PTP Event"},
    {0x48, 3, "QoS.DSCP PTP General"},
    {0x48, 4, "QoS.DSCP Urgent"},
    {0x48, 5, "QoS.DSCP Scheduled"},
    {0x48, 6, "QoS.DSCP High"},
    {0x48, 7, "QoS.DSCP Low"},
    {0x48, 8, "QoS.DSCP Explicit"},
    {0xF5, 3, "TCP/IP Interface.Configuration Control"},
    {0xF5, 5, "TCP/IP Interface.Interface Configuration"},
    {0xF5, 6, "TCP/IP Interface.Host Name"},
    {0xF5, 10, "TCP/IP Interface.SelectAcd"},
    {0xF5, 11, "TCP/IP Interface.LastConflictDetected"},
    {0xF5, 13, "TCP/IP Interface.Encapsulation Inactivity Timeout"},
    {0xF6, 6, "Ethernet Link.Interface Control"},
});

}  // namespace

std::string attribute_name(const drive::Device& device, std::uint32_t class_id, std::uint32_t attribute) {
    if (class_id <= 0xFFFF && attribute <= 0xFFFF) {
        const auto* row = device.find({static_cast<std::uint16_t>(class_id), static_cast<std::uint16_t>(attribute)});
        if (row != nullptr) return drive::qualified_name(drive::parameter_classes(), *row);
    }
    const auto found = std::ranges::find_if(
        names, [&](const Name& name) { return name.class_id == class_id && name.attribute == attribute; });
    return found != names.end() ? std::string(found->text) : std::string();
}

}  // namespace servobus::adapter
