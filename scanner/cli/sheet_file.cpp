#include "scanner/cli/sheet_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>

#include "scanner/cli/text_output.hpp"
#include "scanner/cli/what.hpp"

namespace servobus::scanner::cli {
namespace {

using Parameters = std::vector<const eds::Parameter*>;

std::string plain(std::string_view name) {
    std::string word;
    for (const char each : name) {
        const auto c = static_cast<unsigned char>(each);
        if (std::isalnum(c) != 0 || c >= 0x80) word += static_cast<char>(std::tolower(c));
    }
    return word;
}

template <class Fits>
Parameters all_that(const eds::DataSheet& sheet, Fits fits) {
    Parameters found;
    for (const auto& each : sheet.parameters) {
        if (fits(each)) found.push_back(&each);
    }
    return found;
}

Parameters meant_by(const eds::DataSheet& sheet, std::string_view word) {
    if (const auto number = eds::number_behind("Param", word)) {
        if (const auto* found = sheet.parameter(*number)) return {found};
    }
    if (word.find('/') != std::string_view::npos) {
        const auto what = parse_what(word);
        if (!what) return {};
        const auto path = what->path();
        return all_that(sheet, [&](const eds::Parameter& each) {
            const auto at = each.address();
            return at && cip::Path::to(at->class_id, at->instance, at->attribute) == path;
        });
    }
    auto exact = sheet.parameters_named(word);
    if (!exact.empty()) return exact;
    const auto wanted = plain(word);
    if (wanted.empty()) return {};
    return all_that(sheet, [&](const eds::Parameter& each) { return plain(each.name) == wanted; });
}

std::vector<std::string> near(const eds::DataSheet& sheet, std::string_view word) {
    constexpr std::size_t worth_listing = 5;
    std::vector<std::string> names;
    const auto wanted = plain(word);
    for (const auto& each : sheet.parameters) {
        if (names.size() == worth_listing) break;
        if (wanted.size() >= 3 && plain(each.name).find(wanted) != std::string::npos) {
            names.push_back(display_name(sheet, each));
        }
    }
    return names;
}

}  // namespace

Parsed<std::string> read_sheet_file(const std::string& file) {
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) return Mistake{fmt::format("'{}' is a directory", file)};
    std::ifstream stream(file, std::ios::binary);
    if (!stream) return Mistake{fmt::format("'{}' cannot be read", file)};
    std::string text(eds::max_octets + 1, '\0');
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(stream.gcount()));
    if (text.size() > eds::max_octets) {
        return Mistake{fmt::format("'{}' is larger than {} octets, which no data sheet is", file, eds::max_octets)};
    }
    return {boost::system::in_place_value, std::move(text)};
}

Parsed<std::shared_ptr<const eds::DataSheet>> load_sheet(const std::string& file) {
    const auto text = read_sheet_file(file);
    if (!text) return text.error();
    auto sheet = eds::read(*text);
    if (!sheet) return Mistake{fmt::format("'{}' is no data sheet: {}", file, printable(to_text(sheet.error())))};
    return std::make_shared<const eds::DataSheet>(std::move(*sheet));
}

Parsed<const eds::Parameter*> find_parameter(const eds::DataSheet& sheet, std::string_view word) {
    const auto found = meant_by(sheet, word);
    if (found.size() == 1) return found.front();
    if (found.empty()) {
        const auto names = near(sheet, word);
        return Mistake{fmt::format("no parameter of the file is called '{}'; {}", word,
                                   names.empty() ? "'servobus-scanner list --eds FILE' shows all" : suggestion(names))};
    }
    std::vector<std::string> numbers;
    for (const auto* each : found) numbers.push_back(fmt::format("Param{}", each->number));
    return Mistake{
        fmt::format("'{}' is the name of {} parameters; write {}", word, found.size(), fmt::join(numbers, " or "))};
}

std::string display_name(const eds::DataSheet& sheet, const eds::Parameter& parameter) {
    if (parameter.name.empty() || sheet.parameters_named(parameter.name).size() > 1) {
        return fmt::format("Param{}", parameter.number);
    }
    return printable(parameter.name);
}

std::string cip_address(const eds::Parameter& parameter) {
    const auto at = parameter.address();
    return at ? cip_address(Attribute{at->class_id, at->instance, at->attribute}) : std::string();
}

}  // namespace servobus::scanner::cli
