// Between the drives of a process and the directory that keeps their state: loads it at start, stores it when it changes.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "adapter/adapter.hpp"
#include "adapter/file_system.hpp"
#include "adapter/log.hpp"
#include "adapter/state_directory.hpp"
#include "adapter/state_file.hpp"
#include "enip/time.hpp"

namespace servobus::adapter {

class StateStoring {
public:
    /// Does a job where it may take its time, and afterwards `done` where the adapter is served, with the time there.
    using Background =
        std::function<void(Adapter& adapter, std::function<void()> job, std::function<void(enip::Time)> done)>;

    /// The file system outlives this, and so do the drives that are given to keep().
    StateStoring(FileSystem& files, StateDirectory directory, Background background, LogSink log)
        : files_(files), directory_(std::move(directory)), background_(std::move(background)), log_(std::move(log)) {}

    /// The drive comes up with what is kept of it, and keeps what changes from now on. What is of no use is kept aside, and
    /// its Identity tells so.
    void keep(Adapter& adapter);

    /// What is not stored yet when nobody is served any more.
    void finish();

private:
    struct Drive {
        Adapter* adapter;
        StateFile file;
        std::error_code outcome{};  ///< of the job that has run last
    };

    void load(Drive& drive);
    void set_aside(Drive& drive, const BadState& bad);
    void begin(Drive& drive, const StoredState& state);
    [[nodiscard]] static std::error_code store(Drive& drive, const StoredState& state);

    FileSystem& files_;
    StateDirectory directory_;
    Background background_;
    Log log_;
    std::vector<std::unique_ptr<Drive>> drives_;
};

}  // namespace servobus::adapter
