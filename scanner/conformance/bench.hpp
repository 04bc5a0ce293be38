// Where one case is tried: the wire to the device, what is held against it, and what was seen on the way.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/message.hpp"
#include "enip/common_packet.hpp"
#include "enip/encapsulation.hpp"
#include "scanner/conformance/case.hpp"
#include "scanner/conformance/record.hpp"
#include "scanner/conformance/subject.hpp"

namespace servobus::enip::asio {
class RawStream;
}  // namespace servobus::enip::asio

namespace servobus::scanner::conformance {

using std::chrono::milliseconds;

/// What is held against the device.
struct Finding {
    bool firm = true;  ///< a failure; otherwise an advisory
    std::string words{};
};

class Bench {
public:
    Bench(Subject& subject, const Case& which) : subject_(subject), which_(which) {}
    Bench(const Bench&) = delete;
    Bench& operator=(const Bench&) = delete;

    [[nodiscard]] Subject& subject() { return subject_; }
    [[nodiscard]] const Case& which() const { return which_; }
    [[nodiscard]] milliseconds timeout() const { return subject_.options().timeout; }

    // What must be so, or should be: `words` say what is wrong when it is not, in a sentence without a full stop. They
    // return `good`.
    bool require(bool good, std::string words);
    bool advise(bool good, std::string words);
    /// Something that explains the outcome.
    void note(std::string words) { record.add(Step::Kind::note, std::move(words)); }
    /// The case cannot be tried on this device; unless something was found, that is its outcome.
    void skip(std::string reason);

    /// The case goes on after that time; meanwhile others run. Whatever `then` needs it keeps.
    void later(milliseconds time, std::function<void()> then);
    struct Later {
        std::chrono::steady_clock::time_point due;
        std::function<void()> then;
    };
    [[nodiscard]] std::optional<Later> take_later();

    [[nodiscard]] Outcome outcome() const;
    [[nodiscard]] const std::vector<Finding>& findings() const { return findings_; }
    [[nodiscard]] const std::string& reason() const { return reason_; }

    Record record{};

private:
    Subject& subject_;
    const Case& which_;
    std::vector<Finding> findings_;
    std::string reason_;
    std::optional<Later> later_;
};

/// A TCP connection to the device. One that could not be made, or is over, answers nothing.
class Wire {
public:
    /// Connects; that this fails is held against the device.
    explicit Wire(Bench& bench);
    Wire(Wire&& other) noexcept;
    ~Wire();

    [[nodiscard]] bool is_open() const;
    [[nodiscard]] Bench& bench() { return *bench_; }

    /// False when the connection is over, or takes no more.
    bool send(cip::ByteView octets, std::string words = {});
    bool send(const enip::Frame& frame) { return send(frame.encode()); }
    /// What is no part of the case, and is not recorded.
    void send_unrecorded(const enip::Frame& frame);
    /// The next message, or nullopt when none comes in time or the connection is over.
    [[nodiscard]] std::optional<enip::Frame> receive(milliseconds patience);
    [[nodiscard]] std::optional<enip::Frame> receive();
    /// Sends and waits for the message with the same context; others are held against the device, and so is silence.
    [[nodiscard]] std::optional<enip::Frame> exchange(const enip::Frame& request);
    /// The answer to what was sent already.
    [[nodiscard]] std::optional<enip::Frame> answer_to(const enip::Frame& request);

    /// Sends octets that nobody may answer, and an ordinary request behind them: its answer is the first to come. False
    /// when something else came or the connection is over.
    bool expect_silence(cip::ByteView octets, std::string_view what, bool firm = true);
    /// Whether an ordinary request is answered; what comes before it is passed over.
    [[nodiscard]] bool is_alive();
    /// Whether the device closes in time.
    [[nodiscard]] bool closes(milliseconds patience);

    void close();
    void reset();

private:
    Bench* bench_;
    std::unique_ptr<enip::asio::RawStream> stream_;
};

/// A message with a context of its own.
[[nodiscard]] enip::Frame make_frame(Bench& bench, enip::Command command, cip::Bytes data = {},
                                     std::uint32_t session = 0);

/// A CIP reply and what came with it.
struct Reply {
    enip::Frame frame{};
    cip::Bytes message{};  ///< of the message router, as it came
    cip::Response response{};
    std::vector<enip::Item> items{};  ///< behind the message

    [[nodiscard]] bool ok() const { return response.status.ok(); }
};

/// A connection with a session. Leaves in good manners.
class Session {
public:
    /// Connects and registers; that this fails is held against the device.
    explicit Session(Bench& bench);
    Session(Session&& other) noexcept = default;
    ~Session();

    [[nodiscard]] bool is_open() const { return handle_ != 0 && wire_.is_open(); }
    [[nodiscard]] Wire& wire() { return wire_; }
    [[nodiscard]] Bench& bench() { return wire_.bench(); }
    [[nodiscard]] std::uint32_t handle() const { return handle_; }

    /// A SendRRData of these items around no, one or several messages.
    [[nodiscard]] enip::Frame rr_frame(cip::ByteView message, std::vector<enip::Item> items = {});
    [[nodiscard]] enip::Frame unit_frame(std::uint32_t connection, std::uint16_t sequence, cip::ByteView message);

    /// A request and its reply. Anything but one well-formed reply is held against the device.
    [[nodiscard]] std::optional<Reply> call(cip::ByteView message, std::vector<enip::Item> items = {});
    [[nodiscard]] std::optional<Reply> call(const cip::Request& request, std::vector<enip::Item> items = {});
    /// The reply in a frame that has come.
    [[nodiscard]] std::optional<Reply> read(const enip::Frame& frame, std::uint8_t service);

    void leave();

private:
    Wire wire_;
    std::uint32_t handle_ = 0;
};

/// A datagram to the device's UDP port 44818 and what comes back.
class Udp {
public:
    explicit Udp(Bench& bench);
    Udp(Udp&& other) noexcept;
    ~Udp();

    void send(cip::ByteView octets, const std::string& words = {});
    /// To all in the device's network, where there is a way; false where not.
    [[nodiscard]] bool broadcast(cip::ByteView octets);
    /// To the device's port for I/O data.
    void send_io(cip::ByteView octets, std::string words = {});
    /// The next datagram from the device.
    [[nodiscard]] std::optional<cip::Bytes> receive(milliseconds patience);
    [[nodiscard]] std::optional<enip::Frame> exchange(const enip::Frame& request);
    bool expect_silence(cip::ByteView octets, std::string_view what, bool firm = true);

private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

/// Octets from `0E 03 20 01`; blanks do not matter. Nothing when it is no hex.
[[nodiscard]] cip::Bytes hex(std::string_view text);
/// Pieces one after the other.
[[nodiscard]] cip::Bytes join(std::initializer_list<cip::ByteView> pieces);
[[nodiscard]] cip::Bytes u16(std::uint32_t value);
[[nodiscard]] cip::Bytes u32(std::uint32_t value);

/// A general status, with an extended one where that tells more.
struct Code {
    std::uint8_t general = 0;
    std::optional<std::uint16_t> extended{};

    Code(std::uint8_t code) : general(code) {}  // NOLINT(google-explicit-constructor): a code is a status
    Code(std::uint8_t code, std::uint16_t word) : general(code), extended(word) {}
    [[nodiscard]] bool matches(const cip::Status& status) const;
};
[[nodiscard]] std::string describe(std::span<const Code> codes);

/// How much a refusal with another status weighs. A grant is a failure in the first two.
enum class Weight : std::uint8_t {
    exact,  ///< a failure
    any,    ///< an advisory: that it is refused is what counts
    soft,   ///< an advisory, and a grant too
};

/// The request must be refused, and with one of `right`; with one of `tolerated` is an advisory.
void refused(Bench& bench, const std::optional<Reply>& reply, std::initializer_list<Code> right,
             std::initializer_list<Code> tolerated = {}, Weight weight = Weight::exact);
/// The request must be granted.
bool granted(Bench& bench, const std::optional<Reply>& reply);
/// The encapsulation layer refuses it with one of these and sends no data.
void refused(Bench& bench, const std::optional<enip::Frame>& reply, std::initializer_list<std::uint32_t> right,
             std::initializer_list<std::uint32_t> tolerated = {}, Weight weight = Weight::exact);

/// The service is not among those of the device: the case is skipped.
[[nodiscard]] bool is_unsupported(const std::optional<Reply>& reply);

}  // namespace servobus::scanner::conformance
