#include "adapter/access_gate.hpp"

#include <optional>
#include <utility>

#include "adapter/identity_object.hpp"
#include "cip/services.hpp"

namespace servobus::adapter {
namespace {

// What is told by its parts is not told once more.
bool parts_tell(Effect effect, const cip::Access& access, const cip::Response& response) {
    const auto status = response.status.general;
    if (effect == Effect::carries) {
        const bool its_own = response.service == access.request.service;  // otherwise it is that of the request in it
        return !its_own || status == cip::GeneralStatus::success ||
               status == cip::GeneralStatus::embedded_service_error;
    }
    const bool has_entries = access.request.service == cip::service::set_attribute_list && !access.is_entry;
    return has_entries && (status == cip::GeneralStatus::success || status == cip::GeneralStatus::attribute_list_error);
}

}  // namespace

cip::Status AccessGate::admit(const cip::Access& access) {
    why_ = {};
    if (!protection_.read_only && !protection_.harden) return {};
    auto denial = denied(protection_, access, {node_identity(device_.identity()), device_, questions_.owned()});
    if (!denial) return {};
    why_ = denial->why;
    return std::move(denial->status);
}

void AccessGate::ended(const cip::Access& access, const cip::Response& response) {
    const auto why = std::exchange(why_, {});
    const auto effect = effect_of(access.request.service, access.path != nullptr ? access.path->class_id : 0);
    if (effect == Effect::reads || parts_tell(effect, access, response)) return;
    using Kind = AccessLog::Kind;
    const bool about_connections = (effect == Effect::opens || effect == Effect::closes) && why.empty();
    const auto kind = about_connections ? Kind::connection : response.status.ok() ? Kind::change : Kind::refusal;
    log_.note(kind, questions_.true_time(access.origin.now), [&] {
        return access_line(access, response.status, questions_.handle(access.origin.session), device_, why);
    });
}

}  // namespace servobus::adapter
