// The part of the doctor that looks at a connection which was granted.
#include <fmt/format.h>

#include <algorithm>

#include "scanner/connection_path.hpp"
#include "scanner/open_doctor.hpp"
#include "scanner/open_terms.hpp"

namespace servobus::scanner {
namespace {

using std::chrono::microseconds;
using std::chrono::nanoseconds;

class TrafficDoctor {
public:
    TrafficDoctor(const OpenQuestion& question, const IoTraffic& traffic) : question_(question), traffic_(traffic) {
        if (!question.request) return;
        path_ = ConnectionPath::read(question.request->path);
        diagnosis_.asked = asked_text(*question.request, path_);
        code_ = std::min<std::uint8_t>(question.request->timeout_multiplier, 7);
    }

    Diagnosis diagnosis() && {
        for (const bool o_to_t : {false, true}) look_at(o_to_t);
        note_losses();
        diagnosis_.well = summary_.empty();
        diagnosis_.summary = diagnosis_.well ? "granted, and data flows" : "granted, but " + summary_;
        if (!diagnosis_.well) diagnosis_.may_pass = true;
        return std::move(diagnosis_);
    }

private:
    [[nodiscard]] const IoTraffic::Direction& direction(bool o_to_t) const {
        return o_to_t ? traffic_.o_to_t : traffic_.t_to_o;
    }
    [[nodiscard]] bool exists(bool o_to_t) const {
        if (!question_.request) return true;
        const auto& parameters = o_to_t ? question_.request->o_to_t : question_.request->t_to_o;
        return parameters.type != cip::ConnectionType::null;
    }
    [[nodiscard]] microseconds interval(bool o_to_t) const {
        return microseconds(o_to_t ? traffic_.o_to_t_api : traffic_.t_to_o_api);
    }
    [[nodiscard]] nanoseconds timeout(bool o_to_t) const { return enip::connection_timeout(interval(o_to_t), code_); }

    void trouble(std::string what) {
        if (summary_.empty()) summary_ = std::move(what);
    }
    void find(std::string sentence) { diagnosis_.findings.push_back(std::move(sentence)); }
    void suspect(std::string sentence) { diagnosis_.causes.push_back(std::move(sentence)); }
    void advise(std::string sentence) { diagnosis_.next.push_back(std::move(sentence)); }

    void look_at(bool o_to_t) {
        if (!exists(o_to_t)) return;
        const auto& seen = direction(o_to_t);
        if (seen.packets == 0) {
            o_to_t ? nothing_sent() : nothing_received();
            return;
        }
        if (seen.elsewhere) look_elsewhere(o_to_t, *seen.elsewhere);
        if (seen.other_size) look_at_size(o_to_t, seen);
        if (!traffic_.closed && seen.silent > timeout(o_to_t) && timeout(o_to_t).count() > 0) went_silent(o_to_t, seen);
        if (seen.always_idle) idle(o_to_t);
    }

    void nothing_received() {
        trouble("no T->O datagram came");
        find(fmt::format("No T->O datagram was seen in {}; one is due every {}.", duration_text(traffic_.observed),
                         duration_text(interval(false))));
        if (traffic_.observed < interval(false)) {
            suspect("What was seen ends before the first one was due.");
            return;
        }
        if (enip::is_multicast(traffic_.receiver.address)) {
            suspect(
                fmt::format("The multicast to {} does not arrive: IGMP snooping in a switch without a querier, or the "
                            "group was joined on another interface.",
                            enip::to_string(traffic_.receiver)));
            suspect(fmt::format("A firewall on the originator drops UDP to port {}.", traffic_.receiver.port));
            advise("Try point-to-point, without --multicast.");
        } else {
            suspect(fmt::format("A firewall on the originator drops UDP to port {}, or on the way between.",
                                traffic_.receiver.port));
            suspect(
                "The target sends to another address or port than the originator listens at: its gateway or mask is "
                "wrong, or it ignores the sockaddr item and always takes port 2222.");
        }
        if (traffic_.o_to_t.packets == 0 && exists(true)) {
            suspect("The originator sends nothing either, and some targets wait for it.");
        }
        advise("Look with Wireshark at the originator, filter enip or udp.port == 2222, whether they arrive there.");
    }

    void nothing_sent() {
        trouble("the originator sends nothing");
        find(fmt::format("No O->T datagram was seen in {}; the target ends the connection after {}.",
                         duration_text(traffic_.observed),
                         duration_text(std::max<nanoseconds>(timeout(true), enip::first_packet_patience))));
        suspect("The originator's program does not produce, or waits for T->O first; it has to start by itself.");
        suspect("The capture was taken where O->T does not pass by.");
        advise("Let the originator send at its interval at once after the reply, idle when there is no data yet.");
    }

    void look_elsewhere(bool o_to_t, enip::Endpoint where) {
        if (o_to_t) {
            find(fmt::format("O->T goes to {}, which is not where the target listens.", enip::to_string(where)));
            trouble("O->T goes to another place than the target named");
            suspect("The originator ignores the sockaddr item of the reply, or sends to another device.");
            return;
        }
        find(fmt::format("T->O goes to {} instead of {}.", enip::to_string(where), enip::to_string(traffic_.receiver)));
        trouble(
            fmt::format("T->O goes to {} instead of {}", enip::to_string(where), enip::to_string(traffic_.receiver)));
        suspect("The target ignores the sockaddr item of the request and sends to its usual port.");
        suspect("The originator names a port in the item at which it does not listen.");
        advise("Let the originator listen at UDP 2222, and stop other programs that use this port.");
    }

    void look_at_size(bool o_to_t, const IoTraffic::Direction& seen) {
        if (!question_.request) return;
        const std::size_t size = o_to_t ? question_.request->o_to_t.size : question_.request->t_to_o.size;
        const auto* name = o_to_t ? "O->T" : "T->O";
        if (seen.other_size_packets == 0 || variable(o_to_t, *seen.other_size)) return;
        find(fmt::format("{} of {} {} datagrams have {} octets; the connection's size is {}.", seen.other_size_packets,
                         seen.packets, name, *seen.other_size, size));
        trouble(fmt::format("{} datagrams have {} octets and not {}", name, *seen.other_size, size));
        // Here the size on the wire is what somebody counted, and the connection's is right.
        for (auto& cause : size_causes({o_to_t, *seen.other_size, size, {}, {}})) {
            if (cause.starts_with("You ")) cause = "The sender" + cause.substr(3);
            suspect(std::move(cause));
        }
        advise(fmt::format("The receiver drops datagrams of another size; let the {} send {} octets.",
                           o_to_t ? "originator" : "target", size));
    }
    [[nodiscard]] bool variable(bool o_to_t, std::size_t seen) const {
        const auto& parameters = o_to_t ? question_.request->o_to_t : question_.request->t_to_o;
        return parameters.variable && seen <= parameters.size;
    }

    void went_silent(bool o_to_t, const IoTraffic::Direction& seen) {
        const auto* name = o_to_t ? "O->T" : "T->O";
        find(fmt::format("{} stopped after {} datagrams, {} before the end of what was seen; the timeout is {}.", name,
                         seen.packets, duration_text(seen.silent), duration_text(timeout(o_to_t))));
        trouble(fmt::format("{} timed out after {} datagrams", name, seen.packets));
        if (o_to_t) {
            suspect("The originator's program ended or stalled without a Forward_Close.");
            return;
        }
        const auto& out = traffic_.o_to_t;
        if (out.packets > 0 && (out.longest_interval > timeout(true) || out.silent > seen.silent)) {
            suspect(
                fmt::format("The target stopped because O->T stopped: {} without a datagram, and its timeout is {}.",
                            duration_text(std::max(out.longest_interval, out.silent)), duration_text(timeout(true))));
            advise(
                "A larger multiplier, or a longer interval, lets a connection live through pauses of the originator.");
        } else {
            suspect("The target was switched off, restarted or unplugged.");
            suspect(
                "The O->T datagrams do not arrive at the target any more, or it drops them: size, id or source "
                "address.");
        }
        advise("Open it anew; with a capture on both sides of the network one sees where datagrams end.");
    }

    void idle(bool o_to_t) {
        find(fmt::format("All {} {} datagrams say idle: bit 0 of the run/idle header is clear.",
                         direction(o_to_t).packets, o_to_t ? "O->T" : "T->O"));
        trouble(o_to_t ? "the originator is idle all the time" : "the target is idle all the time");
        if (!o_to_t) {
            suspect("The target is not in its run mode: it is itself a controller in program mode.");
            return;
        }
        suspect("The controller is in program mode, or its program does not set run.");
        suspect("The originator sends data without header, whose first octets are taken for one.");
        advise("Set bit 0 of the 4 octets behind the sequence count; a target does not apply outputs in idle.");
    }

    /// They do not keep a connection from working, and are said all the same.
    void note_losses() {
        for (const bool o_to_t : {true, false}) {
            const auto& seen = direction(o_to_t);
            if (seen.lost == 0) continue;
            find(fmt::format("{} {} datagrams are missing beside {} that came.", seen.lost, o_to_t ? "O->T" : "T->O",
                             seen.packets));
        }
    }

    const OpenQuestion& question_;
    const IoTraffic& traffic_;
    ConnectionPath path_;
    std::uint8_t code_ = 0;
    std::string summary_;
    Diagnosis diagnosis_;
};

}  // namespace

Diagnosis diagnose_traffic(const OpenQuestion& question, const IoTraffic& traffic) {
    return TrafficDoctor(question, traffic).diagnosis();
}

}  // namespace servobus::scanner
