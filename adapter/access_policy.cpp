#include "adapter/access_policy.hpp"

#include <algorithm>
#include <array>

#include "adapter/forward_open_checks.hpp"
#include "cip/file_transfer.hpp"
#include "cip/forward_open.hpp"
#include "cip/services.hpp"

namespace servobus::adapter {
namespace {

namespace service = cip::service;
using cip::class_id::connection_manager;

constexpr std::uint32_t any_class = 0;

struct EffectRow {
    std::uint8_t service;
    std::uint32_t class_id;
    Effect effect;
};

// Reading comes first, since it is what most requests do. The codes are those of R-MSG-4, R-CM and R-FIL.
// clang-format off
constexpr auto effects = std::to_array<EffectRow>({
    {service::get_attribute_single,    any_class,                         Effect::reads},
    {service::get_attributes_all,      any_class,                         Effect::reads},
    {service::get_attribute_list,      any_class,                         Effect::reads},
    {0x11 /* Find_Next_Object_Instance */, any_class,                     Effect::reads},
    {0x17 /* No_Operation */,          any_class,                         Effect::reads},
    {0x18 /* Get_Member */,            any_class,                         Effect::reads},
    {service::multiple_service_packet, cip::class_id::message_router,     Effect::carries},
    {service::unconnected_send,        connection_manager,                Effect::carries},
    {service::get_connection_data,     connection_manager,                Effect::reads},
    {service::search_connection_data,  connection_manager,                Effect::reads},
    {service::get_connection_owner,    connection_manager,                Effect::reads},
    {cip::file::initiate_upload, cip::file::class_id, Effect::reads},
    {0x4D /* Initiate_Partial_Read */, cip::file::class_id, Effect::reads},
    {cip::file::upload_transfer, cip::file::class_id, Effect::reads},
    {service::set_attribute_single,    any_class,                         Effect::sets},
    {service::set_attribute_list,      any_class,                         Effect::sets},
    {service::set_attributes_all,      any_class,                         Effect::sets},
    {0x19 /* Set_Member */,            any_class,                         Effect::sets},
    {service::reset,                   any_class,                         Effect::resets},
    {service::forward_open,            connection_manager,                Effect::opens},
    {service::large_forward_open,      connection_manager,                Effect::opens},
    {service::forward_close,           connection_manager,                Effect::closes},
});

// What makes up the node's place on the network: whole classes, and the rows of the port for WebMotion.
struct NetworkSetting {
    std::uint32_t class_id;
    std::optional<std::uint32_t> attribute{};
};
constexpr auto network_settings = std::to_array<NetworkSetting>({
    {0xF5},          // TCP/IP Interface
    {0xF6},          // Ethernet Link
    {0x48},          // QoS
    {0x47},          // Device Level Ring
    {0x43},          // Time Sync
    {0x65, 0xBA},    // EGW, gateway
    {0x65, 0xBB},    // EIP, address
    {0x65, 0xBC},    // ENM, net mask
    {0x65, 0xBF},    // EPRT, port
});
// clang-format on

struct Question {
    const cip::Access& access;
    Effect effect;
    const Surroundings& surroundings;
};

bool changes_something(const Question& q) {
    return q.effect == Effect::sets || q.effect == Effect::resets || q.effect == Effect::changes;
}

// An open that is wrong in itself opens nothing, and has a refusal of its own.
bool opens_control(const Question& q) {
    if (q.effect != Effect::opens) return false;
    const bool large = q.access.request.service == service::large_forward_open;
    const auto open = cip::ForwardOpen::parse(q.access.data, large);
    if (!open || open->transport.transport_class == explicit_class) return false;
    const auto wanted = check_io_open(*open, q.surroundings.node);
    return wanted && wanted->connection->kind == assemblies::Connection::Kind::exclusive_owner;
}

bool resets(const Question& q) { return q.effect == Effect::resets; }

bool sets_network(const Question& q) {
    if (!changes_something(q)) return false;
    return std::ranges::any_of(network_settings, [&](const NetworkSetting& setting) {
        return setting.class_id == q.access.path->class_id &&
               (!setting.attribute || setting.attribute == q.access.attribute);
    });
}

// Rows that are two addresses of one variable are one.
drive::Key variable_of(const drive::Parameter& row) { return row.same_as.value_or(row.key()); }

const drive::Parameter* row_of(const Question& q) {
    const auto class_id = q.access.path->class_id;
    if (!q.access.attribute || class_id > 0xFFFF || *q.access.attribute > 0xFFFF) return nullptr;
    return q.surroundings.device.find(
        {static_cast<std::uint16_t>(class_id), static_cast<std::uint16_t>(*q.access.attribute)});
}

// O->T assemblies as a whole are closed to others while there is an owner, hardened or not (AssemblyObject).
bool sets_owned_parameter(const Question& q) {
    if (q.effect != Effect::sets || q.surroundings.owned == nullptr) return false;
    const auto* row = row_of(q);
    if (row == nullptr) return false;
    return std::ranges::any_of(q.surroundings.owned->members, [&](const assemblies::Member& member) {
        if (member.kind != assemblies::Member::Kind::parameter) return false;
        const auto* owned = q.surroundings.device.find(member.key);
        return owned != nullptr && variable_of(*owned) == variable_of(*row);
    });
}

struct Rule {
    bool Protection::*when;
    bool (*concerns)(const Question&);
    std::string_view why;
};

// The first that concerns a request denies it.
constexpr auto rules = std::to_array<Rule>({
    {&Protection::read_only, changes_something, "the drive is read-only"},
    {&Protection::read_only, opens_control, "the drive is read-only, and this connection carries data to it"},
    {&Protection::harden, resets, "a hardened drive is not reset over the network"},
    {&Protection::harden, sets_network, "a hardened drive keeps its network settings"},
    {&Protection::harden, sets_owned_parameter, "the drive is hardened, and an I/O connection owns this parameter"},
});

}  // namespace

Effect effect_of(std::uint8_t code, std::uint32_t class_id) {
    const auto found = std::ranges::find_if(effects, [&](const EffectRow& row) {
        return row.service == code && (row.class_id == any_class || row.class_id == class_id);
    });
    return found != effects.end() ? found->effect : Effect::changes;
}

std::optional<Denial> denied(const Protection& protection, const cip::Access& access,
                             const Surroundings& surroundings) {
    if (!protection.read_only && !protection.harden) return std::nullopt;
    const Question question{access, effect_of(access.request.service, access.path->class_id), surroundings};
    if (question.effect == Effect::reads) return std::nullopt;
    for (const auto& rule : rules) {
        if (protection.*rule.when && rule.concerns(question)) {
            return Denial{cip::GeneralStatus::privilege_violation, rule.why};
        }
    }
    return std::nullopt;
}

}  // namespace servobus::adapter
