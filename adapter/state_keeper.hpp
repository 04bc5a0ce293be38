// Brings the state of one device into safety, one write at a time: what changes meanwhile goes with the next one. Who
// writes, and how long that takes, is somebody else's business (decision 2).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "adapter/stored_state.hpp"

namespace servobus::adapter {

class StateKeeper {
public:
    /// Counts the states that differ from the one before. A reply to a write waits until its state is safe.
    using Generation = std::uint64_t;
    /// Begins to write; on_stored() follows, not from in here.
    using Sink = std::function<void(const StoredState&)>;

    /// What is safe already.
    explicit StateKeeper(StoredState stored) : durable_(std::move(stored)), newest_(durable_) {}

    /// This is what is safe, and nothing else is on its way.
    void start_from(StoredState stored);

    /// Without a sink everything is safe at once: in the memory of the program.
    void write_with(Sink sink) { sink_ = std::move(sink); }

    /// The state is this now.
    void change(const StoredState& state);
    /// The write that has begun has ended. When it failed, everything that was not safe is lost: newest() is durable().
    void on_stored(bool ok);
    /// The power has gone: what no write has begun for is lost. What comes up is newest().
    void cut_power();

    [[nodiscard]] const StoredState& newest() const { return newest_; }
    [[nodiscard]] const StoredState& durable() const { return durable_; }
    /// The generation of newest().
    [[nodiscard]] Generation generation() const { return generation_; }
    [[nodiscard]] bool is_settled(Generation generation) const { return generation <= settled_; }
    /// Something is not safe yet.
    [[nodiscard]] bool waits() const { return settled_ != generation_; }

private:
    void write();

    Sink sink_;
    StoredState durable_;
    StoredState newest_;
    std::optional<StoredState> in_writing_;
    Generation generation_ = 0;
    Generation in_writing_generation_ = 0;
    Generation settled_ = 0;  ///< safe, or known to be lost
};

}  // namespace servobus::adapter
