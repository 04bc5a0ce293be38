// The gate of the message router: what it is asked, when, and what it is told.
#include "cip/gate.hpp"

#include <gmock/gmock.h>

#include <memory>
#include <string>
#include <vector>

#include "cip/message_router.hpp"
#include "cip/services.hpp"
#include "tests/support/octets.hpp"

namespace servobus::cip {
namespace {

using test::hex;
using test::octets;
using testing::ElementsAre;
using testing::IsEmpty;

/// Attributes 0 (also when it is left out) and 1, an octet each; service 0x4B answers with its data.
class Octets : public Object {
public:
    ClassInfo info() const override { return {.class_id = 0x64}; }
    bool offers(std::uint8_t code) const override {
        return code == service::get_attribute_single || code == service::set_attribute_single ||
               code == service::set_attribute_list || code == 0x4B;
    }
    std::optional<AttributeAccess> attribute(std::uint32_t, std::uint32_t id) const override {
        if (id > 1) return std::nullopt;
        return AttributeAccess{true, true};
    }
    std::optional<std::uint32_t> implied_attribute() const override { return 0; }
    Status get(std::uint32_t, std::uint32_t id, Writer& value) const override {
        value.u8(values[id]);
        return {};
    }
    Status set(std::uint32_t, std::uint32_t id, ByteView value) override {
        values[id] = value[0];
        return {};
    }
    std::optional<std::size_t> value_size(std::uint32_t, std::uint32_t, ByteView) const override { return 1; }
    Response call(const RequestView& request, const RequestPath&, const Origin&) override {
        return {request.service, {}, {request.data.begin(), request.data.end()}};
    }
    Response refuse(const RequestView& request, Status status) override {
        return {request.service, std::move(status), request.service == 0x4B ? Bytes{0x77} : Bytes{}};
    }

    std::array<std::uint8_t, 2> values{};
};

/// Notes all that it hears, and refuses what `refuses` says.
class Porter : public Gate {
public:
    Status admit(const Access& access) override {
        asked.push_back(text(access));
        return refuses && refuses(access) ? GeneralStatus::privilege_violation : GeneralStatus::success;
    }
    void ended(const Access& access, const Response& response) override {
        told.push_back(text(access) + " -> " + hex(Bytes{static_cast<std::uint8_t>(response.status.general)}));
    }

    bool (*refuses)(const Access&) = nullptr;
    std::vector<std::string> asked;
    std::vector<std::string> told;

private:
    static std::string text(const Access& access) {
        auto line = hex(Bytes{access.request.service});
        if (access.path == nullptr) line += " no path";
        if (access.attribute) line += " @" + std::to_string(*access.attribute);
        if (access.is_entry) line += " entry";
        if (access.origin.is_part) line += " part";
        if (!access.data.empty()) line += " " + hex(access.data);
        return line;
    }
};

class GateOfARouter : public testing::Test {
protected:
    GateOfARouter() {
        auto own = std::make_unique<Octets>();
        object = own.get();
        router.add(std::move(own));
        router.set_gate(&porter);
    }
    std::string call(std::string_view request) {
        const auto response = router.handle(octets(request), {});
        return response ? hex(response->encode()) : "none";
    }

    Porter porter;
    MessageRouter router{{}};
    Octets* object = nullptr;
};

TEST_F(GateOfARouter, IsAskedBeforeAndToldAfterwards) {
    EXPECT_EQ(call("10 03 20 64 24 01 30 01 05"), "90 00 00 00");
    EXPECT_EQ(call("0E 02 20 64 24 01"), "8E 00 00 00 00");
    EXPECT_THAT(porter.asked, ElementsAre("10 @1 05", "0E @0"));
    EXPECT_THAT(porter.told, ElementsAre("10 @1 05 -> 00", "0E @0 -> 00"));
}

TEST_F(GateOfARouter, WhatItDoesNotAdmitDoesNotHappen) {
    porter.refuses = [](const Access&) { return true; };
    EXPECT_EQ(call("10 03 20 64 24 01 30 01 05"), "90 00 0F 00");
    EXPECT_EQ(object->values[1], 0);
    EXPECT_EQ(call("4B 02 20 64 24 01 01 02"), "CB 00 0F 00 77") << "the object says it in its own way";
    EXPECT_THAT(porter.told, ElementsAre("10 @1 05 -> 0F", "4B 01 02 -> 0F"));
}

TEST_F(GateOfARouter, IsNotAskedForWhatTheRouterRefusesAndIsToldOfIt) {
    EXPECT_EQ(call("10 03 20 65 24 01 30 01 05"), "90 00 05 00");  // no such class
    EXPECT_EQ(call("10 03 20 64 24 02 30 01 05"), "90 00 05 00");  // no such instance
    EXPECT_EQ(call("05 02 20 64 24 01"), "85 00 08 00");           // no such service
    EXPECT_EQ(call("90 03 20 64 24 01 30 01 05"), "90 00 08 00");  // a reply
    EXPECT_EQ(call("10 02 FF 00 24 01 05"), "90 00 04 00");        // no such segment
    EXPECT_EQ(call("10 09 20 64"), "90 00 26 00");                 // a path that is not all there
    EXPECT_EQ(call("0E 03 20 64 24 00 30 01"), "8E 00 00 00 01 00");
    EXPECT_THAT(porter.asked, IsEmpty());
    EXPECT_THAT(porter.told, ElementsAre("10 @1 05 -> 05", "10 @1 05 -> 05", "05 -> 08", "90 @1 05 -> 08",
                                         "10 no path 05 -> 04", "10 no path -> 26", "0E @1 -> 00"));
    EXPECT_EQ(call("10"), "none");
    EXPECT_EQ(porter.told.size(), 7U) << "what is no message is nothing to tell";
}

TEST_F(GateOfARouter, ListsAreAskedAsAWholeAndByEntry) {
    porter.refuses = [](const Access& access) { return access.attribute == 1U; };
    EXPECT_EQ(call("04 02 20 64 24 01 03 00 00 00 0A 01 00 0B 07 00 0C"),
              "84 00 0A 00 03 00 00 00 00 00 01 00 0F 00 07 00 14 00");
    EXPECT_EQ(object->values[0], 0x0A);
    EXPECT_EQ(object->values[1], 0);
    EXPECT_THAT(porter.asked, ElementsAre("04 03 00 00 00 0A 01 00 0B 07 00 0C", "04 @0 entry 0A", "04 @1 entry 0B"));
    EXPECT_THAT(porter.told, ElementsAre("04 @0 entry 0A -> 00", "04 @1 entry 0B -> 0F", "04 @7 entry -> 14",
                                         "04 03 00 00 00 0A 01 00 0B 07 00 0C -> 0A"));
    porter.refuses = [](const Access& access) { return !access.is_entry; };
    EXPECT_EQ(call("04 02 20 64 24 01 01 00 00 00 0C"), "84 00 0F 00");
    EXPECT_EQ(object->values[0], 0x0A);
}

TEST_F(GateOfARouter, EachPartOfAPacketIsAsked) {
    porter.refuses = [](const Access& access) { return access.attribute == 1U; };
    EXPECT_EQ(call("0A 02 20 02 24 01 02 00 06 00 0F 00 10 03 20 64 24 01 30 00 05 10 03 20 64 24 01 30 01 05"),
              "8A 00 1E 00 02 00 06 00 0A 00 90 00 00 00 90 00 0F 00");
    EXPECT_EQ(object->values[0], 5);
    EXPECT_EQ(object->values[1], 0);
    EXPECT_THAT(porter.asked, ElementsAre("10 @0 part 05", "10 @1 part 05"));
}

TEST_F(GateOfARouter, WithoutOneEverythingIsAdmitted) {
    router.set_gate(nullptr);
    EXPECT_EQ(call("10 03 20 64 24 01 30 01 05"), "90 00 00 00");
    EXPECT_EQ(object->values[1], 5);
    EXPECT_THAT(porter.told, IsEmpty());
}

}  // namespace
}  // namespace servobus::cip
