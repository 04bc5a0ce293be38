// A device is what its data sheet says: each class, each Param and each connection of the sheet is asked for at the device
// that the sheet is of, as a tool would.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "adapter/limits.hpp"
#include "cip/forward_open.hpp"
#include "cip/message.hpp"
#include "cip/real_time_format.hpp"
#include "cip/services.hpp"
#include "eds/data_sheet.hpp"
#include "eds/generate.hpp"
#include "eds/icon.hpp"
#include "tests/support/adapter_harness.hpp"

namespace servobus::test {
namespace {

adapter::DeviceFile file_of(cip::Bytes content, std::string name) {
    adapter::DeviceFile file;
    file.content = std::make_shared<const cip::Bytes>(std::move(content));
    file.name = std::move(name);
    return file;
}

class DescribedDevice : public testing::TestWithParam<const char*> {
protected:
    DescribedDevice() {
        EXPECT_TRUE(sheet_.findings.empty());
        harness_.register_session();
    }

    cip::Response ask(std::uint8_t service, const cip::Path& path, cip::Bytes data = {}) {
        const auto answer = harness_.call(cip::Request{service, path, std::move(data)}.encode());
        return cip::Response::parse(answer).value();
    }
    cip::Response ask(std::uint8_t service, const eds::Parameter& parameter, cip::Bytes data = {}) {
        return ask(service, cip::Path::parse(*parameter.path.octets()).value(), std::move(data));
    }
    std::optional<std::uint16_t> class_attribute(std::uint32_t class_id, std::uint32_t attribute) {
        const auto response = ask(cip::service::get_attribute_single, cip::Path::to(class_id, 0, attribute));
        if (response.status != cip::Status{} || response.data.size() != 2) return std::nullopt;
        return cip::Reader(response.data).u16();
    }

    // What an originator makes of an entry of the sheet (R-EDS-8, R-EDS-9, R-CON-7).
    cip::ForwardOpen forward_open(const eds::Connection& connection) {
        const auto direction = [](const eds::DirectionBits& bits, const eds::Flow& flow) {
            const auto octets =
                cip::connection_size(static_cast<cip::RealTimeFormat>(bits.format), flow.size.standard.value_or(0));
            return cip::ConnectionParameters{.type = cip::ConnectionType::point_to_point,
                                             .priority = cip::Priority::scheduled,
                                             .size = static_cast<std::uint16_t>(octets)};
        };
        cip::ForwardOpen open;
        open.triad = {++serial_, 1, 2};
        open.t_to_o_id = serial_;
        open.o_to_t_rpi = *connection.o_to_t.rpi.standard;
        open.t_to_o_rpi = *connection.t_to_o.rpi.standard;
        open.o_to_t = direction(connection.parameters.o_to_t(), connection.o_to_t);
        open.t_to_o = direction(connection.parameters.t_to_o(), connection.t_to_o);
        open.transport = {.transport_class = 1};
        open.path = *sheet_.connection_path(connection);
        return open;
    }

    drive::Model model_ = *drive::xenax_model(GetParam());
    std::string text_ = eds::generate(model_);
    eds::DataSheet sheet_ = *eds::read(text_);
    AdapterHarness harness_{drive::Device(model_),
                            {},
                            {},
                            {.eds = file_of({text_.begin(), text_.end()}, eds::file_name(model_)),
                             .icon = file_of(eds::icon(), std::string(eds::icon_file_name))}};
    std::uint16_t serial_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Variants, DescribedDevice, testing::Values("75v8s", "75v8", "48v8"));

TEST_P(DescribedDevice, IsFoundByItsIdentity) {
    const auto response = ask(cip::service::get_attributes_all, cip::Path::to(0x01, 1));
    ASSERT_EQ(response.status, cip::Status{});
    cip::Reader reader(response.data);
    EXPECT_EQ(reader.u16(), sheet_.device.vendor);
    EXPECT_EQ(reader.u16(), sheet_.device.product_type);
    EXPECT_EQ(reader.u16(), sheet_.device.product_code);
    EXPECT_EQ(reader.u8(), sheet_.device.major_revision);
    EXPECT_EQ(reader.u8(), sheet_.device.minor_revision);
}

TEST_P(DescribedDevice, HasTheClassesAndInstances) {
    ASSERT_EQ(sheet_.classes.size(), 8U);
    for (const auto& object : sheet_.classes) {
        EXPECT_EQ(class_attribute(*object.class_id, 1), object.revision) << object.section;
        EXPECT_EQ(class_attribute(*object.class_id, 2), object.max_instance) << object.section;
        EXPECT_EQ(class_attribute(*object.class_id, 3), object.static_instances) << object.section;
    }
}

TEST_P(DescribedDevice, AnswersForEachParam) {
    for (const auto& parameter : sheet_.parameters) {
        if (parameter.path.empty()) continue;
        const auto response = ask(cip::service::get_attribute_single, parameter);
        if (parameter.help.starts_with("Only to be written.")) {
            EXPECT_EQ(response.status.general, cip::GeneralStatus::attribute_not_gettable) << parameter.name;
            continue;
        }
        ASSERT_EQ(response.status, cip::Status{}) << parameter.name;
        if (parameter.type == cip::DataType::STRING) {
            EXPECT_LE(response.data.size(), *parameter.size) << parameter.name;
        } else {
            EXPECT_EQ(response.data.size(), *parameter.size) << parameter.name;
        }
    }
}

TEST_P(DescribedDevice, TakesNothingForWhatIsReadOnly) {
    std::size_t read_only = 0;
    for (const auto& parameter : sheet_.parameters) {
        if (!parameter.read_only()) continue;
        const auto response = ask(cip::service::set_attribute_single, parameter, parameter.standard_octets());
        EXPECT_EQ(response.status.general, cip::GeneralStatus::attribute_not_settable) << parameter.name;
        ++read_only;
    }
    EXPECT_GT(read_only, 50U);
}

// A value one past the limits is refused, one at them is legal, unless it is no listed value.
TEST_P(DescribedDevice, HasTheLimits) {
    std::size_t looked_at = 0;
    for (const auto& parameter : sheet_.parameters) {
        const auto* maximum = std::get_if<std::int64_t>(&parameter.maximum);
        if (parameter.path.empty() || parameter.read_only() || parameter.type == cip::DataType::STRING) continue;
        const auto octets = parameter.encode(*maximum + 1);
        if (!octets) continue;
        const auto response = ask(cip::service::set_attribute_single, parameter, *octets);
        EXPECT_EQ(response.status.general, cip::GeneralStatus::invalid_attribute_value) << parameter.name;
        ++looked_at;
    }
    EXPECT_GT(looked_at, 50U);
}

TEST_P(DescribedDevice, OpensEachConnectionAsItSays) {
    for (const auto& connection : sheet_.connections) {
        const auto open = forward_open(connection);
        const auto opened = ask(cip::service::forward_open, cip::Path::to(0x06, 1), open.encode());
        ASSERT_EQ(opened.status, cip::Status{}) << connection.name;
        const auto reply = cip::ForwardOpenReply::parse(opened.data).value();
        EXPECT_EQ(reply.o_to_t_api, open.o_to_t_rpi);
        EXPECT_EQ(reply.t_to_o_api, open.t_to_o_rpi);
        const cip::ForwardClose close{.triad = open.triad, .path = open.path};
        EXPECT_EQ(ask(cip::service::forward_close, cip::Path::to(0x06, 1), close.encode()).status, cip::Status{});
    }
}

TEST_P(DescribedDevice, TakesNoOtherInterval) {
    for (const auto interval :
         {*sheet_.connections[0].o_to_t.rpi.minimum - 1, *sheet_.connections[0].o_to_t.rpi.maximum + 1}) {
        auto open = forward_open(sheet_.connections[0]);
        open.o_to_t_rpi = interval;
        open.t_to_o_rpi = interval;
        const auto refused = ask(cip::service::forward_open, cip::Path::to(0x06, 1), open.encode());
        EXPECT_EQ(refused.status.general, cip::GeneralStatus::connection_failure) << interval;
    }
}

TEST_P(DescribedDevice, TakesAsManyConnectionsAsItSays) {
    const adapter::Limits limits;
    EXPECT_EQ(sheet_.capacity.io_connections, 1 + limits.listening_connections);
    EXPECT_EQ(sheet_.capacity.message_connections, limits.class3_connections);
}

}  // namespace
}  // namespace servobus::test
