// Results as programs read them: each function returns one JSON document, described in docs/scanner.md.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scanner/cli/results.hpp"

namespace servobus::scanner::cli {

/// `host` is left out when it is empty, `failure` when there is none.
[[nodiscard]] std::string values_json(const std::string& host, const std::vector<Outcome>& outcomes,
                                      const std::optional<Failure>& failure = {});
[[nodiscard]] std::string dump_json(const std::string& host, const std::vector<Outcome>& outcomes,
                                    const std::optional<Failure>& failure = {});
[[nodiscard]] std::string identity_json(const std::string& host, const Identity& identity);
[[nodiscard]] std::string devices_json(const enip::asio::FoundDevices& devices,
                                       const std::optional<Failure>& failure = {});
[[nodiscard]] std::string call_json(const std::string& host, const CallResult& result);
[[nodiscard]] std::string reset_json(const std::string& host, const ResetResult& result);
[[nodiscard]] std::string command_json(const std::string& host, const CommandResult& result);
[[nodiscard]] std::string list_json(std::span<const drive::Parameter* const> rows);
[[nodiscard]] std::string commands_json(std::span<const drive::DirectCommand* const> commands);
[[nodiscard]] std::string failure_json(const std::string& host, const Failure& failure);

}  // namespace servobus::scanner::cli
