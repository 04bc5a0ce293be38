#include "eds/data_sheet.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace servobus::eds {
namespace {

constexpr std::uint8_t extended_symbol = 0x91;
constexpr std::size_t longest_symbol = 255;

// Octets that members are put into, lowest bit first. What is past max_image_octets is left out.
class BitWriter {
public:
    [[nodiscard]] bool full() const { return bits_ >= 8 * max_image_octets; }

    /// `count` bits: those of `octets`, then zeros.
    void put(cip::ByteView octets, std::uint32_t count) {
        const auto room = 8 * max_image_octets - std::min(bits_, 8 * max_image_octets);
        const auto taken = std::min<std::size_t>(count, room);
        octets_.resize((bits_ + taken + 7) / 8);
        for (std::size_t bit = 0; bit < std::min(taken, 8 * octets.size()); ++bit) {
            const auto to = bits_ + bit;
            const unsigned value = octets[bit / 8] >> (bit % 8) & 1U;
            octets_[to / 8] = static_cast<std::uint8_t>(octets_[to / 8] | value << (to % 8));
        }
        bits_ += taken;
    }
    [[nodiscard]] cip::Bytes take() { return std::move(octets_); }

private:
    cip::Bytes octets_;
    std::size_t bits_ = 0;
};

cip::Bytes constant_octets(std::int64_t number) {
    cip::Bytes octets;
    for (auto rest = static_cast<std::uint64_t>(number); octets.size() < 8; rest >>= 8) {
        octets.push_back(static_cast<std::uint8_t>(rest));
    }
    return octets;
}

cip::Bytes chosen_octets(const Parameter& parameter, const Choices& choices) {
    const auto choice = choices.find(parameter.number);
    const auto octets = choice != choices.end() ? parameter.encode(choice->second) : std::nullopt;
    return octets ? *octets : parameter.standard_octets();
}

// Makes one image, with inner assemblies where they stand.
class ImageMaker {
public:
    ImageMaker(const DataSheet& sheet, const Choices& choices) : sheet_(sheet), choices_(choices) {}

    cip::Bytes make(const Assembly& assembly, unsigned depth = 0) {
        BitWriter writer;
        for (const auto& member : assembly.members) {
            if (writer.full() || ++members_ > max_image_members) break;
            const auto octets = octets_of_member(member, depth);
            const auto all = static_cast<std::uint32_t>(8 * std::min(octets.size(), max_image_octets));
            writer.put(octets, member.bits.value_or(all));
        }
        auto octets = writer.take();
        if (assembly.size) octets.resize(std::min(*assembly.size, max_image_octets));
        return octets;
    }

private:
    cip::Bytes octets_of_member(const Member& member, unsigned depth) {
        if (const auto* reference = std::get_if<Member::Parameter>(&member.reference)) {
            const auto* parameter = sheet_.parameter(reference->number);
            return parameter != nullptr ? chosen_octets(*parameter, choices_) : cip::Bytes{};
        }
        if (const auto* reference = std::get_if<Member::Assembly>(&member.reference)) {
            const auto* inner = sheet_.assembly(reference->keyword);
            return inner != nullptr && depth < max_assembly_depth ? make(*inner, depth + 1) : cip::Bytes{};
        }
        const auto* constant = std::get_if<std::int64_t>(&member.reference);
        return constant != nullptr ? constant_octets(*constant) : cip::Bytes{};
    }

    const DataSheet& sheet_;
    const Choices& choices_;
    std::size_t members_ = 0;
};

cip::Bytes symbol_segment(std::string_view name) {
    cip::Bytes octets{extended_symbol, static_cast<std::uint8_t>(name.size())};
    octets.insert(octets.end(), name.begin(), name.end());
    if (octets.size() % 2 != 0) octets.push_back(0);
    return octets;
}

void append(cip::Bytes& octets, cip::ByteView more) { octets.insert(octets.end(), more.begin(), more.end()); }

}  // namespace

const Parameter* DataSheet::parameter(std::uint32_t number) const {
    const auto found = parameter_index.find(number);
    return found != parameter_index.end() ? &parameters[found->second] : nullptr;
}

std::vector<const Parameter*> DataSheet::parameters_named(std::string_view name) const {
    std::vector<const Parameter*> found;
    for (const auto& each : parameters) {
        if (same_name(trimmed(each.name), trimmed(name))) found.push_back(&each);
    }
    return found;
}

const Parameter* DataSheet::parameter_at(const AttributeAddress& address) const {
    const auto found = std::ranges::find(parameters, std::optional(address), &Parameter::address);
    return found != parameters.end() ? &*found : nullptr;
}

const Assembly* DataSheet::assembly(std::string_view keyword) const {
    const auto found = assembly_index.find(lower_case(keyword));
    return found != assembly_index.end() ? &assemblies[found->second] : nullptr;
}

const Connection* DataSheet::connection(std::string_view name_or_keyword) const {
    for (const auto& name : {&Connection::name, &Connection::keyword}) {
        const auto found = std::ranges::find_if(connections, [&](const Connection& each) {
            return same_name(trimmed(each.*name), trimmed(name_or_keyword));
        });
        if (found != connections.end()) return &*found;
    }
    return nullptr;
}

cip::Bytes DataSheet::image(const Assembly& assembly, const Choices& choices) const {
    return ImageMaker(*this, choices).make(assembly);
}

boost::system::result<cip::Bytes, std::string> DataSheet::connection_path(const Connection& connection,
                                                                          const Choices& choices,
                                                                          std::string_view symbol) const {
    cip::Bytes octets;
    for (const auto& part : connection.path.parts) {
        if (const auto* fixed = std::get_if<cip::Bytes>(&part)) {
            append(octets, *fixed);
        } else if (const auto* reference = std::get_if<PathPattern::Parameter>(&part)) {
            const auto* found = parameter(reference->number);
            if (found == nullptr) return fmt::format("the path needs Param{}, which is not there", reference->number);
            const auto value = chosen_octets(*found, choices);
            if (value.empty()) return fmt::format("the path needs a value of Param{}", reference->number);
            append(octets, value);
        } else if (symbol.empty() || symbol.size() > longest_symbol) {
            return std::string("the path needs the name of a tag, of 1 to 255 characters");
        } else {
            append(octets, symbol_segment(symbol));
        }
    }
    return octets;
}

cip::Bytes DataSheet::configuration(const Connection& connection, const Choices& choices) const {
    cip::Bytes octets;
    for (const auto* part : {&connection.proxy_configuration, &connection.target_configuration}) {
        cip::Bytes piece;
        if (const auto* format = assembly(part->format)) {
            piece = image(*format, choices);
        } else if (const auto number = number_behind("Param", part->format)) {
            if (const auto* found = parameter(*number)) piece = chosen_octets(*found, choices);
        }
        if (part->size.standard) piece.resize(std::min<std::size_t>(*part->size.standard, max_image_octets));
        append(octets, piece);
    }
    return octets;
}

}  // namespace servobus::eds
