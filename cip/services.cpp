#include "cip/services.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include "cip/file_transfer.hpp"

namespace servobus::cip::service {
namespace {

constexpr std::uint32_t any_class = 0;
constexpr std::uint32_t file_class = file::class_id;

struct Name {
    std::uint8_t code;
    std::uint32_t class_id;
    std::string_view text;
};

constexpr auto names = std::to_array<Name>({
    {0x01, any_class, "Get_Attributes_All"},
    {0x02, any_class, "Set_Attributes_All"},
    {0x03, any_class, "Get_Attribute_List"},
    {0x04, any_class, "Set_Attribute_List"},
    {0x05, any_class, "Reset"},
    {0x06, any_class, "Start"},
    {0x07, any_class, "Stop"},
    {0x08, any_class, "Create"},
    {0x09, any_class, "Delete"},
    {0x0A, any_class, "Multiple_Service_Packet"},
    {0x0D, any_class, "Apply_Attributes"},
    {0x0E, any_class, "Get_Attribute_Single"},
    {0x10, any_class, "Set_Attribute_Single"},
    {0x11, any_class, "Find_Next_Object_Instance"},
    {0x15, any_class, "Restore"},
    {0x16, any_class, "Save"},
    {0x17, any_class, "No_Operation"},
    {0x18, any_class, "Get_Member"},
    {0x19, any_class, "Set_Member"},
    {0x1A, any_class, "Insert_Member"},
    {0x1B, any_class, "Remove_Member"},
    {0x1C, any_class, "Group_Sync"},
    {0x4E, class_id::connection_manager, "Forward_Close"},
    {0x52, class_id::connection_manager, "Unconnected_Send"},
    {0x54, class_id::connection_manager, "Forward_Open"},
    {0x56, class_id::connection_manager, "Get_Connection_Data"},
    {0x57, class_id::connection_manager, "Search_Connection_Data"},
    {0x5A, class_id::connection_manager, "Get_Connection_Owner"},
    {0x5B, class_id::connection_manager, "Large_Forward_Open"},
    {file::initiate_upload, file_class, "Initiate_Upload"},
    {0x4C, file_class, "Initiate_Download"},
    {0x4D, file_class, "Initiate_Partial_Read"},
    {file::upload_transfer, file_class, "Upload_Transfer"},
    {0x50, file_class, "Download_Transfer"},
    {0x51, file_class, "Clear_File"},
});

bool same_name(std::string_view a, std::string_view b) {
    const auto next = [](std::string_view& text) {
        while (!text.empty() && (text.front() == '_' || text.front() == ' ' || text.front() == '-'))
            text.remove_prefix(1);
        if (text.empty()) return 0;
        const auto c = std::tolower(static_cast<unsigned char>(text.front()));
        text.remove_prefix(1);
        return c;
    };
    for (;;) {
        const auto x = next(a);
        if (x != next(b)) return false;
        if (x == 0) return true;
    }
}

}  // namespace

std::string_view name(std::uint8_t code, std::uint32_t class_id) {
    const auto found = std::ranges::find_if(names, [&](const Name& entry) {
        return entry.code == code && (entry.class_id == any_class || entry.class_id == class_id);
    });
    return found != names.end() ? found->text : std::string_view{};
}

std::optional<std::uint8_t> from_name(std::string_view text) {
    const auto found = std::ranges::find_if(names, [&](const Name& entry) { return same_name(entry.text, text); });
    if (found == names.end()) return std::nullopt;
    return found->code;
}

}  // namespace servobus::cip::service
