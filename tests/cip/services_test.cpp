// Service codes and their names.
#include "cip/services.hpp"

#include <gtest/gtest.h>

#include <string>

namespace servobus::cip {
namespace {

TEST(Services, R_MSG_4_common_services_have_one_name_everywhere) {
    EXPECT_EQ(service::name(0x0E, 0x66), "Get_Attribute_Single");
    EXPECT_EQ(service::name(0x0E, class_id::connection_manager), "Get_Attribute_Single");
    EXPECT_EQ(service::name(0x0A, class_id::message_router), "Multiple_Service_Packet");
    EXPECT_EQ(service::name(0x05, 0x01), "Reset");
}

TEST(Services, R_MSG_4_from_0x4B_the_class_decides) {
    EXPECT_EQ(service::name(0x4E, class_id::connection_manager), "Forward_Close");
    EXPECT_EQ(service::name(0x54, class_id::connection_manager), "Forward_Open");
    EXPECT_EQ(service::name(0x5B, class_id::connection_manager), "Large_Forward_Open");
    EXPECT_EQ(service::name(0x4B, 0x37), "Initiate_Upload");
    EXPECT_EQ(service::name(0x54, 0x66), "");
    EXPECT_EQ(service::name(0x4E, 0x37), "");
}

TEST(Services, R_MSG_4_unknown_codes_have_no_name) {
    for (const unsigned code : {0x00U, 0x0BU, 0x0FU, 0x7FU, 0x8EU, 0xFFU}) {
        EXPECT_EQ(service::name(static_cast<std::uint8_t>(code), 1), "") << code;
    }
}

TEST(Services, a_name_is_found_in_any_spelling) {
    for (const auto* text : {"Get_Attribute_Single", "get_attribute_single", "GetAttributeSingle",
                             "get attribute single", "GET-ATTRIBUTE-SINGLE", "_getattributesingle_"}) {
        EXPECT_EQ(service::from_name(text), 0x0E) << text;
    }
    EXPECT_EQ(service::from_name("forward open"), 0x54);
    EXPECT_EQ(service::from_name("Large_Forward_Open"), 0x5B);
}

TEST(Services, what_is_no_name_is_not_found) {
    for (const auto* text : {"", "Get", "Get_Attribute_Singl", "Get_Attribute_Singles", "0E", "___"}) {
        EXPECT_EQ(service::from_name(text), std::nullopt) << text;
    }
}

TEST(Services, every_name_leads_back_to_its_code) {
    for (unsigned code = 0; code < 0x80; ++code) {
        for (const std::uint32_t class_id : {1U, 6U, 0x37U}) {
            const auto name = service::name(static_cast<std::uint8_t>(code), class_id);
            if (name.empty()) continue;
            EXPECT_EQ(service::from_name(name), code) << name;
        }
    }
}

}  // namespace
}  // namespace servobus::cip
