#include "scanner/plan_arguments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "cip/hex.hpp"
#include "scanner/io_words.hpp"

namespace servobus::scanner {
namespace {

using Words = std::vector<std::string>;
using Microseconds = std::chrono::microseconds;

/// `10`, `2.5`.
std::string milliseconds(Microseconds time) { return fmt::format("{}", static_cast<double>(time.count()) / 1000); }

std::string route_text(const cip::Path& route) {
    std::string text;
    for (const auto& segment : route.segments) {
        const auto* hop = std::get_if<cip::PortSegment>(&segment);
        if (hop == nullptr) continue;
        if (!text.empty()) text += ',';
        const auto& link = hop->link_address;
        text += fmt::format("{}/", hop->port);
        text += link.size() == 1 ? fmt::format("{}", link[0]) : std::string(link.begin(), link.end());
    }
    return text;
}

std::string key_text(const cip::ElectronicKey& key) {
    // With the compatibility bit, bit 7, as --key takes it.
    return fmt::format("{}/{}/{}/{}.{}", key.vendor, key.device_type, key.product_code, key.major_revision,
                       key.minor_revision);
}

bool fits(const IoPlan& plan, const assemblies::Connection& connection) {
    const auto same = [](const IoDirection& direction, std::uint32_t point, cip::RealTimeFormat format,
                         std::size_t size) {
        return direction.point == point && direction.format == format && direction.connection_size() == size;
    };
    return same(plan.o_to_t, connection.o_to_t_point, connection.o_to_t_format(), connection.o_to_t_size()) &&
           same(plan.t_to_o, connection.t_to_o_point, connection.t_to_o_format(), connection.t_to_o_size());
}

const assemblies::Connection* connection_of(const IoPlan& plan) {
    const auto* connection = assemblies::find_connection(plan.o_to_t.point, plan.t_to_o.point);
    return connection != nullptr && fits(plan, *connection) ? connection : nullptr;
}

class Arguments {
public:
    explicit Arguments(const IoPlan& plan) : plan_(plan) {}

    Words words() && {
        if (const auto* connection = connection_of(plan_)) {
            add("--connection", std::string(connection->key));
            // The key alone means the first that has it.
            if (assemblies::find_connection(connection->key) != connection) {
                add("--t2o", fmt::format("{}", connection->t_to_o_point));
            }
            if (plan_.configuration_instance != usual_.configuration_instance) add_configuration_instance();
        } else {
            add_numbers();
        }
        add_intervals();
        add_behaviour();
        add_path();
        return std::move(words_);
    }

private:
    void add(std::string option) { words_.push_back(std::move(option)); }
    void add(std::string option, std::string value) {
        words_.push_back(std::move(option));
        words_.push_back(std::move(value));
    }
    void add_configuration_instance() {
        add("--config-instance",
            plan_.configuration_instance ? fmt::format("{}", *plan_.configuration_instance) : "none");
    }
    void add_numbers() {
        const auto& out = plan_.o_to_t;
        const auto& in = plan_.t_to_o;
        add("--o2t", fmt::format("{}", out.point));
        add("--o2t-size", fmt::format("{}", out.data_octets));
        add("--t2o", fmt::format("{}", in.point));
        add("--t2o-size", fmt::format("{}", in.data_octets));
        add_configuration_instance();
        const auto usual = out.data_octets == 0 ? cip::RealTimeFormat::heartbeat : usual_.o_to_t.format;
        if (out.format != usual) add("--o2t-format", std::string(word_of(format_words, out.format)));
        if (in.format != usual_.t_to_o.format) add("--t2o-format", std::string(word_of(format_words, in.format)));
    }
    void add_intervals() {
        const auto out = plan_.o_to_t.rpi;
        const auto in = plan_.t_to_o.rpi;
        if (out != in) {
            add("--rpi-o2t", milliseconds(out));
            add("--rpi-t2o", milliseconds(in));
        } else if (out != usual_.o_to_t.rpi || connection_of(plan_) == nullptr) {
            add("--rpi", milliseconds(out));
        }
    }
    void add_behaviour() {
        if (plan_.t_to_o.type == cip::ConnectionType::multicast) add("--multicast");
        if (plan_.multiplier_code != usual_.multiplier_code) {
            add("--multiplier", fmt::format("{}", 4U << std::min<unsigned>(plan_.multiplier_code, 7)));
        }
        if (plan_.trigger != usual_.trigger) add("--trigger", std::string(word_of(trigger_words, plan_.trigger)));
        if (plan_.inhibit) add("--inhibit", milliseconds(*plan_.inhibit));
        if (plan_.o_to_t.priority != usual_.o_to_t.priority) {
            add("--priority", std::string(word_of(priority_words, plan_.o_to_t.priority)));
        }
        if (plan_.o_to_t.variable || plan_.t_to_o.variable) add("--variable");
        if (plan_.large) add("--large");
    }
    void add_path() {
        if (plan_.key) add("--key", key_text(*plan_.key));
        if (!plan_.configuration.empty()) {
            auto text = cip::to_hex(plan_.configuration);
            std::erase(text, ' ');
            add("--config", std::move(text));
        }
        if (auto route = route_text(plan_.route); !route.empty()) add("--route", std::move(route));
    }

    const IoPlan& plan_;
    const IoPlan usual_{};  ///< what `io` does without options
    Words words_;
};

}  // namespace

Words plan_arguments(const IoPlan& plan, const std::string& host) {
    Words words{host};
    auto options = Arguments(plan).words();
    words.insert(words.end(), std::make_move_iterator(options.begin()), std::make_move_iterator(options.end()));
    return words;
}

std::string command_line(const IoPlan& plan, const std::string& host) {
    std::string line = "servobus-scanner io";
    for (const auto& word : plan_arguments(plan, host)) {
        const bool plain = word.find_first_of(" '\"$&;|<>()*?\\`") == std::string::npos;
        line += plain ? ' ' + word : fmt::format(" '{}'", word);
    }
    return line;
}

}  // namespace servobus::scanner
