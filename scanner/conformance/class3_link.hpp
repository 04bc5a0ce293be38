// An explicit connection in the hands of a case.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "cip/forward_open.hpp"
#include "scanner/conformance/bench.hpp"

namespace servobus::scanner::conformance {

/// The Forward_Open of a class 3 connection to the message router: 500 octets, an interval of one second, 16 of which
/// end it.
[[nodiscard]] cip::ForwardOpen class3_open(Bench& bench);

class Class3Link {
public:
    /// Opens. That it is refused is held against the device; that it has none left, or no such connections, skips the case.
    Class3Link(Session& session, const std::function<void(cip::ForwardOpen&)>& change = {});
    Class3Link(const Class3Link&) = delete;
    Class3Link& operator=(const Class3Link&) = delete;
    /// Closes if it is open.
    ~Class3Link();

    [[nodiscard]] bool is_open() const { return open_; }
    [[nodiscard]] const cip::ForwardOpen& request() const { return request_; }
    [[nodiscard]] const cip::ForwardOpenReply& grant() const { return grant_; }

    /// A message of the message router and its reply, with the next sequence count or the one given.
    [[nodiscard]] std::optional<Reply> call(cip::ByteView message, std::optional<std::uint16_t> sequence = {});
    /// Sends, and says whether anything but the answer to an ordinary request behind it came.
    bool expect_silence(cip::ByteView message, std::string_view what, bool firm = true);
    [[nodiscard]] std::uint16_t next_sequence() { return ++sequence_; }

    std::optional<Reply> close();
    /// The device has closed it.
    void forget() { open_ = false; }

private:
    Session& session_;
    cip::ForwardOpen request_;
    cip::ForwardOpenReply grant_{};
    bool open_ = false;
    std::uint16_t sequence_ = 0;
};

}  // namespace servobus::scanner::conformance
