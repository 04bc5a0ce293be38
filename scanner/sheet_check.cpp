#include "scanner/sheet_check.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "cip/services.hpp"
#include "cip/wire.hpp"
#include "scanner/sheet_value.hpp"

namespace servobus::scanner {
namespace {

using cip::GeneralStatus;
using Group = Comparison::Group;

constexpr std::uint32_t data_attribute = 3;
constexpr std::uint32_t size_attribute = 4;

Comparison equal(Group group, std::string subject) { return {group, std::move(subject), Agreement::equal, {}}; }
Comparison different(Group group, std::string subject, std::string words) {
    return {group, std::move(subject), Agreement::different, std::move(words)};
}
Comparison not_compared(Group group, std::string subject, std::string words) {
    return {group, std::move(subject), Agreement::not_compared, std::move(words)};
}

// ------------------------------------------------------------------------------------------------------------ identity

std::string named(std::uint32_t number, std::string_view name) {
    return name.empty() ? fmt::format("{}", number) : fmt::format("{} ({})", number, name);
}

Comparison compare_number(const std::string& subject, std::optional<std::uint16_t> in_file, std::uint16_t in_device,
                          std::string_view device_name, const std::string& meaning) {
    if (!in_file) return not_compared(Group::identity, subject, "the file does not say it");
    if (*in_file == in_device) return equal(Group::identity, subject);
    return different(
        Group::identity, subject,
        fmt::format("the device says {}, the file {}: {}", named(in_device, device_name), *in_file, meaning));
}

Comparison compare_revision(const eds::Device& device, const Identity& identity) {
    const std::string subject = "revision";
    if (!device.major_revision) return not_compared(Group::identity, subject, "the file does not say it");
    const auto minor = device.minor_revision.value_or(identity.minor_revision);
    if (*device.major_revision == identity.major_revision && minor == identity.minor_revision) {
        return equal(Group::identity, subject);
    }
    const bool major = *device.major_revision != identity.major_revision;
    return different(Group::identity, subject,
                     fmt::format("the device says {}.{}, the file {}.{}: {}", identity.major_revision,
                                 identity.minor_revision, *device.major_revision, minor,
                                 major ? "no tool takes this file for the device"
                                       : "the file was made for another firmware, and some tools insist on theirs"));
}

// ---------------------------------------------------------------------------------------------------------- parameters

std::string subject_of(const eds::Parameter& parameter) {
    return fmt::format("Param{} {}", parameter.number, parameter.name);
}

Comparison compare_refusal(const eds::Parameter& parameter, const cip::Status& status) {
    const auto subject = subject_of(parameter);
    const auto words = cip::describe(status);
    switch (status.general) {
        case GeneralStatus::attribute_not_gettable:
            if (parameter.read_only()) {
                return different(Group::parameter, subject,
                                 "the file says that it is read only, the device that it cannot be read: " + words);
            }
            return not_compared(Group::parameter, subject, "it can only be written: " + words);
        case GeneralStatus::resource_unavailable:
        case GeneralStatus::object_state_conflict:
        case GeneralStatus::device_state_conflict:
        case GeneralStatus::vendor_specific:
            return not_compared(Group::parameter, subject, "the device does not tell it now: " + words);
        case GeneralStatus::path_destination_unknown:
        case GeneralStatus::object_does_not_exist:
        case GeneralStatus::attribute_not_supported:
            return different(Group::parameter, subject, "the device does not have it: " + words);
        default:
            return different(Group::parameter, subject, "the device does not let it be read: " + words);
    }
}

/// A STRING of odd length may be padded to whole words (R-TYP-5).
bool is_padding(const eds::Parameter& parameter, std::size_t size, std::size_t surplus) {
    return parameter.type == cip::DataType::STRING && size % 2 != 0 && surplus == 1;
}

// ---------------------------------------------------------------------------------------------------------- assemblies

std::string octets_text(std::size_t octets) { return fmt::format("{} octets", octets); }

/// Empty: as it should be, or not told. `point` is the place in the path.
std::string size_difference(std::string_view direction, const IoDirection& flow, const AssemblySize& size) {
    const bool has_data = flow.format != cip::RealTimeFormat::heartbeat && flow.data_octets > 0;
    if (!has_data) return {};
    if (size.is_missing()) return fmt::format("{}: the device has no assembly {}", direction, flow.point);
    if (!size.octets || *size.octets == flow.data_octets) return {};
    return fmt::format("{}: assembly {} has {} in the device, {} in the file", direction, flow.point,
                       octets_text(*size.octets), octets_text(flow.data_octets));
}

/// The data in the path is filled up to whole words.
std::string configuration_difference(const IoPlan& plan, const AssemblySize& size) {
    if (plan.configuration.empty() || !size.octets || (*size.octets + 1) / 2 * 2 == plan.configuration.size())
        return {};
    return fmt::format("configuration: assembly {} has {} in the device, {} in the file",
                       plan.configuration_instance.value_or(0), octets_text(*size.octets),
                       octets_text(plan.configuration.size()));
}

bool is_told(const IoDirection& flow, const AssemblySize& size) {
    return flow.format == cip::RealTimeFormat::heartbeat || flow.data_octets == 0 || size.octets.has_value();
}

std::size_t line_at(cip::ByteView text, std::size_t offset) {
    return 1 + static_cast<std::size_t>(std::ranges::count(text.first(offset), std::uint8_t{'\n'}));
}

}  // namespace

std::string_view name(Comparison::Group group) {
    switch (group) {
        case Group::identity:
            return "identity";
        case Group::parameter:
            return "parameter";
        case Group::assembly:
            return "assembly";
        case Group::connection:
            return "connection";
        case Group::file:
            return "file";
    }
    return "";
}

std::string_view name(Agreement agreement) {
    switch (agreement) {
        case Agreement::equal:
            return "equal";
        case Agreement::different:
            return "different";
        case Agreement::not_compared:
            return "not_compared";
    }
    return "";
}

std::vector<Comparison> compare_identity(const eds::Device& device, const Identity& identity) {
    std::vector<Comparison> all{
        compare_number("vendor", device.vendor, identity.vendor, vendor_name(identity.vendor),
                       "the file is of another maker's device"),
        compare_number("device type", device.product_type, identity.device_type, device_type_name(identity.device_type),
                       "the file is of another kind of device"),
        compare_number("product code", device.product_code, identity.product_code, identity.product_name,
                       "the file is of another product"),
        compare_revision(device, identity),
    };
    if (device.product_name.empty()) {
        all.push_back(not_compared(Group::identity, "product name", "the file does not say it"));
    } else if (device.product_name == identity.product_name) {
        all.push_back(equal(Group::identity, "product name"));
    } else {
        all.push_back(
            different(Group::identity, "product name",
                      fmt::format("the device says '{}', the file '{}'", identity.product_name, device.product_name)));
    }
    return all;
}

std::optional<cip::Request> read_request(const eds::Parameter& parameter) {
    const auto address = parameter.address();
    if (!address || parameter.has(eds::ParameterBit::not_addressable)) return std::nullopt;
    return cip::Request{cip::service::get_attribute_single,
                        cip::Path::to(address->class_id, address->instance, address->attribute),
                        {}};
}

Comparison compare_parameter(const eds::Parameter& parameter, const cip::Response& response) {
    if (!response.status.ok()) return compare_refusal(parameter, response.status);
    const auto subject = subject_of(parameter);
    const auto of_type = eds::octets_of(parameter.type);
    if (of_type && parameter.size && *of_type != *parameter.size) {
        return different(Group::parameter, subject,
                         fmt::format("the file contradicts itself: {} octets, and {} has {}", *parameter.size,
                                     type_name(parameter.type), *of_type));
    }
    const cip::ByteView data(response.data);
    const auto size = value_octets(parameter, data);
    if (!size) {
        return not_compared(Group::parameter, subject,
                            fmt::format("values of {} are not understood here", type_name(parameter.type)));
    }
    if (*size != data.size() && !(*size < data.size() && is_padding(parameter, *size, data.size() - *size))) {
        return different(Group::parameter, subject,
                         fmt::format("{} in the device, {} by the {} of the file", octets_text(data.size()),
                                     octets_text(*size), type_name(parameter.type)));
    }
    const auto value = decode(parameter, data.first(*size));
    if (!value) {
        return not_compared(Group::parameter, subject,
                            fmt::format("values of {} are not understood here", type_name(parameter.type)));
    }
    if (within_limits(parameter, *value)) return equal(Group::parameter, subject);
    const bool is_text = std::holds_alternative<std::string>(*value);
    return different(Group::parameter, subject,
                     fmt::format("its value {} in the device is outside the limits of the file, {}",
                                 is_text ? "'" + std::get<std::string>(*value) + "'" : value_text(parameter, *value),
                                 limits_text(parameter)));
}

std::optional<std::uint32_t> instance_of(const eds::Assembly& assembly) {
    const auto octets = assembly.path.octets();
    const auto path = octets ? eds::segments(*octets) : std::nullopt;
    if (!path || path->segments.size() < 2) return std::nullopt;
    const auto* first = std::get_if<cip::LogicalSegment>(&path->segments[0]);
    const auto* second = std::get_if<cip::LogicalSegment>(&path->segments[1]);
    if (first == nullptr || second == nullptr) return std::nullopt;
    if (first->type != cip::LogicalType::class_id || first->value != cip::class_id::assembly) return std::nullopt;
    const bool names_it =
        second->type == cip::LogicalType::instance || second->type == cip::LogicalType::connection_point;
    return names_it ? std::optional(second->value) : std::nullopt;
}

bool AssemblySize::is_missing() const {
    return !octets && (status.general == GeneralStatus::path_destination_unknown ||
                       status.general == GeneralStatus::object_does_not_exist);
}

cip::Request size_request(std::uint32_t instance) {
    return {cip::service::get_attribute_single, cip::Path::to(cip::class_id::assembly, instance, size_attribute), {}};
}

cip::Request data_request(std::uint32_t instance) {
    return {cip::service::get_attribute_single, cip::Path::to(cip::class_id::assembly, instance, data_attribute), {}};
}

AssemblySize assembly_size(const cip::Response& size, const std::optional<cip::Response>& data) {
    cip::Reader reader(size.data);
    const std::size_t told = reader.u16();
    if (size.status.ok() && reader.ok()) return {.octets = told};
    if (data && data->status.ok()) return {.octets = data->data.size()};
    return {.status = data ? data->status : size.status};
}

Comparison compare_assembly(const eds::Assembly& assembly, const AssemblySize& size) {
    const auto subject = fmt::format("{} {}", assembly.keyword, assembly.name);
    if (size.is_missing()) {
        return different(Group::assembly, subject, "the device does not have it: " + cip::describe(size.status));
    }
    if (!assembly.size) return not_compared(Group::assembly, subject, "the file does not say how long it is");
    if (!size.octets) {
        return not_compared(Group::assembly, subject,
                            "the device does not tell its size: " + cip::describe(size.status));
    }
    if (*size.octets == *assembly.size) return equal(Group::assembly, subject);
    return different(
        Group::assembly, subject,
        fmt::format("{} in the device, {} in the file", octets_text(*size.octets), octets_text(*assembly.size)));
}

Comparison compare_connection(const eds::Connection& connection, const IoPlan& plan, const ConnectionSizes& sizes) {
    const auto subject = fmt::format("{} {}", connection.keyword, connection.name);
    for (const auto& words :
         {size_difference("O->T", plan.o_to_t, sizes.o_to_t), size_difference("T->O", plan.t_to_o, sizes.t_to_o),
          configuration_difference(plan, sizes.configuration)}) {
        if (!words.empty()) return different(Group::connection, subject, words);
    }
    if (is_told(plan.o_to_t, sizes.o_to_t) && is_told(plan.t_to_o, sizes.t_to_o)) {
        return equal(Group::connection, subject);
    }
    return not_compared(Group::connection, subject, "the device does not tell the sizes of its assemblies");
}

Comparison compare_file(cip::ByteView in_device, cip::ByteView file) {
    const std::string subject = "the file in the device (class 0x37)";
    if (std::ranges::equal(in_device, file)) return equal(Group::file, subject);
    const auto [at, other] = std::ranges::mismatch(in_device, file);
    const auto offset = static_cast<std::size_t>(at - in_device.begin());
    return different(Group::file, subject,
                     fmt::format("it is another one: {} in the device, {} here, different from line {} on",
                                 octets_text(in_device.size()), octets_text(file.size()), line_at(file, offset)));
}

}  // namespace servobus::scanner
