#include "scanner/cli/open_trial.hpp"

#include <memory>

#include "enip/asio/asio.hpp"
#include "scanner/originator.hpp"

namespace servobus::scanner::cli {
namespace {

using Clock = std::chrono::steady_clock;

/// One connection of a trial. Its originator outlives it, and what that still tells must not meet a guest that has gone.
class Guest {
public:
    Guest(Originator& originator, const Host& host, std::chrono::milliseconds timeout, const IoPlan& plan) {
        IoOptions options;
        options.host = host.name;
        options.port = host.port;
        options.plan = plan;
        options.timeout = timeout;
        options.reopen = false;
        IoEvents events;
        events.input = [state = state_](const IoInput&) { state->heard = true; };
        events.closed = [state = state_](const IoClosed& closed) { state->closed = closed; };
        connection_ = &originator.add(std::move(options), std::move(events));
    }
    Guest(const Guest&) = delete;
    Guest& operator=(const Guest&) = delete;

    void open() { connection_->open(); }
    void close() {
        if (!closed()) connection_->close();
    }
    [[nodiscard]] bool heard() const { return state_->heard; }
    [[nodiscard]] const std::optional<IoClosed>& closed() const { return state_->closed; }

private:
    struct State {
        bool heard = false;
        std::optional<IoClosed> closed{};
    };
    std::shared_ptr<State> state_ = std::make_shared<State>();
    IoConnection* connection_ = nullptr;
};

class Trial {
public:
    Trial(const Host& host, std::chrono::milliseconds timeout) : host_(host), timeout_(timeout) {}

    TrialResult run(const IoPlan& plan, const std::optional<IoPlan>& companion) {
        std::optional<Guest> other;
        if (companion) {
            open(other.emplace(originator_, host_, timeout_, *companion));
            if (!other->heard()) return {.closed = other->closed()};
        }
        Guest guest(originator_, host_, timeout_, plan);
        open(guest);
        TrialResult result{.well = guest.heard(), .closed = guest.closed()};
        close(guest);
        if (other) close(*other);
        return result;
    }

private:
    void open(Guest& guest) {
        guest.open();
        // Connecting, session, answer and the first datagram each have their time.
        run_until(4 * timeout_, [&] { return guest.heard() || guest.closed().has_value(); });
    }
    void close(Guest& guest) {
        guest.close();
        run_until(timeout_, [&] { return guest.closed().has_value(); });
    }

    template <class Done>
    void run_until(std::chrono::milliseconds limit, Done done) {
        const auto end = Clock::now() + limit;
        while (!done() && Clock::now() < end) {
            context_.restart();
            context_.run_one_until(end);
        }
    }

    const Host& host_;
    std::chrono::milliseconds timeout_;
    net::io_context context_{1};
    Originator originator_{context_.get_executor()};
};

}  // namespace

TrialResult try_open(const Host& host, std::chrono::milliseconds timeout, const IoPlan& plan,
                     const std::optional<IoPlan>& companion) {
    return Trial(host, timeout).run(plan, companion);
}

}  // namespace servobus::scanner::cli
