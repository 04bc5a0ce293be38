#include "scanner/conformance/attribute.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "cip/hex.hpp"
#include "cip/services.hpp"

namespace servobus::scanner::conformance {
namespace {

constexpr auto absent = {cip::GeneralStatus::path_destination_unknown, cip::GeneralStatus::attribute_not_supported,
                         cip::GeneralStatus::service_not_supported, cip::GeneralStatus::attribute_not_gettable};

bool is_absent(const cip::Status& status) { return std::ranges::find(absent, status.general) != absent.end(); }

std::string name(const Place& place) {
    return fmt::format("attribute {} of class 0x{:02X}, instance {}", place.attribute, place.class_id, place.instance);
}

cip::Path path_of(const Place& place) { return cip::Path::to(place.class_id, place.instance, place.attribute); }

}  // namespace

cip::Bytes get_request(const Place& place) {
    return cip::Request{cip::service::get_attribute_single, path_of(place), {}}.encode();
}

cip::Bytes set_request(const Place& place, cip::ByteView value) {
    return cip::Request{cip::service::set_attribute_single, path_of(place), {value.begin(), value.end()}}.encode();
}

std::optional<cip::Bytes> read(Session& session, const Place& place, Presence presence) {
    auto& bench = session.bench();
    const auto reply = session.call(get_request(place));
    if (!reply) return std::nullopt;
    const auto& status = reply->response.status;
    if (presence == Presence::optional && is_absent(status)) {
        bench.skip(fmt::format("the device does not have {}", name(place)));
        return std::nullopt;
    }
    if (!bench.require(status.ok(), fmt::format("{} is refused with {}", name(place), cip::describe(status))))
        return std::nullopt;
    return reply->response.data;
}

std::optional<cip::Bytes> peek(Session& session, const Place& place) {
    const auto reply = session.call(get_request(place));
    if (!reply || !reply->ok()) return std::nullopt;
    return reply->response.data;
}

void check_value(Bench& bench, const Place& place, Presence presence, std::size_t octets, const Judge& judge) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto value = read(session, place, presence);
    if (!value) return;
    if (!bench.require(value->size() == octets, fmt::format("{} octets and not {}", value->size(), octets))) return;
    if (!judge) return;
    cip::Reader reader(*value);
    const auto wrong = judge(reader);
    bench.require(wrong.empty(), fmt::format("{} ({})", wrong, cip::to_hex(*value)));
}

void check_whole(Bench& bench, const Place& place, Presence presence, const Judge& judge) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto value = read(session, place, presence);
    if (!value) return;
    cip::Reader reader(*value);
    const auto wrong = judge(reader);
    if (!bench.require(wrong.empty(), fmt::format("{} ({})", wrong, cip::to_hex(*value)))) return;
    bench.require(reader.done(),
                  fmt::format("the value of {} octets is {} ({})", value->size(),
                              reader.ok() ? fmt::format("{} octets too long", reader.remaining()) : "too short",
                              cip::to_hex(*value)));
}

void check_class(Bench& bench, std::uint16_t class_id, std::uint16_t lowest_revision, std::uint16_t highest_revision,
                 Presence presence) {
    Session session(bench);
    if (!session.is_open()) return;
    const bool there = has_instance(session, class_id, 1);
    if (!there && presence == Presence::optional)
        return bench.skip(fmt::format("the device does not have class 0x{:02X}", class_id));
    constexpr std::array<std::uint16_t, 5> known{1, 2, 3, 6, 7};
    std::array<std::optional<std::uint16_t>, known.size()> values{};
    for (std::size_t i = 0; i < known.size(); ++i) {
        const auto value = peek(session, {class_id, 0, known[i]});
        if (!value) continue;
        if (bench.require(value->size() == 2,
                          fmt::format("class attribute {} has {} octets and not 2", known[i], value->size()))) {
            values[i] = cip::Reader(*value).u16();
        }
    }
    const auto& [revision, max_instance, instances, max_class, max_attribute] = values;
    if (std::ranges::none_of(values, [](const auto& each) { return each.has_value(); })) {
        return bench.skip("the device has no class attributes here");
    }
    if (revision) {
        bench.require(*revision != 0, "revision 0");
        bench.advise(*revision >= lowest_revision && *revision <= highest_revision,
                     fmt::format("revision {}; known are {} to {}", *revision, lowest_revision, highest_revision));
    }
    if (max_instance && instances) {
        bench.advise(*instances <= *max_instance,
                     fmt::format("{} instances, the highest of which is {}", *instances, *max_instance));
    }
    if (max_class) {
        bench.advise(*max_class >= 1 && *max_class <= 0x64,
                     fmt::format("the highest class attribute is {}", *max_class));
    }
    static_cast<void>(max_attribute);
}

void check_all(Bench& bench, std::uint16_t class_id, std::uint16_t instance, std::uint16_t last, Presence presence) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto reply =
        session.call(cip::Request{cip::service::get_attributes_all, cip::Path::to(class_id, instance), {}});
    if (!reply) return;
    if (presence == Presence::optional && is_absent(reply->response.status))
        return bench.skip("the device does not offer Get_Attributes_All here");
    if (!granted(bench, reply)) return;
    cip::Reader rest(reply->response.data);
    for (std::uint16_t id = 1; id <= last && rest.remaining() > 0; ++id) {
        const auto one = peek(session, {class_id, instance, id});
        if (!one) {
            bench.note(fmt::format("attribute {} cannot be read alone; what stands behind it is not compared", id));
            return;
        }
        const auto octets = rest.take(one->size());
        bench.require(rest.ok() && std::ranges::equal(octets, *one),
                      fmt::format("attribute {} is not in its place: {} alone, {} among all", id, cip::to_hex(*one),
                                  cip::to_hex(octets)));
    }
}

void check_refused_set(Bench& bench, const Place& place, cip::ByteView value, std::initializer_list<Code> right,
                       std::initializer_list<Code> tolerated, Weight weight) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto before = read(session, place, Presence::optional);
    if (!before) return;
    const auto reply = session.call(set_request(place, value));
    refused(bench, reply, right, tolerated, weight);
    const auto after = peek(session, place);
    bench.require(after && *after == *before, "the value has changed all the same");
    if (reply && reply->ok()) static_cast<void>(session.call(set_request(place, *before)));
}

void check_write_back(Bench& bench, const Place& place) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto before = read(session, place, Presence::optional);
    if (!before) return;
    const auto reply = session.call(set_request(place, *before));
    if (!reply) return;
    if (!reply->ok()) {
        const auto& status = reply->response.status;
        const bool cannot = is_absent(status) || status.general == cip::GeneralStatus::attribute_not_settable;
        if (cannot) return bench.skip(fmt::format("{} cannot be written here", name(place)));
        bench.require(false, fmt::format("what has just been read is refused with {}", cip::describe(status)));
        return;
    }
    bench.require(reply->response.data.empty(),
                  fmt::format("{} octets of data came with success", reply->response.data.size()));
    const auto after = peek(session, place);
    bench.require(after && *after == *before, "what was written is not what is read");
}

bool has_instance(Session& session, std::uint16_t class_id, std::uint16_t instance) {
    // An attribute that nobody has is 0x14 where the instance is there, and 0x05 where it is not.
    const auto reply = session.call(get_request({class_id, instance, 0x63}));
    return reply && reply->response.status.general != cip::GeneralStatus::path_destination_unknown;
}

}  // namespace servobus::scanner::conformance
