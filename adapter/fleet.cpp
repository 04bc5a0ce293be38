#include "adapter/fleet.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <random>
#include <utility>

#include "adapter/file_settings.hpp"
#include "drive/xenax.hpp"

namespace servobus::adapter {
namespace {

std::optional<std::uint32_t> address_of(const std::string& text) {
    in_addr address{};
    if (::inet_pton(AF_INET, text.c_str(), &address) != 1) return std::nullopt;
    return ntohl(address.s_addr);
}

// Each line says which of several drives it is about.
LineSink naming(const LineSink& sink, const std::string& drive) {
    auto own = sink;
    own.take = [take = sink.take, drive](LogLine line) {
        line.values.emplace(line.values.begin(), "drive", drive);
        take(line);
    };
    return own;
}

}  // namespace

std::variant<std::vector<std::string>, std::string> drive_addresses(const std::vector<std::string>& binds,
                                                                    std::size_t count) {
    if (count < 1 || count > max_drives) return fmt::format("--count is a number from 1 to {}", max_drives);
    if (binds.size() == count) return binds;
    if (binds.size() != 1) {
        return fmt::format("there are {} addresses for {} drives; give one for each, or the first alone", binds.size(),
                           count);
    }
    const auto first = address_of(binds.front());
    if (!first)
        return fmt::format("'{}' is not an IPv4 address; give one of this machine, such as 127.0.0.1", binds[0]);
    if (*first == 0) return std::string("several drives need an address each; 0.0.0.0 is all of them at once");
    std::vector<std::string> addresses;
    for (std::size_t i = 0; i < count; ++i)
        addresses.push_back(enip::address_text(*first + static_cast<std::uint32_t>(i)));
    return addresses;
}

Fleet::Member::Member(drive::Device made, const Config& config, std::uint64_t seed, LogSink log, DeviceFiles files)
    : device(std::move(made)),
      adapter(device, config.limits, seed, std::move(log), make_network(device.identity(), config.network),
              std::move(files)) {
    if (config.eds) return;
    adapter.on_revision([&config](const drive::Identity& identity) {
        auto revised = config;
        revised.major_revision = identity.major_revision;
        revised.minor_revision = identity.minor_revision;
        return *generated_files(revised).eds;
    });
}

Fleet::Fleet(const Config& config, const std::vector<std::string>& addresses, std::uint64_t seed, const LogSink& log,
             const DeviceFiles& files, const Timetable& scenario)
    : addresses_(addresses) {
    std::mt19937_64 seeds(seed);
    for (std::size_t i = 0; i < addresses.size(); ++i) {
        auto own = config;
        own.seed = config.seed + i;
        own.serial_number = config.serial_number.value_or(drive::xenax_model(config.variant)->identity.serial_number) +
                            static_cast<std::uint32_t>(i);
        auto sink = log;
        if (addresses.size() > 1) {
            sink = [log, name = addresses[i]](LogLevel level, std::string_view line) {
                log(level, fmt::format("{}: {}", name, line));
            };
        }
        auto& member =
            *members_.emplace_back(std::make_unique<Member>(make_device(own), config, seeds(), std::move(sink), files));
        member.adapter.seed_faults(own.seed);
        member.adapter.play(scenario);
        member.adapter.allow(config.allowed);
        member.adapter.protect(config.protection);
    }
}

std::size_t Fleet::sessions() const {
    std::size_t total = 0;
    for (const auto& member : members_) total += member->adapter.sessions();
    return total;
}

std::optional<std::string> Fleet::install(const FlashImage& image) {
    for (const auto& member : members_) {
        if (auto wrong = member->adapter.install(image)) return wrong;
    }
    return std::nullopt;
}

void Fleet::on_access(const LineSink& sink) {
    for (std::size_t i = 0; i < members_.size(); ++i) {
        members_[i]->adapter.on_access(members_.size() > 1 ? naming(sink, addresses_[i]) : sink);
    }
}

void Fleet::shut_down() {
    for (const auto& member : members_) member->adapter.shut_down();
}

}  // namespace servobus::adapter
