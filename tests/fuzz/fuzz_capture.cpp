// Captures, pcapng and pcap, and what the doctor makes of them.
#include <sstream>
#include <string>

#include "scanner/capture.hpp"
#include "scanner/capture_file.hpp"
#include "scanner/connection_path.hpp"
#include "scanner/open_doctor.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using namespace scanner;
using test::require;

void check(const Diagnosis& diagnosis) { require(!diagnosis.summary.empty(), "a diagnosis has a summary"); }

IoTraffic traffic_of(const CapturedOpen& open) {
    IoTraffic traffic;
    traffic.o_to_t_api = open.reply->o_to_t_api;
    traffic.t_to_o_api = open.reply->t_to_o_api;
    traffic.o_to_t.packets = open.o_to_t.packets;
    traffic.t_to_o.packets = open.t_to_o.packets;
    traffic.t_to_o.lost = open.t_to_o.statistics.counters().lost;
    traffic.t_to_o.longest_interval = open.t_to_o.statistics.longest_silence();
    traffic.receiver = open.expected_receiver();
    traffic.closed = open.closing.has_value();
    return traffic;
}

void examine(const CapturedOpen& open, const Conversation& conversation) {
    OpenQuestion question;
    question.request = open.request;
    if (const auto* identity = conversation.identity(open.target.address)) question.identity = *identity;
    if (auto route = cip::Path::parse(open.route)) question.route = *std::move(route);
    if (open.encapsulation_status) {
        check(diagnose_refusal(question, *open.encapsulation_status));
    } else if (!open.answered) {
        check(diagnose_silence(question));
    } else if (!open.status.ok()) {
        check(diagnose_refusal(question, open.status));
    } else if (!open.granted() || !open.request) {
        check(diagnose_bad_reply(question));
    } else {
        check(diagnose_traffic(question, traffic_of(open)));
    }
    if (open.request) (void)ConnectionPath::read(open.request->path).oddities();
    require(open.o_to_t.sizes.size() <= CapturedFlow::max_sizes &&
                open.t_to_o.destinations.size() <= CapturedFlow::max_destinations,
            "what is counted of a flow is bounded");
}

}  // namespace

void capture(cip::ByteView input) {
    std::istringstream file(std::string(input.begin(), input.end()));
    Conversation conversation;
    std::uint64_t handed = 0;
    const auto summary = read_capture(file, [&](const CapturedPacket& packet) {
        ++handed;
        require(packet.payload.size() <= input.size(), "a payload is in the file", input);
        conversation.take(packet);
    });
    conversation.finish();
    // The smallest record of either format has 16 octets.
    require(summary.packets * 16 <= input.size(), "every packet is in the file", input);
    require(handed + summary.foreign + summary.fragments + summary.malformed + summary.unknown_link <=
                summary.packets + summary.cut,
            "every packet is counted once", input);
    if (summary.damage) {
        require(summary.damage->offset <= input.size() && !summary.damage->text.empty(), "damage is in the file",
                input);
    }
    require(conversation.opens().size() <= Conversation::max_opens, "opens are bounded", input);
    for (const auto& open : conversation.opens()) examine(open, conversation);
    (void)conversation.tcp();
}

}  // namespace servobus::fuzz
