// What an I/O connection carries, by name: the members of an assembly, of the drive or of a data sheet, or places in the
// octets of any other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "assemblies/layout.hpp"
#include "cip/bytes.hpp"
#include "drive/parameter.hpp"
#include "drive/store.hpp"
#include "eds/parameter.hpp"
#include "scanner/mistake.hpp"

namespace servobus::scanner::cli {

/// A member of an assembly and where it lies.
struct IoField {
    assemblies::Member::Kind kind = assemblies::Member::Kind::parameter;
    const drive::Parameter* row = nullptr;      ///< for Kind::parameter of the drive
    const eds::Parameter* parameter = nullptr;  ///< for Kind::parameter of a data sheet, where that has a Param for it
    std::string label{};                        ///< its name in a data sheet
    std::size_t offset = 0;
    std::size_t octets = 0;     ///< that it touches
    std::size_t first_bit = 0;  ///< in the first octet
    std::size_t bits = 0;       ///< 0: all of its octets

    /// `Statusword`, `drive.Acceleration…` where the name alone is not enough, `Padding`, `TimeStamp`.
    [[nodiscard]] std::string name() const;
    /// `increment`; `us` for a time stamp (R-IO-10).
    [[nodiscard]] std::string unit() const;
    friend bool operator==(const IoField&, const IoField&) = default;
};
using IoFields = std::vector<IoField>;

[[nodiscard]] IoFields fields_of(const assemblies::Layout& layout);

/// The value of a field in `data`, which has all octets of the assembly: as it is on the wire.
[[nodiscard]] std::int64_t number_in(const IoField& field, cip::ByteView data);
/// The same for programs: in the units of a data sheet that scales.
[[nodiscard]] eds::Value value_in(const IoField& field, cip::ByteView data);
/// The same for people, without unit: `1000`, `0x0637 (1591)`.
[[nodiscard]] std::string text_in(const IoField& field, cip::ByteView data);
/// What the bits of a word mean: `Operation enabled; target position reached`. Empty for numbers.
[[nodiscard]] std::string meaning_in(const IoField& field, cip::ByteView data);

/// Octets to be put somewhere into the outputs; with `bits`, so many of them, from `first_bit` of the first octet on.
struct IoChange {
    std::size_t offset = 0;
    cip::Bytes octets;
    std::size_t first_bit = 0;
    std::size_t bits = 0;
    friend bool operator==(const IoChange&, const IoChange&) = default;
};

/// What the outputs of a connection are called.
struct IoOutputs {
    const assemblies::Layout* layout = nullptr;  ///< of the drive's; nullptr for any other
    std::size_t octets = 0;
    IoFields fields{};   ///< empty when only the number of octets is known
    std::string name{};  ///< `assembly 101`

    [[nodiscard]] static IoOutputs of(const assemblies::Layout* layout);
};

/// `TargetPositionOrDistance=1000`, `AC=0x0F`, as `set` takes it; `@4:DINT=-5`, `@16:hex=0F 00` for any place. What a data
/// sheet names is held to its limits.
[[nodiscard]] Parsed<IoChange> parse_change(std::string_view text, const IoOutputs& outputs);

/// `image` has the octets of the outputs that the change was read for.
void put(const IoChange& change, std::span<std::uint8_t> image);

/// The change that gives a parameter a value; nullopt when the assembly does not have it.
[[nodiscard]] std::optional<IoChange> change_of(const IoFields& fields, const drive::Parameter& row,
                                                const drive::Value& value);
/// nullptr when the assembly does not have it.
[[nodiscard]] const IoField* find_field(const IoFields& fields, const drive::Parameter& row);

}  // namespace servobus::scanner::cli
