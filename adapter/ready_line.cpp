#include "adapter/ready_line.hpp"

#include <nlohmann/json.hpp>

namespace servobus::adapter {

std::string ready_line(const std::vector<ReadyDrive>& drives, std::int64_t pid,
                       const std::vector<std::string>& control) {
    using Line = nlohmann::ordered_json;
    Line line{{"ready", true}, {"pid", pid}, {"drives", Line::array()}, {"control", control}};
    for (const auto& drive : drives) {
        line["drives"].push_back({{"address", drive.address ? Line(*drive.address) : Line(nullptr)},
                                  {"port", drive.port},
                                  {"io_port", drive.io_port},
                                  {"serial_number", drive.identity.serial_number},
                                  {"product_code", drive.identity.product_code},
                                  {"product_name", drive.identity.product_name}});
        if (drive.interface) line["drives"].back()["interface"] = *drive.interface;
    }
    return line.dump(-1, ' ', false, Line::error_handler_t::replace);
}

}  // namespace servobus::adapter
