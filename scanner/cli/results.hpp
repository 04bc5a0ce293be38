// What a verb found out, before it becomes text or JSON.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/message.hpp"
#include "drive/device.hpp"
#include "drive/parameter.hpp"
#include "drive/store.hpp"
#include "enip/asio/discovery.hpp"
#include "scanner/cli/exit_code.hpp"
#include "scanner/cli/link.hpp"
#include "scanner/cli/what.hpp"
#include "scanner/error.hpp"
#include "scanner/identity.hpp"

namespace servobus::scanner::cli {

/// Nobody asked the device: the row is write only, or something went wrong before it was its turn.
struct NotAsked {
    std::string reason;
};

/// One parameter or attribute, and what became of it: its value, its octets when its type is not known, the device's
/// refusal, or an answer that makes no sense.
struct Outcome {
    What what;
    std::variant<NotAsked, drive::Value, cip::Bytes, cip::Status, error_code> result;
    std::size_t surplus = 0;

    [[nodiscard]] bool has_value() const { return result.index() == 1 || result.index() == 2; }
};

/// done when every outcome has a value; otherwise the worst: no connection, nonsense, refused.
[[nodiscard]] ExitCode exit_code_of(const std::vector<Outcome>& outcomes);

/// The same for `dump`, which many rows of a healthy device refuse: refused only when nothing was read.
[[nodiscard]] ExitCode dump_exit_code_of(const std::vector<Outcome>& outcomes);

struct CallResult {
    cip::Request request;
    cip::Response response;
};

/// The data of an Identity Reset (R-ID-8).
enum class ResetKind : std::uint8_t { restart = 0, factory = 1, factory_keep_network = 2 };

/// A device, and how it has got its address, as far as it tells.
struct ResetDevice {
    Identity identity{};
    std::optional<std::uint8_t> address_method{};  ///< bits 0 to 3 of 0xF5/1/3 (R-TCP-4)
    std::string address{};                         ///< of 0xF5/1/5; empty when it does not tell
};

struct ResetResult {
    ResetKind kind = ResetKind::restart;
    ResetDevice before{};
    std::optional<ResetDevice> after{};  ///< nullopt: nobody has waited
    std::chrono::milliseconds away{};
};

struct CommandResult {
    const drive::DirectCommand* command = nullptr;
    Outcome outcome;
};

}  // namespace servobus::scanner::cli
