// Every row of the drive's classes through a real socket, unconnected and through a class 3 connection. What the rows
// are is proved against the printed table by tests/drive/printed_table_test.cpp; here the wire has to say the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>

#include "tests/adapter/tcp_client.hpp"
#include "tests/support/octets.hpp"
#include "tests/support/places.hpp"

namespace servobus::test {
namespace {

constexpr std::uint8_t get = 0x0E;
constexpr std::uint8_t set = 0x10;

enum class Way : std::uint8_t { unconnected, class3 };

/// `20 64 24 01 30 08`, with 16-bit segments where a number needs them.
cip::Bytes path(std::uint32_t class_id, std::uint32_t instance, std::uint32_t attribute) {
    cip::Bytes octets;
    for (const auto& [type, value] : {std::pair(0x20U, class_id), {0x24U, instance}, {0x30U, attribute}}) {
        if (value <= 0xFF) {
            octets.insert(octets.end(), {static_cast<std::uint8_t>(type), static_cast<std::uint8_t>(value)});
        } else {
            octets.insert(octets.end(), {static_cast<std::uint8_t>(type | 1U), 0, static_cast<std::uint8_t>(value),
                                         static_cast<std::uint8_t>(value >> 8)});
        }
    }
    return octets;
}

cip::Bytes request(std::uint8_t service, const cip::Bytes& path, const cip::Bytes& data = {}) {
    return cip::Bytes{service, static_cast<std::uint8_t>(path.size() / 2)} + path + data;
}

cip::Bytes little_endian(std::int64_t value, std::size_t size) {
    cip::Bytes octets;
    for (std::size_t i = 0; i < size; ++i) octets.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    return octets;
}

/// STRING: a count of two octets, then the characters.
cip::Bytes string(std::string_view text) {
    auto octets = little_endian(static_cast<std::int64_t>(text.size()), 2);
    octets.insert(octets.end(), text.begin(), text.end());
    return octets;
}

cip::Bytes standard(const drive::Parameter& row) {
    return row.is_text() ? string(row.standard_text) : little_endian(row.standard, drive::size_of(row.cip.type));
}

std::string ok(std::uint8_t service, const cip::Bytes& data = {}) {
    return hex(cip::Bytes{static_cast<std::uint8_t>(service | 0x80), 0, 0, 0} + data);
}
std::string refused(std::uint8_t service, std::uint8_t status) {
    return hex(cip::Bytes{static_cast<std::uint8_t>(service | 0x80), 0, status, 0});
}

class OverTcp : public testing::TestWithParam<Way> {
protected:
    void SetUp() override {
        ASSERT_TRUE(client_.register_session());
        if (GetParam() == Way::class3) {
            ASSERT_TRUE(client_.open_class3());
        }
    }
    std::string ask(const cip::Bytes& message) {
        return hex(GetParam() == Way::class3 ? client_.connected_call(message) : client_.call(message));
    }
    std::string read(const drive::Parameter& row) { return ask(request(get, path_of(row))); }
    std::string write(const drive::Parameter& row, const cip::Bytes& data) {
        return ask(request(set, path_of(row), data));
    }
    std::string write(const drive::Parameter& row, std::int64_t value) {
        return write(row, little_endian(value, drive::size_of(row.cip.type)));
    }
    static cip::Bytes path_of(const drive::Parameter& row) {
        return path(row.cip.class_id, row.cip.instance, row.cip.attribute);
    }

    RunningServer server_;
    TcpClient client_{server_.port()};
};

std::set<std::uint16_t> classes() {
    std::set<std::uint16_t> ids;
    for (const auto& row : drive::parameters()) ids.insert(row.cip.class_id);
    return ids;
}

/// Class and attribute of each printed row, with its type.
std::map<drive::Key, std::string> printed_types() {
    std::ifstream file(data_path("reference/xenax_cip_attributes.csv"));
    std::map<drive::Key, std::string> types;
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
        std::vector<std::string> cells(1);
        bool quoted = false;
        for (const char c : line) {
            if (c == '"') {
                quoted = !quoted;
            } else if (c == ',' && !quoted) {
                cells.emplace_back();
            } else {
                cells.back() += c;
            }
        }
        const auto number = [&](std::size_t i) {
            return static_cast<std::uint16_t>(std::stoul(cells[i], nullptr, 16));
        };
        if (classes().contains(number(0))) types[{number(0), number(2)}] = cells[5];
    }
    return types;
}

TEST_P(OverTcp, EveryReadableRowHasItsDefaultInThePrintedLength) {
    const std::map<std::string, std::size_t> sizes{{"SINT", 1}, {"USINT", 1}, {"INT", 2},
                                                   {"UINT", 2}, {"DINT", 4},  {"UDINT", 4}};
    const auto types = printed_types();
    ASSERT_EQ(types.size(), 250U);
    for (const auto& row : drive::parameters()) {
        const auto& type = types.at(row.key());
        if (!drive::may_get(row.access)) {
            EXPECT_EQ(read(row), refused(get, 0x2C)) << row.name;
            continue;
        }
        EXPECT_EQ(read(row), ok(get, standard(row))) << row.name;
        if (type == "STRING") {
            EXPECT_TRUE(row.is_text()) << row.name;
        } else {
            ASSERT_TRUE(sizes.contains(type)) << type;
            EXPECT_EQ(standard(row).size(), sizes.at(type)) << row.name;
        }
    }
}

TEST_P(OverTcp, EverySettableNumberTakesItsLimitsAndNothingPastThem) {
    std::size_t rows = 0;
    for (const auto& row : drive::parameters()) {
        if (!drive::may_set(row.access) || row.is_text()) continue;
        ++rows;
        std::vector<std::int64_t> legal(row.allowed.begin(), row.allowed.end());
        if (legal.empty()) legal = {row.low, row.high, row.standard};
        for (const auto value : legal) {
            EXPECT_EQ(write(row, value), ok(set)) << row.name << ' ' << value;
            if (drive::may_get(row.access)) {
                EXPECT_EQ(read(row), ok(get, little_endian(value, drive::size_of(row.cip.type)))) << row.name;
            }
        }
        const auto before = read(row);
        const auto past = [&](std::int64_t value) {
            const bool fits = drive::lowest(row.cip.type) <= value && value <= drive::highest(row.cip.type);
            if (fits) {
                EXPECT_EQ(write(row, value), refused(set, 0x09)) << row.name << ' ' << value;
            }
        };
        past(row.low - 1);
        past(row.high + 1);
        past(drive::lowest(row.cip.type) < row.low ? drive::lowest(row.cip.type) : row.low - 1);
        past(drive::highest(row.cip.type) > row.high ? drive::highest(row.cip.type) : row.high + 1);
        for (auto value = row.low; !row.allowed.empty() && value < row.low + 20; ++value) {
            if (std::ranges::find(row.allowed, value) == row.allowed.end()) {
                past(value);
            }
        }
        EXPECT_EQ(read(row), before) << row.name << ": a refused Set changes nothing (R-ERR-11)";
        if (row.allowed.empty() || drive::may_get(row.access)) {
            EXPECT_EQ(write(row, row.standard), ok(set)) << row.name;
        }
    }
    EXPECT_GT(rows, 100U);
}

TEST_P(OverTcp, EverySettableNumberNeedsItsExactLength) {
    for (const auto& row : drive::parameters()) {
        if (!drive::may_set(row.access) || row.is_text()) continue;
        auto value = standard(row);
        value.push_back(0);
        EXPECT_EQ(write(row, value), refused(set, 0x15)) << row.name;
        value.resize(value.size() - 2);
        EXPECT_EQ(write(row, value), refused(set, 0x13)) << row.name;
        EXPECT_EQ(write(row, cip::Bytes{}), refused(set, 0x13)) << row.name;
    }
}

TEST_P(OverTcp, EveryReadOnlyRowRefusesWhateverIsWritten) {
    for (const auto& row : drive::parameters()) {
        if (drive::may_set(row.access)) continue;
        EXPECT_EQ(write(row, standard(row)), refused(set, 0x0E)) << row.name;
        EXPECT_EQ(write(row, cip::Bytes{}), refused(set, 0x0E)) << row.name << ": access comes before length (R-ERR-6)";
    }
}

TEST_P(OverTcp, EveryText) {
    std::size_t settable = 0;
    for (const auto& row : drive::parameters()) {
        if (!row.is_text() || !drive::may_set(row.access)) continue;
        ++settable;
        for (const auto& text : {std::string(row.max_length, 'x'), std::string(row.max_length - 1, 'y'),
                                 std::string("a"), std::string()}) {
            EXPECT_EQ(write(row, string(text)), ok(set)) << row.name;
            EXPECT_EQ(read(row), ok(get, string(text))) << row.name << ": no padding is sent (R-TYP-5)";
        }
        EXPECT_EQ(write(row, string("abc") + cip::Bytes{0}), ok(set)) << row.name << ": an odd count may be padded";
        EXPECT_EQ(read(row), ok(get, string("abc"))) << row.name;
        EXPECT_EQ(write(row, string("ab") + cip::Bytes{0}), refused(set, 0x15)) << row.name << ": an even one not";
        EXPECT_EQ(write(row, string("abc") + cip::Bytes{0, 0}), refused(set, 0x15)) << row.name;
        EXPECT_EQ(write(row, string(std::string(row.max_length + 1, 'z'))), refused(set, 0x09)) << row.name;
        EXPECT_EQ(write(row, cip::Bytes{4, 0, 'a', 'b', 'c'}), refused(set, 0x13)) << row.name;
        EXPECT_EQ(write(row, cip::Bytes{4}), refused(set, 0x13)) << row.name;
        EXPECT_EQ(write(row, cip::Bytes{}), refused(set, 0x13)) << row.name;
        EXPECT_EQ(read(row), ok(get, string("abc"))) << row.name;
    }
    EXPECT_EQ(settable, 3U);
}

TEST_P(OverTcp, AttributesThatDoNotExist) {
    for (const auto class_id : classes()) {
        std::size_t unknown = 0;
        for (std::uint32_t attribute = 0; attribute <= 0x100; ++attribute) {
            const auto same = [&](const auto& row) {
                return row.cip.class_id == class_id && row.cip.attribute == attribute;
            };
            if (std::ranges::any_of(drive::parameters(), same)) continue;
            ++unknown;
            EXPECT_EQ(ask(request(get, path(class_id, 1, attribute))), refused(get, 0x14))
                << class_id << '/' << attribute;
            EXPECT_EQ(ask(request(set, path(class_id, 1, attribute), {1, 2, 3, 4})), refused(set, 0x14));
        }
        EXPECT_GT(unknown, 50U);
        EXPECT_EQ(ask(request(get, path(class_id, 1, 0xFFFF))), refused(get, 0x14));
    }
}

TEST_P(OverTcp, ClassesInstancesAndServicesThatDoNotExist) {
    for (const auto class_id : classes()) {
        for (const std::uint32_t instance : {2U, 0xFFU, 0x100U}) {
            EXPECT_EQ(ask(request(get, path(class_id, instance, 0))), refused(get, 0x05));
            EXPECT_EQ(ask(request(0x4B, path(class_id, instance, 0))), refused(0x4B, 0x05))
                << "before the service (R-ERR-3)";
        }
        for (const std::uint8_t service :
             std::to_array<std::uint8_t>({0x01, 0x02, 0x05, 0x0A, 0x15, 0x16, 0x18, 0x4B, 0x7F})) {
            EXPECT_EQ(ask(request(service, path(class_id, 1, 0))), refused(service, 0x08));
        }
        EXPECT_EQ(ask(request(get, path(class_id, 0, 1))), ok(get, {1, 0})) << "the class's revision (R-OBJ-2)";
        EXPECT_EQ(ask(request(set, path(class_id, 0, 1), {1, 0})), refused(set, 0x08));
    }
    for (const std::uint32_t class_id : {0x03U, 0x63U, 0x6AU, 0x6BU, 0x6CU, 0x6DU, 0x6FU, 0xFFU, 0x100U, 0x164U}) {
        EXPECT_EQ(ask(request(get, path(class_id, 1, 0))), refused(get, 0x05)) << class_id;
    }
}

TEST_P(OverTcp, R_DEV_4_AttributeZeroMayBeLeftOut) {
    for (const auto class_id : classes()) {
        const auto short_path = cip::Bytes{0x20, static_cast<std::uint8_t>(class_id), 0x24, 1};
        EXPECT_EQ(ask(request(get, short_path)), ask(request(get, path(class_id, 1, 0)))) << class_id;
    }
}

TEST_P(OverTcp, R_PTH_3_AllWidthsOfASegmentMeanTheSame) {
    const auto expected = ok(get, {0x14, 0, 0, 0});
    EXPECT_EQ(ask(request(get, octets("20 64 24 01 30 00"))), expected);
    EXPECT_EQ(ask(request(get, octets("21 00 64 00 25 00 01 00 31 00 00 00"))), expected);
    EXPECT_EQ(ask(request(get, octets("22 00 64 00 00 00 26 00 01 00 00 00 32 00 00 00 00 00"))), expected);
    EXPECT_EQ(ask(request(get, octets("21 EE 64 00 24 01 30 00"))), expected) << "the pad is not looked at";
}

INSTANTIATE_TEST_SUITE_P(Way, OverTcp, testing::Values(Way::unconnected, Way::class3),
                         [](const auto& each) { return each.param == Way::class3 ? "Class3" : "Unconnected"; });

}  // namespace
}  // namespace servobus::test
