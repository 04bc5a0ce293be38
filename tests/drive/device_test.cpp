#include "drive/device.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "drive/xenax.hpp"

namespace servobus::drive {
namespace {

constexpr Key motor_type{0x64, 0x08};
constexpr Key reference_methods{0x66, 0x58};

Value number(std::int64_t value) { return value; }

TEST(XenaxModels, HaveTheIdentityOfTheManual) {
    const auto models = xenax_models();
    ASSERT_EQ(models.size(), 3U);
    EXPECT_EQ(models[0].key, "75v8s");
    EXPECT_EQ(models[0].identity.product_code, 0x7509);
    EXPECT_EQ(models[1].key, "75v8");
    EXPECT_EQ(models[1].identity.product_code, 0x7508);
    EXPECT_EQ(models[2].key, "48v8");
    EXPECT_EQ(models[2].identity.product_code, 0x4808);
    for (const Model& model : models) {
        EXPECT_EQ(model.identity.vendor, 1389);
        EXPECT_EQ(model.identity.device_type, 43);
        EXPECT_EQ(model.identity.major_revision, 1);
        EXPECT_EQ(model.identity.minor_revision, 1);
        EXPECT_EQ(model.identity.serial_number, 0x00A1B2C3U);
        EXPECT_EQ(model.identity.product_name, model.name);
        EXPECT_LE(model.name.size(), 32U);
        EXPECT_EQ(model.has_force_option, model.key == "75v8s");
    }
}

TEST(XenaxModels, AreFoundByTheirKey) {
    EXPECT_EQ(xenax_model("48v8")->name, "XENAX Xvi 48V8");
    EXPECT_FALSE(xenax_model("75V8S").has_value());
}

TEST(DeviceWithoutForceOption, RefusesTheRowsThatNeedIt) {
    Device device(*xenax_model("75v8"));
    const Parameter& limit_force = *device.find({0x64, 0x09});
    EXPECT_EQ(device.read(limit_force), ReadResult{Refusal::not_configured});
    EXPECT_EQ(device.write(limit_force, number(1000)), Refusal::not_configured);
    EXPECT_EQ(device.store().value(limit_force), number(0));
}

TEST(DeviceWithoutForceOption, NamesTheMissingOptionBeforeTheLimitButAfterTheAccess) {
    const Device device(*xenax_model("48v8"));
    EXPECT_EQ(device.check(*device.find({0x64, 0x09}), number(200'001)), Refusal::not_configured);
    EXPECT_EQ(device.check(*device.find({0x64, 0x0A}), number(0)), Refusal::read_only);
    EXPECT_EQ(device.read(*device.find({0x64, 0x0A})), ReadResult{Refusal::not_configured});
}

TEST(DeviceWithoutForceOption, AnswersAllOtherRows) {
    Device device(*xenax_model("75v8"));
    for (const Parameter& row : parameters()) {
        if (row.access != Access::set) {
            EXPECT_EQ(device.read(row) == ReadResult{Refusal::not_configured}, row.force_option) << row.name;
        }
    }
    EXPECT_EQ(device.write(*device.find({0x66, 0x33}), number(100)), std::nullopt);
}

TEST(DeviceWithForceOption, HasItsRows) {
    Device device(*xenax_model("75v8s"));
    EXPECT_EQ(device.write(*device.find({0x64, 0x09}), number(1000)), std::nullopt);
    EXPECT_EQ(device.read(*device.find({0x64, 0x09})), ReadResult{number(1000)});
}

TEST(DeviceWithALinearMotor, TakesOnlyLinearReferenceMethods) {
    Device device(xenax_models()[0], Motor::linear);
    const Parameter& row = *device.find(reference_methods);
    EXPECT_EQ(device.write(row, number(6)), std::nullopt);
    EXPECT_EQ(device.write(row, number(10)), Refusal::not_configured);
    EXPECT_EQ(device.write(row, number(15)), Refusal::not_configured);
    EXPECT_EQ(device.write(row, number(7)), Refusal::not_allowed);
    EXPECT_EQ(device.write(row, number(16)), Refusal::too_high);
    EXPECT_EQ(device.read(row), ReadResult{number(6)});
}

TEST(DeviceWithARotativeMotor, TakesOnlyRotativeReferenceMethods) {
    Device device(xenax_models()[0], Motor::rotative);
    const Parameter& row = *device.find(reference_methods);
    EXPECT_EQ(device.write(row, number(10)), std::nullopt);
    EXPECT_EQ(device.write(row, number(1)), Refusal::not_configured);
    EXPECT_EQ(device.read(row), ReadResult{number(10)});
}

TEST(DeviceWithAnyMotor, TakesEveryReferenceMethod) {
    Device device(xenax_models()[0]);
    const Parameter& row = *device.find(reference_methods);
    for (const std::int64_t method : row.allowed) {
        EXPECT_EQ(device.write(row, number(method)), std::nullopt) << method;
    }
}

TEST(Device, TellsTheConnectedMotor) {
    const auto motor_of = [](Motor motor) {
        const Device device(xenax_models()[0], motor);
        return std::get<std::string>(device.store().value(*device.find(motor_type)));
    };
    EXPECT_EQ(motor_of(Motor::any), "rotative");
    EXPECT_EQ(motor_of(Motor::rotative), "rotative");
    EXPECT_EQ(motor_of(Motor::linear), "230101");
}

TEST(Device, KeepsTheNameOfItsMotorOverAReset) {
    Device device(xenax_models()[0], Motor::linear);
    EXPECT_EQ(device.write(*device.find({0x64, 0x00}), number(50)), std::nullopt);
    device.reset();
    EXPECT_EQ(device.read(*device.find({0x64, 0x00})), ReadResult{number(20)});
    EXPECT_EQ(device.read(*device.find(motor_type)), ReadResult{Value{std::string("230101")}});
}

TEST(Device, RefusesAWriteWithoutAChange) {
    Device device(xenax_models()[0]);
    EXPECT_EQ(device.write(*device.find({0x64, 0x00}), number(101)), Refusal::too_high);
    EXPECT_EQ(device.write(*device.find({0x64, 0x00}), Value{std::string("50")}), Refusal::wrong_type);
    EXPECT_EQ(device.read(*device.find({0x64, 0x00})), ReadResult{number(20)});
}

TEST(Device, TakesOnlyDirectCommandsThatExist) {
    Device device(xenax_models()[0]);
    const Parameter& row = *device.find(*device.model().direct_command_row);
    EXPECT_EQ(device.write(row, number(0x1000)), std::nullopt);
    EXPECT_EQ(device.write(row, number(0x1040)), Refusal::not_allowed);
    EXPECT_EQ(device.write(row, number(0x7000)), Refusal::not_allowed);
    EXPECT_EQ(device.write(row, number(0x1'0000'0000)), Refusal::too_high);
    EXPECT_EQ(device.read(row), ReadResult{Refusal::write_only});
}

}  // namespace
}  // namespace servobus::drive
