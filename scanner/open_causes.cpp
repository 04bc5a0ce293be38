#include "scanner/open_causes.hpp"

#include <algorithm>
#include <array>

namespace servobus::scanner {
namespace {

constexpr std::string_view see_data_sheet =
    "Compare with the connection entry of the device's EDS file: points, sizes, formats, intervals.";
constexpr std::string_view wait_and_retry = "Wait until the old connection has timed out, or close it, and try again.";
constexpr std::string_view close_others =
    "Close connections that nobody needs, or wait for their timeouts, and try again.";
constexpr std::string_view not_ours =
    "The status belongs to ControlNet or to a controller's backplane: look at the hop that answers, not at the device.";
constexpr std::string_view same_as_producer =
    "Ask for exactly what the running connection to the same point has, or for point-to-point.";

// clang-format off
constexpr auto extended = std::to_array<OpenCause>({
    {0x0100, "A connection with the same serial number, vendor and originator serial number is still open, usually one that was lost without a Forward_Close.", wait_and_retry},
    {0x0103, "The octet of transport class and trigger asks for something that the target does not have; cyclic I/O is 0x01.", "Use class 1 with the cyclic trigger."},
    {0x0106, "Somebody else owns the outputs: another controller, another program on this machine, or an earlier connection that has not timed out yet.", "Close the other owner, or open input only, which any number may do beside an owner."},
    {0x0107, "The target knows no connection with this serial number: it has timed out, or the target was restarted.", "Take it as closed, and open anew."},
    {0x0108, "The connection parameters of a direction make no sense together, often a size of 0 with a type other than null.", see_data_sheet},
    {0x0109, "The size of a direction is wrong; this older code does not say which and does not always say the right one.", see_data_sheet},
    {0x0110, "The target has not been configured yet for the connection that it is asked for.", "Configure the device, or send its configuration data with the open."},
    {0x0111, "The target does not offer the packet interval, for example 0.", "Ask for a usual interval, 10 ms, first."},
    {0x0112, "The packet interval of a direction is outside of what the target accepts.", "Ask for a longer interval first: 10, 20, 100 ms."},
    {0x0113, "All connections of the target are in use, often by connections that were lost and have not timed out yet.", close_others},
    {0x0114, "The electronic key names another vendor or another product code than the device has.", "Read the identity of the device, or leave the key out: --key none."},
    {0x0115, "The electronic key names another device type than the device has.", "Read the identity of the device, or leave the key out: --key none."},
    {0x0116, "The electronic key names a revision that the device does not have and does not emulate.", "Read the identity of the device, or leave the key out: --key none."},
    {0x0117, "The target has none of the connection points for produced or consumed data.", see_data_sheet},
    {0x0118, "The configuration instance does not exist, or does not go with the points.", see_data_sheet},
    {0x0119, "Nobody has opened the data that a listen-only connection would listen to, or not by multicast.", "Let an owner open it by multicast first, or open input only, which needs nobody else."},
    {0x011A, "The connection point has no connection left, often because of connections that have not timed out yet.", close_others},
    {0x011B, "The production inhibit time is longer than the T->O interval.", "Shorten the inhibit time, or leave it out."},
    {0x011C, "The target does not have the transport class; I/O data is class 1, sometimes 0.", "Use class 1."},
    {0x011D, "The target does not have the production trigger; all devices have the cyclic one.", "Use the cyclic trigger."},
    {0x011E, "The direction bit of the transport octet is not what the target expects; for class 1 it is 0.", "Clear bit 7 of the transport octet: 0x01."},
    {0x011F, "O->T is asked with a variable size where the target has a fixed one, or the other way round.", "Ask for the other kind; a fixed size is usual."},
    {0x0120, "T->O is asked with a variable size where the target has a fixed one, or the other way round.", "Ask for the other kind; a fixed size is usual."},
    {0x0121, "The target does not have the priority of O->T; scheduled is usual.", "Use the priority 'scheduled'."},
    {0x0122, "The target does not have the priority of T->O; scheduled is usual.", "Use the priority 'scheduled'."},
    {0x0123, "The target does not have the connection type of O->T; point-to-point is what all devices have.", "Ask for O->T point-to-point."},
    {0x0124, "The target does not have the connection type of T->O: many devices have no multicast, some have nothing else.", "Ask for the other of point-to-point and multicast."},
    {0x0125, "The target does not have redundant owners.", "Clear the redundant owner bit."},
    {0x0126, "The configuration data in the path is longer or shorter than the target wants.", see_data_sheet},
    {0x0127, "The O->T size is not the connection size of that point: data, 4 octets if there is a run/idle header, and 2 for the sequence count.", see_data_sheet},
    {0x0128, "The T->O size is not the connection size of that point: data, 2 octets for the sequence count, and 4 only if T->O has a header.", see_data_sheet},
    {0x0129, "The configuration instance is missing or is not one that the device has.", see_data_sheet},
    {0x012A, "The O->T connection point is not one that the device consumes; perhaps it belongs to the other direction.", see_data_sheet},
    {0x012B, "The T->O connection point is not one that the device produces; perhaps it belongs to the other direction.", see_data_sheet},
    {0x012C, "The configuration symbol in the path does not exist.", "Use numbers, or the names that the controller's program has."},
    {0x012D, "The symbol of the consumed data does not exist.", "Use numbers, or the names that the controller's program has."},
    {0x012E, "The symbol of the produced data does not exist, or is not shared.", "Use numbers, or the names that the controller's program has."},
    {0x012F, "Each point may exist, but they do not go together: another pair, points exchanged, or a missing configuration instance.", see_data_sheet},
    {0x0130, "O->T has another real-time format than the target consumes: a run/idle header too much or too little.", "Change the O->T format: with or without run/idle header, or a heartbeat."},
    {0x0131, "T->O has another real-time format than the target produces: a run/idle header too much or too little.", "Change the T->O format: with or without run/idle header."},
    {0x0132, "Both directions are of the type null, which only asks or configures, and the target does not have that.", "Give each direction a type: point-to-point."},
    {0x0133, "The timeout multiplier is none that the target accepts; the codes are 0 to 7, for 4 to 512.", "Use a usual multiplier, 4 to 32."},
    {0x0134, "The T->O data is already sent to somebody else by multicast with another size.", same_as_producer},
    {0x0135, "The T->O data is already sent to somebody else by multicast, fixed where this asks for variable or the other way round.", same_as_producer},
    {0x0136, "The T->O data is already sent to somebody else by multicast with another priority.", same_as_producer},
    {0x0137, "The T->O data is already sent to somebody else by multicast in another transport class.", same_as_producer},
    {0x0138, "The T->O data is already sent to somebody else by multicast with another trigger.", same_as_producer},
    {0x0139, "The T->O data is already sent to somebody else by multicast with another production inhibit time.", same_as_producer},
    {0x0203, "The connection that the message used has timed out.", "Open it anew, and send often enough."},
    {0x0204, "A node on the way got no answer in time: the device behind the last hop is off, absent, or the route is wrong.", "Check the route hop by hop, and that the device has power and answers by itself."},
    {0x0205, "The Unconnected_Send around the request is malformed: its lengths, its timeout, or its route.", "Check the route; leave it out when the device is reached directly."},
    {0x0206, "The request is too long for a node on the way.", "Shorten the path: no key, no configuration data."},
    {0x0207, "A node on the way has taken the request and got no reply for it.", "Check the device behind the last hop, and try again."},
    {0x0301, "A node has no buffer memory left.", close_others},
    {0x0302, "The network has no bandwidth left for data at this interval.", "Ask for longer intervals, or close other connections."},
    {0x0303, "A node has no filter left for the connection's id.", close_others},
    {0x0304, "A node on the way is not configured to send scheduled data.", not_ours},
    {0x0305, "The schedule of the network was changed and does not fit the request's.", not_ours},
    {0x0306, "A node on the way cannot verify the schedule.", not_ours},
    {0x0311, "A node on the way does not have the port that the route names.", "Check the route: in PORT/LINK, port 1 is the backplane and 2 the network on most controllers."},
    {0x0312, "The link address in the route does not exist behind that port: no such slot, no such node.", "Check the route: in PORT/LINK, the link is a slot number or an address."},
    {0x0315, "The path has a segment that the target does not take: no class, a wrong class, a symbol, hops, or a point that it does not have.", see_data_sheet},
    {0x0316, "The path of a Forward_Close differs from that of the open.", "Close with the same path as was opened, or with the same triad alone."},
    {0x0317, "The connection is to be scheduled and nothing says when.", not_ours},
    {0x0318, "The route leads back to the node itself.", "Leave out the hop that names the node it arrives at."},
    {0x0319, "The secondary of a redundant pair is not available.", "Check the redundant partner."},
    {0x031A, "A connection to the whole rack is open already.", "Close the rack connection before opening one to the module."},
    {0x031B, "A connection to the module is open already.", "Close the connection to the module before."},
    {0x031C, "The target gives no closer reason.", see_data_sheet},
    {0x031D, "The redundant connection does not fit the first one.", "Ask for the same as the first owner has."},
    {0x031E, "The producing module has no room for one more consumer.", "Close another consumer, or ask for multicast."},
    {0x031F, "The producing module has no consumers configured.", "Configure consumers in the producing controller: for example its produced tag."},
    {0x0800, "The network behind a node is offline.", "Check cable and power of the network behind the last hop that answers."},
    {0x0801, "The data is already sent by multicast at an interval that does not go with this one.", "Ask for the running interval, or for point-to-point."},
    {0x0810, "The target has no data for the connection yet, for example because it is still starting.", "Wait until the device has started, and try again."},
    {0x0811, "The originator has no data for the connection.", "Let the originator's program supply its outputs first."},
    {0x0812, "A node's address has changed since the network was scheduled.", not_ours},
    {0x0813, "The originator is in another subnet, and the target does not send multicast beyond its own.", "Ask for T->O point-to-point."},
    {0x0814, "The format of the consumed or produced data is not one that the target has.", "Change the formats: with or without run/idle header."},
    {0xFFFF, "The extended status is none that the standard names; its meaning is the maker's.", "Look it up in the device's manual."},
});

constexpr auto general = std::to_array<OpenCause>({
    {0x01, "The target gives no extended status, so only the request itself can show what is wrong.", see_data_sheet},
    {0x02, "The target or a node on the way has no connection or memory left.", close_others},
    {0x03, "The target dislikes a parameter and does not say which.", see_data_sheet},
    {0x04, "The path has a segment that the target cannot read.", see_data_sheet},
    {0x05, "The target has no such object: no Connection Manager where the request went, or no such point in its path.", see_data_sheet},
    {0x08, "The target does not have this service.", "Use Forward_Open, not the large form; if it was the small one, the node has no I/O connections, or is another than you think."},
    {0x09, "The target dislikes a value in the request and does not say which.", see_data_sheet},
    {0x0C, "The target is in a state in which it takes no connections, for example while it is being configured.", "Bring the device out of that state, and try again."},
    {0x0E, "What the path names cannot be written.", see_data_sheet},
    {0x0F, "The target does not let this node do it: an address filter, a lock, or a keyswitch.", "Check access lists and locks of the device; a Forward_Close has to come from the address that opened."},
    {0x10, "The target is in a state in which it takes no connection: starting, faulted, in a firmware update, or operated locally.", "Look at the device's status and its lamps, and try again."},
    {0x11, "The reply would be too long for the way back.", "Ask without a route, or over an unconnected message."},
    {0x13, "The request ends before its path does: the path size, in words, is larger than what follows.", "Count the path in words of two octets, and pad odd segments."},
    {0x14, "The path names an attribute, or a point is taken for one.", see_data_sheet},
    {0x15, "There are octets behind the path: the path size, in words, is smaller than what follows.", "Count the path in words of two octets, and do not count the reserved octet of Forward_Close."},
    {0x16, "What the path names does not exist.", see_data_sheet},
    {0x1A, "The request is too long for a node on the way.", "Shorten the path: no key, no configuration data."},
    {0x1B, "The reply is too long for a node on the way.", "Ask without a route."},
    {0x1E, "A request inside the request was refused.", "Send the Forward_Open by itself, not in a Multiple_Service_Packet."},
    {0x1F, "The maker of the device has a reason of its own.", "Look the extended status up in the device's manual."},
    {0x20, "The target dislikes a parameter of the service and does not say which.", see_data_sheet},
    {0x25, "The electronic key in the path does not fit the device.", "Read the identity of the device, or leave the key out: --key none."},
    {0x26, "The path size does not go with the path: it counts words of two octets.", "Count the path in words of two octets, and pad odd segments."},
    {0x2E, "The target has the service, but not for what the path of the request names.", "Send Forward_Open to the Connection Manager: 20 06 24 01."},
    {0xFF, "The status is none that a Forward_Open usually gets.", "Look it up in the device's manual."},
});
// clang-format on

static_assert(std::ranges::is_sorted(extended, {}, &OpenCause::code));
static_assert(std::ranges::is_sorted(general, {}, &OpenCause::code));

const OpenCause& find(std::span<const OpenCause> table, std::uint16_t code) {
    const auto found = std::ranges::find(table, code, &OpenCause::code);
    return found != table.end() ? *found : table.back();
}

}  // namespace

std::span<const OpenCause> extended_causes() { return extended; }
std::span<const OpenCause> general_causes() { return general; }

const OpenCause& open_cause(const cip::Status& status) {
    if (status.general == cip::GeneralStatus::connection_failure && !status.extended.empty()) {
        return find(extended, status.extended.front());
    }
    return find(general, static_cast<std::uint16_t>(status.general));
}

bool may_pass(const cip::Status& status) {
    constexpr std::array words{0x0100, 0x0106, 0x0113, 0x011A};
    if (status.general != cip::GeneralStatus::connection_failure || status.extended.empty()) return false;
    return std::ranges::find(words, status.extended.front()) != words.end();
}

}  // namespace servobus::scanner
