// What a device keeps, as text and back.
#include "adapter/state_json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "adapter/state_file.hpp"
#include "drive/xenax.hpp"

namespace servobus::adapter {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class StateText : public testing::Test {
protected:
    std::string text(const StoredState& state) const { return state_text(state, delivered_, device_.store()); }
    StoredState parsed(const std::string& text) const {
        auto result = parse_state(text, delivered_, device_);
        if (const auto* reason = std::get_if<std::string>(&result)) ADD_FAILURE() << *reason;
        return std::holds_alternative<StoredState>(result) ? std::get<StoredState>(result) : StoredState{};
    }
    std::string reason(const std::string& text) const {
        const auto result = parse_state(text, delivered_, device_);
        const auto* reason = std::get_if<std::string>(&result);
        return reason != nullptr ? *reason : "it is taken";
    }

    drive::Device device_{drive::xenax_models().front()};
    StoredState delivered_;
};

/// Each member has another value than the delivered one.
NetworkSettings other_settings() {
    NetworkSettings settings;
    settings.method = AddressMethod::stored;
    settings.configured = {0xC0A80264, 0xFFFFFF00, 0xC0A80201, 0x08080808, 0x08080404, "plant.example"};
    settings.host_name = "press-7";
    settings.ttl = 4;
    settings.multicast = {true, 8, 0xEFC00200};
    settings.select_acd = false;
    settings.last_conflict[0] = 2;
    settings.last_conflict[34] = 0xFF;
    settings.inactivity_seconds = 3600;
    settings.links[0] = {2, 100};
    settings.links[1] = {0, 10};
    settings.qos = {1, {1, 2, 3, 4, 63}, {5, 6}};
    settings.time_sync = {false, std::numeric_limits<std::uint64_t>::max()};
    return settings;
}

TEST_F(StateText, HasOnlyWhatIsNotAsDelivered) {
    EXPECT_EQ(json::parse(text(delivered_)), json::parse(R"({"network":{},"parameters":{}})"));
    auto state = delivered_;
    state.network.host_name = "press-7";
    state.parameters = {{{0x64, 0x00}, 0, std::int64_t{50}}, {{0x65, 0x5D}, 2, std::int64_t{-7}}};
    EXPECT_EQ(json::parse(text(state)),
              json::parse(R"({"network":{"host_name":"press-7"},"parameters":{"0x64/0x00":50,"0x65/0x5D":{"3":-7}}})"));
}

TEST_F(StateText, OfEverythingComesBack) {
    const StoredState state{other_settings(),
                            {{{0x64, 0x00}, 0, std::int64_t{50}},
                             {{0x65, 0x5D}, 0, std::int64_t{-2'000'000'000}},
                             {{0x65, 0x5D}, 9, std::int64_t{7}},
                             {{0x65, 0x5D}, 49, std::int64_t{2'000'000'000}},
                             {{0x69, 0x02}, 0, std::string("press 7")}},
                            {{{2, 5}, {3, 1}}, true, false}};
    const auto document = json::parse(text(state));
    EXPECT_EQ(document["network"].size(), json::parse(text({other_settings(), {}, {}}))["network"].size());
    EXPECT_EQ(document["network"].size(), 11U) << "every member is there";
    EXPECT_EQ(parsed(text(state)), state);
}

TEST_F(StateText, WhatIsNotThereIsAsDelivered) {
    delivered_.network.inactivity_seconds = 60;
    delivered_.firmware.release.version = {9, 1};
    EXPECT_EQ(parsed("{}"), delivered_);
    EXPECT_EQ(parsed(R"({"network":{"qos":{"tag_enable":1}}})").network.qos.dscp, delivered_.network.qos.dscp);
    auto state = delivered_;
    state.network.inactivity_seconds = 120;  // the manual's default, which this device was not delivered with
    EXPECT_EQ(parsed(text(state)), state);
}

TEST_F(StateText, KeepsOctetsThatAreNoCharacters) {
    std::string octets;
    for (int i = 0; i < 256; ++i) octets += static_cast<char>(i);
    auto state = delivered_;
    state.network.configured.domain = octets;
    EXPECT_EQ(parsed(text(state)), state);
    state.parameters = {{{0x69, 0x02}, 0, std::string("\xFF\x80\x01\"\\", 5)}};
    EXPECT_EQ(parsed(text(state)), state);
}

TEST_F(StateText, OfAnotherOrderIsTheSame) {
    const auto first = parsed(R"({"parameters":{"0x65/0x5D":{"10":1,"9":2},"0x64/0x00":50}})");
    EXPECT_EQ(first.parameters, (drive::StoredValues{{{0x64, 0x00}, 0, std::int64_t{50}},
                                                     {{0x65, 0x5D}, 8, std::int64_t{2}},
                                                     {{0x65, 0x5D}, 9, std::int64_t{1}}}));
}

TEST_F(StateText, ThatIsNotUnderstoodIsRefusedWithItsPlace) {
    EXPECT_EQ(reason(""), "it is no JSON object");
    EXPECT_EQ(reason("[]"), "it is no JSON object");
    EXPECT_EQ(reason("{\"network\":"), "it is no JSON object");
    EXPECT_EQ(reason(R"({"netzwerk":{}})"), "'netzwerk': is not known");
    EXPECT_EQ(reason(R"({"network":[]})"), "'network': must be an object");
    EXPECT_EQ(reason(R"({"network":{"hostname":"a"}})"), "'network': 'hostname' is not known");
    EXPECT_EQ(reason(R"({"network":{"host_name":7}})"),
              "'network': 'host_name' must be a text of characters up to 255");
    EXPECT_EQ(reason(R"({"network":{"host_name":"\u0100"}})"),
              "'network': 'host_name' must be a text of characters up to 255");
    EXPECT_EQ(reason(R"({"network":{"ttl":256}})"), "'network': 'ttl' must be a whole number from 0 to 255");
    EXPECT_EQ(reason(R"({"network":{"ttl":-1}})"), "'network': 'ttl' must be a whole number from 0 to 255");
    EXPECT_EQ(reason(R"({"network":{"ttl":1.5}})"), "'network': 'ttl' must be a whole number from 0 to 255");
    EXPECT_EQ(reason(R"({"network":{"method":3}})"), "'network': 'method' cannot be 3");
    EXPECT_EQ(reason(R"({"network":{"select_acd":1}})"), "'network': 'select_acd' must be true or false");
    EXPECT_EQ(reason(R"({"network":{"last_conflict":[1]}})"), "'network': 'last_conflict' must be a list of 35");
    EXPECT_EQ(reason(R"({"network":{"qos":{"dscp":[1,2,3,4,"5"]}}})"),
              "'network': 'qos' 'dscp' [4] must be a whole number from 0 to 255");
    EXPECT_EQ(reason(R"({"firmware":{"release":{"version":{"major":1,"minor":0,"patch":1}}}})"),
              "'firmware': 'release' 'version' 'patch' is not known");
}

TEST_F(StateText, OfParametersThatTheDriveDoesNotKeepIsRefused) {
    const auto of = [this](const std::string& parameters) { return reason(R"({"parameters":)" + parameters + "}"); };
    EXPECT_EQ(of("7"), "'parameters': must be an object");
    EXPECT_EQ(of(R"({"0x65/0x01":1})"), "'parameters': '0x65/0x01' is no parameter");
    EXPECT_EQ(of(R"({"SCurve":1})"), "'parameters': 'SCurve' is no parameter");
    EXPECT_EQ(of(R"({"0x64/0x00":true})"), "'parameters': '0x64/0x00' must be a whole number or a text");
    EXPECT_EQ(of(R"({"0x64/0x00":18446744073709551615})"),
              "'parameters': '0x64/0x00' must be a whole number or a text");
    const std::string refused = "is nothing that this drive keeps, or out of its limits";
    EXPECT_EQ(of(R"({"0x64/0x00":101})"), "'parameters': '0x64/0x00' " + refused);
    EXPECT_EQ(of(R"({"0x64/0x00":"50"})"), "'parameters': '0x64/0x00' " + refused);
    EXPECT_EQ(of(R"({"0x66/0x00":6})"), "'parameters': '0x66/0x00' " + refused);
    EXPECT_EQ(of(R"({"0x65/0x5D":5})"), "'parameters': '0x65/0x5D' must be an object");
    for (const auto* element : {"0", "51", "-1", "70000", "x", "", "3x"}) {
        EXPECT_EQ(of(R"({"0x65/0x5D":{")" + std::string(element) + R"(":5}})"),
                  "'parameters': '0x65/0x5D' '" + std::string(element) + "' " + refused);
    }
}

TEST_F(StateText, OfAnEverydayDriveFitsIntoItsFile) {
    auto state = StoredState{other_settings(), {}, {}};
    for (const auto& row : drive::parameters()) {
        for (std::uint16_t element = 0; element < row.elements; ++element) {
            drive::StoredValue value{row.key(), element, row.low};
            if (row.is_text()) value.value = std::string(row.max_length, '\xFF');
            if (device_.fits(value)) state.parameters.push_back(value);
        }
    }
    EXPECT_GT(state.parameters.size(), 400U);
    EXPECT_EQ(parsed(text(state)), state);
    EXPECT_LT(seal(text(state)).size(), max_state_octets / 16);
}

}  // namespace
}  // namespace servobus::adapter
