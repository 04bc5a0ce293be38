// What a verb found out, before it becomes text or JSON.
#pragma once

#include <cstddef>
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

struct CommandResult {
    const drive::DirectCommand* command = nullptr;
    Outcome outcome;
};

}  // namespace servobus::scanner::cli
