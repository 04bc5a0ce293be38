// Why a Forward_Open is refused: the status for the peer, and a sentence for the person who looks at the log.
#pragma once

#include <boost/system/result.hpp>
#include <string>

#include "cip/status.hpp"

namespace servobus::adapter {

struct OpenRefusal {
    cip::Status status{};
    std::string words{};  ///< what was expected and what came; empty where the status says all
};

template <class T>
using OpenResult = boost::system::result<T, OpenRefusal>;

}  // namespace servobus::adapter
