// Whether a device is what its data sheet says, from its answers: one finding for each thing that is compared.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cip/message.hpp"
#include "eds/data_sheet.hpp"
#include "scanner/identity.hpp"
#include "scanner/io_plan.hpp"

namespace servobus::scanner {

enum class Agreement : std::uint8_t {
    equal,
    different,
    not_compared,  ///< the device does not tell, or the sheet does not
};

struct Comparison {
    enum class Group : std::uint8_t { identity, parameter, assembly, connection, file };

    Group group = Group::identity;
    std::string subject{};  ///< `Param12 SCurve`; of the sheet, so ISO 8859-1
    Agreement agreement = Agreement::equal;
    std::string words{};  ///< what differs, or why it is not compared, without a full stop; empty when equal
    friend bool operator==(const Comparison&, const Comparison&) = default;
};

/// `identity`, `parameter`, ...
[[nodiscard]] std::string_view name(Comparison::Group group);
[[nodiscard]] std::string_view name(Agreement agreement);

/// Identity 1 to 4 and 7 against [Device]: five comparisons, the two numbers of the revision being one.
[[nodiscard]] std::vector<Comparison> compare_identity(const eds::Device& device, const Identity& identity);

/// How a parameter is asked for: the attribute of its path. Nullopt: it is in the data of a connection alone, or its path
/// is made of other parameters.
[[nodiscard]] std::optional<cip::Request> read_request(const eds::Parameter& parameter);
/// Readable, as many octets as it should have, inside its limits.
[[nodiscard]] Comparison compare_parameter(const eds::Parameter& parameter, const cip::Response& response);

/// The instance of the Assembly object that an assembly is, or nullopt.
[[nodiscard]] std::optional<std::uint32_t> instance_of(const eds::Assembly& assembly);

/// What the Assembly object says of an instance.
struct AssemblySize {
    std::optional<std::size_t> octets{};  ///< by attribute 4, or counted in attribute 3
    cip::Status status{};                 ///< why there is no size
    /// There is no such instance, which is not the same as that its size cannot be read.
    [[nodiscard]] bool is_missing() const;
};
[[nodiscard]] cip::Request size_request(std::uint32_t instance);
[[nodiscard]] cip::Request data_request(std::uint32_t instance);
/// `data` is the answer to data_request, where that had to be asked because the size is not told.
[[nodiscard]] AssemblySize assembly_size(const cip::Response& size, const std::optional<cip::Response>& data);

[[nodiscard]] Comparison compare_assembly(const eds::Assembly& assembly, const AssemblySize& size);

/// The assemblies at the points of a connection.
struct ConnectionSizes {
    AssemblySize o_to_t{};
    AssemblySize t_to_o{};
    AssemblySize configuration{};
};
/// Sizes of a connection against those of its assemblies, as far as they are told.
[[nodiscard]] Comparison compare_connection(const eds::Connection& connection, const IoPlan& plan,
                                            const ConnectionSizes& sizes);

/// Octet by octet, with the line where they begin to differ.
[[nodiscard]] Comparison compare_file(cip::ByteView in_device, cip::ByteView file);

}  // namespace servobus::scanner
