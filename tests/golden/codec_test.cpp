// Every golden vector on TCP and UDP goes through the codecs down to its last layer and comes out octet by octet; those
// that are damaged on purpose are refused by the right decoder with the right error. What has been decoded is counted,
// so that nothing is skipped silently.
#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <set>
#include <string>

#include "assemblies/layout.hpp"
#include "assemblies/parameter_value.hpp"
#include "cip/forward_open.hpp"
#include "cip/message.hpp"
#include "cip/path.hpp"
#include "cip/request_path.hpp"
#include "cip/services.hpp"
#include "cip/unconnected_send.hpp"
#include "drive/xenax.hpp"
#include "enip/common_packet.hpp"
#include "enip/encapsulation.hpp"
#include "enip/frame_decoder.hpp"
#include "enip/messages.hpp"
#include "tests/support/golden.hpp"

namespace servobus {
namespace {

using cip::Bytes;
using cip::ByteView;
using test::error_of;
using test::golden_vectors;
using test::GoldenVector;
using test::hex;

/// How many octet strings of each kind have been decoded and encoded again.
using Count = std::map<std::string, unsigned>;

/// Walks down the layers of one vector.
class Walk {
public:
    Walk(const GoldenVector& vector, Count& count) : vector_(vector), count_(count) {}

    void encapsulation() {
        const auto frame = same<enip::Frame>("frame", vector_.octets);
        if (!frame) return;
        enip::FrameDecoder decoder;
        ByteView stream = vector_.octets;
        const auto message = decoder.next(stream);
        ASSERT_TRUE(message && !message->oversize && stream.empty());
        EXPECT_EQ(message->frame, *frame);
        payload(*frame);
    }

    void io_datagram() {
        const auto packet = same<enip::CommonPacket>("common packet", vector_.octets);
        ASSERT_TRUE(packet && packet->items.size() == 2);
        EXPECT_EQ(packet->items[0].type, enip::ItemType::sequenced_address);
        EXPECT_EQ(packet->items[0].data.size(), 8U);
        ASSERT_EQ(packet->items[1].type, enip::ItemType::connected_data);
        // Sequence count, and from the originator the run/idle header; then an image, or nothing for a heartbeat.
        const std::size_t head = vector_.is_request() ? 6 : 2;
        const auto size = packet->items[1].data.size();
        const bool heartbeat = size == 2;
        bool known = heartbeat;
        for (const auto& layout : assemblies::layouts()) {
            const bool direction = (layout.direction == assemblies::Direction::o_to_t) == vector_.is_request();
            known = known || (direction && size == head + layout.size());
        }
        EXPECT_TRUE(known) << size << " octets are no assembly with its head";
        ++count_["io datagram"];
    }

private:
    /// Decodes and encodes again. Nothing when the vector is damaged in this layer.
    template <class Message>
    std::optional<Message> same(const char* layer, ByteView octets) {
        const auto message = Message::parse(octets);
        return compare<Message>(layer, message, octets);
    }
    template <class Message>
    std::optional<Message> compare(const char* layer, const cip::Decoded<Message>& message, ByteView octets) {
        if (!message) {
            ADD_FAILURE() << layer << ": " << describe(message.error());
            return std::nullopt;
        }
        EXPECT_EQ(hex(message->encode()), hex(octets)) << layer;
        ++count_[layer];
        return *message;
    }

    void payload(const enip::Frame& frame) {
        switch (frame.command) {
            case enip::Command::register_session:
                if (!frame.data.empty()) same<enip::RegisterSession>("register session", frame.data);
                return;
            case enip::Command::list_identity:
            case enip::Command::list_services:
            case enip::Command::list_interfaces:
                if (!frame.data.empty()) items(frame.data);
                return;
            case enip::Command::send_rr_data:
            case enip::Command::send_unit_data:
                if (!frame.data.empty()) send_data(frame);
                return;
            case enip::Command::nop:
            case enip::Command::unregister_session:
                return;
        }
        EXPECT_TRUE(frame.data.empty()) << "an unknown command";
    }

    void items(ByteView data) {
        const auto packet = same<enip::CommonPacket>("common packet", data);
        if (!packet) return;
        for (const auto& item : packet->items) {
            if (item.type == enip::ItemType::identity) {
                same<enip::IdentityItem>("identity item", item.data);
            } else {
                ASSERT_EQ(item.type, enip::ItemType::service_information);
                same<enip::ServiceItem>("service item", item.data);
            }
        }
    }

    void send_data(const enip::Frame& frame) {
        const auto data = same<enip::SendData>("send data", frame.data);
        if (!data) return;
        for (const auto type : {enip::ItemType::sockaddr_o_to_t, enip::ItemType::sockaddr_t_to_o}) {
            if (const auto* item = data->packet.find(type)) same<enip::SocketAddress>("socket address", item->data);
        }
        if (frame.command == enip::Command::send_unit_data) {
            const auto message = enip::connected_message(*data);
            ASSERT_TRUE(message) << describe(message.error());
            EXPECT_EQ(enip::SendData::connected(message->connection_id, message->sequence, message->message), *data);
            return router(message->message);
        }
        const auto message = enip::unconnected_message(*data);
        if (vector_.name == "rrdata_wrong_item_req") {
            EXPECT_EQ(error_of(message), cip::DecodeError::bad_value);
            ++count_["refused item"];
            return;
        }
        ASSERT_TRUE(message) << describe(message.error());
        router(*message);
    }

    void router(ByteView message) { vector_.is_request() ? request(message) : response(message); }

    void request(ByteView message) {
        if (vector_.malformed && broken_path(message)) return;
        const auto request = same<cip::Request>("request", message);
        if (!request) return;
        const auto target = cip::RequestPath::parse(request->path.encode());
        ASSERT_TRUE(target) << describe(target.error());
        const auto class_id = target->class_id;
        if (class_id == cip::class_id::message_router && request->service == cip::service::multiple_service_packet) {
            for (const auto part : parts(request->data)) this->request(part);
        } else if (class_id == cip::class_id::connection_manager) {
            manager_request(*request);
        } else if (request->service == cip::service::set_attribute_single && target->attribute) {
            value(*target, request->data);
        }
    }

    bool broken_path(ByteView message) {
        const auto view = cip::RequestView::parse(message);
        if (vector_.name == "err_path_too_long_req") {
            EXPECT_EQ(error_of(view), cip::DecodeError::path_too_long);
        } else if (vector_.name == "err_bad_segment_req") {
            EXPECT_EQ(error_of(cip::Path::parse(view.value().path)), cip::DecodeError::bad_segment);
        } else {
            return false;
        }
        EXPECT_FALSE(cip::Request::parse(message));
        ++count_["refused path"];
        return true;
    }

    void manager_request(const cip::Request& request) {
        switch (request.service) {
            case cip::service::forward_open:
            case cip::service::large_forward_open: {
                const auto open =
                    cip::ForwardOpen::parse(request.data, request.service == cip::service::large_forward_open);
                if (vector_.malformed) {
                    EXPECT_EQ(vector_.name, "fo_short_req");
                    EXPECT_EQ(error_of(open), cip::DecodeError::truncated);
                    ++count_["refused forward open"];
                    return;
                }
                if (compare<cip::ForwardOpen>("forward open", open, request.data)) {
                    same<cip::Path>("connection path", open->path);
                }
                return;
            }
            case cip::service::forward_close:
                if (const auto close = same<cip::ForwardClose>("forward close", request.data)) {
                    same<cip::Path>("connection path", close->path);
                }
                return;
            case cip::service::unconnected_send:
                if (const auto send = same<cip::UnconnectedSend>("unconnected send", request.data)) {
                    same<cip::Path>("route", send->route_path);
                    this->request(send->message);
                }
                return;
            default:
                ADD_FAILURE() << "another service of the Connection Manager";
        }
    }

    void response(ByteView message) {
        const auto response = same<cip::Response>("response", message);
        if (!response) return;
        using namespace cip::service;
        if (response->service == multiple_service_packet) {
            for (const auto part : parts(response->data)) this->response(part);
        } else if (response->service == forward_open || response->service == large_forward_open) {
            if (response->status.ok()) {
                same<cip::ForwardOpenReply>("forward open reply", response->data);
            } else {
                same<cip::ConnectionRefusal>("refusal", response->data);
            }
        } else if (response->service == forward_close) {
            if (response->status.ok()) {
                same<cip::ForwardCloseReply>("forward close reply", response->data);
            } else {
                same<cip::ConnectionRefusal>("refusal", response->data);
            }
        } else if (response->service == get_attribute_single && response->status.ok()) {
            if (const auto target = asked()) value(*target, response->data);
        }
    }

    /// The request that this reply answers, as far as it is a plain one.
    std::optional<cip::RequestPath> asked() const {
        const auto* vector = test::find_golden_vector(vector_.reply_to);
        if (vector == nullptr) return std::nullopt;
        const auto frame = enip::Frame::parse(vector->octets).value();
        const auto data = enip::SendData::parse(frame.data).value();
        const auto message = frame.command == enip::Command::send_unit_data
                                 ? enip::connected_message(data).value().message
                                 : enip::unconnected_message(data).value();
        const auto request = cip::Request::parse(message).value();
        if (request.service != cip::service::get_attribute_single) return std::nullopt;
        return cip::RequestPath::parse(request.path.encode()).value();
    }

    /// The value of a drive parameter; a value of another length is left to the conversation, where it is refused.
    void value(const cip::RequestPath& target, ByteView octets) {
        const drive::Key key{static_cast<std::uint16_t>(target.class_id),
                             static_cast<std::uint16_t>(target.attribute.value_or(0))};
        const auto& rows = drive::parameters();
        const auto row = std::ranges::find(rows, key, &drive::Parameter::key);
        if (row == rows.end()) return;
        const auto value = assemblies::read_value(*row, octets);
        if (!value) {
            ++count_["refused value"];
            return;
        }
        Bytes again;
        cip::Writer writer(again);
        assemblies::write_value(writer, *row, *value);
        EXPECT_EQ(hex(again), hex(octets)) << row->name;
        ++count_["value"];
    }

    // R-MSG-16: a count, the offsets, and from each offset to the next a message.
    static std::vector<ByteView> parts(ByteView data) {
        cip::Reader reader(data);
        std::vector<std::size_t> offsets(reader.u16());
        for (auto& offset : offsets) offset = reader.u16();
        EXPECT_TRUE(reader.ok());
        offsets.push_back(data.size());
        std::vector<ByteView> parts;
        for (std::size_t i = 0; i + 1 < offsets.size(); ++i) {
            parts.push_back(data.subspan(offsets[i], offsets[i + 1] - offsets[i]));
        }
        return parts;
    }

    const GoldenVector& vector_;
    Count& count_;
};

TEST(Codec, golden_file_is_whole) {
    EXPECT_EQ(golden_vectors().size(), 284U);
    std::set<std::string> names;
    for (const auto& vector : golden_vectors()) {
        EXPECT_TRUE(names.insert(vector.name).second) << vector.name;
        EXPECT_EQ(vector.reply_to.empty(), test::find_golden_vector(vector.reply_to) == nullptr) << vector.name;
    }
}

TEST(Codec, every_golden_vector_decodes_and_encodes_to_the_same_octets) {
    Count count;
    for (const auto& vector : golden_vectors()) {
        SCOPED_TRACE(testing::PrintToString(vector));
        if (vector.transport == "eth") {
            ++count["ethernet"];  // ARP and DLR frames are not for these codecs
            continue;
        }
        Walk walk(vector, count);
        if (vector.is_io_datagram()) {
            walk.io_datagram();
        } else {
            ASSERT_TRUE(vector.is_encapsulation());
            walk.encapsulation();
        }
    }
    const Count expected{
        {"common packet", 19},
        {"connection path", 33},
        {"ethernet", 6},
        {"forward close", 5},
        {"forward close reply", 4},
        {"forward open", 28},
        {"forward open reply", 11},
        {"frame", 264},
        {"identity item", 2},
        {"io datagram", 14},
        {"refusal", 19},
        {"refused forward open", 1},
        {"refused item", 1},
        {"refused path", 2},
        {"refused value", 2},
        {"register session", 7},
        {"request", 125},
        {"response", 123},
        {"route", 3},
        {"send data", 240},
        {"service item", 2},
        {"socket address", 5},
        {"unconnected send", 3},
        {"value", 21},
    };
    EXPECT_EQ(count, expected);
    EXPECT_EQ(count["ethernet"] + count["io datagram"] + count["frame"], golden_vectors().size());
}

}  // namespace
}  // namespace servobus
