#include "scanner/open_doctor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "scanner/connection_path.hpp"
#include "scanner/open_causes.hpp"
#include "scanner/open_terms.hpp"

namespace servobus::scanner {
namespace {

using assemblies::Connection;
using std::chrono::microseconds;

constexpr std::uint16_t jenny_science = 1389;
constexpr std::size_t small_size_limit = 511;  ///< of Forward_Open (R-CON-3)
constexpr std::size_t header_overhead = cip::run_idle_octets + cip::sequence_count_octets;

/// How the device came to be known as a XENAX.
enum class Known : std::uint8_t { no, by_points, by_vendor };

IoDirection direction_from(std::uint32_t point, const cip::ConnectionParameters& parameters, std::uint32_t rpi,
                           cip::RealTimeFormat format) {
    IoDirection direction;
    direction.point = point;
    direction.format = format;
    const auto overhead = cip::connection_size(format, 0);
    direction.data_octets = parameters.size > overhead ? parameters.size - overhead : 0;
    direction.type = parameters.type;
    direction.priority = parameters.priority;
    direction.variable = parameters.variable;
    direction.rpi = microseconds(rpi);
    return direction;
}

cip::RealTimeFormat likely_o_to_t_format(std::size_t size) {
    if (size <= cip::sequence_count_octets) return cip::RealTimeFormat::heartbeat;
    return size >= header_overhead ? cip::RealTimeFormat::header32 : cip::RealTimeFormat::modeless;
}

/// The connection of the XENAX that somebody meant who named these points and sizes.
const Connection* meant(const ConnectionPath& path, const cip::ForwardOpen& request) {
    const auto o_to_t = path.o_to_t();
    const auto t_to_o = path.t_to_o();
    if (!o_to_t || !t_to_o) return nullptr;
    if (const auto* pair = assemblies::find_connection(*o_to_t, *t_to_o)) return pair;
    if (const auto* exchanged = assemblies::find_connection(*t_to_o, *o_to_t)) return exchanged;
    if (const auto* output = assemblies::find_by_output(*o_to_t)) return output;
    const auto all = assemblies::connections();
    const auto by_size = std::ranges::find_if(all, [&](const Connection& each) {
        return each.t_to_o_point == *t_to_o && each.o_to_t_size() == request.o_to_t.size;
    });
    return by_size != all.end() ? &*by_size : assemblies::find_by_input(*t_to_o);
}

class Doctor {
public:
    explicit Doctor(const OpenQuestion& question) : question_(question) {
        if (!question.request) return;
        path_ = ConnectionPath::read(request().path);
        diagnosis_.asked = asked_text(request(), path_);
        plan_ = question.plan ? question.plan : plan_from(request());
        if (plan_ && plan_->route.segments.empty()) plan_->route = question.route;
        recognise();
    }

    Diagnosis refusal(const cip::Status& status) && {
        status_ = status;
        diagnosis_.summary = cip::describe(status);
        diagnosis_.may_pass = may_pass(status);
        if (question_.request) look();
        const auto& typical = open_cause(status);
        if (!question_.request) {
            diagnosis_.findings.emplace_back(
                "The request cannot be read: its length and the path size in it contradict each other.");
        }
        if (diagnosis_.causes.empty()) diagnosis_.causes.emplace_back(typical.cause);
        finish_plan();
        if (!diagnosis_.corrected || diagnosis_.may_pass) diagnosis_.next.emplace_back(typical.next);
        return std::move(diagnosis_);
    }

    Diagnosis encapsulation_refusal(enip::EncapsulationStatus status) && {
        diagnosis_.summary =
            fmt::format("encapsulation status 0x{:04X} {}", static_cast<std::uint32_t>(status), enip::describe(status));
        diagnosis_.findings.emplace_back("The message around the request was refused; the request was not looked at.");
        if (status == enip::EncapsulationStatus::invalid_session) {
            diagnosis_.causes.emplace_back(
                "The session is not registered, or no more: each TCP connection needs RegisterSession first.");
        } else {
            diagnosis_.causes.emplace_back(
                "The header or the items of the message are wrong: length, options, or the item types 0x0000 and "
                "0x00B2.");
        }
        diagnosis_.next.emplace_back(
            "Look at the message before the Forward_Open, and at RegisterSession, in Wireshark.");
        return std::move(diagnosis_);
    }

    Diagnosis silence() && {
        diagnosis_.summary = "the Forward_Open was not answered";
        diagnosis_.may_pass = true;
        if (!question_.route.segments.empty()) {
            diagnosis_.causes.emplace_back("The route leads nowhere, and the router has not said so in time.");
        }
        diagnosis_.causes.emplace_back(
            "The device takes longer than the originator waits, or has dropped the connection.");
        diagnosis_.causes.emplace_back("The device drops requests whose lengths do not fit instead of refusing them.");
        diagnosis_.next.emplace_back("See whether the device still answers an explicit message: identity.");
        return std::move(diagnosis_);
    }

    Diagnosis bad_reply() && {
        diagnosis_.summary = "the Forward_Open was granted, but the reply makes no sense";
        diagnosis_.findings.emplace_back("The reply has not the 26 octets of ids, serial numbers and intervals.");
        diagnosis_.causes.emplace_back("The device, or a router on the way, has cut the reply or writes another form.");
        diagnosis_.next.emplace_back("Close the connection with a Forward_Close, and report it to the device's maker.");
        return std::move(diagnosis_);
    }

private:
    using Look = void (Doctor::*)();
    struct Looker {
        std::uint16_t code;
        Look look;
    };

    [[nodiscard]] const cip::ForwardOpen& request() const { return *question_.request; }
    void find(std::string sentence) { diagnosis_.findings.push_back(std::move(sentence)); }
    void suspect(std::string sentence) { diagnosis_.causes.push_back(std::move(sentence)); }
    void advise(std::string sentence) { diagnosis_.next.push_back(std::move(sentence)); }

    // --- what is known

    void recognise() {
        if (question_.identity) {
            if (question_.identity->vendor == jenny_science) known_ = Known::by_vendor;
        } else if (path_.key && path_.key->vendor == jenny_science) {
            known_ = Known::by_vendor;
        } else if (path_.o_to_t() && path_.t_to_o() &&
                   assemblies::find_connection(*path_.o_to_t(), *path_.t_to_o()) != nullptr) {
            known_ = Known::by_points;
        }
        if (known_ == Known::no) return;
        connection_ = meant(path_, request());
        if (connection_ == nullptr) connection_ = assemblies::find_connection("standard");
    }

    /// The target itself says something else than the table: it only shares the points with a XENAX.
    void forget_if_other(std::size_t told, bool o_to_t) {
        if (connection_ == nullptr || known_ == Known::by_vendor) return;
        if (told != (o_to_t ? connection_->o_to_t_size() : connection_->t_to_o_size())) connection_ = nullptr;
    }

    /// What is asked, set right as far as the device is known.
    [[nodiscard]] std::optional<IoPlan> base() const {
        if (connection_ == nullptr) return plan_;
        auto plan = plan_of(*connection_);
        if (!plan_) return plan;
        const auto set_right = [](IoDirection asked, const IoDirection& right) {
            asked.point = right.point;
            asked.data_octets = right.data_octets;
            asked.format = right.format;
            asked.variable = false;
            asked.rpi =
                std::clamp(asked.rpi, microseconds(assemblies::smallest_rpi), microseconds(assemblies::largest_rpi));
            return asked;
        };
        const auto right = plan;
        plan = *plan_;
        plan.o_to_t = set_right(plan.o_to_t, right.o_to_t);
        plan.t_to_o = set_right(plan.t_to_o, right.t_to_o);
        plan.o_to_t.type = cip::ConnectionType::point_to_point;
        if (plan.t_to_o.type != cip::ConnectionType::multicast) plan.t_to_o.type = cip::ConnectionType::point_to_point;
        plan.configuration.clear();
        return plan;
    }
    /// The plan that is being put right.
    IoPlan* correction() {
        if (!diagnosis_.corrected) diagnosis_.corrected = base();
        return diagnosis_.corrected ? &*diagnosis_.corrected : nullptr;
    }
    /// Of a known device the whole plan can be told, except where the request was right and the time was not.
    void finish_plan() {
        if (connection_ != nullptr && !diagnosis_.corrected && question_.request) diagnosis_.corrected = base();
        if (!diagnosis_.corrected) return;
        auto& plan = *diagnosis_.corrected;
        plan.redundant_owner = false;
        plan.multiplier_code = std::min<std::uint8_t>(plan.multiplier_code, 7);
        if (diagnosis_.corrected == plan_ && !forced_) {
            diagnosis_.corrected.reset();
            return;
        }
        if (known_ == Known::by_points && connection_ != nullptr) {
            find(
                fmt::format("The points are those of the connection '{}' of a XENAX; the corrected plan takes the "
                            "device for one.",
                            connection_->name));
        }
    }

    // --- by status

    void look() {
        static constexpr auto extended = std::to_array<Looker>({
            {0x0100, &Doctor::look_at_duplicate},
            {0x0103, &Doctor::look_at_transport},
            {0x0106, &Doctor::look_at_owner},
            {0x0108, &Doctor::look_at_sizes},
            {0x0109, &Doctor::look_at_sizes},
            {0x0111, &Doctor::look_at_intervals},
            {0x0112, &Doctor::look_at_intervals},
            {0x0114, &Doctor::look_at_key},
            {0x0115, &Doctor::look_at_key},
            {0x0116, &Doctor::look_at_key},
            {0x0117, &Doctor::look_at_points},
            {0x0118, &Doctor::look_at_points},
            {0x0119, &Doctor::look_at_listening},
            {0x011B, &Doctor::look_at_inhibit_time},
            {0x011C, &Doctor::look_at_transport},
            {0x011D, &Doctor::look_at_transport},
            {0x011E, &Doctor::look_at_transport},
            {0x011F, &Doctor::turn_o_to_t_variable},
            {0x0120, &Doctor::turn_t_to_o_variable},
            {0x0121, &Doctor::look_at_priority},
            {0x0122, &Doctor::look_at_priority},
            {0x0123, &Doctor::look_at_o_to_t_type},
            {0x0124, &Doctor::look_at_t_to_o_type},
            {0x0125, &Doctor::look_at_redundancy},
            {0x0126, &Doctor::look_at_configuration_size},
            {0x0127, &Doctor::look_at_o_to_t_size},
            {0x0128, &Doctor::look_at_t_to_o_size},
            {0x0129, &Doctor::look_at_points},
            {0x012A, &Doctor::look_at_points},
            {0x012B, &Doctor::look_at_points},
            {0x012F, &Doctor::look_at_points},
            {0x0132, &Doctor::look_at_null},
            {0x0133, &Doctor::look_at_multiplier},
            {0x0134, &Doctor::look_at_t_to_o_size},
            {0x0135, &Doctor::turn_t_to_o_variable},
            {0x0138, &Doctor::look_at_transport},
            {0x0139, &Doctor::look_at_inhibit_time},
            {0x0204, &Doctor::look_at_route},
            {0x0205, &Doctor::look_at_route},
            {0x0311, &Doctor::look_at_route},
            {0x0312, &Doctor::look_at_route},
            {0x0315, &Doctor::look_at_points},
            {0x0801, &Doctor::leave_multicast},
            {0x0813, &Doctor::leave_multicast},
        });
        static constexpr auto general = std::to_array<Looker>({
            {0x01, &Doctor::look_at_everything},
            {0x04, &Doctor::look_at_points},
            {0x05, &Doctor::look_at_points},
            {0x08, &Doctor::look_at_service},
            {0x13, &Doctor::look_at_points},
            {0x15, &Doctor::look_at_points},
            {0x20, &Doctor::look_at_everything},
            {0x25, &Doctor::look_at_key},
            {0x26, &Doctor::look_at_points},
        });
        const bool has_word = status_.general == cip::GeneralStatus::connection_failure && !status_.extended.empty();
        const std::span<const Looker> table = has_word ? std::span<const Looker>(extended) : general;
        const auto code = has_word ? status_.extended.front() : static_cast<std::uint16_t>(status_.general);
        const auto found = std::ranges::find(table, code, &Looker::code);
        if (found != table.end()) (this->*found->look)();
    }

    [[nodiscard]] std::uint16_t word() const { return status_.extended.empty() ? 0 : status_.extended.front(); }
    [[nodiscard]] std::optional<std::size_t> told_size() const {
        return status_.extended.size() > 1 ? std::optional<std::size_t>(status_.extended[1]) : std::nullopt;
    }

    // --- sizes

    void look_at_o_to_t_size() { look_at_size(true, told_size()); }
    void look_at_t_to_o_size() { look_at_size(false, told_size()); }
    /// The direction is not told, or nothing is.
    void look_at_sizes() {
        look_at_size(true, std::nullopt);
        look_at_size(false, std::nullopt);
        if (const auto told = told_size(); told && diagnosis_.causes.empty()) {
            find(fmt::format("The target gives the size {}, without a direction.", *told));
        }
    }

    void look_at_size(bool o_to_t, std::optional<std::size_t> told) {
        const std::size_t asked = o_to_t ? request().o_to_t.size : request().t_to_o.size;
        if (told) forget_if_other(*told, o_to_t);
        auto expected = told;
        if (connection_ != nullptr) expected = o_to_t ? connection_->o_to_t_size() : connection_->t_to_o_size();
        if (told && connection_ != nullptr && *told != *expected) {
            // A known device whose assemblies have grown: its own word counts.
            expected = told;
            connection_ = nullptr;
        }
        const auto* name = o_to_t ? "O->T" : "T->O";
        if (!expected) {
            if (status_.extended.size() == 1 && (word() == 0x0127 || word() == 0x0128 || word() == 0x0134)) {
                find(fmt::format("{} size {} asked; the target does not say which it expects.", name, asked));
            }
            return;
        }
        if (asked == *expected && !told) return;
        find(fmt::format("{} size {} asked, {} expected{}.", name, asked, *expected, parts_of(o_to_t, *expected)));
        if (asked == *expected) {
            suspect(
                "The size is what the target names: it means another property of the direction, or counts otherwise.");
            return;
        }
        for (auto& cause : size_causes({o_to_t, asked, *expected, header_of(o_to_t), opposite_of(o_to_t)})) {
            suspect(std::move(cause));
        }
        suspect_other_assembly(o_to_t, asked);
        correct_size(o_to_t, *expected);
        if (connection_ != nullptr && told) look_at_size(!o_to_t, std::nullopt);
    }

    [[nodiscard]] std::string parts_of(bool o_to_t, std::size_t expected) const {
        if (connection_ != nullptr) return ": " + size_parts(*connection_, o_to_t);
        if (expected < cip::sequence_count_octets) return "";
        if (o_to_t && expected >= header_overhead) {
            return fmt::format(": 2 sequence count + {}, which is either data alone, or 4 run/idle header + {} data",
                               expected - cip::sequence_count_octets, expected - header_overhead);
        }
        return fmt::format(": 2 sequence count + {} data", expected - cip::sequence_count_octets);
    }
    [[nodiscard]] std::optional<bool> header_of(bool o_to_t) const {
        if (connection_ == nullptr) return std::nullopt;
        const auto format = o_to_t ? connection_->o_to_t_format() : connection_->t_to_o_format();
        return format == cip::RealTimeFormat::header32;
    }
    [[nodiscard]] std::optional<std::size_t> opposite_of(bool o_to_t) const {
        if (connection_ == nullptr) return std::nullopt;
        return o_to_t ? connection_->t_to_o_size() : connection_->o_to_t_size();
    }
    void suspect_other_assembly(bool o_to_t, std::size_t asked) {
        if (connection_ == nullptr) return;
        for (const auto& other : assemblies::connections()) {
            const auto point = o_to_t ? other.o_to_t_point : other.t_to_o_point;
            const auto own = o_to_t ? connection_->o_to_t_point : connection_->t_to_o_point;
            if (point == own || (o_to_t ? other.o_to_t_size() : other.t_to_o_size()) != asked) continue;
            suspect(fmt::format("{} is the size for point {}, of the connection '{}'.", asked, point, other.key));
            return;
        }
    }
    void correct_size(bool o_to_t, std::size_t expected) {
        auto* plan = correction();
        if (plan == nullptr || connection_ != nullptr) return;
        auto& direction = o_to_t ? plan->o_to_t : plan->t_to_o;
        if (o_to_t) direction.format = likely_o_to_t_format(expected);
        const auto overhead = cip::connection_size(direction.format, 0);
        if (expected < overhead) {
            diagnosis_.corrected.reset();
            return;
        }
        direction.data_octets = expected - overhead;
        if (direction.format == cip::RealTimeFormat::header32) {
            advise(
                fmt::format("If the device has no run/idle header in O->T, the same connection is --o2t-size {} "
                            "--o2t-format modeless; its EDS file says.",
                            expected - cip::sequence_count_octets));
        }
    }

    void look_at_configuration_size() {
        const auto given = path_.data ? path_.data->size() / 2 : 0;
        auto* plan = connection_ != nullptr ? correction() : nullptr;
        if (const auto told = told_size()) {
            find(fmt::format("{} words of configuration data given, {} expected.", given, *told));
            if (*told == 0) {
                suspect("The device takes no configuration data with the open.");
                plan = correction();
            }
        } else {
            find(fmt::format("{} words of configuration data given; the target does not say how many it expects.",
                             given));
        }
        if (plan != nullptr) plan->configuration.clear();
    }

    // --- intervals

    void look_at_intervals() {
        const auto told = cip::RpiRefusal::from(status_);
        if (!told) {
            look_at_untold_intervals();
            return;
        }
        auto out = microseconds(request().o_to_t_rpi);
        auto in = microseconds(request().t_to_o_rpi);
        out = compare_interval("O->T", out, told->o_to_t_kind, microseconds(told->o_to_t));
        in = compare_interval("T->O", in, told->t_to_o_kind, microseconds(told->t_to_o));
        const bool required =
            told->o_to_t_kind == cip::RpiKind::required || told->t_to_o_kind == cip::RpiKind::required;
        if (required) {
            suspect("The data is already sent to somebody else by multicast, and all receivers share one interval.");
            advise("Point-to-point, without --multicast, may have an interval of its own.");
        } else if (out > microseconds(request().o_to_t_rpi) || in > microseconds(request().t_to_o_rpi)) {
            suspect("The interval is shorter than the device can keep.");
        } else if (out < microseconds(request().o_to_t_rpi) || in < microseconds(request().t_to_o_rpi)) {
            suspect("The interval is longer than the device supervises.");
        }
        auto* plan = correction();
        if (plan == nullptr) return;
        plan->o_to_t.rpi = out;
        plan->t_to_o.rpi = in;
        // Where the target names nothing there is nothing to correct.
        if (plan->o_to_t.rpi.count() == 0 || plan->t_to_o.rpi.count() == 0) diagnosis_.corrected.reset();
    }

    microseconds compare_interval(const char* name, microseconds asked, cip::RpiKind kind, microseconds told) {
        const auto say = [&](const char* what) {
            find(fmt::format("{} interval {} asked; the target takes {} {}.", name, duration_text(asked), what,
                             duration_text(told)));
        };
        switch (kind) {
            case cip::RpiKind::acceptable:
                find(fmt::format("{} interval {} asked, and acceptable.", name, duration_text(asked)));
                return asked;
            case cip::RpiKind::unspecified:
                find(fmt::format("{} interval {} asked; the target wants another and does not say which.", name,
                                 duration_text(asked)));
                return asked;
            case cip::RpiKind::minimum:
                say("at least");
                return std::max(asked, told);
            case cip::RpiKind::maximum:
                say("at most");
                return std::min(asked, told);
            case cip::RpiKind::required:
                say("only");
                return told;
        }
        return asked;
    }

    void look_at_untold_intervals() {
        const microseconds out(request().o_to_t_rpi);
        const microseconds in(request().t_to_o_rpi);
        find(fmt::format("Intervals of {} (O->T) and {} (T->O) asked; the target does not say which it takes.",
                         duration_text(out), duration_text(in)));
        if (out.count() == 0 || in.count() == 0)
            suspect("An interval of 0 is none; it has to be given in microseconds.");
        if (connection_ == nullptr) return;
        find(fmt::format("A XENAX takes {} to {}.", duration_text(microseconds(assemblies::smallest_rpi)),
                         duration_text(microseconds(assemblies::largest_rpi))));
        auto* plan = correction();
        if (plan == nullptr) return;
        // An interval of 0 says nothing about the one that is wanted: the other one, or the usual one, does.
        const auto usual = std::max(out, in).count() == 0 ? IoDirection{}.rpi : std::max(out, in);
        if (out.count() == 0) plan->o_to_t.rpi = usual;
        if (in.count() == 0) plan->t_to_o.rpi = usual;
    }

    void look_at_inhibit_time() {
        const auto inhibit = path_.inhibit;
        if (inhibit) {
            find(fmt::format("Production inhibit time {} asked, with a T->O interval of {}.",
                             duration_text(microseconds(*inhibit)), duration_text(microseconds(request().t_to_o_rpi))));
        }
        if (auto* plan = inhibit ? correction() : nullptr) plan->inhibit.reset();
    }

    // --- key

    void look_at_key() {
        if (!path_.key) {
            find("The path has no electronic key; the target, or a router on the way, compares something of its own.");
            return;
        }
        const auto& key = *path_.key;
        if (const auto& identity = question_.identity) {
            compare_key(key, *identity);
        } else if (known_ == Known::by_vendor || connection_ != nullptr) {
            find(fmt::format("The key asks for vendor {}, device type {}, product code {}, revision {}.{}.", key.vendor,
                             key.device_type, key.product_code, key.major_revision & 0x7F, key.minor_revision));
            if (key.vendor != 0 && key.vendor != jenny_science) {
                suspect(fmt::format("The key names vendor {}; a XENAX is of vendor {}.", key.vendor, jenny_science));
            }
        }
        auto* plan = correction();
        if (plan == nullptr) return;
        plan->key.reset();
        forced_ = true;
        if (!question_.identity) {
            advise("Leave the key out, as the corrected plan does (--key none), or read the device's identity.");
            return;
        }
        const auto& identity = *question_.identity;
        plan->key = cip::ElectronicKey{identity.vendor,         identity.device_type,    identity.product_code,
                                       identity.major_revision, identity.minor_revision, {}};
    }

    void compare_key(const cip::ElectronicKey& key, const Identity& identity) {
        const auto compare = [&](const char* field, unsigned asked, unsigned has) {
            if (asked == 0 || asked == has) return;
            suspect(fmt::format("The key asks for {} {}, and the device has {}.", field, asked, has));
        };
        compare("vendor", key.vendor, identity.vendor);
        compare("device type", key.device_type, identity.device_type);
        compare("product code", key.product_code, identity.product_code);
        const auto major = key.major_revision & 0x7FU;
        if ((key.major_revision & 0x80) == 0) {
            compare("major revision", major, identity.major_revision);
            compare("minor revision", major == 0 ? 0 : key.minor_revision, identity.minor_revision);
        } else if (major != identity.major_revision || key.minor_revision > identity.minor_revision) {
            suspect(fmt::format("The key asks for a revision that can stand in for {}.{}, and the device has {}.{}.",
                                major, key.minor_revision, identity.major_revision, identity.minor_revision));
        }
    }

    // --- path and points

    void look_at_points() {
        auto odd = path_.oddities();
        for (auto& sentence : odd) find(std::move(sentence));
        if (connection_ != nullptr) {
            compare_points();
            return;
        }
        const auto out = path_.o_to_t();
        const auto in = path_.t_to_o();
        if (out && in) {
            find(fmt::format(
                "The device is asked for O->T point {} and T->O point {}{}; whether it has them is not "
                "known here.",
                *out, *in,
                path_.configuration() ? fmt::format(" with configuration instance {}", *path_.configuration())
                                      : " without a configuration instance"));
        }
        suspect(std::string(open_cause(status_).cause));
        if (out && in) {
            suspect("The points are exchanged: O->T is what the device calls its output or consumed assembly.");
            suspect(path_.configuration() ? "The configuration instance is not the device's."
                                          : "The device insists on a configuration instance.");
        }
    }

    void compare_points() {
        const auto out = path_.o_to_t();
        const auto in = path_.t_to_o();
        if (out && in && *out == connection_->t_to_o_point && *in == connection_->o_to_t_point) {
            suspect(
                fmt::format("The points are exchanged: {} is what the drive consumes (O->T) and {} what it produces "
                            "(T->O).",
                            connection_->o_to_t_point, connection_->t_to_o_point));
        } else if (out && in) {
            compare_point("O->T", *out, connection_->o_to_t_point, *in);
            compare_point("T->O", *in, connection_->t_to_o_point, *out);
        }
        auto* plan = correction();
        if (plan == nullptr) return;
        const bool configuration_told = word() == 0x0118 || word() == 0x0129;
        const bool all_right = out == connection_->o_to_t_point && in == connection_->t_to_o_point;
        if ((configuration_told || all_right) && path_.configuration() != assemblies::configuration_instance) {
            suspect(path_.configuration() ? fmt::format("Configuration instance {} is asked; the XENAX has {}.",
                                                        *path_.configuration(), assemblies::configuration_instance)
                                          : fmt::format("The configuration instance, {}, is missing.",
                                                        assemblies::configuration_instance));
            plan->configuration_instance = assemblies::configuration_instance;
        }
        // The node has answered itself, so there is nothing to pass on.
        if (question_.identity && word() == 0x0315) plan->route = {};
        // A path that the plan cannot express is the difference, even when all else is as asked.
        if (path_.class_id != 0x04U || !path_.symbols.empty() || !path_.route.segments.empty()) forced_ = true;
    }

    void compare_point(const char* name, std::uint32_t asked, std::uint32_t right, std::uint32_t partner) {
        if (asked == right) return;
        const bool other_way =
            name[0] == 'O' ? assemblies::find_by_input(asked) != nullptr : assemblies::find_by_output(asked) != nullptr;
        const bool exists = assemblies::find_by_input(asked) != nullptr || assemblies::find_by_output(asked) != nullptr;
        if (other_way) {
            suspect(
                fmt::format("{} point {} is of the other direction; with {} it is {}.", name, asked, partner, right));
        } else if (exists) {
            suspect(fmt::format("{} point {} does not go with {}; {} does.", name, asked, partner, right));
        } else {
            suspect(fmt::format("{} point {} does not exist; {} goes with {}.", name, asked, right, partner));
        }
    }

    void look_at_route() {
        const auto& route = question_.route.segments.empty() ? path_.route : question_.route;
        find(route.segments.empty() ? "The request has no route; the node that was asked says so of itself."
                                    : fmt::format("The request takes the route {}.", cip::describe(route)));
    }

    // --- transport, types and the rest of the parameters

    void look_at_transport() {
        const auto& transport = request().transport;
        const auto code = word();
        if (transport.transport_class == 3) {
            suspect("Class 3 is for explicit messages: no I/O device takes it with its I/O points.");
        } else if (transport.transport_class == 0) {
            suspect("Class 0, without sequence count, is optional; many devices have class 1 only.");
        } else if (transport.transport_class != 1) {
            suspect(fmt::format("Transport class {} is none for I/O data; class 1 is.", transport.transport_class));
        }
        if (transport.trigger > 2) {
            suspect(fmt::format("Trigger {} is reserved; cyclic is 0.", transport.trigger));
        } else if (transport.trigger != 0) {
            suspect("The trigger is not cyclic: change of state and application are optional.");
        }
        if (transport.server) suspect("The direction bit is set, 0x81 for 0x01; some devices refuse that for class 1.");
        find(fmt::format("The octet of class and trigger is 0x{:02X}; cyclic class 1 is 0x01.", transport.to_byte()));
        if (diagnosis_.causes.empty()) {
            suspect(code == 0x0138 ? std::string(open_cause(status_).cause)
                                   : "The octet is the usual one; a target that refuses it serves no class 1 at these "
                                     "points, or means another part of the request.");
            return;
        }
        if (auto* plan = correction()) {
            plan->trigger = enip::Trigger::cyclic;
            plan->inhibit.reset();
            forced_ = true;
        }
    }

    void turn_o_to_t_variable() { turn_variable(true); }
    void turn_t_to_o_variable() { turn_variable(false); }
    void turn_variable(bool o_to_t) {
        const bool asked = o_to_t ? request().o_to_t.variable : request().t_to_o.variable;
        find(fmt::format("{} asked with a {} size.", o_to_t ? "O->T" : "T->O", asked ? "variable" : "fixed"));
        if (auto* plan = correction()) (o_to_t ? plan->o_to_t : plan->t_to_o).variable = !asked;
    }

    void look_at_priority() {
        if (auto* plan = correction()) {
            plan->o_to_t.priority = cip::Priority::scheduled;
            plan->t_to_o.priority = cip::Priority::scheduled;
        }
    }

    void look_at_o_to_t_type() {
        using enum cip::ConnectionType;
        if (request().o_to_t.type == multicast)
            suspect("O->T is asked as multicast; an originator sends to one target.");
        if (request().o_to_t.type == null) {
            suspect("O->T has the type null; a device that is to be watched only wants a heartbeat there.");
        }
        if (request().o_to_t.type == reserved) suspect("O->T has connection type 3, which is reserved.");
        if (auto* plan = correction()) plan->o_to_t.type = point_to_point;
    }
    void look_at_t_to_o_type() {
        using enum cip::ConnectionType;
        const auto type = request().t_to_o.type;
        if (type == multicast) suspect("T->O is asked as multicast, which this target or point does not have.");
        if (type == point_to_point) suspect("T->O is asked point-to-point; this target or point has multicast only.");
        if (type == null) suspect("T->O has the type null, and so nothing would come back.");
        if (type == reserved) suspect("T->O has connection type 3, which is reserved.");
        if (auto* plan = correction()) plan->t_to_o.type = type == point_to_point ? multicast : point_to_point;
    }
    void leave_multicast() {
        if (auto* plan = correction()) plan->t_to_o.type = cip::ConnectionType::point_to_point;
    }
    void look_at_null() {
        using enum cip::ConnectionType;
        if (request().o_to_t.type != null || request().t_to_o.type != null) return;
        find("Both directions have the type null.");
        if (auto* plan = correction()) plan->o_to_t.type = plan->t_to_o.type = point_to_point;
    }
    void look_at_redundancy() {
        if (correction() != nullptr) forced_ = true;
    }
    void look_at_multiplier() {
        find(request().timeout_multiplier > 7
                 ? fmt::format("Multiplier code {} asked; 0 to 7 mean 4 to 512.", request().timeout_multiplier)
                 : fmt::format("Multiplier {} asked.", 4 << request().timeout_multiplier));
        if (request().timeout_multiplier > 7) suspect("The field takes the code 0 to 7, not the multiplier itself.");
        if (auto* plan = correction()) plan->multiplier_code = request().timeout_multiplier == 2 ? 3 : 2;
    }

    // --- who has what

    void look_at_duplicate() {
        const auto& triad = request().triad;
        find(fmt::format("Serial number 0x{:04X} of originator 0x{:04X}/0x{:08X} is in use at the target.",
                         triad.serial_number, triad.originator_vendor, triad.originator_serial));
        const auto patience = target_patience(request());
        advise(
            fmt::format("If it was asked with the same interval and multiplier, it times out within {} of its last "
                        "datagram, or 10 s after an open without any.",
                        duration_text(patience)));
        advise("Or take another connection serial number, as servobus-scanner does with each open.");
    }

    void look_at_owner() {
        const auto patience = target_patience(request());
        suspect(std::string(open_cause(status_).cause));
        suspect(
            fmt::format("If it was your own connection and broke with this interval and multiplier, the target lets "
                        "go of it within {}.",
                        duration_text(patience)));
        if (connection_ == nullptr) {
            advise("Input only is asked with the device's own O->T heartbeat point, which its EDS file names.");
            return;
        }
        offer(Connection::Kind::input_only);
        advise("The corrected plan is input only: it looks at the same inputs beside the owner, and controls nothing.");
    }

    void look_at_listening() {
        const bool multicast = request().t_to_o.type == cip::ConnectionType::multicast;
        if (!multicast) suspect("Listen only is asked point-to-point; it can only listen to a multicast.");
        suspect(std::string(open_cause(status_).cause));
        if (!multicast) {
            if (auto* plan = correction()) plan->t_to_o.type = cip::ConnectionType::multicast;
            advise("There has to be an owner, or an input-only connection, by multicast before.");
        } else if (connection_ != nullptr) {
            offer(Connection::Kind::input_only);
            advise("The corrected plan is input only, which needs nobody else.");
        }
    }

    /// The connection of another kind that sees the same inputs.
    void offer(Connection::Kind kind) {
        const auto all = assemblies::connections();
        const auto found = std::ranges::find_if(all, [&](const Connection& each) {
            return each.kind == kind && each.t_to_o_point == connection_->t_to_o_point;
        });
        if (found == all.end()) return;
        connection_ = &*found;
        diagnosis_.corrected = base();
    }

    // --- others

    void look_at_service() {
        if (!request().large) {
            suspect("The node has no Forward_Open: it is no I/O device, or not the node that you think.");
            return;
        }
        suspect("The target has no Large_Forward_Open; Forward_Open does the same up to 511 octets.");
        if (std::max(request().o_to_t.size, request().t_to_o.size) > small_size_limit) {
            find("A size above 511 octets does not fit into the small Forward_Open.");
            return;
        }
        if (auto* plan = correction()) plan->large = false;
    }

    /// The target does not say what it is: everything that can be compared is.
    void look_at_everything() {
        for (auto& sentence : path_.oddities()) find(std::move(sentence));
        if (request().transport.to_byte() != 0x01) {
            find(fmt::format("The octet of class and trigger is 0x{:02X}; cyclic class 1 is 0x01.",
                             request().transport.to_byte()));
        }
        look_at_sizes();
    }

    const OpenQuestion& question_;
    ConnectionPath path_;
    std::optional<IoPlan> plan_;
    Known known_ = Known::no;
    const Connection* connection_ = nullptr;  ///< what it should be, of a device that is known
    cip::Status status_;
    bool forced_ = false;  ///< the correction differs from the request in what a plan does not show
    Diagnosis diagnosis_;
};

}  // namespace

Diagnosis diagnose_refusal(const OpenQuestion& question, const cip::Status& status) {
    return Doctor(question).refusal(status);
}

Diagnosis diagnose_refusal(const OpenQuestion& question, enip::EncapsulationStatus status) {
    return Doctor(question).encapsulation_refusal(status);
}

Diagnosis diagnose_silence(const OpenQuestion& question) { return Doctor(question).silence(); }
Diagnosis diagnose_bad_reply(const OpenQuestion& question) { return Doctor(question).bad_reply(); }

std::optional<IoPlan> plan_from(const cip::ForwardOpen& request) {
    const auto path = ConnectionPath::read(request.path);
    const auto out = path.o_to_t();
    const auto in = path.t_to_o();
    if (!out || !in) return std::nullopt;
    IoPlan plan;
    plan.route = path.route;
    plan.key = path.key;
    plan.configuration_instance = path.configuration();
    plan.configuration = path.data.value_or(cip::Bytes{});
    const auto* known = assemblies::find_connection(*out, *in);
    const auto format = known != nullptr ? known->o_to_t_format() : likely_o_to_t_format(request.o_to_t.size);
    plan.o_to_t = direction_from(*out, request.o_to_t, request.o_to_t_rpi, format);
    plan.t_to_o = direction_from(*in, request.t_to_o, request.t_to_o_rpi, cip::RealTimeFormat::modeless);
    plan.trigger =
        request.transport.trigger <= 2 ? static_cast<enip::Trigger>(request.transport.trigger) : enip::Trigger::cyclic;
    if (path.inhibit) plan.inhibit = microseconds(*path.inhibit);
    plan.multiplier_code = request.timeout_multiplier;
    plan.redundant_owner = request.o_to_t.redundant_owner;
    plan.large = request.large;
    return plan;
}

}  // namespace servobus::scanner
