// A drive with its axis, without any bus: rows by their mnemonic or name, and virtual time.
//
//     DriveHarness drive;
//     drive.set("Controlword", 0x06);
//     EXPECT_EQ(drive.get("Statusword"), 0x0231);
//     EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 10); }, 2s));
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "drive/device.hpp"
#include "drive/lookup.hpp"
#include "drive/xenax.hpp"

namespace servobus::test {

class DriveHarness {
public:
    explicit DriveHarness(const drive::AxisKind& axis = {}, std::string_view variant = "75v8s", std::uint64_t seed = 1)
        : device_(*drive::xenax_model(variant), drive::Machine{axis, seed}) {
        device_.step(now_);
    }
    explicit DriveHarness(const drive::Machine& machine, std::string_view variant = "75v8s")
        : device_(*drive::xenax_model(variant), machine) {
        device_.step(now_);
    }

    drive::Device& device() { return device_; }
    drive::Time now() const { return now_; }

    const drive::Parameter& row(std::string_view name) {
        const auto rows = drive::find_by_name(device_.store().table(), drive::parameter_classes(), name);
        EXPECT_EQ(rows.size(), 1U) << name;
        return *rows.front();
    }

    std::int64_t get(std::string_view name) { return std::get<std::int64_t>(device_.store().value(row(name))); }
    std::string text(std::string_view name) { return std::get<std::string>(device_.store().value(row(name))); }
    /// A bit pattern of a signed row, as people write it.
    std::uint32_t word(std::string_view name) {
        const auto& parameter = row(name);
        const auto mask = drive::size_of(parameter.cip.type) == 2 ? 0xFFFFU : 0xFFFFFFFFU;
        return static_cast<std::uint32_t>(std::get<std::int64_t>(device_.store().value(parameter))) & mask;
    }
    bool bit(std::string_view name, unsigned number) { return (word(name) >> number & 1U) != 0; }

    /// What a bus would write; a refusal fails the test.
    void set(std::string_view name, std::int64_t value) {
        const auto refusal = try_set(name, value);
        EXPECT_FALSE(refusal) << name << " = " << value << ": " << (refusal ? drive::describe(*refusal) : "");
    }
    std::optional<drive::Refusal> try_set(std::string_view name, std::int64_t value) {
        return device_.write(row(name), value);
    }
    void command(std::string_view mnemonic) {
        const auto refusal = try_command(mnemonic);
        EXPECT_FALSE(refusal) << mnemonic << ": " << (refusal ? drive::describe(*refusal) : "");
    }
    std::optional<drive::Refusal> try_command(std::string_view mnemonic) {
        const auto* known = drive::find_command(drive::direct_commands(), mnemonic);
        EXPECT_NE(known, nullptr) << mnemonic;
        return device_.write(*device_.find({0x65, 0x00}), std::int64_t{known->value});
    }
    void inject(const drive::Event& event) { device_.inject(event); }

    void run(std::chrono::microseconds duration) {
        const auto end = now_ + duration;
        while (now_ < end) {
            now_ = std::min(end, now_ + std::chrono::milliseconds(1));
            device_.step(now_);
        }
    }
    /// False when it does not come true within `limit`.
    [[nodiscard]] bool runs_until(const std::function<bool()>& condition, std::chrono::microseconds limit) {
        const auto end = now_ + limit;
        while (!condition()) {
            if (now_ >= end) return false;
            now_ += std::chrono::milliseconds(1);
            device_.step(now_);
        }
        return true;
    }

    /// POWER-ON of the sequences: 0x06, 0x07, 0x0F, with the status words that belong to them.
    void power_on() {
        set("Controlword", 0x06);
        EXPECT_EQ(word("Statusword") & 0x006FU, 0x0021U);
        set("Controlword", 0x07);
        EXPECT_EQ(word("Statusword") & 0x006FU, 0x0023U);
        set("Controlword", 0x0F);
        EXPECT_EQ(word("Statusword") & 0x006FU, 0x0027U);
    }
    void enter_mode(std::int64_t mode) {
        set("ModesOfOperationRequested", mode);
        EXPECT_EQ(get("ModesOfOperationDisplayed"), mode);
    }
    /// Reference by control word, with the method given, and on to a mode.
    void reference(std::int64_t method = 1, std::int64_t mode_after = 1) {
        enter_mode(6);
        set("ReferenceMethods", method);
        power_on();
        set("Controlword", 0x1F);
        EXPECT_TRUE(runs_until([&] { return bit("Statusword", 12); }, std::chrono::seconds(30)));
        EXPECT_FALSE(bit("Statusword", 13));
        enter_mode(mode_after);
        set("Controlword", 0x0F);
    }
    /// A move in profile position mode, waited for.
    void move(std::int64_t target, bool relative = false) {
        set("Controlword", 0x0F);
        set("TargetPositionOrDistance", target);
        set("Controlword", relative ? 0x5F : 0x1F);
        EXPECT_TRUE(runs_until([&] { return reached(); }, std::chrono::seconds(60)));
    }
    bool reached() { return bit("Statusword", 10) && !bit("Statusword", 12); }

private:
    drive::Device device_;
    drive::Time now_{0};
};

}  // namespace servobus::test
