// The connection path of a Forward_Open, taken apart as a target would (R-CON-10, R-CON-12).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"
#include "cip/path.hpp"

namespace servobus::scanner {

struct ConnectionPath {
    std::optional<cip::DecodeError> error{};  ///< why it cannot be read; the rest is empty then
    cip::Path route{};                        ///< port segments in front
    std::optional<cip::ElectronicKey> key{};
    std::optional<std::uint32_t> inhibit{};  ///< microseconds
    std::optional<std::uint32_t> class_id{};
    /// Instances and connection points behind the class, in their order.
    std::vector<std::uint32_t> points{};
    std::optional<cip::Bytes> data{};
    std::vector<std::string> symbols{};
    bool wide = false;  ///< a class, instance or point takes 16 or 32 bits though 8 would do

    [[nodiscard]] static ConnectionPath read(cip::ByteView octets);

    // Three points are configuration, O->T and T->O; two are O->T and T->O.
    [[nodiscard]] std::optional<std::uint32_t> configuration() const;
    [[nodiscard]] std::optional<std::uint32_t> o_to_t() const;
    [[nodiscard]] std::optional<std::uint32_t> t_to_o() const;

    /// What is not as in the usual `[key] 20 04 24 cfg 2C o2t 2C t2o`, a sentence each.
    [[nodiscard]] std::vector<std::string> oddities() const;
};

}  // namespace servobus::scanner
