// Process images of a cyclic connection: what is written, what is left out, and that neither costs memory.
#include "assemblies/image.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "drive/xenax.hpp"
#include "enip/io_packet.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/golden.hpp"
#include "tests/support/octets.hpp"

namespace servobus::assemblies {
namespace {

using namespace std::chrono_literals;
using test::hex;
using test::octets;

constexpr drive::Key control_word{0x66, 0x00};
constexpr drive::Key target{0x66, 0x3A};
constexpr drive::Key speed{0x66, 0x41};
constexpr drive::Key acceleration{0x66, 0x43};
constexpr drive::Key scurve{0x64, 0x00};
constexpr drive::Key limit_i_force{0x66, 0x33};
constexpr drive::Key limit_force{0x64, 0x09};

std::string little(std::int64_t value, int count) {
    cip::Bytes bytes;
    for (int i = 0; i < count; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    return hex(bytes);
}

/// An image of 101, which the tests change member by member.
struct Standard {
    std::int64_t target = 200'000;
    std::int64_t speed = 50'000;
    std::int64_t acceleration = 1'000'000;
    std::int64_t scurve = 20;
    std::int64_t word = 0x0F;

    [[nodiscard]] cip::Bytes octets() const {
        return test::octets(little(target, 4) + little(speed, 4) + little(acceleration, 4) + little(scurve, 4) +
                            little(word, 2));
    }
};

/// A table that keeps what is written.
class Table {
public:
    explicit Table(std::string_view variant = "75v8s") : device(*drive::xenax_model(variant)) {}

    void assign(drive::Key key, std::int64_t value) { device.store().assign(*device.find(key), value); }
    std::int64_t value(drive::Key key) const { return std::get<std::int64_t>(device.store().value(*device.find(key))); }
    Image image(std::uint16_t instance) { return Image(*find_layout(instance), device); }

    drive::Device device;
};

/// A drive with an axis that has its reference and stands at 10,000 in profile position mode, enabled.
class Machine : public Table {
public:
    Machine() {
        device = drive::Device(*drive::xenax_model("75v8s"), drive::Machine{});
        run(1ms);
        set({0x66, 0x20}, 6);
        for (const auto word : {0x06, 0x07, 0x0F, 0x1F}) set(control_word, word);
        run(20s);
        set({0x66, 0x20}, 1);
        set(control_word, 0x0F);
        move(10'000);
        EXPECT_NEAR(static_cast<double>(position()), 10'000, 50);
    }
    void set(drive::Key key, std::int64_t value) { EXPECT_FALSE(device.write(*device.find(key), value)); }
    void run(drive::Time duration) { device.step(now_ += duration); }
    void move(std::int64_t place) {
        set(target, place);
        set(control_word, 0x1F);
        run(10s);
        set(control_word, 0x0F);
    }
    std::int64_t position() const { return value({0x66, 0x24}); }
    bool in_motion() const { return (value({0x64, 0x06}) & 0x04) != 0; }

private:
    drive::Time now_{0};
};

/// The application's octets of a golden datagram, behind sequence count and run/idle header.
cip::Bytes data_of(std::string_view vector) {
    const auto* golden = test::find_golden_vector(vector);
    EXPECT_NE(golden, nullptr) << vector;
    const auto packet = enip::IoPacket::parse(golden->octets);
    EXPECT_TRUE(packet) << vector;
    const auto data = packet->data.subspan(golden->direction == "O->T" ? 6 : 2);
    return {data.begin(), data.end()};
}

std::string packed(const Image& image, std::int64_t time_stamp = 0) {
    cip::Bytes bytes(image.size(), 0xEE);
    image.pack(time_stamp, bytes);
    return hex(bytes);
}

TEST(Image, R_IO_2_packs_the_golden_datagrams) {
    Table table;
    table.assign({0x66, 0x01}, 0x0237);
    table.assign({0x66, 0x38}, 250);
    table.assign({0x66, 0x24}, 123456);
    table.assign({0x64, 0x05}, -125);
    table.assign({0x64, 0x06}, 3);
    table.assign({0x66, 0xB4}, -2);
    table.assign({0x66, 0xBD}, 5);
    table.assign({0x66, 0xBF}, 1);
    table.assign({0x64, 0x0A}, 1490);
    EXPECT_EQ(packed(table.image(100)), hex(data_of("io_t2o_100")));
    EXPECT_EQ(packed(table.image(105)), hex(data_of("io_t2o_105")));
    EXPECT_EQ(packed(table.image(113), 0x00060A2418202240), hex(data_of("io_t2o_113"))) << "R-IO-10";
}

TEST(Image, PacksWhatLayoutsPack) {
    Machine machine;
    for (const auto& layout : layouts()) {
        cip::Bytes expected(layout.size());
        pack(layout, machine.device, 77, expected);
        EXPECT_EQ(packed(Image(layout, machine.device), 77), hex(expected)) << layout.instance;
    }
}

TEST(Image, R_IO_10_time_stamps_are_signed_and_of_64_bits) {
    Table table;
    const auto image = table.image(113);
    EXPECT_EQ(packed(image, -1).substr(32 * 3), hex("FFFFFFFFFFFFFFFF"));
    EXPECT_EQ(packed(image, 0x0102030405060708).substr(32 * 3), hex("0807060504030201"));
}

TEST(Image, R_IO_1_applies_the_golden_datagrams) {
    struct Vector {
        std::uint16_t instance;
        const char* name;
    };
    for (const auto& [instance, name] : {Vector{101, "io_o2t_101_run"},
                                         {102, "io_o2t_102_run"},
                                         {103, "io_o2t_103_run"},
                                         {104, "io_o2t_104_run"},
                                         {112, "io_o2t_112_run"}}) {
        SCOPED_TRACE(name);
        Table table;
        auto image = table.image(instance);
        EXPECT_EQ(image.apply(data_of(name)), Image::Outcome{});
        EXPECT_EQ(table.value(target), 200'000);
        EXPECT_EQ(table.value(speed), 50'000);
        EXPECT_EQ(table.value(acceleration), 1'000'000);
        EXPECT_EQ(table.value(scurve), 20);
        EXPECT_EQ(table.value(control_word), 0x1F);
        if (instance < 102) continue;
        EXPECT_EQ(table.value(limit_i_force), 1200);
        if (instance < 103) continue;
        EXPECT_EQ(table.value({0x66, 0x25}), 1000);
        EXPECT_EQ(table.value({0x66, 0x27}), 20);
        EXPECT_EQ(table.value({0x66, 0xBF}), 3);
        if (instance < 104) continue;
        EXPECT_EQ(table.value(limit_force), 1500);
    }
}

// Each member in turn is past its limits; all others are written, and the mask says which one was not.
TEST(Image, R_IO_9_leaves_out_the_members_that_are_refused) {
    unsigned refused = 0;
    const auto& layout = *find_layout(104);
    for (std::size_t bad = 0; bad < layout.members.size(); ++bad) {
        Table table;
        auto image = table.image(104);
        const auto& row = *table.device.find(layout.members[bad].key);
        if (row.high == drive::highest(row.cip.type) && row.low == drive::lowest(row.cip.type)) continue;
        const bool above = row.high < drive::highest(row.cip.type);
        cip::Bytes bytes;
        std::vector<std::int64_t> wanted;
        for (std::size_t i = 0; i < layout.members.size(); ++i) {
            const auto& each = *table.device.find(layout.members[i].key);
            wanted.push_back(i != bad ? each.high : above ? each.high + 1 : each.low - 1);
            for (int k = 0; k < layout.members[i].octets; ++k) {
                bytes.push_back(static_cast<std::uint8_t>(wanted.back() >> (8 * k)));
            }
        }
        const auto before = table.value(row.key());
        const auto outcome = image.apply(bytes);
        SCOPED_TRACE(row.name);
        EXPECT_EQ(outcome.refused, 1U << bad);
        EXPECT_EQ(outcome.first_refusal, above ? drive::Refusal::too_high : drive::Refusal::too_low);
        for (std::size_t i = 0; i < layout.members.size(); ++i) {
            if (layout.members[i].key == control_word) continue;  // below
            EXPECT_EQ(table.value(layout.members[i].key), i == bad ? before : wanted[i]) << i;
        }
        ++refused;
    }
    EXPECT_GE(refused, 6U) << "too few members have limits inside their type for this test to say something";
}

TEST(Image, R_IO_9_tells_the_first_of_several) {
    Table table;
    auto image = table.image(101);
    const auto outcome = image.apply(Standard{.speed = 0, .scurve = 101}.octets());
    EXPECT_EQ(outcome.refused, 0b1010U);
    EXPECT_EQ(outcome.first_refusal, drive::Refusal::too_low);
    EXPECT_EQ(image.row(1)->name, "SpeedJogOrProfilePositionMode");
    EXPECT_EQ(table.value(target), 200'000);
    EXPECT_EQ(table.value(control_word), 0x0F);
}

TEST(Image, AnotherSizeIsNotApplied) {
    Table table;
    auto image = table.image(101);
    auto bytes = Standard{}.octets();
    const auto before = packed(image);
    bytes.push_back(0);
    for (std::size_t size = 0; size <= bytes.size(); ++size) {
        if (size == image.size()) continue;
        const auto outcome = image.apply(cip::ByteView(bytes).first(size));
        EXPECT_EQ(outcome.refused, 0b11111U) << size;
        EXPECT_EQ(packed(image), before);
    }
}

TEST(Image, R_ERR_10_a_row_that_the_variant_does_not_have_means_nothing) {
    Table table("75v8");
    auto image = table.image(104);
    auto bytes = data_of("io_o2t_104_run");
    EXPECT_EQ(image.apply(bytes), Image::Outcome{});
    EXPECT_EQ(table.value(limit_force), 0);
    bytes[32] = bytes[33] = bytes[34] = bytes[35] = 0x7F;
    EXPECT_EQ(image.apply(bytes), Image::Outcome{}) << "not even its limits";
    EXPECT_EQ(packed(table.image(105)).substr(28 * 3), hex("00000000"));
}

// ----------------------------------------------------------------------------------------- a start beside what is bad

TEST(Image, StartBesideARefusedMemberDoesNotMove) {
    for (const auto& bad : {Standard{.target = 50'000, .speed = 0, .word = 0x1F},
                            Standard{.target = 50'000, .acceleration = 0, .word = 0x1F},
                            Standard{.target = 50'000, .scurve = 101, .word = 0x1F}}) {
        Machine machine;
        auto image = machine.image(101);
        EXPECT_EQ(image.apply(Standard{}.octets()), Image::Outcome{});
        const auto outcome = image.apply(bad.octets());
        EXPECT_TRUE(outcome.start_held);
        EXPECT_NE(outcome.refused, 0U);
        EXPECT_EQ(machine.value(control_word), 0x0F);
        machine.run(1s);
        EXPECT_NEAR(static_cast<double>(machine.position()), 10'000, 50);

        // Also when the values are good again: the controller has to show the edge.
        EXPECT_TRUE(image.apply(Standard{.target = 50'000, .word = 0x1F}.octets()).start_held);
        machine.run(1s);
        EXPECT_NEAR(static_cast<double>(machine.position()), 10'000, 50);
        EXPECT_FALSE(image.apply(Standard{.target = 50'000}.octets()).start_held);
        EXPECT_FALSE(image.apply(Standard{.target = 50'000, .word = 0x1F}.octets()).start_held);
        machine.run(5s);
        EXPECT_NEAR(static_cast<double>(machine.position()), 50'000, 50);
    }
}

// Limits that come behind the Controlword in the image count as well: pressing harder than wanted breaks things.
TEST(Image, StartBesideARefusedForceLimitDoesNotMove) {
    Machine machine;
    auto image = machine.image(102);
    auto bytes = Standard{.target = 50'000, .word = 0x1F}.octets();
    for (const auto octet : octets(little(2001, 2))) bytes.push_back(octet);
    const auto outcome = image.apply(bytes);
    EXPECT_EQ(outcome.refused, 1U << 5);
    EXPECT_TRUE(outcome.start_held);
    machine.run(1s);
    EXPECT_NEAR(static_cast<double>(machine.position()), 10'000, 50);
}

TEST(Image, WordThatStaysTheSameStopsNothing) {
    Machine machine;
    machine.set({0x66, 0x20}, -1);
    auto image = machine.image(101);
    EXPECT_EQ(image.apply(Standard{.word = 0x5F}.octets()), Image::Outcome{});
    machine.run(100ms);
    ASSERT_TRUE(machine.in_motion());
    const auto outcome = image.apply(Standard{.speed = 0, .word = 0x5F}.octets());
    EXPECT_FALSE(outcome.start_held);
    EXPECT_EQ(outcome.refused, 0b10U);
    machine.run(100ms);
    EXPECT_TRUE(machine.in_motion());
    EXPECT_FALSE(image.apply(Standard{.speed = 0, .word = 0x15F}.octets()).refused == 0) << "halt";
    machine.run(1s);
    EXPECT_FALSE(machine.in_motion());
    EXPECT_TRUE(image.apply(Standard{.speed = 0, .word = 0x5F}.octets()).start_held) << "the end of a halt is a start";
    machine.run(100ms);
    EXPECT_FALSE(machine.in_motion());
}

// A word that enables operation with bit 4 set all the time starts a jog.
TEST(Image, EnablingBesideARefusedMemberStartsNothing) {
    Machine machine;
    machine.set({0x66, 0x20}, -1);
    auto image = machine.image(101);
    EXPECT_EQ(image.apply(Standard{.word = 0x57}.octets()), Image::Outcome{});  // Disable operation
    const auto outcome = image.apply(Standard{.speed = 0, .word = 0x5F}.octets());
    EXPECT_TRUE(outcome.start_held);
    EXPECT_EQ(machine.value({0x66, 0x01}) & 0x6F, 0x27);
    machine.run(100ms);
    EXPECT_FALSE(machine.in_motion());
}

TEST(Image, TargetIsASetPointAlsoWhenItIsTheSame) {
    Machine machine;
    machine.set({0x66, 0x20}, 8);
    machine.set(target, machine.position());
    auto image = machine.image(101);
    const auto place = machine.position();
    for (int cycle = 0; cycle < 100; ++cycle) {
        EXPECT_EQ(image.apply(Standard{.target = place + 20 * cycle, .word = 0x1F}.octets()), Image::Outcome{});
        machine.run(1ms);
    }
    EXPECT_NEAR(static_cast<double>(machine.position()), static_cast<double>(place + 2'000), 200);
}

// ------------------------------------------------------------------------------------------------------------- memory

TEST(Image, NeitherPackingNorApplyingAsksForMemory) {
    Machine machine;
    machine.set({0x66, 0x20}, 8);
    for (const int instance : {101, 102, 103, 104, 112}) {
        auto outputs = machine.image(static_cast<std::uint16_t>(instance));
        const auto inputs = machine.image(113);
        cip::Bytes bytes(outputs.size());
        outputs.pack(0, bytes);
        cip::Bytes packed(inputs.size());
        const auto place = machine.position();
        const auto before = test::allocations();
        std::uint32_t refused = 0;
        for (std::int64_t i = 0; i < 1'000; ++i) {
            const auto next = place + i % 50;
            for (unsigned k = 0; k < 4; ++k) bytes[k] = static_cast<std::uint8_t>(next >> (8 * k));
            bytes[4] = static_cast<std::uint8_t>(i);  // SpeedJogOrProfilePositionMode
            bytes[15] = i % 7 == 0 ? 0x7F : 0;        // SCurve: refused now and then
            bytes[16] = i % 2 == 0 ? 0x0F : 0x1F;
            refused |= outputs.apply(bytes).refused;
            inputs.pack(i, packed);
        }
        EXPECT_EQ(test::allocations() - before, 0U) << instance;
        EXPECT_EQ(refused, 0b1000U) << "the loop has to have met a refusal";
    }
}

TEST(Allocations, AreCounted) {
    const auto before = test::allocations();
    const auto memory = std::make_unique<std::vector<int>>(100);
    EXPECT_EQ(test::allocations() - before, 2U);
    EXPECT_EQ(memory->size(), 100U);
}

}  // namespace
}  // namespace servobus::assemblies
