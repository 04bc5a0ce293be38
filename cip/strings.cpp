#include "cip/strings.hpp"

#include <algorithm>

namespace servobus::cip {
namespace {

ByteView octets(std::string_view text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }

std::string characters(ByteView bytes) { return {bytes.begin(), bytes.end()}; }

}  // namespace

void write_string(Writer& writer, std::string_view text) {
    text = text.substr(0, 0xFFFF);
    writer.u16(static_cast<std::uint16_t>(text.size()));
    writer.bytes(octets(text));
}

std::string read_string(Reader& reader) {
    const auto count = reader.u16();
    return characters(reader.take(count));
}

void write_short_string(Writer& writer, std::string_view text) {
    text = text.substr(0, 0xFF);
    writer.u8(static_cast<std::uint8_t>(text.size()));
    writer.bytes(octets(text));
}

std::string read_short_string(Reader& reader) {
    const auto count = reader.u8();
    return characters(reader.take(count));
}

void write_stringi(Writer& writer, const std::vector<InternationalString>& strings) {
    writer.u8(static_cast<std::uint8_t>(strings.size()));
    for (const auto& string : strings) {
        auto language = string.language;
        language.resize(3, ' ');
        writer.bytes(octets(language));
        writer.field(string.type);
        writer.u16(string.character_set);
        if (string.type == DataType::STRING) {
            write_string(writer, string.text);
        } else {
            write_short_string(writer, string.text);
        }
    }
}

std::vector<InternationalString> read_stringi(Reader& reader) {
    std::vector<InternationalString> strings;
    for (auto count = reader.u8(); count > 0 && reader.ok(); --count) {
        InternationalString string;
        string.language = characters(reader.take(3));
        reader.field(string.type);
        string.character_set = reader.u16();
        if (string.type == DataType::STRING) {
            string.text = read_string(reader);
        } else if (string.type == DataType::SHORT_STRING) {
            string.text = read_short_string(reader);
        } else {
            reader.take(reader.remaining() + 1);  // wide strings have another length rule: fail here
        }
        strings.push_back(std::move(string));
    }
    return strings;
}

}  // namespace servobus::cip
