#include "adapter/ptp_management.hpp"

#include "cip/wire.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint8_t management_message = 0x0D;
constexpr std::uint8_t version = 2;
constexpr std::uint8_t management_control = 4;
constexpr std::uint8_t no_interval = 0x7F;
constexpr std::uint8_t get_action = 0;
constexpr std::uint8_t response_action = 2;
constexpr std::uint8_t slave_only_flag = 0x02;
constexpr std::uint16_t management_tlv = 0x0001;
constexpr std::uint16_t management_error_tlv = 0x0002;

constexpr std::size_t correction_octets = 8;
constexpr std::size_t type_specific_octets = 4;
constexpr std::size_t message_octets = 48;  // header and management fields, before the TLV
constexpr std::size_t tlv_header_octets = 4;
constexpr std::size_t id_octets = 2;
constexpr std::size_t identity_octets = 8;

// Who asks is no PTP node: an identity of zeros is nobody's.
constexpr std::uint16_t asking_port = 1;

ClockIdentity read_identity(cip::Reader& reader) {
    ClockIdentity identity{};
    reader.field(identity);
    return identity;
}

PortIdentity read_port_identity(cip::Reader& reader) {
    const auto clock = read_identity(reader);
    return {clock, reader.big<std::uint16_t>()};
}

ClockQuality read_quality(cip::Reader& reader) {
    ClockQuality quality;
    quality.clock_class = reader.u8();
    quality.accuracy = reader.u8();
    quality.variance = reader.big<std::uint16_t>();
    return quality;
}

// PTPText (5.3.9).
std::string read_text(cip::Reader& reader) {
    const auto octets = reader.take(reader.u8());
    return {octets.begin(), octets.end()};
}

cip::Bytes read_octets(cip::Reader& reader) {
    const auto octets = reader.take(reader.big<std::uint16_t>());
    return {octets.begin(), octets.end()};
}

template <class T>
std::optional<T> whole(const cip::Reader& reader, T value) {
    return reader.ok() ? std::optional(std::move(value)) : std::nullopt;
}

}  // namespace

cip::Bytes encode(const ManagementQuestion& question) {
    cip::Bytes message;
    cip::Writer writer(message);
    writer.u8(management_message);
    writer.u8(version);
    writer.big(static_cast<std::uint16_t>(message_octets + tlv_header_octets + id_octets));
    writer.u8(question.domain);
    writer.zeros(1);
    writer.big(std::uint16_t{0});  // flags
    writer.zeros(correction_octets + type_specific_octets);
    writer.zeros(identity_octets);
    writer.big(asking_port);
    writer.big(question.sequence);
    writer.u8(management_control);
    writer.u8(no_interval);
    writer.bytes(ClockIdentity{0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF});  // whoever it is
    writer.big(question.port);
    writer.zeros(2);  // boundary hops: the question goes no farther
    writer.u8(get_action);
    writer.zeros(1);
    writer.big(management_tlv);
    writer.big(static_cast<std::uint16_t>(id_octets));
    writer.big(question.id);
    return message;
}

std::optional<ManagementAnswer> decode_answer(cip::ByteView message) {
    cip::Reader reader(message);
    const auto type = reader.u8();
    const auto spoken = reader.u8();
    const auto length = reader.big<std::uint16_t>();
    if ((type & 0x0F) != management_message || (spoken & 0x0F) != version) return std::nullopt;
    if (length > message.size() || length < message_octets) return std::nullopt;
    reader = cip::Reader(message.first(length));
    constexpr std::size_t before_sequence = 30;
    constexpr std::size_t before_action = 14;  // from the sequence on
    constexpr std::size_t sequence_octets = 2;
    reader.take(before_sequence);
    ManagementAnswer answer;
    answer.sequence = reader.big<std::uint16_t>();
    reader.take(before_action);
    if ((reader.u8() & 0x0F) != response_action) return std::nullopt;
    reader.take(1);
    static_assert(before_sequence + sequence_octets + before_action + 2 == message_octets);
    const auto tlv = reader.big<std::uint16_t>();
    const auto tlv_octets = reader.big<std::uint16_t>();
    auto body = cip::Reader(reader.take(tlv_octets));
    if (tlv == management_error_tlv) {
        answer.refused = true;
        body.take(id_octets);  // of the error
    } else if (tlv != management_tlv) {
        return std::nullopt;
    }
    answer.id = body.big<ManagementId>();
    answer.data = body.rest();
    if (!reader.ok() || !body.ok()) return std::nullopt;
    return answer;
}

std::optional<DefaultDataSet> decode_default_data_set(cip::ByteView data) {
    cip::Reader reader(data);
    DefaultDataSet set;
    set.slave_only = (reader.u8() & slave_only_flag) != 0;
    reader.take(1);
    set.ports = reader.big<std::uint16_t>();
    set.priority_1 = reader.u8();
    set.quality = read_quality(reader);
    set.priority_2 = reader.u8();
    set.identity = read_identity(reader);
    set.domain = reader.u8();
    return whole(reader, set);
}

std::optional<CurrentDataSet> decode_current_data_set(cip::ByteView data) {
    cip::Reader reader(data);
    CurrentDataSet set;
    set.steps_removed = reader.big<std::uint16_t>();
    set.offset_from_master = reader.big<std::int64_t>();
    set.mean_path_delay = reader.big<std::int64_t>();
    return whole(reader, set);
}

std::optional<ParentDataSet> decode_parent_data_set(cip::ByteView data) {
    cip::Reader reader(data);
    ParentDataSet set;
    set.parent = read_port_identity(reader);
    reader.take(2);  // statistics, reserved
    set.observed_variance = reader.big<std::uint16_t>();
    set.observed_phase_change_rate = reader.big<std::uint32_t>();
    set.grandmaster_priority_1 = reader.u8();
    set.grandmaster_quality = read_quality(reader);
    set.grandmaster_priority_2 = reader.u8();
    set.grandmaster = read_identity(reader);
    return whole(reader, set);
}

std::optional<TimePropertiesDataSet> decode_time_properties(cip::ByteView data) {
    cip::Reader reader(data);
    TimePropertiesDataSet set;
    set.utc_offset = reader.big<std::int16_t>();
    set.flags = reader.u8();
    set.time_source = reader.u8();
    return whole(reader, set);
}

std::optional<PortDataSet> decode_port_data_set(cip::ByteView data) {
    cip::Reader reader(data);
    PortDataSet set;
    set.identity = read_port_identity(reader);
    set.state = reader.big<PtpPortState>();
    reader.take(1 + sizeof(std::int64_t));  // interval of delay requests, delay to the peer
    set.log_announce_interval = reader.big<std::int8_t>();
    reader.take(1);  // timeout
    set.log_sync_interval = reader.big<std::int8_t>();
    return whole(reader, set);
}

std::optional<ClockDescription> decode_clock_description(cip::ByteView data) {
    cip::Reader reader(data);
    ClockDescription description;
    description.clock_type = reader.big<std::uint16_t>();
    description.physical_protocol = read_text(reader);
    description.physical_address = read_octets(reader);
    description.network_protocol = reader.big<std::uint16_t>();
    description.protocol_address = read_octets(reader);
    reader.take(4);                        // manufacturer, reserved
    static_cast<void>(read_text(reader));  // product
    static_cast<void>(read_text(reader));  // revision
    description.user_description = read_text(reader);
    reader.field(description.profile);
    return whole(reader, std::move(description));
}

}  // namespace servobus::adapter
