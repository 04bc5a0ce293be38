#include "scanner/conformance/candidate.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "assemblies/connection.hpp"
#include "eds/data_sheet.hpp"
#include "scanner/sheet_plan.hpp"

namespace servobus::scanner::conformance {
namespace {

constexpr unsigned all_priorities = 0xF;

Kind kind_of(const eds::Connection& connection) {
    switch (connection.transport.ownership().value_or(eds::Ownership::exclusive_owner)) {
        case eds::Ownership::listen_only:
            return Kind::listen_only;
        case eds::Ownership::input_only:
            return Kind::input_only;
        case eds::Ownership::redundant_owner:
            return Kind::redundant_owner;
        case eds::Ownership::exclusive_owner:
            break;
    }
    return Kind::exclusive_owner;
}

Kind kind_of(assemblies::Connection::Kind kind) {
    switch (kind) {
        case assemblies::Connection::Kind::input_only:
            return Kind::input_only;
        case assemblies::Connection::Kind::listen_only:
            return Kind::listen_only;
        case assemblies::Connection::Kind::exclusive_owner:
            break;
    }
    return Kind::exclusive_owner;
}

}  // namespace

std::string_view name(Kind kind) {
    switch (kind) {
        case Kind::exclusive_owner:
            return "exclusive owner";
        case Kind::redundant_owner:
            return "redundant owner";
        case Kind::input_only:
            return "input only";
        case Kind::listen_only:
            return "listen only";
    }
    return "unknown";
}

std::vector<Candidate> candidates_of(const eds::DataSheet& sheet) {
    std::vector<Candidate> candidates;
    for (const auto& each : sheet.connections) {
        const auto plan = plan_of(sheet, each);
        if (!plan) continue;
        const auto bits = each.parameters.t_to_o();
        Candidate candidate;
        candidate.name = each.name.empty() ? each.keyword : each.name;
        candidate.kind = kind_of(each);
        candidate.plan = *plan;
        candidate.point_to_point = bits.point_to_point;
        candidate.multicast = bits.multicast;
        candidate.variable = each.parameters.o_to_t().variable && bits.variable;
        candidate.change_of_state = each.transport.change_of_state();
        candidate.application = each.transport.application();
        candidate.priorities = bits.priorities != 0 ? bits.priorities : all_priorities;
        candidate.shortest_rpi =
            std::max({each.o_to_t.rpi.minimum.value_or(1), each.t_to_o.rpi.minimum.value_or(1), 1U});
        candidate.longest_rpi =
            std::min(each.o_to_t.rpi.maximum.value_or(0xFFFFFFFF), each.t_to_o.rpi.maximum.value_or(0xFFFFFFFF));
        candidates.push_back(std::move(candidate));
    }
    return candidates;
}

std::vector<Candidate> candidates_of_xenax() {
    std::vector<Candidate> candidates;
    for (const auto& each : assemblies::connections()) {
        Candidate candidate;
        candidate.name = fmt::format("{} {}/{}", each.key, each.o_to_t_point, each.t_to_o_point);
        candidate.kind = kind_of(each.kind);
        candidate.plan = plan_of(each);
        candidate.point_to_point = candidate.kind != Kind::listen_only;
        candidate.multicast = true;
        candidate.variable = true;
        candidate.change_of_state = true;
        candidate.application = true;
        candidate.shortest_rpi = assemblies::smallest_rpi;
        candidate.longest_rpi = assemblies::largest_rpi;
        if (candidate.kind == Kind::listen_only) candidate.plan.t_to_o.type = cip::ConnectionType::multicast;
        candidates.push_back(std::move(candidate));
    }
    return candidates;
}

Candidate candidate_of(const IoPlan& plan) {
    Candidate candidate;
    candidate.kind = plan.o_to_t.data_octets == 0 ? Kind::input_only : Kind::exclusive_owner;
    candidate.name = fmt::format("{}/{}", plan.o_to_t.point, plan.t_to_o.point);
    candidate.plan = plan;
    candidate.point_to_point = plan.t_to_o.type == cip::ConnectionType::point_to_point;
    candidate.multicast = plan.t_to_o.type == cip::ConnectionType::multicast;
    candidate.priorities = 1U << static_cast<unsigned>(plan.t_to_o.priority);
    return candidate;
}

}  // namespace servobus::scanner::conformance
