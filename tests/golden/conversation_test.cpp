// Each scene of the golden vectors as one conversation with a whole device. Every reply is compared octet by octet; the
// only octets that may differ are those that the file calls free: the session handle, and connection ids that the target
// chooses. Drive values are free too: they are set before the request, as the table below says.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cip/forward_open.hpp"
#include "cip/message.hpp"
#include "cip/services.hpp"
#include "tests/support/adapter_harness.hpp"
#include "tests/support/golden.hpp"

namespace servobus {
namespace {

using cip::Bytes;
using cip::ByteView;
using test::AdapterHarness;
using test::golden_vectors;
using test::GoldenVector;
using test::hex;

constexpr std::uint32_t example_session = 0x00010203;
constexpr std::uint32_t example_id_prefix = 0x56A0;  ///< upper half of the ids that the target chooses

// Every vector states in words what it takes for granted. What a device that has just been started does not have is set
// here, before the request.
struct Precondition {
    std::string_view request;
    std::string_view why;
    std::vector<std::pair<drive::Key, drive::Value>> values{};
    std::function<void(adapter::Network&)> network{};
    std::string_view sent_before{};  ///< a request of the same scene whose reply is not looked at
};

constexpr adapter::MacAddress peer_mac{0x02, 0x00, 0x00, 0x00, 0x00, 0x01};

adapter::InterfaceConfiguration example_interface() {
    adapter::InterfaceConfiguration interface;
    interface.address = AdapterHarness::local.address;
    interface.mask = 0xFFFFFF00;
    return interface;
}

adapter::LastConflict example_conflict() {
    // Activity 2, the other node's MAC, and the ARP request that it sent.
    const auto octets =
        test::octets("02 020000000001 0001 0800 06 04 0001 020000000001 C0A80264 000000000000 C0A80264");
    adapter::LastConflict conflict{};
    std::ranges::copy(octets, conflict.begin());
    return conflict;
}

const std::vector<Precondition>& preconditions() {
    constexpr auto actual = "an actual value of a running axis";
    constexpr auto chosen = "a value that somebody has set";
    constexpr auto state = "a state of the DS402 machine";
    static const std::vector<Precondition> table{
        {"get_64_1_5_iforce_req", actual, {{{0x64, 0x05}, -125}}},
        {"get_64_1_6_psr_req", actual, {{{0x64, 0x06}, 3}}},
        {"get_64_1_7_pdo_cycle_req", chosen, {{{0x64, 0x07}, 1000}}},
        {"get_64_1_8_motor_type_req",
         "not the motor of err_vendor_specific",
         {{{0x64, 0x08}, std::string("rotative")}}},
        {"get_64_1_9_limit_force_req", chosen, {{{0x64, 0x09}, -200'000}}},
        {"get_66_1_1_statusword_req", state, {{{0x66, 0x01}, 0x0250}}},
        {"get_66_1_0x24_position_req", actual, {{{0x66, 0x24}, 123'456}}},
        {"get_66_1_0xC3_version_req", "the version of the example's module", {{{0x66, 0xC3}, 0x000100A1}}},
        {"msp_req", state, {{{0x66, 0x01}, 0x0250}}},
        {"unconnected_send_req", state, {{{0x66, 0x01}, 0x0250}}},
        {"get_16bit_path_req", "actual values do not outlive the Reset before it", {{{0x64, 0x06}, 3}}},
        {"get_missing_attr_req", "set in this scene, but a Reset lies between", {{{0x64, 0x00}, 50}}},
        {"get_asm_100_data_req",
         actual,
         {{{0x66, 0x01}, 0x0237},
          {{0x66, 0x38}, 250},
          {{0x66, 0x24}, 123'456},
          {{0x64, 0x05}, -125},
          {{0x64, 0x06}, 3},
          {{0x66, 0xB4}, -2},
          {{0x66, 0xBD}, 5},
          {{0x66, 0xBF}, 1}}},
        {"get_asm_101_data_req", "R-ASM-2: what was written last", {}, {}, "set_asm_101_data_req"},
        {"class3_get_req", state, {{{0x66, 0x01}, 0x0250}}},
        {"get_f5_lastconflict_set_req",
         "after a conflict",
         {},
         [](auto& network) { network.settings.last_conflict = example_conflict(); }},
        {"gaa_f5_req",
         "as before the Sets of this scene, but for the host name",
         {},
         [](auto& network) {
             network.settings.method = adapter::AddressMethod::dhcp;
             network.state.interface = example_interface();
         }},
        {"gaa_dlr_req",
         "in a ring, not in a line",
         {},
         [](auto& network) {
             network.state.ring = {.topology = 1,
                                   .status = 0,
                                   .supervisor_address = AdapterHarness::peer.address,
                                   .supervisor_mac = peer_mac};
         }},
        {"file_wrong_number_req", "number 0 is expected after an Initiate_Upload", {}, {}, "file_init_upload_req"},
    };
    return table;
}

adapter::Network example_network() {
    adapter::Network network;
    network.state.interface = example_interface();
    return network;
}

adapter::DeviceFiles example_files() {
    constexpr std::string_view text = "[File]\r\nDescText = \"Golden vector\";\r\n";
    return {.eds = adapter::DeviceFile{.content = std::make_shared<const cip::Bytes>(text.begin(), text.end()),
                                       .name = "golden.eds"}};
}

std::uint32_t word_at(ByteView bytes, std::size_t offset) {
    return bytes.size() < offset + 4 ? 0 : cip::Reader(bytes.subspan(offset, 4)).u32();
}
void put_word(Bytes& bytes, std::size_t offset, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) bytes[offset + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

constexpr std::size_t session_offset = 4;
constexpr std::size_t connected_id_offset = 36;  ///< header, interface handle, timeout, item count, item header
constexpr std::size_t response_offset = 40;      ///< the same, and two items

constexpr std::size_t io_id_offset = 6;
constexpr unsigned first_io_scene = 5;

bool is_output_data(const GoldenVector& vector) { return vector.name.starts_with("io_o2t"); }

/// A scene: the device, and what its free octets are called in the vectors.
class Conversation {
public:
    explicit Conversation(unsigned scene) : scene_(scene) {
        // Scenes 1 to 3 are about sessions themselves.
        if (scene_ > 3) harness_.register_session();
    }

    /// What the device answers to a vector, in the vector's own free octets.
    Bytes ask(const GoldenVector& request) {
        prepare(request);
        if (request.transport == "udp") {
            auto replies = harness_.datagram(request.octets, request.broadcast);
            if (replies.empty()) return {};
            EXPECT_EQ(replies.size(), 1U);
            EXPECT_EQ(replies[0].peer, AdapterHarness::peer);
            return replies[0].octets;
        }
        harness_.send(to_device(request.octets));
        return harness_.take();
    }

    /// The device's octets as the vector would have them, where the vector's are free.
    Bytes to_vector(Bytes reply, const GoldenVector& expected) {
        if (reply.size() < enip::header_bytes) return reply;
        if (learns_session(expected)) {
            session_ = word_at(reply, session_offset);
            EXPECT_NE(session_, 0U);
        }
        if (session() != 0 && word_at(reply, session_offset) == session())
            put_word(reply, session_offset, example_session);
        for (const auto offset : {response_offset + 4, response_offset + 8}) {
            const auto example = word_at(expected.octets, offset);
            if (!opens(expected) || example >> 16 != example_id_prefix || reply.size() < offset + 4) continue;
            ids_[example] = word_at(reply, offset);
            put_word(reply, offset, example);
        }
        return reply;
    }

    /// A Reset ends all connections; whoever goes on speaking comes back.
    void carry_on() {
        // Connections of the later scenes would not outlive a second of silence.
        harness_.advance(scene_ < first_io_scene ? std::chrono::milliseconds(1000) : std::chrono::milliseconds(1));
        if (harness_.connected()) return;
        harness_.connect();
        harness_.register_session();
        session_.reset();
    }

    bool connected() const { return harness_.connected(); }

    /// A class 1 datagram, under the id that the device has chosen.
    void send_data(const GoldenVector& datagram) {
        auto octets = datagram.octets;
        const auto id = ids_.find(word_at(octets, io_id_offset));
        ASSERT_NE(id, ids_.end()) << "no connection has this id: " << datagram.name;
        put_word(octets, io_id_offset, id->second);
        harness_.io(octets);
    }

private:
    static bool learns_session(const GoldenVector& expected) { return expected.name == "register_session_rep"; }
    static bool opens(const GoldenVector& expected) {
        const auto& octets = expected.octets;
        return octets.size() >= response_offset + 30 && word_at(octets, 0) % 0x10000 == 0x006F &&
               (octets[response_offset] == 0xD4 || octets[response_offset] == 0xDB) && octets[response_offset + 2] == 0;
    }
    std::uint32_t session() const { return session_.value_or(harness_.session()); }

    void prepare(const GoldenVector& request) {
        for (const auto& entry : preconditions()) {
            if (entry.request != request.name) continue;
            if (entry.network) entry.network(harness_.adapter().network());
            for (const auto& [key, value] : entry.values) {
                auto& device = harness_.device();
                device.store().assign(*device.find(key), value);
            }
            if (entry.sent_before.empty()) continue;
            harness_.send(to_device(test::find_golden_vector(entry.sent_before)->octets));
            (void)harness_.take();
        }
    }

    Bytes to_device(Bytes request) const {
        if (word_at(request, session_offset) == example_session) put_word(request, session_offset, session());
        const bool connected = word_at(request, 0) % 0x10000 == 0x0070;
        const auto id = connected ? ids_.find(word_at(request, connected_id_offset)) : ids_.end();
        if (id != ids_.end()) put_word(request, connected_id_offset, id->second);
        return request;
    }

    unsigned scene_;
    AdapterHarness harness_{
        drive::Device(drive::xenax_models().front(), drive::Motor::linear), {}, example_network(), example_files()};
    std::optional<std::uint32_t> session_;        ///< when the scene has registered itself
    std::map<std::uint32_t, std::uint32_t> ids_;  ///< the vectors' to the device's
};

const GoldenVector* reply_of(const GoldenVector& request) {
    for (const auto& vector : golden_vectors()) {
        if (vector.reply_to == request.name) return &vector;
    }
    return nullptr;
}

class Scene : public testing::TestWithParam<unsigned> {};

TEST_P(Scene, is_answered_octet_by_octet) {
    Conversation conversation(GetParam());
    for (const auto& request : golden_vectors()) {
        if (request.scene != GetParam()) continue;
        if (is_output_data(request)) conversation.send_data(request);
        if (!request.is_request() || !request.is_encapsulation()) continue;
        SCOPED_TRACE(testing::PrintToString(request));
        auto reply = conversation.ask(request);
        const auto* expected = reply_of(request);
        if (expected == nullptr) {
            EXPECT_EQ(hex(reply), "") << "there is no answer to this";
            EXPECT_EQ(conversation.connected(), request.name != "unregister_session");
            continue;
        }
        reply = conversation.to_vector(std::move(reply), *expected);
        EXPECT_EQ(hex(reply), hex(expected->octets)) << expected->meaning;
        conversation.carry_on();
    }
}

INSTANTIATE_TEST_SUITE_P(Golden, Scene, testing::Range(1U, 16U),
                         [](const auto& each) { return "scene_" + std::to_string(each.param); });

// Whoever adds a vector or a precondition sees here what that changes.
TEST(Conversation, every_request_is_answered) {
    unsigned answered = 0;
    unsigned data = 0;
    std::set<std::string> names;
    for (const auto& vector : golden_vectors()) {
        names.insert(vector.name);
        if (vector.is_request() && vector.is_encapsulation()) ++answered;
        if (is_output_data(vector)) ++data;
    }
    EXPECT_EQ(answered, 133U);
    EXPECT_EQ(data, 9U);
    for (const auto& entry : preconditions()) {
        EXPECT_TRUE(names.contains(std::string(entry.request))) << entry.request;
        EXPECT_FALSE(entry.why.empty()) << entry.request;
    }
}

}  // namespace
}  // namespace servobus
