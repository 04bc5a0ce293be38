// The whole target without sockets: encapsulation, sessions, CIP objects, over one drive (decision 2).
//
//     drive::Device device(drive::xenax_models().front());
//     adapter::Adapter adapter(device, adapter::Limits{}, seed);
//     auto id = adapter.on_open(peer, local, now);
//     adapter.on_octets(*id, request, now);
//     auto reply = adapter.take_replies(*id);
#pragma once

#include <boost/system/result.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "adapter/access_gate.hpp"
#include "adapter/access_log.hpp"
#include "adapter/address_rivalry.hpp"
#include "adapter/allow_list.hpp"
#include "adapter/connection_manager.hpp"
#include "adapter/device_files.hpp"
#include "adapter/drive_io.hpp"
#include "adapter/firmware_unit.hpp"
#include "adapter/identity_object.hpp"
#include "adapter/limits.hpp"
#include "adapter/log.hpp"
#include "adapter/network_faults.hpp"
#include "adapter/network_settings.hpp"
#include "adapter/network_state.hpp"
#include "adapter/session.hpp"
#include "adapter/state_keeper.hpp"
#include "adapter/status_lights.hpp"
#include "adapter/stored_state.hpp"
#include "adapter/timetable.hpp"
#include "cip/message_router.hpp"
#include "drive/device.hpp"
#include "enip/encapsulation.hpp"
#include "enip/frame_decoder.hpp"
#include "enip/messages.hpp"
#include "enip/target.hpp"

namespace servobus::adapter {

class FileObject;
class TimeSyncObject;
struct TimeSync;

/// Why the address is to be given up.
enum class AddressChange : std::uint8_t { set, restart };

class Adapter final : public enip::Target {
public:
    /// The device must outlive the adapter. `seed` chooses session handles, connection ids and broadcast delays; the
    /// same seed and the same input give the same octets. `files` are what the File object hands out.
    Adapter(drive::Device& device, Limits limits, std::uint64_t seed, LogSink log = {}, Network network = {},
            DeviceFiles files = {});
    ~Adapter() override;
    Adapter(const Adapter&) = delete;
    Adapter& operator=(const Adapter&) = delete;

    [[nodiscard]] std::optional<ConnectionId> on_open(enip::Endpoint peer, enip::Endpoint local,
                                                      enip::Time now) override;
    [[nodiscard]] std::size_t on_octets(ConnectionId id, cip::ByteView octets, enip::Time now) override;
    [[nodiscard]] cip::Bytes take_replies(ConnectionId id) override;
    [[nodiscard]] bool wants_close(ConnectionId id) const override;
    void on_closed(ConnectionId id, enip::Time now) override;
    void on_datagram(enip::Endpoint peer, enip::Endpoint local, bool broadcast, cip::ByteView octets,
                     enip::Time now) override;
    [[nodiscard]] std::vector<enip::Datagram> take_datagrams() override;
    [[nodiscard]] std::uint8_t explicit_dscp() const override { return explicit_dscp_; }
    void on_io(enip::Endpoint peer, enip::Endpoint local, cip::ByteView octets, enip::Time now) override;
    [[nodiscard]] bool io_may_wait() const override { return manager_->io().tells_at_deadlines(); }
    [[nodiscard]] enip::IoQueue& io_queue() override { return io_queue_; }
    void on_timer(enip::Time now) override;
    [[nodiscard]] std::optional<enip::Time> next_deadline() const override;
    void on_day_clock(std::chrono::nanoseconds ahead) override { day_ahead_ = ahead; }
    [[nodiscard]] std::vector<ConnectionId> take_expired() override;
    [[nodiscard]] std::vector<ConnectionId> take_ready() override;

    /// What a Set of address or method does to the device's address (R-TCP-6): called when all connections are closed, a
    /// moment after the reply, and at each restart. Without it the settings are applied by apply_address_settings().
    void on_address_change(std::function<void(AddressChange)> change) { change_address_ = std::move(change); }
    /// All connections end, class 1 too, because the device gives its address up.
    void give_address_up();

    /// The firmware of the module. A download begins, or why it does not: a clause. What it has written runs after the next
    /// power cycle or reset. The server has to look at next_deadline() afterwards.
    [[nodiscard]] std::optional<std::string> download(const FlashImage& image, enip::Time now);
    /// The image as if it had been there at power-on, or why not; before anybody is served.
    [[nodiscard]] std::optional<std::string> install(const FlashImage& image);
    [[nodiscard]] const FirmwareUnit& firmware() const { return firmware_; }
    /// Who makes the data sheet of a device with another revision. Without it the data sheet stays as it is.
    using MakeSheet = std::function<DeviceFile(const drive::Identity&)>;
    void on_revision(MakeSheet make) { make_sheet_ = std::move(make); }

    /// Who may do what from now on.
    void protect(Protection protection) { gate_.protect(protection); }
    /// Who may be here at all: others are not connected, not answered and not listened to.
    void allow(AllowList allowed) { allowed_ = std::move(allowed); }
    /// Who wants a line about each access that changes something or is refused.
    void on_access(LineSink sink) { access_log_.listen(std::move(sink)); }
    struct StrangerCounters {
        std::uint64_t connections = 0;
        std::uint64_t requests = 0;   ///< by UDP
        std::uint64_t datagrams = 0;  ///< of class 0 and 1
    };
    [[nodiscard]] const StrangerCounters& strangers() const { return strangers_; }

    /// Who makes durable what is kept over power-off, one state at a time, and says on_stored() when that is done. Replies
    /// to writes wait for it. Without, what is kept lives in memory.
    void store_with(StateKeeper::Sink sink) { keeper_.write_with(std::move(sink)); }
    /// The state that was handed out last is durable, or could not be made so: then what was written since the one before
    /// is taken back, and those writes are answered with 0x19. The server has to look at take_ready() afterwards.
    void on_stored(bool ok, enip::Time now);
    /// The device comes up with what was kept; before anybody is served.
    void power_up_with(const StoredState& state);
    /// What was kept could not be used: the Identity tells so until something is stored, or the next power-up.
    void report_bad_configuration() { configuration_bad_ = true; }
    /// What is kept, as it will be when everything is durable; and as it is before anybody has written anything.
    [[nodiscard]] const StoredState& kept() const { return keeper_.newest(); }
    [[nodiscard]] const StoredState& delivered() const { return delivered_; }
    /// Something of that is not durable yet.
    [[nodiscard]] bool is_storing() const { return keeper_.waits(); }
    /// What the Identity object makes its status of.
    [[nodiscard]] DeviceCondition condition() const;

    /// What happens to the drive while it runs. The timetable's clock starts at the first `now` that the adapter is
    /// given, which is when the server starts to serve.
    void play(Timetable timetable) { playback_ = Playback(std::move(timetable)); }
    /// Something happens to the drive or its network now. The server has to look at next_deadline() afterwards. False:
    /// there are too many faults already.
    bool inject(const Happening& event, enip::Time now);
    /// Brings the drive, and what the timetable has for it, to `now`.
    void advance(enip::Time now);
    /// The time on the timetable's clock.
    [[nodiscard]] drive::Time elapsed(enip::Time now) const;

    /// Ends every session in order: nothing more is answered, and all connections are reported as expired.
    void shut_down();

    [[nodiscard]] const Limits& limits() const { return limits_; }
    [[nodiscard]] std::size_t tcp_connections() const { return connections_.size(); }
    [[nodiscard]] std::size_t sessions() const { return sessions_.size(); }
    /// The handle of each session and whose it is.
    [[nodiscard]] std::vector<std::pair<std::uint32_t, enip::Endpoint>> open_sessions() const;
    [[nodiscard]] std::size_t class3_connections() const { return manager_->explicit_connections().size(); }
    /// The I/O connections, for those who look at them.
    [[nodiscard]] const IoConnections& io() const { return manager_->io(); }
    [[nodiscard]] const ConnectionManager& connection_manager() const { return *manager_; }
    /// The device has a Time Sync object from now on, which tells what is known there; that outlives the adapter. Before
    /// anybody is served.
    void follow_time(const TimeSync& known);
    /// Who tells how much of a CPU the device uses, in tenths of a percent: attribute 11 of the Connection Manager.
    void measure_cpu(std::function<std::uint16_t()> measure) { measure_cpu_ = std::move(measure); }
    /// What the lights of the module tell, and what they show of it.
    [[nodiscard]] ModuleState module_state() const;
    [[nodiscard]] StatusLights lights() const { return status_lights(module_state()); }
    /// What is wrong with the network on purpose.
    [[nodiscard]] const NetworkFaults& faults() const { return faults_; }
    /// Faults that leave something to chance repeat with this number. Before any of them.
    void seed_faults(std::uint64_t seed) { faults_ = NetworkFaults(seed); }
    [[nodiscard]] drive::Device& device() { return device_; }
    [[nodiscard]] const drive::Device& device() const { return device_; }
    /// The values behind the network objects; whoever knows the host's address writes it here.
    [[nodiscard]] Network& network() { return network_; }

private:
    struct Connection;
    struct Reset {
        ResetType type;
        StateKeeper::Generation waits_for;  ///< the reply does, and what is kept then is what comes up
        std::optional<enip::Time> due;
    };
    struct DelayedReply {
        enip::Time due;
        enip::Datagram datagram;
    };

    void build_objects();
    [[nodiscard]] Resources resources() const;
    void build_time_objects();
    [[nodiscard]] std::chrono::nanoseconds system_time_ahead() const;
    [[nodiscard]] std::optional<OpenRefusal> refuse_open(const cip::ForwardOpen& open);
    void advance_firmware(enip::Time now);
    void start_firmware();
    void tell_revision(Revision revision);
    /// In factory mode nobody speaks EtherNet/IP.
    [[nodiscard]] bool is_mute() const { return faults_.is_silent() || firmware_.is_in_factory_mode(); }
    [[nodiscard]] bool make_room();
    [[nodiscard]] Connection* longest_silent(const std::function<bool(const Connection&)>& condition) const;
    void expire(Connection& connection);
    void on_message(Connection& connection, const enip::FrameDecoder::Result& message, enip::Time now);
    [[nodiscard]] std::optional<enip::Frame> answer(Connection& connection, const enip::Frame& request, enip::Time now);
    [[nodiscard]] enip::Frame register_session(const Connection& connection, const enip::Frame& request);
    [[nodiscard]] std::optional<enip::Frame> unregister_session(Connection& connection, const enip::Frame& request);
    [[nodiscard]] boost::system::result<enip::SendDataView, enip::EncapsulationStatus> session_data(
        const Connection& connection, const enip::Frame& request) const;
    [[nodiscard]] cip::Origin origin_of(const Connection& connection, enip::Time now) const;
    [[nodiscard]] enip::Frame send_rr_data(const Connection& connection, const enip::Frame& request, enip::Time now);
    [[nodiscard]] std::optional<enip::Frame> send_unit_data(const Connection& connection, const enip::Frame& request,
                                                            enip::Time now);
    [[nodiscard]] enip::Frame list(const enip::Frame& request, enip::Endpoint local) const;
    [[nodiscard]] bool delay(enip::Datagram datagram, const enip::Frame& request, enip::Time now);
    [[nodiscard]] cip::GeneralStatus grant_reset(ResetType type);
    [[nodiscard]] StoredState after_reset(ResetType type) const;
    void schedule_reset(enip::Time now);
    void schedule_address(enip::Time now);
    void reset(enip::Time now);
    void restart();
    void come_up();
    void end_connections();
    void note_changes();
    void take_back();
    void refuse_waiting_replies();
    void apply_address(AddressChange change);
    void change_address(enip::Time now);
    bool apply(const Happening& event, enip::Time now);
    bool begin(const NetworkFault& fault, enip::Time now);
    void suffer(const fault::ClaimAddress& claim, enip::Time now);
    void note_lights();
    [[nodiscard]] bool is_stranger(enip::Endpoint peer, std::uint64_t& count, std::string_view way, enip::Time now);
    [[nodiscard]] bool io_is_due_by(enip::Time time) const;
    void take_messages(Connection& connection, cip::ByteView& rest, enip::Time now);
    void hold_octets(Connection& connection, cip::ByteView octets);
    void take_held_octets(enip::Time now);
    void take_late_io(enip::Time now);
    void send_reply(Connection& connection, const enip::Frame& reply, StateKeeper::Generation waits_for,
                    enip::Time now);
    [[nodiscard]] bool may_leave(const Connection& connection, enip::Time now) const;
    void send_late_replies(Connection& connection, enip::Time now);
    void produce(enip::Time now);
    [[nodiscard]] std::optional<enip::Time> deadline_of(const Connection& connection) const;

    drive::Device& device_;
    Limits limits_;
    Network network_;
    DeviceFiles files_;
    Log log_;
    std::mt19937_64 random_;
    SessionTable sessions_;
    FirmwareUnit firmware_;
    MakeSheet make_sheet_;
    AccessLog access_log_;
    AccessGate gate_;
    AllowList allowed_;
    StrangerCounters strangers_{};
    cip::MessageRouter router_;
    IdentityObject* identity_ = nullptr;  ///< owned by router_
    FileObject* file_object_ = nullptr;   ///< owned by router_
    std::unique_ptr<DriveIo> drive_io_;
    ConnectionManager* manager_ = nullptr;        ///< owned by router_
    const TimeSync* time_sync_ = nullptr;         ///< null: the device has no Time Sync object
    TimeSyncObject* time_sync_object_ = nullptr;  ///< owned by router_
    std::chrono::nanoseconds day_ahead_{0};       ///< of the clock that `now` is of
    std::map<ConnectionId, std::unique_ptr<Connection>> connections_;
    ConnectionId last_id_ = 0;
    enip::IoQueue io_queue_;
    std::vector<enip::Datagram> datagrams_;
    std::vector<DelayedReply> delayed_;
    std::vector<ConnectionId> expired_;
    std::vector<ConnectionId> ready_;
    ModuleState shown_{};  ///< by the lights, when the log was last told of them
    NetworkFaults faults_;
    enip::IoQueue produced_;     ///< on its way through faults
    bool holds_octets_ = false;  ///< of some connection
    std::optional<Reset> reset_{};
    StoredState delivered_;
    StateKeeper keeper_;
    bool configuration_bad_ = false;
    std::uint64_t resets_granted_ = 0;
    std::uint64_t noted_writes_ = 0;  ///< of the device, that keeper_ knows of
    bool moves_ = false;              ///< the device did at the last step
    bool came_to_rest_ = false;       ///< since keeper_ was told: a command may have changed what is kept
    FirmwareUnit::Flash noted_flash_;
    std::uint8_t explicit_dscp_ = 0;
    std::optional<StateKeeper::Generation> wants_address_{};  ///< the reply of the Set waits for it
    std::optional<enip::Time> address_due_{};
    std::function<void(AddressChange)> change_address_;
    AddressRivalry rivalry_{network_};
    std::function<std::uint16_t()> measure_cpu_;
    Playback playback_;
};

}  // namespace servobus::adapter
