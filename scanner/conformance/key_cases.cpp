// Electronic keys (R-PTH-5, R-CON-11). An explicit connection has them as an I/O connection has, owns nothing, and is
// there without a data sheet.
#include <fmt/format.h>

#include <array>

#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"
#include "scanner/conformance/class3_link.hpp"
#include "scanner/conformance/io_link.hpp"

namespace servobus::scanner::conformance {
namespace {

using KeyChange = void (*)(cip::ElectronicKey&);

std::optional<cip::ElectronicKey> own_key(Bench& bench) {
    const auto& identity = bench.subject().identity;
    if (!identity) {
        bench.skip("the device does not say who it is");
        return std::nullopt;
    }
    return cip::ElectronicKey{.vendor = identity->vendor,
                              .device_type = identity->device_type,
                              .product_code = identity->product_code,
                              .major_revision = identity->major_revision,
                              .minor_revision = identity->minor_revision};
}

/// The reply to a Forward_Open with these octets in front of the path; nullopt when there is none, or no such connections.
std::optional<Reply> open_behind(Bench& bench, const cip::Bytes& front) {
    Session session(bench);
    if (!session.is_open()) return std::nullopt;
    auto open = class3_open(bench);
    open.path = join({front, open.path});
    auto reply = try_open(session, open);
    if (is_unsupported(reply)) {
        bench.skip("the device has no explicit connections");
        return std::nullopt;
    }
    check_refusal_data(bench, reply, open);
    return reply;
}

std::optional<Reply> open_with(Bench& bench, KeyChange change) {
    auto key = own_key(bench);
    if (!key) return std::nullopt;
    if (change != nullptr) change(*key);
    return open_behind(bench, cip::Path({*key}).encode());
}

void fits(Bench& bench, KeyChange change, bool firm = true) {
    const auto reply = open_with(bench, change);
    if (!reply || reply->ok()) return;
    const auto words = fmt::format("refused with {}", cip::describe(reply->response.status));
    if (firm) {
        bench.require(false, words);
    } else {
        bench.advise(false, words);
    }
}

void misfits(Bench& bench, KeyChange change, std::uint16_t word, Weight weight = Weight::any) {
    refused(bench, open_with(bench, change), {{0x01, word}}, {}, weight);
}

void wrong_minor(Bench& bench) {
    if (bench.subject().identity && bench.subject().identity->minor_revision == 0xFF)
        return bench.skip("there is no higher minor revision than 255");
    misfits(
        bench, [](cip::ElectronicKey& key) { ++key.minor_revision; }, 0x0116);
}

void malformed(Bench& bench, std::string_view key) {
    refused(bench, open_behind(bench, hex(key)), {{0x01, 0x0315}}, {0x04, 0x26, 0x05}, Weight::any);
}

void io_connection(Bench& bench, KeyChange change, std::uint16_t word) {
    const auto* candidate = bench.subject().harmless();
    if (candidate == nullptr)
        return bench.skip("no connection is known that may be opened without --allow-writes; give --eds");
    auto key = own_key(bench);
    Session session(bench);
    if (!key || !session.is_open()) return;
    if (change != nullptr) change(*key);
    auto plan = usual_plan(*candidate, std::chrono::milliseconds(20));
    plan.key = *key;
    const auto open = open_of(session, plan);
    const auto reply = try_open(session, open);
    if (word == 0) {
        granted(bench, reply);
        return;
    }
    refused(bench, reply, {{0x01, word}}, {}, Weight::any);
    check_refusal_data(bench, reply, open);
}

void explicit_request(Bench& bench, KeyChange change, bool right) {
    auto key = own_key(bench);
    Session session(bench);
    if (!key || !session.is_open()) return;
    if (change != nullptr) change(*key);
    const auto path = join({cip::Path({*key}).encode(), hex("20 01 24 01 30 01")});
    const auto reply = session.call(join({hex("0E"), std::array{static_cast<std::uint8_t>(path.size() / 2)}, path}));
    if (!reply) return;
    if (right) {
        bench.advise(reply->ok(), fmt::format("refused with {}", cip::describe(reply->response.status)));
    } else {
        refused(bench, reply, {0x25}, {0x04}, Weight::soft);
    }
}

constexpr std::uint8_t compatible = 0x80;
constexpr auto K = Group::keys;
constexpr auto R = Manner::reads;

// clang-format off
constexpr std::array cases{
    Case{"KEY-01", K, "The right key fits", "R-CON-11", "Vendor, type, product code and revision as the device has them.", R, [](Bench& b) { fits(b, nullptr); }},
    Case{"KEY-02", K, "A key of zeros fits", "R-CON-11", "Zero means any.", R, [](Bench& b) { fits(b, [](cip::ElectronicKey& key) { key = {}; }); }},
    Case{"KEY-03", K, "Any vendor", "R-CON-11", "Zero means any.", R, [](Bench& b) { fits(b, [](cip::ElectronicKey& key) { key.vendor = 0; }); }},
    Case{"KEY-04", K, "Any product code", "R-CON-11", "Zero means any.", R, [](Bench& b) { fits(b, [](cip::ElectronicKey& key) { key.product_code = 0; }); }},
    Case{"KEY-05", K, "Any device type", "R-CON-11", "Zero means any.", R, [](Bench& b) { fits(b, [](cip::ElectronicKey& key) { key.device_type = 0; }); }},
    Case{"KEY-06", K, "Any minor revision", "R-CON-11", "Zero means any.", R, [](Bench& b) { fits(b, [](cip::ElectronicKey& key) { key.minor_revision = 0; }); }},
    Case{"KEY-07", K, "Any revision", "R-CON-11", "Zero means any.", R, [](Bench& b) { fits(b, [](cip::ElectronicKey& key) { key.major_revision = 0; key.minor_revision = 0; }); }},
    Case{"KEY-08", K, "Another vendor", "R-CON-11", "Status 0x01, extended status 0x0114.", R, [](Bench& b) { misfits(b, [](cip::ElectronicKey& key) { key.vendor ^= 0x0F0F; }, 0x0114); }},
    Case{"KEY-09", K, "Another product code", "R-CON-11", "Status 0x01, extended status 0x0114.", R, [](Bench& b) { misfits(b, [](cip::ElectronicKey& key) { key.product_code ^= 0x0F0F; }, 0x0114); }},
    Case{"KEY-10", K, "Another device type", "R-CON-11", "Status 0x01, extended status 0x0115.", R, [](Bench& b) { misfits(b, [](cip::ElectronicKey& key) { key.device_type ^= 0x0F0F; }, 0x0115); }},
    Case{"KEY-11", K, "Another major revision", "R-CON-11", "Status 0x01, extended status 0x0116.", R, [](Bench& b) { misfits(b, [](cip::ElectronicKey& key) { key.major_revision ^= 0x40; }, 0x0116); }},
    Case{"KEY-12", K, "A higher minor revision", "R-CON-11", "Status 0x01, extended status 0x0116.", R, wrong_minor},
    Case{"KEY-13", K, "The own revision, compatible", "R-CON-11", "The compatibility bit asks for this revision or what can take its place.", R, [](Bench& b) { fits(b, [](cip::ElectronicKey& key) { key.major_revision |= compatible; }); }},
    Case{"KEY-14", K, "Another major revision, compatible", "R-CON-11", "The major revision must be the own: extended status 0x0116.", R, [](Bench& b) { misfits(b, [](cip::ElectronicKey& key) { key.major_revision = static_cast<std::uint8_t>((key.major_revision ^ 0x40) | compatible); }, 0x0116, Weight::soft); }},
    Case{"KEY-15", K, "A higher minor revision, compatible", "R-CON-11", "The minor revision must be at most the own: extended status 0x0116.", R, [](Bench& b) { misfits(b, [](cip::ElectronicKey& key) { key.major_revision |= compatible; key.minor_revision = 0xFF; }, 0x0116, Weight::soft); }},
    Case{"KEY-16", K, "The vendor is looked at first", "R-CON-11", "Where all is wrong the vendor is told: extended status 0x0114.", R, [](Bench& b) { misfits(b, [](cip::ElectronicKey& key) { key.vendor ^= 0x0F0F; key.device_type ^= 0x0F0F; key.major_revision ^= 0x40; }, 0x0114); }},
    Case{"KEY-17", K, "A format that is none", "R-PTH-5", "Status 0x01, extended status 0x0315.", R, [](Bench& b) { malformed(b, "34 77 00 00 00 00 00 00 00 00"); }},
    Case{"KEY-18", K, "A key in the wrong width", "R-PTH-5", "Status 0x01, extended status 0x0315.", R, [](Bench& b) { malformed(b, "35 04 00 00 00 00 00 00 00 00"); }},
    Case{"KEY-19", K, "The right key in front of an I/O connection", "R-CON-11", "Keys are the same for all connections.", R, [](Bench& b) { io_connection(b, nullptr, 0); }},
    Case{"KEY-20", K, "Another vendor in front of an I/O connection", "R-CON-11", "Status 0x01, extended status 0x0114.", R, [](Bench& b) { io_connection(b, [](cip::ElectronicKey& key) { key.vendor ^= 0x0F0F; }, 0x0114); }},
    Case{"KEY-21", K, "Another device type in front of an I/O connection", "R-CON-11", "Status 0x01, extended status 0x0115.", R, [](Bench& b) { io_connection(b, [](cip::ElectronicKey& key) { key.device_type ^= 0x0F0F; }, 0x0115); }},
    Case{"KEY-22", K, "Another major revision in front of an I/O connection", "R-CON-11", "Status 0x01, extended status 0x0116.", R, [](Bench& b) { io_connection(b, [](cip::ElectronicKey& key) { key.major_revision ^= 0x40; }, 0x0116); }},
    Case{"KEY-23", K, "The right key in front of a request", "R-PTH-10", "A key may lead the path of a request.", R, [](Bench& b) { explicit_request(b, nullptr, true); }},
    Case{"KEY-24", K, "Another vendor in front of a request", "R-ERR-12", "Status 0x25.", R, [](Bench& b) { explicit_request(b, [](cip::ElectronicKey& key) { key.vendor ^= 0x0F0F; }, false); }},
};
// clang-format on

}  // namespace

std::span<const Case> key_cases() { return cases; }

}  // namespace servobus::scanner::conformance
