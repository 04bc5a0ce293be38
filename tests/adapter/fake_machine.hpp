// A drive whose machine does nothing but remember what it was told: what the adapter owes to any machine.
//
//     Site site({}, device_with_fake_machine());
//     fake_machine().deadline = drive::Time(...);
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "drive/device.hpp"
#include "drive/xenax.hpp"

namespace servobus::test {

class FakeMachine final : public drive::Behaviour {
public:
    [[nodiscard]] std::optional<drive::Refusal> check(const drive::Parameter&, const drive::Value&) const override {
        return std::nullopt;
    }
    void written(const drive::Parameter& row) override { rows.push_back(row.key()); }
    void step(drive::Time now) override {
        steps.push_back(now);
        if (on_step) deadline = on_step(now);
    }
    [[nodiscard]] std::optional<drive::Time> next_deadline() const override { return deadline; }
    void inject(const drive::Event& event) override {
        events.push_back(event);
        event_times.push_back(steps.empty() ? drive::Time{-1} : steps.back());
    }
    [[nodiscard]] drive::OutputLevel output_wire(int number) const override {
        return number == 2 ? drive::OutputLevel::high : drive::OutputLevel::open;
    }
    void tell_machine() override {}
    void power_up() override { ++power_ups; }
    [[nodiscard]] bool has_fault() const override { return fault; }

    std::vector<drive::Time> steps;
    std::vector<drive::Event> events;
    std::vector<drive::Time> event_times;  ///< of the last step before each event
    std::vector<drive::Key> rows;
    int power_ups = 0;
    bool fault = false;
    std::optional<drive::Time> deadline;
    std::optional<drive::Time> (*on_step)(drive::Time now) = nullptr;
};

inline FakeMachine*& last_fake_machine() {
    static FakeMachine* last = nullptr;
    return last;
}
/// The machine of the device that was made last.
inline FakeMachine& fake_machine() { return *last_fake_machine(); }

inline drive::Device device_with_fake_machine() {
    auto model = drive::xenax_models().front();
    model.make_behaviour = [](const drive::Model&, drive::Store&, const drive::Machine&) {
        auto machine = std::make_unique<FakeMachine>();
        last_fake_machine() = machine.get();
        return std::unique_ptr<drive::Behaviour>(std::move(machine));
    };
    return {std::move(model), drive::Machine{}};
}

}  // namespace servobus::test
