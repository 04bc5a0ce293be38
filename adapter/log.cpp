#include "adapter/log.hpp"

namespace servobus::adapter {

void Log::operator()(LogLevel level, const std::string& line) const {
    if (sink_) sink_(level, line);
}

}  // namespace servobus::adapter
