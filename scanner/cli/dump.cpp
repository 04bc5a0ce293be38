// dump: every parameter, in packets of many where the device takes them.
#include <fmt/format.h>

#include "drive/xenax.hpp"
#include "scanner/cli/json_output.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/cli/verbs.hpp"
#include "scanner/multiple_service.hpp"

namespace servobus::scanner::cli {
namespace {

using Rows = std::vector<const drive::Parameter*>;

/// Octets of an embedded reply: offset, header, value.
std::size_t reply_share(const drive::Parameter& row) {
    constexpr std::size_t offset_and_header = 2 + 4;
    // Length field and padding of a text.
    return offset_and_header + (row.is_text() ? row.max_length + 3 : drive::size_of(row.cip.type));
}

/// What an Unconnected_Send adds around a packet: service and path, ticks, length, route.
std::size_t route_overhead(const cip::Path& route) {
    constexpr std::size_t fixed = 6 + 4 + 3;
    return route.segments.empty() ? 0 : fixed + 2 * route.words();
}

Outcome outcome_of(const drive::Parameter& row, const boost::system::result<ReadOutcome>& answer) {
    const What what{&row};
    if (!answer) return {what, answer.error()};
    if (!answer->value) return {what, answer->status};
    return {what, *answer->value, answer->surplus};
}

class Reader {
public:
    explicit Reader(Link& link) : link_(link) {}

    std::vector<Outcome> read_all() {
        for (const auto& row : drive::parameters()) {
            if (!drive::may_get(row.access)) {
                outcomes_.push_back({What{&row}, NotAsked{"write only"}});
            } else {
                add(row);
            }
        }
        flush();
        return std::move(outcomes_);
    }

    /// Why it came to an early end.
    [[nodiscard]] const std::optional<Failure>& failure() const { return failure_; }
    /// The device says that it takes packets, and then breaks them.
    [[nodiscard]] bool broken_packets() const { return broken_packets_; }

private:
    /// Keeps the row for the packet that is being filled. Its outcome has its place already.
    void add(const drive::Parameter& row) {
        const auto request = read_request(row);
        if (request_octets_ + packet_share(request) > limit_ || reply_octets_ + reply_share(row) > limit_) flush();
        request_octets_ += packet_share(request);
        reply_octets_ += reply_share(row);
        batch_.push_back(outcomes_.size());
        outcomes_.push_back({What{&row}, NotAsked{"not asked any more"}});
    }

    void flush() {
        if (!packets_ || batch_.size() == 1 || !read_packet()) {
            for (const auto index : batch_) read_single(index);
        }
        batch_.clear();
        request_octets_ = reply_octets_ = packet_overhead;
    }

    [[nodiscard]] const drive::Parameter& row(std::size_t index) const { return *outcomes_[index].what.row(); }

    void read_single(std::size_t index) {
        if (failure_) return;
        outcomes_[index] = outcome_of(row(index), link_.read(row(index)));
        if (const auto* error = std::get_if<error_code>(&outcomes_[index].result)) stop_if_lost(*error);
    }

    void stop_if_lost(const error_code& error) {
        if (trouble_of(error) == Trouble::connection) failure_ = link_.failure_of(error);
    }

    /// False when the rows are to be read one by one.
    bool read_packet() {
        if (failure_ || batch_.empty()) return true;
        std::vector<cip::Request> requests;
        for (const auto index : batch_) requests.push_back(read_request(row(index)));
        const auto reply = link_.call(multiple_service_packet(requests));
        if (!reply) {
            stop_if_lost(reply.error());
            packets_ = false;
            return failure_.has_value();
        }
        using enum cip::GeneralStatus;
        if (!reply->status.ok() && reply->status.general != embedded_service_error) {
            // Too long is a matter of this packet; anything else means that the device has no such service.
            packets_ = reply->status.general == reply_data_too_large;
            return false;
        }
        const auto responses = multiple_service_responses(requests, *reply);
        if (!responses) {
            broken_packets_ = true;
            packets_ = false;
            return false;
        }
        for (std::size_t i = 0; i < batch_.size(); ++i) take((*responses)[i], batch_[i]);
        return true;
    }

    void take(const cip::Response& response, std::size_t index) {
        if (response.status.general == cip::GeneralStatus::reply_data_too_large) {
            read_single(index);
        } else {
            outcomes_[index] = outcome_of(row(index), read_outcome(row(index), response));
        }
    }

    Link& link_;
    std::size_t limit_ = max_packet_bytes - route_overhead(link_.settings().route);
    bool packets_ = true;
    bool broken_packets_ = false;
    std::vector<std::size_t> batch_;  ///< places in outcomes_
    std::size_t request_octets_ = packet_overhead;
    std::size_t reply_octets_ = packet_overhead;
    std::vector<Outcome> outcomes_;
    std::optional<Failure> failure_;
};

}  // namespace

ExitCode dump(const Console& console, const Settings& settings, const std::string& host) {
    const auto where = parse_host(host);
    if (!where) return fail(console, where.error());
    Link link(settings, *where);
    if (const auto failure = link.open()) return fail(console, *failure, host);
    link.count_from_last_answer();
    Reader reader(link);
    const auto outcomes = reader.read_all();
    const auto& failure = reader.failure();
    console.show(dump_text(outcomes), console.json ? dump_json(host, outcomes, failure) : std::string());
    if (reader.broken_packets()) {
        console.say("the device's answer to a Multiple_Service_Packet makes no sense; the rows were read one by one");
    }
    if (failure) {
        console.say(failure->text);
        return failure->code;
    }
    const auto code = dump_exit_code_of(outcomes);
    if (code == ExitCode::refused) console.say("the device refused every parameter");
    if (code == ExitCode::nonsense) console.say("some answers make no sense; see the remarks");
    return code;
}

}  // namespace servobus::scanner::cli
