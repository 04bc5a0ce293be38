// call: any CIP service.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cip/hex.hpp"
#include "cip/services.hpp"
#include "drive/text.hpp"
#include "scanner/cli/json_output.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/cli/typed_value.hpp"
#include "scanner/cli/verbs.hpp"

namespace servobus::scanner::cli {
namespace {

Parsed<std::uint8_t> parse_service(std::string_view text) {
    constexpr std::int64_t highest = 0x7F;
    if (const auto number = drive::parse_number(text)) {
        if (*number >= 0 && *number <= highest) return static_cast<std::uint8_t>(*number);
        return Mistake{fmt::format("'{}' is no service: the number is at most 0x7F", text)};
    }
    if (const auto code = cip::service::from_name(text)) return *code;
    return Mistake{
        fmt::format("no service is called '{}'; write its number, or a name like Get_Attribute_Single", text)};
}

Parsed<cip::Bytes> parse_data(const std::vector<std::string>& words) {
    const auto text = fmt::format("{}", fmt::join(words, " "));
    if (has_type(text)) return parse_typed(text);
    auto octets = cip::from_hex(text);
    if (!octets) return Mistake{fmt::format("'{}' is no data: write pairs of hex digits, or DINT:50", text)};
    return std::move(*octets);
}

}  // namespace

ExitCode call(const Console& console, const Settings& settings, const std::string& host, const std::string& service,
              const std::string& path, const std::vector<std::string>& data) {
    const auto where = parse_host(host);
    if (!where) return fail(console, where.error());
    const auto code = parse_service(service);
    if (!code) return fail(console, code.error(), host);
    auto target = parse_path(path);
    if (!target) return fail(console, target.error(), host);
    auto octets = parse_data(data);
    if (!octets) return fail(console, octets.error(), host);

    Link link(settings, *where);
    if (const auto failure = link.open()) return fail(console, *failure, host);
    CallResult result{{*code, std::move(*target), std::move(*octets)}, {}};
    auto answer = link.call(result.request);
    if (!answer) return fail(console, link.failure_of(answer.error()), host);
    result.response = std::move(*answer);
    console.show(call_text(result), call_json(host, result));
    if (result.response.status.ok()) return ExitCode::done;
    console.say(fmt::format("refused with {}", cip::describe(result.response.status)));
    return ExitCode::refused;
}

}  // namespace servobus::scanner::cli
