#include "adapter/drive_io.hpp"

#include <fmt/format.h>

namespace servobus::adapter {

namespace {

std::string words_of(const assemblies::Image& image, const assemblies::Image::Outcome& outcome) {
    std::string names;
    for (std::size_t i = 0; i < image.layout().members.size(); ++i) {
        const auto* row = image.row(i);
        if ((outcome.refused >> i & 1) == 0 || row == nullptr) continue;
        names += fmt::format("{}{}", names.empty() ? "" : ", ", row->name);
    }
    return fmt::format("output assembly {}: {} left out: {}{}", image.layout().instance, names,
                       drive::describe(*outcome.first_refusal),
                       outcome.start_held ? "; nothing is started beside it" : "");
}

}  // namespace

DriveIo::DriveIo(drive::Device& device, AssemblyObject& assemblies, const Log& log)
    : device_(device), assemblies_(assemblies), log_(log) {
    for (const auto& layout : assemblies::layouts()) {
        bound_.try_emplace(layout.instance, Bound{assemblies::Image(layout, device), cip::Bytes(layout.size())});
    }
}

cip::ByteView DriveIo::inputs(const assemblies::Layout& layout, cip::Time now) {
    auto& [image, octets, refused] = bound(layout);
    const auto time = std::chrono::floor<std::chrono::microseconds>(now.time_since_epoch() + day_ahead_);
    image.pack(time.count(), octets);
    return octets;
}

void DriveIo::apply(const assemblies::Layout& layout, cip::ByteView octets) {
    auto& to = bound(layout);
    const auto result = to.image.apply(octets);
    assemblies_.received(layout, octets);
    // Once for each member, until a datagram comes that is refused nothing: the next one may be there in a millisecond.
    const auto news = result.refused & ~to.refused;
    to.refused = result.refused == 0 ? 0 : to.refused | result.refused;
    if (news != 0) log_(LogLevel::warning, words_of(to.image, result));
}

void DriveIo::lose_controller() { device_.inject(drive::event::LoseController{}); }

}  // namespace servobus::adapter
