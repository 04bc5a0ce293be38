#include "adapter/memory_settings.hpp"

#include <charconv>

#include "drive/xenax.hpp"

namespace servobus::adapter {
namespace {

using nlohmann::json;

constexpr drive::Key direct_command_row{0x65, 0x00};

// The number that a program or profile is called by, from 1.
std::optional<int> number_of(const std::string& key, int highest) {
    int number = 0;
    const auto* end = key.data() + key.size();
    const auto [rest, error] = std::from_chars(key.data(), end, number);
    const bool valid = error == std::errc() && rest == end && number >= 1 && number <= highest;
    return valid ? std::optional<int>(number) : std::nullopt;
}

Reason list_reason(const json& value) {
    if (!value.is_array()) return "must be a list in brackets";
    if (value.size() > drive::MotionMemory::steps_at_most) {
        return fmt::format("has {} entries; at most {} are kept", value.size(), drive::MotionMemory::steps_at_most);
    }
    return {};
}

// Where an entry of a list stands.
struct Place {
    const std::string& pointer;
    const std::string& key;
    std::size_t index;
};

// One list after the other; `read` makes an entry, or says at which place and why not.
template <class Entries, class Read>
std::optional<FileError> read_lists(const Walk& walk, const json& members, const std::string& pointer, int highest,
                                    Entries& entries, Read read) {
    for (const auto& [key, value] : members.items()) {
        const auto number = number_of(key, highest);
        if (!number) return walk.error(pointer, key, fmt::format("must be a number from 1 to {}", highest));
        if (const auto reason = list_reason(value); !reason.empty()) return walk.error(pointer, key, reason);
        auto& list = entries[*number];
        for (std::size_t i = 0; i < value.size(); ++i) {
            if (auto error = read(value[i], Place{pointer, key, i}, list)) return error;
        }
    }
    return std::nullopt;
}

std::optional<FileError> read_part(const Walk& walk, const json& value, const std::string& pointer,
                                   std::vector<drive::ProfilePart>& parts) {
    if (!value.is_object()) return walk.error(pointer, Reason("must be an object in braces"));
    constexpr std::int64_t farthest = 2'000'000'000;
    std::optional<std::int64_t> to;
    std::optional<std::int64_t> by;
    drive::ProfilePart part;
    const Setters setters{
        {"to", whole_number(to, -farthest, farthest)},
        {"by", whole_number(by, -farthest, farthest)},
        {"speed", whole_number(part.speed, 10, 100'000'000)},
        {"acceleration", whole_number(part.acceleration, 2'000, 1'000'000'000)},
    };
    if (auto error = walk.object(value, pointer, setters)) return error;
    if (to.has_value() == by.has_value()) {
        return walk.error(pointer, Reason("needs either 'to', a position, or 'by', a distance"));
    }
    part.relative = by.has_value();
    part.target = by.value_or(to.value_or(0));
    parts.push_back(part);
    return std::nullopt;
}

}  // namespace

std::optional<FileError> read_programs(const Walk& walk, const json& members, const std::string& pointer,
                                       drive::MotionMemory& memory) {
    const auto read = [&](const json& value, const Place& place,
                          std::vector<drive::ProgramStep>& steps) -> std::optional<FileError> {
        const auto wrong_step = [&](const Reason& reason) {
            return walk.error(place.pointer, place.key,
                              fmt::format("has a wrong step {}: {}", place.index + 1, reason));
        };
        if (!value.is_string()) return wrong_step("it must be a text, such as \"G 10000\"");
        auto step = drive::parse_step(drive::parameters(), drive::direct_commands(), direct_command_row,
                                      value.get_ref<const std::string&>());
        if (auto* wrong = std::get_if<std::string>(&step)) return wrong_step(*wrong);
        steps.push_back(std::get<drive::ProgramStep>(step));
        return std::nullopt;
    };
    return read_lists(walk, members, pointer, drive::MotionMemory::programs_at_most, memory.programs, read);
}

std::optional<FileError> read_profiles(const Walk& walk, const json& members, const std::string& pointer,
                                       drive::MotionMemory& memory) {
    const auto read = [&](const json& value, const Place& place, std::vector<drive::ProfilePart>& parts) {
        return read_part(walk, value, fmt::format("{}/{}/{}", place.pointer, place.key, place.index), parts);
    };
    return read_lists(walk, members, pointer, drive::MotionMemory::profiles_at_most, memory.profiles, read);
}

}  // namespace servobus::adapter
