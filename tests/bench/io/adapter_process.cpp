#include "tests/bench/io/adapter_process.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "enip/encapsulation.hpp"
#include "tests/bench/io/explicit_client.hpp"

namespace servobus::bench {
namespace {

std::string dotted(std::uint32_t address) {
    const auto text = to_string(enip::Endpoint{address, 0});
    return text.substr(0, text.find(':'));
}

}  // namespace

Child start_adapter(const Settings& settings, std::size_t count) {
    std::vector<std::string> command{settings.adapter, "--bind", dotted(settings.address), "--log-level", "error"};
    if (count > 1) command.insert(command.end(), {"--count", std::to_string(count)});
    command.insert(command.end(), settings.adapter_options.begin(), settings.adapter_options.end());
    Child adapter(std::move(command));
    const ExplicitClient client(explicit_endpoint(settings));  // Waits until it answers.
    if (!adapter.runs()) give_up("the adapter has ended");
    return adapter;
}

Child start_load(const Settings& settings) {
    return Child::in_role({"load", dotted(settings.address), fmt::format("{}", settings.load_rate),
                           std::to_string(settings.load_attributes)});
}

double stop_load(Child& load) {
    const auto said = nlohmann::json::parse(load.stop(), nullptr, false);
    return said.is_object() ? said.value("rate", 0.0) : 0;
}

enip::Endpoint explicit_endpoint(const Settings& settings) { return {settings.address, enip::tcp_port}; }

}  // namespace servobus::bench
