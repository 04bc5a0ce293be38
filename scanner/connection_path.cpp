#include "scanner/connection_path.hpp"

#include <fmt/format.h>

#include <variant>

#include "cip/forward_open.hpp"

namespace servobus::scanner {
namespace {

constexpr std::uint32_t assembly_class = 0x04;

/// Hands each segment to its place.
struct Sorter {
    ConnectionPath& path;

    void operator()(const cip::LogicalSegment& segment) const {
        using enum cip::LogicalType;
        const std::uint32_t limit = segment.width == cip::Width::bits16 ? 0xFF : 0xFFFF;
        if (segment.width != cip::Width::bits8 && segment.value <= limit) path.wide = true;
        if (segment.type == class_id && !path.class_id) path.class_id = segment.value;
        if (segment.type == instance || segment.type == connection_point) path.points.push_back(segment.value);
    }
    void operator()(const cip::ElectronicKey& key) const { path.key = key; }
    void operator()(const cip::PortSegment& hop) const { path.route.segments.emplace_back(hop); }
    void operator()(const cip::NetworkSegment&) const {}
    void operator()(const cip::SymbolSegment& symbol) const { path.symbols.push_back(symbol.name); }
    void operator()(const cip::DataSegment& segment) const { path.data = segment.data; }
};

}  // namespace

ConnectionPath ConnectionPath::read(cip::ByteView octets) {
    ConnectionPath path;
    const auto parsed = cip::Path::parse(octets);
    if (!parsed) {
        path.error = parsed.error();
        return path;
    }
    for (const auto& segment : parsed->segments) std::visit(Sorter{path}, segment);
    path.inhibit = cip::production_inhibit_time(*parsed);
    return path;
}

std::optional<std::uint32_t> ConnectionPath::configuration() const {
    return points.size() >= 3 ? std::optional(points[0]) : std::nullopt;
}

std::optional<std::uint32_t> ConnectionPath::o_to_t() const {
    if (points.size() < 2) return std::nullopt;
    return points.size() >= 3 ? points[1] : points[0];
}

std::optional<std::uint32_t> ConnectionPath::t_to_o() const {
    if (points.size() < 2) return std::nullopt;
    return points.size() >= 3 ? points[2] : points[1];
}

std::vector<std::string> ConnectionPath::oddities() const {
    std::vector<std::string> list;
    if (error) {
        list.push_back(fmt::format("The path cannot be read: {}.", cip::describe(*error)));
        return list;
    }
    if (!class_id) {
        list.emplace_back("The path names no class; 20 04, the Assembly object, has to stand before the points.");
    } else if (*class_id != assembly_class) {
        list.push_back(
            fmt::format("The path names class 0x{:02X}; I/O data is in class 0x04, the Assembly object.", *class_id));
    }
    for (const auto& symbol : symbols) {
        list.push_back(fmt::format(
            "The path has the symbol '{}'; most devices other than controllers take numbers only.", symbol));
    }
    if (points.empty() && symbols.empty()) list.emplace_back("The path names no connection point at all.");
    if (points.size() == 1) {
        list.push_back(fmt::format("The path names one point, {}, for both directions; O->T and T->O each need theirs.",
                                   points[0]));
    }
    if (points.size() == 2)
        list.emplace_back("The path names no configuration instance, which some devices insist on.");
    if (points.size() > 3) list.push_back(fmt::format("The path names {} points; three are the most.", points.size()));
    if (!route.segments.empty()) {
        list.emplace_back("The path begins with hops to another node, which only a router understands.");
    }
    if (wide) list.emplace_back("A class or point takes 16 or 32 bits where 8 would do; some devices accept 8 only.");
    if (data && data->empty()) list.emplace_back("The path ends with a data segment without data.");
    return list;
}

}  // namespace servobus::scanner
