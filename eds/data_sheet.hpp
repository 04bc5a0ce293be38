// A data sheet as a tool uses it: who the device is, what it has, and how to open a connection to it (R-EDS-3 to
// R-EDS-10). Texts are ISO 8859-1. What a sheet leaves out is nullopt or empty.
#pragma once

#include <boost/system/result.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <variant>
#include <vector>

#include "cip/bytes.hpp"
#include "eds/connection_words.hpp"
#include "eds/document.hpp"
#include "eds/parameter.hpp"
#include "eds/path_pattern.hpp"

namespace servobus::eds {

struct File {
    std::string description{};
    std::optional<std::chrono::year_month_day> create_date{};
    std::optional<std::chrono::seconds> create_time{};
    std::optional<std::chrono::year_month_day> modification_date{};
    std::optional<std::chrono::seconds> modification_time{};
    std::optional<Revision> revision{};
    std::string home_url{};
};

/// By vendor, type, product code and revision a tool finds the sheet of a device: Identity attributes 1 to 4.
struct Device {
    std::optional<std::uint16_t> vendor{};
    std::string vendor_name{};
    std::optional<std::uint16_t> product_type{};
    std::string product_type_name{};
    std::optional<std::uint16_t> product_code{};
    std::optional<std::uint8_t> major_revision{};
    std::optional<std::uint8_t> minor_revision{};
    std::string product_name{};
    std::string catalog{};
    std::string icon{};         ///< a file name
    cip::Bytes icon_content{};  ///< an .ico file; empty where none is in the sheet, or it is damaged
};

struct Member {
    struct Parameter {
        std::uint32_t number = 0;
        friend bool operator==(const Parameter&, const Parameter&) = default;
    };
    struct Assembly {
        std::string keyword{};
        friend bool operator==(const Assembly&, const Assembly&) = default;
    };
    /// monostate: padding; an integer: that constant; a path: of an attribute that no Param describes.
    using Reference = std::variant<std::monostate, Parameter, Assembly, std::int64_t, PathPattern>;

    std::optional<std::uint32_t> bits{};  ///< nullopt: as many as what it refers to has
    Reference reference{};
};

struct Assembly {
    std::string keyword{};     ///< `Assem100`; connections refer to it by this
    std::uint32_t number = 0;  ///< N, which need not be the instance
    std::size_t line = 0;
    std::string name{};
    PathPattern path{};
    std::optional<std::size_t> size{};  ///< octets: as stated, otherwise as the members have; nullopt: nothing tells
    std::uint16_t descriptor = 0;
    std::vector<Member> members{};
};

/// How deep an assembly in an assembly in an assembly is looked into, and how large an image is made.
inline constexpr unsigned max_assembly_depth = 16;
inline constexpr std::size_t max_image_octets = 65'535;
/// How many members are looked at for one image, those of inner assemblies counted each time.
inline constexpr std::size_t max_image_members = 262'144;

/// A number of a connection: fixed (all three alike), between limits that a Param has, or open (all nullopt: any).
struct Range {
    std::optional<std::uint32_t> parameter{};  ///< N of the Param
    std::optional<std::uint32_t> minimum{};
    std::optional<std::uint32_t> maximum{};
    std::optional<std::uint32_t> standard{};  ///< the default

    [[nodiscard]] bool allows(std::uint32_t value) const {
        return value >= minimum.value_or(0) && (!maximum || value <= *maximum);
    }
    friend bool operator==(const Range&, const Range&) = default;
};

/// One direction of a connection.
struct Flow {
    Range rpi{};           ///< microseconds
    Range size{};          ///< octets of data alone: no sequence count, no run/idle header (R-EDS-8)
    std::string format{};  ///< `Assem100`, a Param, or empty
};

struct ConfigurationPart {
    Range size{};  ///< octets
    std::string format{};
};

struct Connection {
    std::string keyword{};  ///< `Connection1`
    std::size_t line = 0;
    TransportWord transport{};
    ParameterWord parameters{};
    Flow o_to_t{};
    Flow t_to_o{};
    ConfigurationPart proxy_configuration{};
    ConfigurationPart target_configuration{};
    std::string name{};
    std::string help{};
    PathPattern path{};
};

struct Group {
    std::string name{};
    std::size_t line = 0;
    std::vector<std::uint32_t> parameters{};  ///< numbers of Params
};

struct Port {
    std::string type{};  ///< `TCP`
    std::string name{};
    PathPattern path{};
    std::optional<std::uint16_t> number{};
};

/// `TSpecN`: so many packets per second of this size.
struct TrafficSpecification {
    std::string direction{};  ///< `TxRx`, `Tx`, `Rx`
    std::optional<std::uint32_t> size{};
    std::optional<std::uint32_t> packets_per_second{};
};

struct Capacity {
    std::optional<std::uint32_t> io_connections{};
    std::optional<std::uint32_t> message_connections{};
    std::optional<std::uint32_t> consumers_per_multicast{};
    std::vector<TrafficSpecification> traffic{};
};

/// `[TCP/IP Interface Class]` and the like: any section that says how many instances of a class there are.
struct ObjectClass {
    std::string section{};
    std::optional<std::uint32_t> class_id{};
    std::optional<std::uint32_t> revision{};
    std::optional<std::uint32_t> max_instance{};
    std::optional<std::uint32_t> static_instances{};
};

/// Values for Params where a user wants another than the default, by their number.
using Choices = std::map<std::uint32_t, Value>;

struct DataSheet {
    File file{};
    Device device{};
    std::vector<std::string> classifications{};  ///< `EtherNetIP`
    std::vector<Parameter> parameters{};         ///< in the order of the sheet, as the other lists
    std::vector<Group> groups{};
    std::vector<Assembly> assemblies{};
    std::vector<Connection> connections{};
    std::vector<Port> ports{};
    Capacity capacity{};
    std::vector<ObjectClass> classes{};
    std::vector<Finding> findings{};  ///< what text and fields have against them; all was read as far as it could be

    // Where to find what has a number or a keyword: filled by read(), for the functions below.
    std::unordered_map<std::uint32_t, std::size_t> parameter_index{};
    std::unordered_map<std::string, std::size_t> assembly_index{};  ///< in lower case

    /// ParamN, or nullptr.
    [[nodiscard]] const Parameter* parameter(std::uint32_t number) const;
    /// All of that name; case and blanks around it do not count. Sheets have names twice.
    [[nodiscard]] std::vector<const Parameter*> parameters_named(std::string_view name) const;
    /// The one that stands for this attribute, or nullptr.
    [[nodiscard]] const Parameter* parameter_at(const AttributeAddress& address) const;
    /// By keyword: `Assem100`.
    [[nodiscard]] const Assembly* assembly(std::string_view keyword) const;
    /// By name or keyword; case and blanks around it do not count.
    [[nodiscard]] const Connection* connection(std::string_view name_or_keyword) const;

    /// The octets of an assembly made of its Params' defaults, or of `choices`: constants are themselves, what nothing
    /// is known of is 0. As long as its size.
    [[nodiscard]] cip::Bytes image(const Assembly& assembly, const Choices& choices = {}) const;

    /// The connection path: values of Params and, for SYMBOL_ANSI, the tag name `symbol` put in. Why not, in words, when
    /// a Param is missing or has no value, or a tag name is wanted and not there.
    [[nodiscard]] boost::system::result<cip::Bytes, std::string> connection_path(const Connection& connection,
                                                                                 const Choices& choices = {},
                                                                                 std::string_view symbol = {}) const;

    /// What goes into the data segment of the path (R-PTH-8): the configuration of the proxy, then of the target, each
    /// as long as its size says. Empty: none.
    [[nodiscard]] cip::Bytes configuration(const Connection& connection, const Choices& choices = {}) const;
};

/// What a document means. Fields that say nothing legal are left out, with a finding.
[[nodiscard]] DataSheet read(const Document& document);
/// The same from the text.
[[nodiscard]] boost::system::result<DataSheet, Finding> read(std::string_view octets);

}  // namespace servobus::eds
