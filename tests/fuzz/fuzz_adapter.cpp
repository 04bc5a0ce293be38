// A TCP stream into a whole device, and its pieces as datagrams of class 1. The first octet chooses the piece size, the
// second how long a piece takes. The session handle and the connection ids of the golden vectors stand for those that are
// open here.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "cip/wire.hpp"
#include "tests/fuzz/device_site.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using std::chrono::milliseconds;

constexpr std::uint32_t example_session = 0x00010203;
constexpr std::uint32_t example_connection = 0x56A0000B;
constexpr std::uint32_t example_owner = 0x56A00001;   // of 101/100
constexpr std::uint32_t example_looker = 0x56A00008;  // with a heartbeat

/// A device with one TCP connection, a session, a class 3 connection, an owner and one who looks on.
class Listener {
public:
    explicit Listener(adapter::Limits limits) : site_(limits), id_(site_.connect().value()) {
        test::require(site_.register_session(id_), "the first gets a session");
        session_ = site_.session(id_);
        connection_ = open("0A00 4D00 44332211 02 000000 80841E00 F443 80841E00 F443 A3 02 20 02 24 01");
        owner_ = open("0100 4D00 44332211 00 000000 E8030000 1848 E8030000 1E28 11 04 20 04 24 01 2C 65 2C 64");
        looker_ = open("0200 4D00 44332211 00 000000 E8030000 0248 E8030000 1E28 11 04 20 04 24 01 2C FE 2C 64");
    }

    void hear(cip::ByteView stream, std::size_t piece_octets, milliseconds pause) {
        const auto octets = with_own_numbers(stream);
        site_.send_datagram(octets, false);
        site_.send_datagram(octets, true);
        in_pieces(octets, piece_octets, [&](cip::ByteView piece) {
            site_.send_io(piece);
            site_.send_io(piece, 1);
            site_.advance(pause / 16);
        });
        in_pieces(octets, piece_octets, [&](cip::ByteView piece) {
            (void)site_.send(id_, piece);
            site_.advance(pause);
        });
        site_.leave();
    }

private:
    std::uint32_t open(std::string_view rest) {
        const auto request = test::octets("54 02 20 06 24 01 0A 0E 00000000 0A00110A" + std::string(rest));
        const auto response = site_.call(id_, request);
        test::require(response->status.ok(), "a good connection opens", request);
        return cip::ForwardOpenReply::parse(response->data)->o_to_t_id;
    }

    static void in_pieces(cip::ByteView octets, std::size_t piece_octets, const auto& each) {
        while (!octets.empty()) {
            const auto piece = octets.first(std::min(piece_octets, octets.size()));
            each(piece);
            octets = octets.subspan(piece.size());
        }
    }

    [[nodiscard]] cip::Bytes with_own_numbers(cip::ByteView stream) const {
        cip::Bytes octets(stream.begin(), stream.end());
        for (std::size_t i = 0; i + 4 <= octets.size(); ++i) {
            const auto number = own(cip::Reader(cip::ByteView(octets).subspan(i, 4)).u32());
            for (std::size_t k = 0; k < 4; ++k) octets[i + k] = static_cast<std::uint8_t>(number >> (8 * k));
        }
        return octets;
    }
    [[nodiscard]] std::uint32_t own(std::uint32_t number) const {
        switch (number) {
            case example_session:
                return session_;
            case example_connection:
                return connection_;
            case example_owner:
                return owner_;
            case example_looker:
                return looker_;
            default:
                return number;
        }
    }

    DeviceSite site_;
    DeviceSite::Id id_;
    std::uint32_t session_ = 0;
    std::uint32_t connection_ = 0;
    std::uint32_t owner_ = 0;
    std::uint32_t looker_ = 0;
};

}  // namespace

void adapter(cip::ByteView input) {
    if (input.size() < 2) return;
    adapter::Limits limits;
    limits.queued_bytes = 2000;  // few, so that they are reached
    Listener(limits).hear(input.subspan(2), input[0] + std::size_t{1}, milliseconds(input[1]));
}

}  // namespace servobus::fuzz
