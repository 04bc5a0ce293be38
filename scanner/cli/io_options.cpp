#include "scanner/cli/io_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <utility>

#include "cip/hex.hpp"
#include "drive/text.hpp"
#include "scanner/cli/duration.hpp"
#include "scanner/cli/sheet_fields.hpp"
#include "scanner/cli/sheet_file.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/io_words.hpp"
#include "scanner/sheet_plan.hpp"

namespace servobus::scanner::cli {
namespace {

using std::chrono::microseconds;
/// The value of a word; an empty text leaves it as it is.
template <class Value, std::size_t size>
std::optional<Mistake> take_word(std::string_view option, std::string_view text,
                                 const std::array<Word<Value>, size>& words, Value& value) {
    if (text.empty()) return std::nullopt;
    const auto found = std::ranges::find(words, text, &Word<Value>::first);
    if (found != words.end()) {
        value = found->second;
        return std::nullopt;
    }
    std::vector<std::string_view> known;
    known.reserve(words.size());
    for (const auto& word : words) known.push_back(word.first);
    return Mistake{fmt::format("{}: '{}' is none of {}", option, text, fmt::join(known, ", "))};
}

std::optional<Mistake> take_interval(std::string_view option, std::string_view text, microseconds& interval) {
    if (text.empty()) return std::nullopt;
    const auto parsed = parse_interval(option, text);
    if (!parsed) return parsed.error();
    interval = *parsed;
    return std::nullopt;
}

std::optional<std::uint32_t> number_to(std::string_view text, std::int64_t most) {
    const auto number = drive::parse_number(text);
    if (!number || *number < 0 || *number > most) return std::nullopt;
    return static_cast<std::uint32_t>(*number);
}

/// `1389/2/3/1.4`.
std::optional<cip::ElectronicKey> parse_key(std::string_view text) {
    std::array<std::string_view, 4> parts;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const auto end = text.find('/');
        if ((end == std::string_view::npos) != (i + 1 == parts.size())) return std::nullopt;
        parts[i] = text.substr(0, end);
        text.remove_prefix(std::min(text.size(), parts[i].size() + 1));
    }
    const auto dot = parts[3].find('.');
    if (dot == std::string_view::npos) return std::nullopt;
    const auto vendor = number_to(parts[0], 0xFFFF);
    const auto type = number_to(parts[1], 0xFFFF);
    const auto product = number_to(parts[2], 0xFFFF);
    const auto major = number_to(parts[3].substr(0, dot), 0xFF);
    const auto minor = number_to(parts[3].substr(dot + 1), 0xFF);
    if (!vendor || !type || !product || !major || !minor) return std::nullopt;
    return cip::ElectronicKey{.vendor = static_cast<std::uint16_t>(*vendor),
                              .device_type = static_cast<std::uint16_t>(*type),
                              .product_code = static_cast<std::uint16_t>(*product),
                              .major_revision = static_cast<std::uint8_t>(*major),
                              .minor_revision = static_cast<std::uint8_t>(*minor)};
}

/// The connection of that key, with those inputs where it can have several.
const assemblies::Connection* find_known(std::string_view key, std::optional<std::uint32_t> t_to_o_point) {
    const auto all = assemblies::connections();
    const auto found = std::ranges::find_if(all, [&](const assemblies::Connection& each) {
        return each.key == key && (!t_to_o_point || each.t_to_o_point == *t_to_o_point);
    });
    return found != all.end() ? &*found : nullptr;
}

class Builder {
public:
    Builder(const ConnectionArguments& arguments, const cip::Path& route, microseconds default_rpi)
        : arguments_(arguments), route_(route), default_rpi_(default_rpi) {}

    Parsed<ConnectionTask> build() {
        using Step = std::optional<Mistake> (Builder::*)();
        for (const Step step :
             {&Builder::choose, &Builder::take_times, &Builder::take_formats, &Builder::take_manners,
              &Builder::take_configuration, &Builder::take_key, &Builder::ask_sheet, &Builder::take_changes}) {
            if (auto mistake = (this->*step)()) return *mistake;
        }
        return std::move(task_);
    }

private:
    std::optional<Mistake> choose() {
        if (!arguments_.eds.empty()) return choose_described();
        if (arguments_.o_to_t_point) return choose_numbers();
        const auto key = arguments_.connection.empty() ? std::string_view("standard") : arguments_.connection;
        task_.known = find_known(key, arguments_.t_to_o_point);
        if (task_.known == nullptr) return unknown_connection(key);
        if (arguments_.o_to_t_octets || arguments_.t_to_o_octets) {
            return Mistake{"--o2t-size and --t2o-size go with --o2t and --t2o; a --connection has its sizes"};
        }
        task_.plan = plan_of(*task_.known);
        const auto* layout = task_.known->outputs();
        task_.outputs = IoOutputs::of(layout);
        if (layout != nullptr) task_.output_name = layout->name;
        task_.inputs = task_.known->inputs();
        if (task_.inputs != nullptr) {
            task_.input_fields = fields_of(*task_.inputs);
            task_.input_name = task_.inputs->name;
        }
        return std::nullopt;
    }

    std::optional<Mistake> choose_described() {
        if (arguments_.o_to_t_point || arguments_.t_to_o_point) {
            return Mistake{"--eds has the points of the connection; --o2t and --t2o are for devices without a file"};
        }
        auto sheet = load_sheet(arguments_.eds);
        if (!sheet) return sheet.error();
        task_.sheet = std::move(*sheet);
        const auto connection = choose_connection(*task_.sheet, arguments_.connection);
        if (!connection) return about_file(connection.error());
        task_.described = *connection;
        const auto plan = plan_of(*task_.sheet, *task_.described);
        if (!plan) return about_file(plan.error());
        task_.plan = *plan;
        if (arguments_.o_to_t_octets) task_.plan.o_to_t.data_octets = *arguments_.o_to_t_octets;
        if (arguments_.t_to_o_octets) task_.plan.t_to_o.data_octets = *arguments_.t_to_o_octets;
        describe_flows();
        return std::nullopt;
    }

    [[nodiscard]] Mistake about_file(const Mistake& mistake) const {
        return {fmt::format("{}: {}", arguments_.eds, printable(mistake.text))};
    }

    /// What the octets of both directions are called, and with what the outputs begin.
    void describe_flows() {
        const auto outputs = format_of(task_.described->o_to_t);
        const auto inputs = format_of(task_.described->t_to_o);
        task_.outputs.octets = task_.plan.o_to_t.data_octets;
        if (task_.outputs.octets > 0) {
            task_.outputs.fields = fields_inside(outputs, task_.outputs.octets);
            task_.outputs.name = outputs.keyword;
            task_.output_name = printable(outputs.name);
            task_.start = task_.sheet->image(outputs);
            task_.start.resize(task_.outputs.octets);
        }
        task_.input_fields = fields_inside(inputs, task_.plan.t_to_o.data_octets);
        task_.input_name = printable(inputs.name);
    }

    /// The assembly that a direction has as its format; of a Param alone one that holds it.
    [[nodiscard]] eds::Assembly format_of(const eds::Flow& flow) const {
        if (const auto* assembly = task_.sheet->assembly(flow.format)) return *assembly;
        eds::Assembly alone{.keyword = flow.format, .name = flow.format};
        if (const auto number = eds::number_behind("Param", flow.format)) {
            alone.members.push_back({.reference = eds::Member::Parameter{*number}});
        }
        return alone;
    }

    /// A connection may be shorter than the assembly.
    [[nodiscard]] IoFields fields_inside(const eds::Assembly& assembly, std::size_t octets) const {
        auto fields = fields_of(*task_.sheet, assembly);
        std::erase_if(fields, [&](const IoField& field) { return field.offset + field.octets > octets; });
        return fields;
    }

    [[nodiscard]] Mistake unknown_connection(std::string_view key) const {
        if (find_known(key, {}) != nullptr) {
            return {fmt::format("the connection '{}' has no inputs {}", key, *arguments_.t_to_o_point)};
        }
        return {fmt::format("--connection: '{}' is none of {}", key, connection_keys())};
    }

    std::optional<Mistake> choose_numbers() {
        if (!arguments_.connection.empty()) return Mistake{"it is either --connection or --o2t with its numbers"};
        if (!arguments_.t_to_o_point || !arguments_.o_to_t_octets || !arguments_.t_to_o_octets) {
            return Mistake{"--o2t also needs --o2t-size, --t2o and --t2o-size; the device's EDS file has them"};
        }
        auto& plan = task_.plan;
        plan.o_to_t.point = *arguments_.o_to_t_point;
        plan.o_to_t.data_octets = *arguments_.o_to_t_octets;
        // Who sends nothing usually has no header either.
        plan.o_to_t.format =
            plan.o_to_t.data_octets == 0 ? cip::RealTimeFormat::heartbeat : cip::RealTimeFormat::header32;
        plan.t_to_o.point = *arguments_.t_to_o_point;
        plan.t_to_o.data_octets = *arguments_.t_to_o_octets;
        plan.configuration_instance.reset();
        task_.outputs.octets = plan.o_to_t.data_octets;
        return std::nullopt;
    }

    std::optional<Mistake> take_times() {
        auto& plan = task_.plan;
        if (task_.described == nullptr) plan.o_to_t.rpi = plan.t_to_o.rpi = default_rpi_;
        for (auto* direction : {&plan.o_to_t, &plan.t_to_o}) {
            if (auto mistake = take_interval("--rpi", arguments_.rpi, direction->rpi)) return mistake;
        }
        if (auto mistake = take_interval("--rpi-o2t", arguments_.o_to_t_rpi, plan.o_to_t.rpi)) return mistake;
        if (auto mistake = take_interval("--rpi-t2o", arguments_.t_to_o_rpi, plan.t_to_o.rpi)) return mistake;
        if (!arguments_.inhibit.empty()) {
            const auto inhibit = parse_interval("--inhibit", arguments_.inhibit);
            if (!inhibit) return inhibit.error();
            plan.inhibit = *inhibit;
        }
        return std::nullopt;
    }

    std::optional<Mistake> take_formats() {
        auto& plan = task_.plan;
        if (auto mistake = take_word("--o2t-format", arguments_.o_to_t_format, format_words, plan.o_to_t.format)) {
            return mistake;
        }
        if (auto mistake = take_word("--t2o-format", arguments_.t_to_o_format, format_words, plan.t_to_o.format)) {
            return mistake;
        }
        for (auto* direction : {&plan.o_to_t, &plan.t_to_o}) {
            using cip::RealTimeFormat;
            if (direction->format == RealTimeFormat::heartbeat) direction->data_octets = 0;
            // Without data it is shorter than with it.
            if (arguments_.variable || direction->format == RealTimeFormat::zero_length) direction->variable = true;
        }
        if (plan.o_to_t.format == cip::RealTimeFormat::heartbeat) task_.outputs = {};
        if (plan.t_to_o.format == cip::RealTimeFormat::heartbeat) {
            task_.inputs = nullptr;
            task_.input_fields.clear();
        }
        return std::nullopt;
    }

    std::optional<Mistake> take_manners() {
        auto& plan = task_.plan;
        plan.route = route_;
        plan.large = arguments_.large;
        if (!std::has_single_bit(arguments_.multiplier) || arguments_.multiplier < 4 || arguments_.multiplier > 512) {
            return Mistake{"--multiplier is 4, 8, 16, 32, 64, 128, 256 or 512"};
        }
        plan.multiplier_code = static_cast<std::uint8_t>(std::countr_zero(arguments_.multiplier) - 2);
        // Only what others get too can be listened to (R-CON-32).
        const bool listens = task_.known != nullptr && task_.known->kind == assemblies::Connection::Kind::listen_only;
        if (arguments_.multicast || listens) plan.t_to_o.type = cip::ConnectionType::multicast;
        if (auto mistake = take_word("--trigger", arguments_.trigger, trigger_words, plan.trigger)) return mistake;
        if (auto mistake = take_word("--priority", arguments_.priority, priority_words, plan.o_to_t.priority)) {
            return mistake;
        }
        if (!arguments_.priority.empty() || task_.described == nullptr) plan.t_to_o.priority = plan.o_to_t.priority;
        return std::nullopt;
    }

    std::optional<Mistake> take_configuration() {
        auto& plan = task_.plan;
        const auto& instance = arguments_.config_instance;
        if (!instance.empty() && task_.described != nullptr) {
            return Mistake{"--config-instance: it is in the path of the file, as the points are"};
        }
        if (instance == "none") {
            plan.configuration_instance.reset();
        } else if (!instance.empty()) {
            plan.configuration_instance = number_to(instance, 0xFFFFFFFF);
            if (!plan.configuration_instance) {
                return Mistake{fmt::format("--config-instance: '{}' is neither a number nor none", instance)};
            }
        }
        if (arguments_.config.empty()) return std::nullopt;
        auto octets = cip::from_hex(arguments_.config);
        if (!octets || octets->size() % 2 != 0) {
            return Mistake{"--config takes pairs of hex digits, an even number of octets"};
        }
        plan.configuration = std::move(*octets);
        if (plan.path().words() > cip::max_path_words) return Mistake{"--config is longer than a path can be"};
        return std::nullopt;
    }

    std::optional<Mistake> take_key() {
        if (arguments_.key.empty()) return std::nullopt;
        task_.plan.key.reset();
        task_.key_of_device = arguments_.key == "auto";
        if (task_.key_of_device || arguments_.key == "none") return std::nullopt;
        if (arguments_.key == "eds") return take_key_of_sheet();
        task_.plan.key = parse_key(arguments_.key);
        if (task_.plan.key) return std::nullopt;
        return Mistake{
            fmt::format("--key: '{}' is no key: auto, eds, none or VENDOR/TYPE/PRODUCT/MAJOR.MINOR", arguments_.key)};
    }

    std::optional<Mistake> take_key_of_sheet() {
        if (!task_.sheet) return Mistake{"--key eds goes with --eds"};
        task_.plan.key = key_of(task_.sheet->device);
        if (task_.plan.key) return std::nullopt;
        return about_file({"[Device] does not say enough for a key"});
    }

    /// What was said beside the file is held to what the file allows.
    std::optional<Mistake> ask_sheet() {
        if (task_.described == nullptr) return std::nullopt;
        const auto wrong = conflict(*task_.described, task_.plan);
        return wrong ? std::optional(about_file(*wrong)) : std::nullopt;
    }

    std::optional<Mistake> take_changes() {
        task_.run = !arguments_.idle;
        for (const auto& text : arguments_.changes) {
            if (!task_.has_outputs()) {
                return Mistake{fmt::format("--set '{}': this connection sends no outputs", text)};
            }
            auto change = parse_change(text, task_.outputs);
            if (!change) return change.error();
            task_.changes.push_back(std::move(*change));
        }
        return std::nullopt;
    }

    const ConnectionArguments& arguments_;
    const cip::Path& route_;
    microseconds default_rpi_;
    ConnectionTask task_;
};

}  // namespace

Parsed<ConnectionTask> make_task(const ConnectionArguments& arguments, const cip::Path& route,
                                 microseconds default_rpi) {
    return Builder(arguments, route, default_rpi).build();
}

Parsed<microseconds> parse_interval(std::string_view option, std::string_view text) {
    constexpr double longest = 0xFFFFFFFF;
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error == std::errc() && end == text.data() + text.size() && std::isfinite(number)) {
        const double count = number * 1000;
        if (count >= 1 && count <= longest) return microseconds(std::llround(count));
    } else if (const auto duration = parse_duration(text);
               duration && static_cast<double>(duration->count()) <= longest) {
        return *duration;
    }
    return Mistake{fmt::format("{}: '{}' is no number of milliseconds from 0.001 to 4294967.295", option, text)};
}

std::string_view format_key(cip::RealTimeFormat format) { return scanner::word_of(format_words, format); }

std::string connection_keys() {
    std::vector<std::string_view> keys;
    for (const auto& each : assemblies::connections()) {
        if (keys.empty() || keys.back() != each.key) keys.push_back(each.key);
    }
    return fmt::format("{}", fmt::join(keys, ", "));
}

}  // namespace servobus::scanner::cli
