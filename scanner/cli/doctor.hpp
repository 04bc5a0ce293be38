// What `doctor FILE` makes of a capture, before it becomes text or JSON.
#pragma once

#include <string>
#include <vector>

#include "scanner/capture.hpp"
#include "scanner/capture_file.hpp"
#include "scanner/open_doctor.hpp"

namespace servobus::scanner::cli {

struct DiagnosedOpen {
    const CapturedOpen* open = nullptr;
    Diagnosis diagnosis;
};

struct CaptureReport {
    std::string file;
    CaptureSummary summary;
    const Conversation* conversation = nullptr;
    std::vector<DiagnosedOpen> opens;
};

/// `end` is when the capture ends.
[[nodiscard]] Diagnosis diagnose(const CapturedOpen& open, const Conversation& conversation, CaptureTime end);

[[nodiscard]] std::string report_text(const CaptureReport& report);
[[nodiscard]] std::string report_json(const CaptureReport& report);

}  // namespace servobus::scanner::cli
