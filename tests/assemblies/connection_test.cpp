// The connections of the drive: sizes as a Forward_Open asks for them, and which points belong together.
#include "assemblies/connection.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <tuple>

namespace servobus::assemblies {
namespace {

using Kind = Connection::Kind;

struct Size {
    std::uint16_t o_to_t;
    std::uint16_t t_to_o;
    std::size_t o_to_t_size;
    std::size_t t_to_o_size;
};

TEST(Connections, R_CON_9_have_the_sizes_of_the_table) {
    for (const auto& row : {Size{101, 100, 24, 30},
                            {102, 100, 26, 30},
                            {103, 100, 38, 30},
                            {104, 105, 42, 34},
                            {112, 113, 54, 42},
                            {254, 100, 2, 30},
                            {255, 100, 2, 30},
                            {254, 105, 2, 34},
                            {254, 113, 2, 42},
                            {255, 105, 2, 34},
                            {255, 113, 2, 42}}) {
        const auto* connection = find_connection(row.o_to_t, row.t_to_o);
        ASSERT_NE(connection, nullptr) << row.o_to_t << '/' << row.t_to_o;
        EXPECT_EQ(connection->o_to_t_size(), row.o_to_t_size) << row.o_to_t;
        EXPECT_EQ(connection->t_to_o_size(), row.t_to_o_size) << row.t_to_o;
    }
    EXPECT_EQ(connections().size(), 11U);
}

TEST(Connections, R_CON_28_kinds_follow_from_the_output_point) {
    for (const auto& each : connections()) {
        const auto expected = each.o_to_t_point == 254   ? Kind::input_only
                              : each.o_to_t_point == 255 ? Kind::listen_only
                                                         : Kind::exclusive_owner;
        EXPECT_EQ(each.kind, expected) << each.o_to_t_point;
        const bool owner = each.kind == Kind::exclusive_owner;
        EXPECT_EQ(each.o_to_t_format(), owner ? cip::RealTimeFormat::header32 : cip::RealTimeFormat::heartbeat);
        EXPECT_EQ(each.t_to_o_format(), cip::RealTimeFormat::modeless);
        EXPECT_EQ(each.outputs() != nullptr, owner);
        ASSERT_NE(each.inputs(), nullptr);
        EXPECT_EQ(each.inputs()->direction, Direction::t_to_o);
        EXPECT_TRUE(!owner || each.outputs()->direction == Direction::o_to_t);
    }
    EXPECT_EQ(name(Kind::exclusive_owner), "exclusive owner");
    EXPECT_EQ(name(Kind::input_only), "input only");
    EXPECT_EQ(name(Kind::listen_only), "listen only");
}

TEST(Connections, R_CON_9_other_pairs_of_known_points_are_none) {
    unsigned pairs = 0;
    for (const std::uint32_t output : {101, 102, 103, 104, 112, 254, 255}) {
        for (const std::uint32_t input : {100, 105, 113}) {
            const auto* found = find_connection(output, input);
            const bool heartbeat = output >= 254;
            const bool expected = heartbeat || input == (output == 104 ? 105U : output == 112 ? 113U : 100U);
            EXPECT_EQ(found != nullptr, expected) << output << '/' << input;
            ++pairs;
        }
    }
    EXPECT_EQ(pairs, 21U);
    EXPECT_EQ(find_connection(100, 101), nullptr);
    EXPECT_EQ(find_connection(65536 + 101, 100), nullptr) << "points have 32 bits";
    EXPECT_EQ(find_connection(101, 65536 + 100), nullptr);
}

TEST(Connections, AreFoundByKeyAndByPoint) {
    for (const auto& [key, output, input] : {std::tuple{"standard", 101, 100},
                                             {"iforce", 102, 100},
                                             {"outputs", 103, 100},
                                             {"force", 104, 105},
                                             {"cipsync", 112, 113},
                                             {"input-only", 254, 100},
                                             {"listen-only", 255, 100}}) {
        const auto* connection = find_connection(std::string_view(key));
        ASSERT_NE(connection, nullptr) << key;
        EXPECT_EQ(connection->o_to_t_point, output);
        EXPECT_EQ(connection->t_to_o_point, input) << "the first of a key is meant by it";
        EXPECT_EQ(find_by_output(connection->o_to_t_point), connection);
    }
    EXPECT_EQ(find_connection(std::string_view("Standard")), nullptr);
    EXPECT_EQ(find_connection(std::string_view("")), nullptr);
    EXPECT_EQ(find_by_input(100)->key, "standard");
    EXPECT_EQ(find_by_input(105)->key, "force");
    EXPECT_EQ(find_by_input(113)->key, "cipsync");
    for (const std::uint32_t point : {0U, 1U, 99U, 100U, 105U, 253U, 65536U + 101U}) {
        EXPECT_EQ(find_by_output(point), nullptr) << point;
    }
    for (const std::uint32_t point : {0U, 1U, 101U, 112U, 254U, 255U})
        EXPECT_EQ(find_by_input(point), nullptr) << point;
}

// Exclusive owners come first and once each: what the output point says is unambiguous.
TEST(Connections, ThereIsOneOwnerForEachOutputPoint) {
    std::set<std::uint16_t> owners;
    bool others = false;
    for (const auto& each : connections()) {
        if (each.kind != Kind::exclusive_owner) {
            others = true;
            continue;
        }
        EXPECT_FALSE(others) << each.key;
        EXPECT_TRUE(owners.insert(each.o_to_t_point).second) << each.key;
    }
    EXPECT_EQ(owners.size(), 5U);
}

}  // namespace
}  // namespace servobus::assemblies
