// Asks the PTP node of this machine what it knows, one question after the other, again and again. No socket, no clock.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "adapter/log.hpp"
#include "adapter/time_sync.hpp"
#include "enip/message_user.hpp"

namespace servobus::adapter {

/// From the first question of a round to that of the next.
inline constexpr std::chrono::milliseconds ptp_round_interval{500};
/// What an answer may take.
inline constexpr std::chrono::milliseconds ptp_answer_time{1000};
/// Rounds that end without what was asked for, one after the other, before the node counts as gone.
inline constexpr int ptp_failed_rounds = 3;

class PtpClient final : public enip::MessageUser {
public:
    /// What a whole round has told is in `known` afterwards, which outlives this. The node answers in its own domain alone.
    PtpClient(TimeSync& known, std::uint8_t domain, Log log);

    void on_message(cip::ByteView octets, enip::Time now) override;
    void on_timer(enip::Time now) override;
    [[nodiscard]] std::optional<enip::Time> next_deadline() const override { return deadline_; }
    [[nodiscard]] std::vector<cip::Bytes> take_messages() override;

private:
    void begin_round(enip::Time now);
    void ask(enip::Time now);
    /// Nullopt: the round has no more questions.
    [[nodiscard]] std::optional<ManagementQuestion> question_of(std::size_t step) const;
    [[nodiscard]] std::size_t asked_ports() const;
    /// False: without that there is nothing to tell.
    [[nodiscard]] bool take(const ManagementAnswer& answer);
    void publish();
    void fail();
    void wait_for_round(enip::Time now);
    void tell_change();

    TimeSync& known_;
    std::uint8_t domain_;
    Log log_;
    enip::Time deadline_{};  ///< of the answer, or of the next round
    enip::Time round_{};     ///< when it began
    std::size_t step_ = 0;
    std::optional<ManagementQuestion> asked_{};  ///< nullopt: between two rounds
    std::uint16_t sequence_ = 0;
    PtpNode gathered_{};
    int failed_ = 0;
    std::vector<cip::Bytes> messages_;
    std::optional<ClockIdentity> master_{};  ///< that the log was last told of
};

}  // namespace servobus::adapter
