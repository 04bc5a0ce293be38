#include "assemblies/parameter_value.hpp"

#include <string>
#include <variant>

#include "cip/strings.hpp"

namespace servobus::assemblies {
namespace {

// Reads an integer of the type's width and gives it the type's sign.
std::int64_t read_integer(cip::Reader& reader, drive::Type type) {
    switch (type) {
        case drive::Type::i8:
            return reader.little<std::int8_t>();
        case drive::Type::i16:
            return reader.little<std::int16_t>();
        case drive::Type::i32:
            return reader.little<std::int32_t>();
        case drive::Type::u8:
            return reader.u8();
        case drive::Type::u16:
            return reader.u16();
        case drive::Type::u32:
            return reader.u32();
        case drive::Type::text:
            break;
    }
    return 0;
}

boost::system::result<drive::Value, cip::GeneralStatus> read_text(cip::Reader reader) {
    auto text = cip::read_string(reader);
    if (!reader.ok()) return cip::GeneralStatus::not_enough_data;
    const std::size_t padding = text.size() % 2;
    if (reader.remaining() > padding) return cip::GeneralStatus::too_much_data;
    return drive::Value(std::move(text));
}

}  // namespace

cip::DataType data_type(drive::Type type) {
    switch (type) {
        case drive::Type::i8:
            return cip::DataType::SINT;
        case drive::Type::i16:
            return cip::DataType::INT;
        case drive::Type::i32:
            return cip::DataType::DINT;
        case drive::Type::u8:
            return cip::DataType::USINT;
        case drive::Type::u16:
            return cip::DataType::UINT;
        case drive::Type::u32:
            return cip::DataType::UDINT;
        case drive::Type::text:
            return cip::DataType::STRING;
    }
    return cip::DataType::STRING;
}

void write_value(cip::Writer& writer, const drive::Parameter& row, const drive::Value& value) {
    if (const auto* text = std::get_if<std::string>(&value)) {
        cip::write_string(writer, *text);
        return;
    }
    auto raw = static_cast<std::uint64_t>(std::get<std::int64_t>(value));
    for (auto octets = drive::size_of(row.cip.type); octets > 0; --octets, raw >>= 8) {
        writer.u8(static_cast<std::uint8_t>(raw));
    }
}

boost::system::result<drive::Value, cip::GeneralStatus> read_value(const drive::Parameter& row, cip::ByteView data) {
    cip::Reader reader(data);
    if (row.is_text()) return read_text(reader);
    const auto number = read_integer(reader, row.cip.type);
    if (!reader.ok()) return cip::GeneralStatus::not_enough_data;
    if (reader.remaining() > 0) return cip::GeneralStatus::too_much_data;
    return drive::Value(number);
}

std::optional<std::size_t> value_size(const drive::Parameter& row, cip::ByteView data) {
    if (!row.is_text()) return drive::size_of(row.cip.type);
    cip::Reader reader(data);
    const std::size_t characters = reader.u16();
    if (!reader.ok()) return std::nullopt;
    return 2 + characters;
}

cip::Status to_status(drive::Refusal refusal) {
    switch (refusal) {
        case drive::Refusal::read_only:
            return cip::GeneralStatus::attribute_not_settable;
        case drive::Refusal::write_only:
            return cip::GeneralStatus::attribute_not_gettable;
        case drive::Refusal::too_low:
        case drive::Refusal::too_high:
        case drive::Refusal::not_allowed:
        case drive::Refusal::too_long:
        case drive::Refusal::wrong_type:
            return cip::GeneralStatus::invalid_attribute_value;
        case drive::Refusal::not_configured:
        case drive::Refusal::wrong_state:
            return cip::Status(cip::GeneralStatus::vendor_specific, {cip::drive_refuses});
    }
    return cip::Status(cip::GeneralStatus::vendor_specific, {cip::drive_refuses});
}

}  // namespace servobus::assemblies
