// The offline verbs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "drive/lookup.hpp"
#include "drive/xenax.hpp"
#include "scanner/cli/verbs.hpp"

namespace servobus::scanner::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

std::string listed(const ListArguments& arguments, bool as_json = false) {
    std::ostringstream out;
    std::ostringstream err;
    EXPECT_EQ(list({out, err, as_json}, arguments), ExitCode::done) << err.str();
    return out.str();
}

TEST(List, ShowsEverything) {
    const auto document = json::parse(listed({}, true));
    ASSERT_EQ(document["parameters"].size(), drive::parameters().size());
    const auto& first = document["parameters"][0];
    EXPECT_EQ(first["name"], "SCurve");
    EXPECT_EQ(first["default"], 20);
    EXPECT_EQ(first["low"], 1);
    EXPECT_EQ(first["access"], "get/set");
    EXPECT_THAT(first["section"].get<std::string>(), HasSubstr("2.3.1.1"));
}

TEST(List, TakesPatterns) {
    EXPECT_THAT(listed({"scurve"}), HasSubstr("0x64/1/0x00"));
    EXPECT_THAT(listed({"scurve"}), Not(HasSubstr("Statusword")));
    EXPECT_EQ(json::parse(listed({"drive.*"}, true))["parameters"].size(), 24U);
    EXPECT_EQ(json::parse(listed({"SCRV"}, true))["parameters"].size(), 1U);
    EXPECT_EQ(json::parse(listed({"0x6064:00"}, true))["parameters"][0]["cip"], "0x66/1/0x24");
    EXPECT_EQ(json::parse(listed({"s?urve"}, true))["parameters"].size(), 1U);
    EXPECT_EQ(json::parse(listed({"*"}, true))["parameters"].size(), drive::parameters().size());
}

TEST(List, OffersNamesThatMeanOneParameter) {
    std::istringstream names(listed({.names = true}));
    std::size_t count = 0;
    for (std::string name; std::getline(names, name); ++count) {
        EXPECT_EQ(drive::find_by_name(drive::parameters(), drive::parameter_classes(), name).size(), 1U) << name;
    }
    EXPECT_GT(count, 2 * drive::parameters().size());
}

TEST(List, ShowsCommands) {
    EXPECT_THAT(listed({.commands = true}), HasSubstr("REF "));
    EXPECT_EQ(json::parse(listed({.pattern = "power*", .commands = true}, true))["commands"].size(), 4U);
    std::istringstream names(listed({.names = true, .commands = true}));
    for (std::string name; std::getline(names, name);) {
        EXPECT_NE(drive::find_command(drive::direct_commands(), name), nullptr) << name;
    }
}

}  // namespace
}  // namespace servobus::scanner::cli
