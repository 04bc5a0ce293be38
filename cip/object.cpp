#include "cip/object.hpp"

#include <utility>

namespace servobus::cip {

bool Object::get_class_attribute(std::uint32_t, Writer&) const { return false; }

Status Object::set(std::uint32_t, std::uint32_t, ByteView) { return GeneralStatus::attribute_not_settable; }

std::optional<std::size_t> Object::value_size(std::uint32_t, std::uint32_t, ByteView) const { return std::nullopt; }

Response Object::call(const RequestView& request, const RequestPath&, const Origin&) {
    return {request.service, GeneralStatus::service_not_supported, {}};
}

Response Object::refuse(const RequestView& request, Status status) { return {request.service, std::move(status), {}}; }

}  // namespace servobus::cip
