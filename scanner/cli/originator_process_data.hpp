// Process data over a connection of an originator, which runs wherever a link runs.
#pragma once

#include <memory>

#include "scanner/cli/io_options.hpp"
#include "scanner/cli/link.hpp"
#include "scanner/cli/process_data.hpp"
#include "scanner/host.hpp"
#include "scanner/originator.hpp"

namespace servobus::scanner::cli {

class OriginatorProcessData : public ProcessData {
public:
    /// `link` is open, outlives this, and leads to the same device. The task is a known one with outputs, which begin
    /// as `outputs`.
    OriginatorProcessData(Link& link, Host host, const ConnectionTask& task, cip::Bytes outputs);
    OriginatorProcessData(const OriginatorProcessData&) = delete;
    OriginatorProcessData& operator=(const OriginatorProcessData&) = delete;
    ~OriginatorProcessData() override;

    /// Until the first inputs are there.
    [[nodiscard]] std::optional<Failure> open();
    /// Forward_Close; afterwards nothing is sent any more.
    void close();
    /// What the originator said, when it is not open.
    [[nodiscard]] const std::optional<IoClosed>& closed() const { return closed_; }

    [[nodiscard]] const assemblies::Layout& output_layout() const override { return *output_layout_; }
    [[nodiscard]] const assemblies::Layout& input_layout() const override { return *input_layout_; }
    [[nodiscard]] cip::Bytes& outputs() override { return outputs_; }
    [[nodiscard]] std::uint64_t sent() const override { return sent_; }
    [[nodiscard]] const Input& input() const override { return input_; }
    [[nodiscard]] std::uint64_t received() const override { return received_; }
    void on_input(std::function<void(const Input&)> listener) override { listener_ = std::move(listener); }
    [[nodiscard]] std::optional<Failure> run_until(const std::function<bool()>& done) override;

private:
    [[nodiscard]] IoEvents events();

    Link& link_;
    Host host_;
    const assemblies::Layout* output_layout_;
    const assemblies::Layout* input_layout_;
    cip::Bytes outputs_;
    std::uint64_t sent_ = 0;
    Input input_{};
    std::uint64_t received_ = 0;
    std::function<void(const Input&)> listener_;
    std::optional<IoClosed> closed_{};
    Clock::time_point kept_alive_ = Clock::now();
    Originator originator_;
    IoConnection* connection_ = nullptr;
};

}  // namespace servobus::scanner::cli
