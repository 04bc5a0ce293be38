#include "eds/generate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <vector>

#include "assemblies/connection.hpp"
#include "assemblies/layout.hpp"
#include "assemblies/parameter_value.hpp"
#include "cip/hex.hpp"
#include "cip/path.hpp"
#include "drive/lookup.hpp"
#include "drive/value_names.hpp"
#include "drive/xenax.hpp"
#include "eds/base64.hpp"
#include "eds/connection_words.hpp"
#include "eds/icon.hpp"
#include "eds/parameter.hpp"
#include "eds/sheet_text.hpp"

namespace servobus::eds {
namespace {

using assemblies::Connection;

// Of the file, not of the day on which it is written.
constexpr std::string_view sheet_date = "11-21-2025";
constexpr std::string_view sheet_time = "12:00:00";

constexpr std::uint32_t default_rpi = 10'000;
constexpr std::uint32_t microseconds_per_second = 1'000'000;
constexpr std::size_t count_of_string_octets = 2;

std::string hex_path(const cip::Path& path) { return fmt::format("\"{}\"", cip::to_hex(path.encode())); }

std::string_view type_name(drive::Type type) {
    switch (type) {
        case drive::Type::i8:
            return "SINT";
        case drive::Type::i16:
            return "INT";
        case drive::Type::i32:
            return "DINT";
        case drive::Type::u8:
            return "USINT";
        case drive::Type::u16:
            return "UINT";
        case drive::Type::u32:
            return "UDINT";
        case drive::Type::text:
            return "STRING";
    }
    return "";
}

// "000 §2.3.1.1" in ASCII.
std::string ascii_section(std::string_view section) {
    std::string text(section);
    constexpr std::string_view sign = "\xC2\xA7";
    for (auto at = text.find(sign); at != std::string::npos; at = text.find(sign)) text.erase(at, sign.size());
    return text;
}

// A class whose instances the sheet counts (R-EDS-10).
struct ClassSection {
    std::string_view section;
    std::string_view name;
    unsigned class_id;
    unsigned revision;
    unsigned max_instance;
    unsigned instances;
};

constexpr std::array class_sections{
    ClassSection{"Identity Class", "Identity Object", 0x01, 1, 1, 1},
    ClassSection{"File Class", "File Object", 0x37, 3, 0xC9, 2},  // 0xC8 the sheet, 0xC9 the icon (R-FIL-1)
    ClassSection{"DLR Class", "Device Level Ring Object", 0x47, 3, 1, 1},
    ClassSection{"QoS Class", "Quality of Service Object", 0x48, 1, 1, 1},
    ClassSection{"TCP/IP Interface Class", "TCP/IP Interface Object", 0xF5, 4, 1, 1},
    ClassSection{"Ethernet Link Class", "Ethernet Link Object", 0xF6, 4, 2, 2},
};

// An instance of the Assembly object that has no octets: it is only a name in a path (R-DEV-7).
struct EmptyAssembly {
    unsigned instance;
    std::string_view name;
};
constexpr std::array empty_assemblies{
    EmptyAssembly{assemblies::configuration_instance, "Configuration"},
    EmptyAssembly{assemblies::input_only_point, "Heartbeat, input only"},
    EmptyAssembly{assemblies::listen_only_point, "Heartbeat, listen only"},
};

// Multiplier, divisor, base, offset, their links, and decimal places.
constexpr std::string_view no_scaling = "1,1,1,0,,,,,0";

constexpr std::array<std::string_view, 5> parameter_fields{
    "ParamN = 0, octets of the path, path, descriptor, data type, octets of the value, name, units, help,",
    "         minimum, maximum, default, multiplier, divisor, base, offset, links to these four, decimal places;",
    "Descriptor: bit 1 the values have names (EnumN = value, name, ...), bit 4 read only, bit 7 the named values have",
    "gaps; the other bits are not used. Minimum and maximum of a STRING are of its number of characters. The number",
    "behind ParamN is the section of the manual.",
};

// Bits of the two words of a connection, as the comments behind them say.
constexpr std::array<std::string_view, 7> transport_bits{
    "0-6     transport classes that it may have, here class 1",
    "16      trigger: cyclic",
    "17      trigger: change of state",
    "18      trigger: application",
    "24-27   listen only, input only, exclusive owner, redundant owner",
    "31      server",
    "others  reserved",
};
constexpr std::array<std::string_view, 9> parameter_bits{
    "0, 1    O->T size: fixed, variable",
    "2, 3    T->O size: fixed, variable",
    "8-10    O->T format: 0 modeless, 1 zero length, 3 heartbeat, 4 32-bit header",
    "12-14   T->O format",
    "16-18   O->T type: null, multicast, point to point",
    "20-22   T->O type",
    "24-27   O->T priority: low, high, scheduled, urgent",
    "28-31   T->O priority",
    "others  reserved",
};

TransportWord transport_word(const Connection& connection) {
    constexpr std::uint32_t class_1 = 1U << 1;
    constexpr std::uint32_t cyclic = 1U << 16;
    Ownership ownership = Ownership::exclusive_owner;
    if (connection.kind == Connection::Kind::input_only) ownership = Ownership::input_only;
    if (connection.kind == Connection::Kind::listen_only) ownership = Ownership::listen_only;
    return {class_1 | cyclic | 1U << (24 + static_cast<unsigned>(ownership))};
}

// Who only listens joins a multicast, so it has no point to point.
ParameterWord parameter_word(const Connection& connection) {
    constexpr std::uint32_t fixed = 0b0101;
    constexpr std::uint32_t o_to_t_point_to_point = 1U << 18;
    constexpr std::uint32_t t_to_o_multicast = 1U << 21;
    constexpr std::uint32_t t_to_o_point_to_point = 1U << 22;
    constexpr std::uint32_t scheduled = 1U << 26 | 1U << 30;
    auto bits = fixed | o_to_t_point_to_point | t_to_o_multicast | scheduled;
    bits |= static_cast<std::uint32_t>(connection.o_to_t_format()) << 8;
    bits |= static_cast<std::uint32_t>(connection.t_to_o_format()) << 12;
    if (connection.kind != Connection::Kind::listen_only) bits |= t_to_o_point_to_point;
    return {bits};
}

std::string_view help(const Connection& connection) {
    return connection.kind == Connection::Kind::exclusive_owner ? "Commands the drive, and is told its state."
                                                                : "Is told the drive's state, and commands nothing.";
}

class Generator {
public:
    Generator(const drive::Model& model, const ConnectionLimits& limits) : model_(model), limits_(limits) {
        for (const auto& row : model.parameters) {
            if (!row.force_option || model.has_force_option) rows_.push_back(&row);
        }
        for (std::size_t i = 0; i < rows_.size(); ++i) numbers_[rows_[i]->key()] = static_cast<unsigned>(i + 1);
        for (const auto* row : rows_) {
            if (!names_.insert(row->name).second) repeated_names_.insert(row->name);
        }
    }

    std::string run() {
        write_head();
        write_file();
        write_device();
        write_parameters();
        write_groups();
        write_assemblies();
        write_connections();
        write_port_and_capacity();
        for (const auto& each : class_sections) write_class(each);
        return text_.take();
    }

private:
    [[nodiscard]] std::size_t rpi_parameter() const { return rows_.size() + 1; }

    void write_head() {
        text_.comment(file_name(model_));
        text_.comment("");
        text_.comment(
            fmt::format("Electronic data sheet of a {} on EtherNet/IP, written by Servobus from the", model_.name));
        text_.comment("parameter table of its virtual drive. It is not the sheet of Jenny Science AG.");
        text_.comment("000: manual of the EtherNet/IP bus module.");
    }

    void write_file() {
        text_.section("File");
        text_.entry("DescText", quoted(fmt::format("{} servo controller", model_.name)));
        text_.entry("CreateDate", sheet_date);
        text_.entry("CreateTime", sheet_time);
        text_.entry("ModDate", sheet_date);
        text_.entry("ModTime", sheet_time);
        text_.entry("Revision", fmt::format("{}.{}", sheet_revision.major, sheet_revision.minor));
    }

    void write_device() {
        const auto& identity = model_.identity;
        text_.section("Device");
        text_.entry("VendCode", fmt::to_string(identity.vendor));
        text_.entry("VendName", quoted("Jenny Science AG"));
        text_.entry("ProdType", fmt::to_string(identity.device_type));
        text_.entry("ProdTypeStr", quoted("Generic Device (keyable)"));
        text_.entry("ProdCode", fmt::to_string(identity.product_code), fmt::format("0x{:04X}", identity.product_code));
        text_.entry("MajRev", fmt::to_string(identity.major_revision));
        text_.entry("MinRev", fmt::to_string(identity.minor_revision));
        text_.entry("ProdName", quoted(identity.product_name));
        text_.entry("Catalog", quoted(model_.name));
        text_.entry("Icon", quoted(icon_file_name));
        text_.open("IconContents");
        text_.close(quoted_block(to_base64(icon())));
        text_.section("Device Classification");
        text_.entry("Class1", "EtherNetIP");
    }

    void write_parameters() {
        text_.section("ParamClass");
        text_.entry("MaxInst", fmt::to_string(rpi_parameter()));
        text_.entry("Descriptor", "0x0000", "no Parameter object in the device: by path alone");
        text_.entry("CfgAssembly", "0");
        text_.section("Params");
        for (const auto line : parameter_fields) text_.comment(line);
        for (const auto* row : rows_) write_parameter(*row);
        write_rpi();
    }

    // The name that a user chooses by: with its class in front where two classes have it.
    [[nodiscard]] std::string name(const drive::Parameter& row) const {
        return repeated_names_.contains(row.name) ? drive::qualified_name(drive::parameter_classes(), row)
                                                  : std::string(row.name);
    }

    [[nodiscard]] static std::uint16_t descriptor(const drive::Parameter& row) {
        unsigned bits = 0;
        if (!drive::may_set(row.access)) bits |= mask(ParameterBit::read_only);
        if (!row.allowed.empty()) bits |= mask(ParameterBit::enumerated) | mask(ParameterBit::gaps_in_enumeration);
        return static_cast<std::uint16_t>(bits);
    }

    // Of a text its lengths; a command that has no legal value before it is given has no default.
    [[nodiscard]] static std::string limits(const drive::Parameter& row) {
        if (row.is_text()) return fmt::format("0,{},{}", row.max_length, quoted(row.standard_text));
        const bool has_default =
            row.allowed.empty() || std::ranges::find(row.allowed, row.standard) != row.allowed.end();
        return fmt::format("{},{},{}", row.low, row.high, has_default ? fmt::to_string(row.standard) : "");
    }

    [[nodiscard]] static std::string help(const drive::Parameter& row) {
        return drive::may_get(row.access) ? std::string(row.text) : fmt::format("Only to be written. {}", row.text);
    }

    void write_parameter(const drive::Parameter& row) {
        const auto number = numbers_.at(row.key());
        const auto path = cip::Path::to(row.cip.class_id, row.cip.instance, row.cip.attribute);
        const auto octets = row.is_text() ? count_of_string_octets + row.max_length : drive::size_of(row.cip.type);
        text_.open(fmt::format("Param{}", number), ascii_section(row.section));
        text_.fields(fmt::format("0,{},{},0x{:04X}", 2 * path.words(), hex_path(path), descriptor(row)));
        text_.fields(fmt::format("0x{:02X},{}", static_cast<unsigned>(assemblies::data_type(row.cip.type)), octets),
                     type_name(row.cip.type));
        text_.fields(fmt::format("{},{}", quoted(name(row)), quoted(row.unit)));
        text_.fields(quoted(help(row)));
        text_.fields(limits(row));
        text_.close(no_scaling);
        write_enumeration(number, row);
    }

    void write_enumeration(unsigned number, const drive::Parameter& row) {
        const auto names = drive::value_names(model_, row);
        if (names.empty()) return;
        text_.open(fmt::format("Enum{}", number));
        for (const auto& each : names) {
            const auto pair = fmt::format("{},{}", each.value, quoted(each.name));
            if (each.value == names.back().value) {
                text_.close(pair);
            } else {
                text_.fields(pair);
            }
        }
    }

    void write_rpi() {
        text_.open(fmt::format("Param{}", rpi_parameter()), "of the connections");
        text_.fields("0,,,0x0000");
        text_.fields("0xC8,4", type_name(drive::Type::u32));
        text_.fields(fmt::format("{},{}", quoted("RPI"), quoted("us")));
        text_.fields(quoted("Requested packet interval: how often a connection sends its data."));
        text_.fields(fmt::format("{},{},{}", assemblies::smallest_rpi, assemblies::largest_rpi, default_rpi));
        text_.close(no_scaling);
    }

    // A group for each class of the manual that the variant has rows of.
    void write_groups() {
        text_.section("Groups");
        unsigned group = 0;
        for (const auto& each : drive::parameter_classes()) {
            std::vector<unsigned> members;
            for (const auto* row : rows_) {
                if (row->cip.class_id == each.class_id) members.push_back(numbers_.at(row->key()));
            }
            if (members.empty()) continue;
            text_.open(fmt::format("Group{}", ++group), fmt::format("class 0x{:02X}", each.class_id));
            text_.fields(fmt::format("{},{}", quoted(each.title), members.size()));
            write_numbers(members);
        }
    }

    void write_numbers(std::span<const unsigned> numbers) {
        constexpr std::size_t in_a_line = 16;
        while (numbers.size() > in_a_line) {
            text_.fields(fmt::format("{}", fmt::join(numbers.first(in_a_line), ",")));
            numbers = numbers.subspan(in_a_line);
        }
        text_.close(fmt::format("{}", fmt::join(numbers, ",")));
    }

    void write_assemblies() {
        const auto layouts = assemblies::layouts();
        text_.section("Assembly");
        text_.entry("Revision", "2");
        text_.entry("Object_Name", quoted("Assembly Object"));
        text_.entry("Object_Class_Code", "0x04");
        text_.entry("MaxInst", fmt::to_string(std::uint16_t{assemblies::listen_only_point}));
        text_.entry("Number_Of_Static_Instances", fmt::to_string(layouts.size() + empty_assemblies.size()));
        text_.entry("Max_Number_Of_Dynamic_Instances", "0");
        for (const auto& each : empty_assemblies) {
            if (each.instance < layouts.front().instance) write_empty_assembly(each);
        }
        for (const auto& layout : layouts) write_assembly(layout);
        for (const auto& each : empty_assemblies) {
            if (each.instance > layouts.front().instance) write_empty_assembly(each);
        }
    }

    void open_assembly(unsigned instance, std::string_view name, std::size_t octets) {
        constexpr std::uint32_t assembly_class = 0x04;
        constexpr std::uint32_t data = 3;
        text_.open(fmt::format("Assem{}", instance));
        text_.fields(quoted(name), "name");
        text_.fields(hex_path(cip::Path::to(assembly_class, instance, data)), "path");
        text_.fields(fmt::to_string(octets), "size in octets");
        text_.fields("0x0000", "descriptor");
    }

    void write_empty_assembly(const EmptyAssembly& assembly) {
        open_assembly(assembly.instance, assembly.name, 0);
        text_.close(",", "reserved");
    }

    // What a member refers to: its Param, or nothing for padding and for what this variant does not have.
    [[nodiscard]] std::string reference(const assemblies::Member& member) const {
        const auto found = numbers_.find(member.key);
        const bool is_row = member.kind == assemblies::Member::Kind::parameter && found != numbers_.end();
        return is_row ? fmt::format("Param{}", found->second) : std::string();
    }

    [[nodiscard]] std::string member_comment(const assemblies::Member& member) const {
        if (member.kind == assemblies::Member::Kind::time_stamp) return "time stamp, microseconds";
        const auto found = numbers_.find(member.key);
        if (member.kind != assemblies::Member::Kind::parameter || found == numbers_.end()) return "not used";
        return name(*rows_[found->second - 1]);
    }

    void write_assembly(const assemblies::Layout& layout) {
        const bool out = layout.direction == assemblies::Direction::o_to_t;
        open_assembly(layout.instance, fmt::format("{} {}", layout.name, out ? "output" : "input"), layout.size());
        text_.fields(",", "reserved");
        for (const auto& member : layout.members) {
            const auto pair = fmt::format("{},{}", 8 * member.octets, reference(member));
            if (&member == &layout.members.back()) {
                text_.close(pair, member_comment(member));
            } else {
                text_.fields(pair, member_comment(member));
            }
        }
    }

    // One of each kind that anybody can open: who listens needs another's connection, and is no choice of a tool.
    [[nodiscard]] static std::vector<const Connection*> offered() {
        std::vector<const Connection*> list;
        for (const auto& each : assemblies::connections()) {
            const bool listens = each.kind == Connection::Kind::listen_only;
            if (!listens && assemblies::find_connection(each.key) == &each) list.push_back(&each);
        }
        return list;
    }

    void write_connections() {
        text_.section("Connection Manager");
        text_.entry("Revision", "1");
        text_.entry("Object_Name", quoted("Connection Manager Object"));
        text_.entry("Object_Class_Code", "0x06");
        text_.entry("MaxInst", "1");
        text_.entry("Number_Of_Static_Instances", "1");
        text_.entry("Max_Number_Of_Dynamic_Instances", "0");
        text_.entry("PITNS", "Yes", "production inhibit time in milliseconds (segment 0x43)");
        text_.entry("PITNS_usec", "Yes", "and in microseconds (segment 0x51)");
        unsigned number = 0;
        for (const auto* connection : offered()) write_connection(++number, *connection);
    }

    template <std::size_t N>
    void write_word(std::uint32_t word, const std::array<std::string_view, N>& bits) {
        text_.fields(fmt::format("0x{:08X}", word), bits.front());
        for (std::size_t i = 1; i < N; ++i) text_.remark(bits[i]);
    }

    // An interval, the octets of data alone, and the assembly that says what they are (R-EDS-8).
    [[nodiscard]] std::string flow(const assemblies::Layout* layout) const {
        if (layout == nullptr) return fmt::format("Param{},0,", rpi_parameter());
        return fmt::format("Param{},{},Assem{}", rpi_parameter(), layout->size(), layout->instance);
    }

    void write_connection(unsigned number, const Connection& connection) {
        cip::Path path = cip::Path::to(0x04, assemblies::configuration_instance);
        path.segments.emplace_back(cip::logical(cip::LogicalType::connection_point, connection.o_to_t_point));
        path.segments.emplace_back(cip::logical(cip::LogicalType::connection_point, connection.t_to_o_point));
        text_.open(fmt::format("Connection{}", number), assemblies::name(connection.kind));
        write_word(transport_word(connection).bits, transport_bits);
        write_word(parameter_word(connection).bits, parameter_bits);
        text_.fields(flow(connection.outputs()), "O->T interval, size, format");
        text_.fields(flow(connection.inputs()), "T->O interval, size, format");
        text_.fields(",", "proxy configuration size, format");
        text_.fields(",", "target configuration size, format");
        text_.fields(quoted(connection.name), "name");
        text_.fields(quoted(eds::help(connection)), "help");
        text_.close(hex_path(path), "path: configuration, O->T, T->O");
    }

    void write_port_and_capacity() {
        text_.section("Port");
        text_.entry("Port1", fmt::format("TCP,{},\"20 F5 24 01\",2", quoted("EtherNet/IP")));
        std::size_t largest = 0;
        for (const auto& each : assemblies::connections()) {
            largest = std::max({largest, each.o_to_t_size(), each.t_to_o_size()});
        }
        constexpr auto fastest = microseconds_per_second / assemblies::smallest_rpi;
        text_.section("Capacity");
        text_.entry("MaxIOConnections", fmt::to_string(limits_.io), "an owner, and those who look on");
        text_.entry("MaxMsgConnections", fmt::to_string(limits_.messages), "class 3");
        text_.entry("MaxConsumersPerMcast", fmt::to_string(limits_.io));
        text_.entry("TSpec1", fmt::format("TxRx,{},{}", largest, 2 * fastest * limits_.io),
                    "all of them at the shortest interval, both ways");
    }

    void write_class(const ClassSection& each) {
        text_.section(each.section);
        text_.entry("Revision", fmt::to_string(each.revision));
        text_.entry("Object_Name", quoted(each.name));
        text_.entry("Object_Class_Code", fmt::format("0x{:02X}", each.class_id));
        text_.entry("MaxInst", fmt::to_string(each.max_instance));
        text_.entry("Number_Of_Static_Instances", fmt::to_string(each.instances));
        text_.entry("Max_Number_Of_Dynamic_Instances", "0");
        if (each.class_id != 0xF6) return;
        for (unsigned port = 1; port <= each.instances; ++port) {
            text_.entry(fmt::format("InterfaceLabel{}", port), quoted(fmt::format("PORT {}", port)));
        }
    }

    const drive::Model& model_;
    const ConnectionLimits& limits_;
    std::vector<const drive::Parameter*> rows_{};  ///< those that this variant has; ParamN is the N-th, from 1
    std::map<drive::Key, unsigned> numbers_{};
    std::set<std::string_view> names_{};
    std::set<std::string_view> repeated_names_{};
    SheetText text_{};
};

}  // namespace

std::string file_name(const drive::Model& model) {
    std::string variant(model.key);
    std::ranges::transform(variant, variant.begin(),
                           [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
    return fmt::format("XENAX_XVI_{}_EtherNetIP.eds", variant);
}

std::string generate(const drive::Model& model, const ConnectionLimits& limits) {
    return Generator(model, limits).run();
}

}  // namespace servobus::eds
