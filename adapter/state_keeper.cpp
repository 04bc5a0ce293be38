#include "adapter/state_keeper.hpp"

#include <utility>

namespace servobus::adapter {

void StateKeeper::start_from(StoredState stored) {
    durable_ = std::move(stored);
    newest_ = durable_;
    settled_ = generation_;
}

void StateKeeper::change(const StoredState& state) {
    if (state == newest_) return;
    newest_ = state;
    ++generation_;
    if (!sink_) {
        durable_ = newest_;
        settled_ = generation_;
    } else if (!in_writing_) {
        write();
    }
}

void StateKeeper::write() {
    in_writing_ = newest_;
    in_writing_generation_ = generation_;
    sink_(newest_);
}

void StateKeeper::on_stored(bool ok) {
    if (!in_writing_) return;
    auto written = *std::exchange(in_writing_, std::nullopt);
    if (!ok) {
        newest_ = durable_;
        settled_ = generation_;
        return;
    }
    durable_ = std::move(written);
    settled_ = in_writing_generation_;
    if (newest_ == durable_) {
        settled_ = generation_;
    } else {
        write();
    }
}

void StateKeeper::cut_power() { newest_ = in_writing_ ? *in_writing_ : durable_; }

}  // namespace servobus::adapter
