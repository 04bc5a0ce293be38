#include "assemblies/connection.hpp"

#include <algorithm>
#include <array>

namespace servobus::assemblies {
namespace {

using Kind = Connection::Kind;

// Those who only look may also look at what the larger owners see (R-CON-31).
constexpr std::array all{
    Connection{"standard", "Standard", Kind::exclusive_owner, 101, 100},
    Connection{"iforce", "I Force", Kind::exclusive_owner, 102, 100},
    Connection{"outputs", "Digital Outputs", Kind::exclusive_owner, 103, 100},
    Connection{"force", "Force", Kind::exclusive_owner, 104, 105},
    Connection{"cipsync", "CIP Sync", Kind::exclusive_owner, 112, 113},
    Connection{"input-only", "Input only", Kind::input_only, input_only_point, 100},
    Connection{"input-only", "Input only", Kind::input_only, input_only_point, 105},
    Connection{"input-only", "Input only", Kind::input_only, input_only_point, 113},
    Connection{"listen-only", "Listen only", Kind::listen_only, listen_only_point, 100},
    Connection{"listen-only", "Listen only", Kind::listen_only, listen_only_point, 105},
    Connection{"listen-only", "Listen only", Kind::listen_only, listen_only_point, 113},
};

template <class Condition>
const Connection* first(Condition condition) {
    const auto found = std::ranges::find_if(all, condition);
    return found != all.end() ? &*found : nullptr;
}

std::size_t data_octets(const Layout* layout) { return layout != nullptr ? layout->size() : 0; }

}  // namespace

std::size_t Connection::o_to_t_size() const { return cip::connection_size(o_to_t_format(), data_octets(outputs())); }
std::size_t Connection::t_to_o_size() const { return cip::connection_size(t_to_o_format(), data_octets(inputs())); }

std::span<const Connection> connections() { return all; }

const Connection* find_connection(std::string_view key) {
    return first([&](const Connection& each) { return each.key == key; });
}

const Connection* find_connection(std::uint32_t o_to_t_point, std::uint32_t t_to_o_point) {
    return first(
        [&](const Connection& each) { return each.o_to_t_point == o_to_t_point && each.t_to_o_point == t_to_o_point; });
}

const Connection* find_by_output(std::uint32_t o_to_t_point) {
    return first([&](const Connection& each) { return each.o_to_t_point == o_to_t_point; });
}

const Connection* find_by_input(std::uint32_t t_to_o_point) {
    return first([&](const Connection& each) { return each.t_to_o_point == t_to_o_point; });
}

std::string_view name(Connection::Kind kind) {
    switch (kind) {
        case Kind::exclusive_owner:
            return "exclusive owner";
        case Kind::input_only:
            return "input only";
        case Kind::listen_only:
            return "listen only";
    }
    return "";
}

}  // namespace servobus::assemblies
