// Those who look on at an I/O connection: a live table, plain lines, JSON lines, a table in a file.
#pragma once

#include <chrono>
#include <ostream>
#include <string>

#include "cip/bytes.hpp"
#include "scanner/cli/console.hpp"
#include "scanner/cli/io_options.hpp"
#include "scanner/cli/io_runner.hpp"
#include "scanner/cli/live_table.hpp"

namespace servobus::scanner::cli {

/// On a terminal: the inputs by name, about ten times a second.
class IoTable : public IoSink {
public:
    IoTable(const Console& console, const ConnectionTask& task);

    void opened(const IoOpened& opened) override;
    void input(const IoInput& input, std::chrono::duration<double> time) override;
    void closed(const IoClosed& closed, const std::string& text) override;
    void look(const IoReport& report) override;

private:
    const Console& console_;
    const ConnectionTask& task_;
    LiveTable table_;
    std::chrono::steady_clock::time_point next_{};
    cip::Bytes data_;
    bool run_ = false;
    std::string state_ = "opening";
};

/// Elsewhere: a line about every second.
class IoLines : public IoSink {
public:
    /// Nothing but messages when `out` is nullptr.
    IoLines(const Console& console, const ConnectionTask& task, std::ostream* out);

    void opened(const IoOpened& opened) override;
    void input(const IoInput& input, std::chrono::duration<double> time) override;
    void closed(const IoClosed& closed, const std::string& text) override;

private:
    const Console& console_;
    const ConnectionTask& task_;
    std::ostream* out_;
    double next_ = 0;
};

/// A line of JSON for everything that happens.
class IoJsonLines : public IoSink {
public:
    IoJsonLines(std::ostream& out, std::string host, const ConnectionTask& task);

    void opened(const IoOpened& opened) override;
    void input(const IoInput& input, std::chrono::duration<double> time) override;
    void closed(const IoClosed& closed, const std::string& text) override;
    void look(const IoReport& report) override;

private:
    std::ostream& out_;
    std::string host_;
    const ConnectionTask& task_;
};

/// A line for each datagram, under a header with units.
class IoCsv : public IoSink {
public:
    IoCsv(std::ostream& out, const ConnectionTask& task);

    void input(const IoInput& input, std::chrono::duration<double> time) override;
    void look(const IoReport& report) override;

private:
    std::ostream& out_;
    const ConnectionTask& task_;
};

}  // namespace servobus::scanner::cli
