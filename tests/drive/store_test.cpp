#include "drive/store.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>

#include "drive/xenax.hpp"

namespace servobus::drive {
namespace {

class StoreOfXenax : public testing::Test {
protected:
    const Parameter& row(std::uint16_t class_id, std::uint16_t attribute) const {
        return *store.find({class_id, attribute});
    }
    std::int64_t number(const Parameter& row) const { return std::get<std::int64_t>(store.value(row)); }

    Store store{parameters()};
};

TEST_F(StoreOfXenax, FindsEveryRowByItsKeyAndNothingElse) {
    for (const Parameter& each : parameters()) {
        EXPECT_EQ(store.find(each.key()), &each);
    }
    EXPECT_EQ(store.find({0x65, 0x01}), nullptr);  // a hole in the middle
    EXPECT_EQ(store.find({0x64, 0x0B}), nullptr);
    EXPECT_EQ(store.find({0x63, 0x00}), nullptr);
    EXPECT_EQ(store.find({0xFFFF, 0xFFFF}), nullptr);
}

TEST_F(StoreOfXenax, AWriteIsReadBack) {
    EXPECT_EQ(store.write(row(0x66, 0x41), std::int64_t{250'000}), std::nullopt);
    EXPECT_EQ(store.read(row(0x66, 0x41)), ReadResult{Value{std::int64_t{250'000}}});
}

TEST_F(StoreOfXenax, ACheckChangesNothing) {
    EXPECT_EQ(store.check(row(0x66, 0x41), std::int64_t{250'000}), std::nullopt);
    EXPECT_EQ(number(row(0x66, 0x41)), 100'000);
}

TEST_F(StoreOfXenax, AccessIsCheckedBeforeTypeAndTypeBeforeLimits) {
    EXPECT_EQ(store.check(row(0x66, 0x01), std::string("text")), Refusal::read_only);
    EXPECT_EQ(store.check(row(0x66, 0x41), std::string("text")), Refusal::wrong_type);
    EXPECT_EQ(store.check(row(0x66, 0x20), std::int64_t{9}), Refusal::too_high);
    EXPECT_EQ(store.check(row(0x66, 0x20), std::int64_t{3}), Refusal::not_allowed);
}

TEST_F(StoreOfXenax, TheDriveChangesWhatABusMayOnlyRead) {
    store.assign(row(0x66, 0x01), std::int64_t{0x0250});
    EXPECT_EQ(store.read(row(0x66, 0x01)), ReadResult{Value{std::int64_t{0x0250}}});
}

TEST_F(StoreOfXenax, TheDriveSeesWhatABusMayOnlyWrite) {
    EXPECT_EQ(store.write(row(0x65, 0x2B), std::int64_t{-5}), std::nullopt);
    EXPECT_EQ(store.read(row(0x65, 0x2B)), ReadResult{Refusal::write_only});
    EXPECT_EQ(number(row(0x65, 0x2B)), -5);
}

TEST_F(StoreOfXenax, EachIndexHasItsOwnSpeed) {
    const Parameter& nix = row(0x65, 0x5A);
    const Parameter& six = row(0x65, 0x5C);
    EXPECT_EQ(store.write(nix, std::int64_t{3}), std::nullopt);
    EXPECT_EQ(store.write(six, std::int64_t{777}), std::nullopt);
    EXPECT_EQ(number(six), 777);
    EXPECT_EQ(store.write(nix, std::int64_t{1}), std::nullopt);
    EXPECT_EQ(number(six), 100'000);
    EXPECT_EQ(store.write(nix, std::int64_t{50}), std::nullopt);
    EXPECT_EQ(number(six), 100'000);
    EXPECT_EQ(store.write(six, std::int64_t{50}), std::nullopt);
    EXPECT_EQ(store.write(nix, std::int64_t{3}), std::nullopt);
    EXPECT_EQ(number(six), 777);
}

TEST_F(StoreOfXenax, ASelectorDoesNotMoveOtherRows) {
    EXPECT_EQ(store.write(row(0x65, 0x78), std::int64_t{10}), std::nullopt);    // NSEC
    EXPECT_EQ(store.write(row(0x65, 0x6F), std::int64_t{-100}), std::nullopt);  // IFL of sector 10
    EXPECT_EQ(number(row(0x65, 0x70)), 0);
    EXPECT_EQ(store.write(row(0x65, 0x8B), std::int64_t{500}), std::nullopt);  // SIXD, the dynamic index
    EXPECT_EQ(store.write(row(0x65, 0x5A), std::int64_t{7}), std::nullopt);
    EXPECT_EQ(number(row(0x65, 0x8B)), 500);
}

TEST_F(StoreOfXenax, TwoAddressesShareOneVariable) {
    for (const Parameter& each : parameters()) {
        if (!each.same_as) {
            continue;
        }
        const Parameter& owner = *store.find(*each.same_as);
        store.assign(each, each.standard + 1);
        EXPECT_EQ(number(owner), each.standard + 1) << each.name;
        store.assign(owner, each.standard);
        EXPECT_EQ(number(each), each.standard) << each.name;
    }
}

TEST_F(StoreOfXenax, EachAddressKeepsItsOwnLimits) {
    const Parameter& position = row(0x65, 0x4A);  // PO, +-2000000000
    const Parameter& target = row(0x66, 0x3A);    // the whole DINT
    EXPECT_EQ(store.write(position, std::int64_t{2'000'000'001}), Refusal::too_high);
    EXPECT_EQ(store.write(target, std::int64_t{2'000'000'001}), std::nullopt);
    EXPECT_EQ(number(position), 2'000'000'001);
}

TEST_F(StoreOfXenax, ResetBringsBackEveryDefault) {
    for (const Parameter& each : parameters()) {
        store.assign(each, each.is_text() ? Value{std::string("x")} : Value{each.high});
    }
    store.reset();
    const Store fresh(parameters());
    for (const Parameter& each : parameters()) {
        EXPECT_EQ(store.value(each), fresh.value(each)) << each.name;
    }
}

TEST_F(StoreOfXenax, ACopyIsIndependent) {
    Store copy = store;
    copy.assign(row(0x64, 0x00), std::int64_t{99});
    EXPECT_EQ(number(row(0x64, 0x00)), 20);
}

TEST(StoreDeathTest, ARowOfAnotherTableIsOurOwnMistake) {
    const Store store{parameters()};
    const Parameter copy = parameters()[0];
    EXPECT_DEATH((void)store.value(copy), "another table");
}

TEST(StoreDeathTest, ATableOutOfOrderIsOurOwnMistake) {
    static constexpr std::array<Parameter, 2> table{{
        {.name = "B", .mnemonic = "", .cip = {1, 1, 2, Type::i16}, .section = "", .text = ""},
        {.name = "A", .mnemonic = "", .cip = {1, 1, 1, Type::i16}, .section = "", .text = ""},
    }};
    EXPECT_DEATH(Store{table}, "not ordered");
}

TEST(Refusals, EachHasItsOwnWords) {
    EXPECT_EQ(describe(Refusal::read_only), "the parameter is read only");
    EXPECT_NE(describe(Refusal::too_low), describe(Refusal::too_high));
    EXPECT_NE(describe(Refusal::not_allowed), describe(Refusal::not_configured));
}

}  // namespace
}  // namespace servobus::drive
