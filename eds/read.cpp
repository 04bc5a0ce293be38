#include <fmt/format.h>

#include <algorithm>

#include "eds/base64.hpp"
#include "eds/data_sheet.hpp"
#include "eds/entry_reader.hpp"

namespace servobus::eds {
namespace {

constexpr std::size_t reserved_parameter_fields = 1;

class SheetReader {
public:
    explicit SheetReader(const Document& document) : document_(document) { sheet_.findings = document.warnings; }

    DataSheet run() {
        read_file();
        read_device();
        for (const auto& section : document_.sections) read_section(section);
        for (const auto* entry : enumerations_) read_enumeration(*entry);
        sizes_.resize(sheet_.assemblies.size());
        for (std::size_t i = 0; i < sizes_.size(); ++i) size_of(i, 0);
        for (const auto* entry : connections_) read_connection(*entry);
        return std::move(sheet_);
    }

private:
    EntryReader reader(const Entry& entry) { return {entry, sheet_.findings}; }

    // Calls `read` with the entry of a section, when it is there.
    template <class Read>
    void with(std::string_view section, std::string_view keyword, Read read) {
        if (const auto* entry = document_.find(section, keyword)) {
            auto fields = reader(*entry);
            read(fields);
        }
    }
    void text(std::string_view section, std::string_view keyword, std::string& into) {
        with(section, keyword, [&](auto& fields) { into = fields.text(1); });
    }
    template <class T>
    void number(std::string_view section, std::string_view keyword, std::optional<T>& into) {
        with(section, keyword, [&](auto& fields) { into = fields.template number<T>(1, "number"); });
    }

    void read_file() {
        auto& file = sheet_.file;
        text("File", "DescText", file.description);
        with("File", "CreateDate", [&](auto& fields) { file.create_date = fields.value(1, date, "date mm-dd-yyyy"); });
        with("File", "CreateTime",
             [&](auto& fields) { file.create_time = fields.value(1, time_of_day, "time hh:mm:ss"); });
        with("File", "ModDate",
             [&](auto& fields) { file.modification_date = fields.value(1, date, "date mm-dd-yyyy"); });
        with("File", "ModTime",
             [&](auto& fields) { file.modification_time = fields.value(1, time_of_day, "time hh:mm:ss"); });
        with("File", "Revision", [&](auto& fields) { file.revision = fields.value(1, revision, "revision like 1.0"); });
        text("File", "HomeURL", file.home_url);
    }

    void read_device() {
        auto& device = sheet_.device;
        number("Device", "VendCode", device.vendor);
        text("Device", "VendName", device.vendor_name);
        number("Device", "ProdType", device.product_type);
        text("Device", "ProdTypeStr", device.product_type_name);
        number("Device", "ProdCode", device.product_code);
        number("Device", "MajRev", device.major_revision);
        number("Device", "MinRev", device.minor_revision);
        text("Device", "ProdName", device.product_name);
        text("Device", "Catalog", device.catalog);
        text("Device", "Icon", device.icon);
        with("Device", "IconContents", [&](auto& fields) {
            const auto icon = from_base64(fields.text(1));
            if (icon) {
                device.icon_content = *icon;
            } else {
                fields.note(Severity::error, "it is no base64");
            }
        });
    }

    void read_section(const Section& section) {
        read_class(section);
        const bool manages_connections = same_name(std::string_view(section.name).substr(0, 18), "Connection Manager");
        for (const auto& entry : section.entries) {
            const auto is = [&](std::string_view name, std::string_view prefix) {
                return same_name(section.name, name) && number_behind(prefix, entry.keyword);
            };
            if (is("Params", "Param")) {
                read_parameter(entry);
            } else if (is("Params", "Enum")) {
                enumerations_.push_back(&entry);
            } else if (is("Groups", "Group")) {
                read_group(entry);
            } else if (same_name(section.name, "Assembly")) {
                read_assembly(entry);
            } else if (manages_connections && number_behind("Connection", entry.keyword)) {
                connections_.push_back(&entry);
            } else if (is("Device Classification", "Class")) {
                sheet_.classifications.push_back(entry.field(1).value);
            } else if (is("Port", "Port")) {
                read_port(entry);
            } else if (same_name(section.name, "Capacity")) {
                read_capacity(entry);
            }
        }
    }

    void read_class(const Section& section) {
        ObjectClass object{.section = section.name};
        bool any = section.name.ends_with(" Class");
        const auto take = [&](std::string_view keyword, auto& into) {
            const auto* entry = section.find(keyword);
            if (entry == nullptr) return;
            any = any || keyword == "Object_Class_Code";
            into = reader(*entry).number<std::uint32_t>(1, "number");
        };
        if (same_name(section.name, "File") || same_name(section.name, "ParamClass")) return;
        take("Object_Class_Code", object.class_id);
        take("Revision", object.revision);
        take("MaxInst", object.max_instance);
        take("Number_Of_Static_Instances", object.static_instances);
        if (any) sheet_.classes.push_back(std::move(object));
    }

    Value read_value(EntryReader& fields, std::size_t at, const Parameter& parameter, bool is_limit) {
        const auto& field = fields.field(at);
        if (field.is_empty()) return {};
        switch (kind_of(parameter.type)) {
            case TypeKind::text:
                if (!is_limit) return fields.text(at);
                break;
            case TypeKind::real:
                if (const auto number = real(field)) return *number;
                break;
            case TypeKind::boolean:
            case TypeKind::signed_integer:
            case TypeKind::unsigned_integer:
            case TypeKind::unknown:
                break;
        }
        if (const auto whole = integer(field)) return *whole;
        // Dates and the like, and types of which nothing is known, are as they are written.
        if (octets_of(parameter.type) && kind_of(parameter.type) != TypeKind::unknown && !date(field) &&
            !time_of_day(field)) {
            fields.object(at, "no value of the data type");
        }
        return field.value;
    }

    Scaling read_scaling(EntryReader& fields) {
        Scaling scaling;
        const auto take = [&](std::size_t at, double& into) {
            if (const auto number = fields.value(at, real, "number")) into = *number;
        };
        take(13, scaling.multiplier);
        take(14, scaling.divisor);
        take(15, scaling.base);
        take(16, scaling.offset);
        for (std::size_t i = 0; i < scaling.links.size(); ++i) {
            const auto& field = fields.field(17 + i);
            if (const auto reference = parameter_reference(field)) {
                scaling.links.at(i) = *reference;
            } else {
                scaling.links.at(i) = fields.number<std::uint32_t>(17 + i, "number of a Param").value_or(0);
            }
        }
        return scaling;
    }

    void read_parameter(const Entry& entry) {
        auto fields = reader(entry);
        Parameter parameter{.number = number_behind("Param", entry.keyword).value_or(0), .line = entry.line};
        parameter.path = fields.path(reserved_parameter_fields + 2);
        parameter.descriptor = fields.number<std::uint16_t>(4, "descriptor").value_or(0);
        parameter.type = static_cast<cip::DataType>(fields.number<std::uint8_t>(5, "data type").value_or(0));
        parameter.size = fields.number<std::uint16_t>(6, "size in octets");
        if (!parameter.size) parameter.size = octets_of(parameter.type);
        parameter.name = fields.text(7);
        parameter.units = fields.text(8);
        parameter.help = fields.text(9);
        parameter.minimum = read_value(fields, 10, parameter, true);
        parameter.maximum = read_value(fields, 11, parameter, true);
        parameter.standard = read_value(fields, 12, parameter, false);
        parameter.scaling = read_scaling(fields);
        parameter.decimals = fields.number<std::uint8_t>(21, "number of decimal places").value_or(0);
        sheet_.parameter_index.try_emplace(parameter.number, sheet_.parameters.size());
        sheet_.parameters.push_back(std::move(parameter));
    }

    // Pairs of a value and its text.
    void read_enumeration(const Entry& entry) {
        auto fields = reader(entry);
        const auto number = number_behind("Enum", entry.keyword).value_or(0);
        const auto found = sheet_.parameter_index.find(number);
        if (found == sheet_.parameter_index.end()) {
            return fields.note(Severity::error, fmt::format("there is no Param{}", number));
        }
        auto& enumeration = sheet_.parameters[found->second].enumeration;
        for (std::size_t at = 1; at <= entry.fields.size(); at += 2) {
            if (fields.field(at).is_empty() && at == entry.fields.size()) return;  // a comma at the end
            const auto value = fields.value(at, integer, "number");
            if (value) enumeration.push_back({*value, fields.text(at + 1)});
        }
    }

    void read_group(const Entry& entry) {
        auto fields = reader(entry);
        Group group{.name = fields.text(1), .line = entry.line};
        for (std::size_t at = 3; at <= entry.fields.size(); ++at) {
            auto number = parameter_reference(fields.field(at));
            if (!number) number = fields.number<std::uint32_t>(at, "number of a Param");
            if (number) group.parameters.push_back(*number);
        }
        sheet_.groups.push_back(std::move(group));
    }

    static std::optional<std::uint32_t> assembly_number(std::string_view keyword) {
        for (const auto* prefix :
             {"Assem", "AssemExa", "ProxyAssem", "ProxyAssemExa", "ProxiedAssem", "ProxiedAssemExa"}) {
            if (const auto number = number_behind(prefix, keyword)) return number;
        }
        return std::nullopt;
    }

    void read_assembly(const Entry& entry) {
        const auto number = assembly_number(entry.keyword);
        if (!number) return;
        auto fields = reader(entry);
        Assembly assembly{.keyword = entry.keyword, .number = *number, .line = entry.line};
        assembly.name = fields.text(1);
        assembly.path = fields.path(2);
        if (!parameter_reference(fields.field(3))) assembly.size = fields.number<std::uint16_t>(3, "size in octets");
        assembly.descriptor = fields.number<std::uint16_t>(4, "descriptor").value_or(0);
        for (std::size_t at = 7; at <= entry.fields.size(); at += 2) {
            if (at == entry.fields.size() && fields.field(at).is_empty()) break;  // no members, or a comma at the end
            assembly.members.push_back(
                {fields.number<std::uint32_t>(at, "number of bits"), member_reference(fields, at + 1)});
        }
        sheet_.assembly_index.try_emplace(lower_case(entry.keyword), sheet_.assemblies.size());
        sheet_.assemblies.push_back(std::move(assembly));
    }

    static Member::Reference member_reference(EntryReader& fields, std::size_t at) {
        const auto& field = fields.field(at);
        if (field.is_empty()) return {};
        if (const auto number = parameter_reference(field)) return Member::Parameter{*number};
        if (field.kind == Field::Kind::word && assembly_number(field.value)) return Member::Assembly{field.value};
        if (const auto constant = integer(field)) return *constant;
        if (field.kind == Field::Kind::text) return fields.path(at);
        return Member::Assembly{field.value};  // a Variant, an Array: nothing that this reader looks into
    }

    // Octets that an assembly states, or that its members have. Inner ones first, each once; one that is inside itself
    // has no size.
    std::optional<std::size_t> size_of(std::size_t index, unsigned depth) {
        auto& assembly = sheet_.assemblies[index];
        if (assembly.size || sizes_[index] == Size::looked_for || depth > max_assembly_depth) return assembly.size;
        sizes_[index] = Size::looked_for;
        assembly.size = octets_of_members(assembly, depth);
        return assembly.size;
    }

    std::optional<std::size_t> octets_of_members(const Assembly& assembly, unsigned depth) {
        std::uint64_t bits = 0;
        for (const auto& member : assembly.members) {
            const auto count = member.bits ? *member.bits : bits_of(member, depth);
            if (!count) return std::nullopt;
            bits += *count;
        }
        const auto octets = (bits + 7) / 8;
        return octets <= max_image_octets && !assembly.members.empty() ? std::optional(octets) : std::nullopt;
    }

    std::optional<std::uint64_t> bits_of(const Member& member, unsigned depth) {
        std::optional<std::size_t> octets;
        if (const auto* reference = std::get_if<Member::Parameter>(&member.reference)) {
            const auto* parameter = sheet_.parameter(reference->number);
            if (parameter != nullptr) octets = parameter->size;
        } else if (const auto* inner = std::get_if<Member::Assembly>(&member.reference)) {
            const auto found = sheet_.assembly_index.find(lower_case(inner->keyword));
            if (found != sheet_.assembly_index.end()) octets = size_of(found->second, depth + 1);
        }
        return octets ? std::optional<std::uint64_t>(8 * *octets) : std::nullopt;
    }

    static std::optional<std::uint32_t> limit(const Value& value) {
        const auto* number = std::get_if<std::int64_t>(&value);
        if (number == nullptr || *number < 0 || *number > std::numeric_limits<std::uint32_t>::max())
            return std::nullopt;
        return static_cast<std::uint32_t>(*number);
    }

    // A number, or the Param that holds it.
    Range range(EntryReader& fields, std::size_t at) {
        const auto number = parameter_reference(fields.field(at));
        if (!number) {
            const auto fixed = fields.number<std::uint32_t>(at, "number and no Param");
            return {.parameter = {}, .minimum = fixed, .maximum = fixed, .standard = fixed};
        }
        const auto* parameter = sheet_.parameter(*number);
        if (parameter == nullptr) {
            fields.object(at, "which is not there");
            return {.parameter = number};
        }
        return {.parameter = number,
                .minimum = limit(parameter->minimum),
                .maximum = limit(parameter->maximum),
                .standard = limit(parameter->standard)};
    }

    // The size of a direction or of a configuration, which is that of its format when its own field is empty.
    Range size(EntryReader& fields, std::size_t at) {
        if (!fields.field(at).is_empty()) return range(fields, at);
        const auto& format = fields.field(at + 1).value;
        std::optional<std::size_t> octets;
        if (const auto* assembly = sheet_.assembly(format)) {
            octets = assembly->size;
        } else if (const auto number = parameter_reference(fields.field(at + 1))) {
            const auto* parameter = sheet_.parameter(*number);
            if (parameter != nullptr) octets = parameter->size;
        }
        if (!octets) return {};
        const auto fixed = static_cast<std::uint32_t>(*octets);
        return {.parameter = {}, .minimum = fixed, .maximum = fixed, .standard = fixed};
    }

    std::string format(EntryReader& fields, std::size_t at) {
        const auto& field = fields.field(at);
        const auto number = parameter_reference(field);
        const bool known = number ? sheet_.parameter(*number) != nullptr : sheet_.assembly(field.value) != nullptr;
        if (!known && field.kind == Field::Kind::word) fields.object(at, "which is not there");
        return field.value;
    }

    void read_connection(const Entry& entry) {
        auto fields = reader(entry);
        Connection connection{.keyword = entry.keyword, .line = entry.line};
        connection.transport.bits = fields.number<std::uint32_t>(1, "trigger and transport").value_or(0);
        connection.parameters.bits = fields.number<std::uint32_t>(2, "connection parameters").value_or(0);
        connection.o_to_t = {range(fields, 3), size(fields, 4), format(fields, 5)};
        connection.t_to_o = {range(fields, 6), size(fields, 7), format(fields, 8)};
        connection.proxy_configuration = {size(fields, 9), format(fields, 10)};
        connection.target_configuration = {size(fields, 11), format(fields, 12)};
        connection.name = fields.text(13);
        connection.help = fields.text(14);
        connection.path = fields.path(15);
        sheet_.connections.push_back(std::move(connection));
    }

    void read_port(const Entry& entry) {
        auto fields = reader(entry);
        sheet_.ports.push_back({.type = fields.word(1),
                                .name = fields.field(2).value,  // in quotes or not
                                .path = fields.path(3),
                                .number = fields.number<std::uint16_t>(4, "number")});
    }

    void read_capacity(const Entry& entry) {
        auto fields = reader(entry);
        auto& capacity = sheet_.capacity;
        const auto count = [&](std::string_view keyword, std::optional<std::uint32_t>& into) {
            if (same_name(entry.keyword, keyword)) into = fields.number<std::uint32_t>(1, "number");
        };
        count("MaxIOConnections", capacity.io_connections);
        count("MaxMsgConnections", capacity.message_connections);
        count("MaxConsumersPerMcast", capacity.consumers_per_multicast);
        if (!number_behind("TSpec", entry.keyword)) return;
        capacity.traffic.push_back({.direction = fields.word(1),
                                    .size = fields.number<std::uint32_t>(2, "size in octets"),
                                    .packets_per_second = fields.number<std::uint32_t>(3, "number")});
    }

    enum class Size : std::uint8_t { not_looked_for, looked_for };

    const Document& document_;
    DataSheet sheet_{};
    std::vector<Size> sizes_{};                 ///< of each assembly
    std::vector<const Entry*> enumerations_{};  ///< for when all Params are known
    std::vector<const Entry*> connections_{};   ///< for when all assemblies are known
};

}  // namespace

DataSheet read(const Document& document) { return SheetReader(document).run(); }

boost::system::result<DataSheet, Finding> read(std::string_view octets) {
    const auto document = parse(octets);
    if (!document) return document.error();
    return read(*document);
}

}  // namespace servobus::eds
