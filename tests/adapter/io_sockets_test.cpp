// Class 1 over the sockets of this machine: several devices in one server, and as a program.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <memory>
#include <thread>

#include "adapter/adapter.hpp"
#include "cip/forward_open.hpp"
#include "drive/xenax.hpp"
#include "enip/asio/target_server.hpp"
#include "enip/io_packet.hpp"
#include "enip/messages.hpp"
#include "tests/support/octets.hpp"

namespace servobus::test {
namespace {

using namespace std::chrono_literals;

// Addresses that no other test uses.
constexpr std::uint32_t first_device = 0x7F002A01;   // 127.0.42.1
constexpr std::uint32_t second_device = 0x7F002A02;  // 127.0.42.2
constexpr std::uint32_t originator = 0x7F002A64;     // 127.0.42.100
constexpr int patience_ms = 5000;

sockaddr_in native(enip::Endpoint endpoint) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(endpoint.port);
    address.sin_addr.s_addr = htonl(endpoint.address);
    return address;
}
std::string text_of(std::uint32_t address) {
    const auto text = enip::to_string({address, 0});
    return text.substr(0, text.find(':'));
}

/// A plain blocking socket that shares no code with the server.
class Udp {
public:
    explicit Udp(enip::Endpoint local, bool shared = false)
        : descriptor_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
        const int on = 1;
        if (shared) ::setsockopt(descriptor_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
        const auto address = native(local);
        bound_ = ::bind(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
        sockaddr_in own{};
        socklen_t size = sizeof own;
        ::getsockname(descriptor_, reinterpret_cast<sockaddr*>(&own), &size);
        local_ = {ntohl(own.sin_addr.s_addr), ntohs(own.sin_port)};
    }
    ~Udp() { ::close(descriptor_); }
    Udp(const Udp&) = delete;
    Udp& operator=(const Udp&) = delete;

    bool bound() const { return bound_; }
    enip::Endpoint local() const { return local_; }
    bool join(std::uint32_t group, std::uint32_t interface) const {
        ip_mreq request{};
        request.imr_multiaddr.s_addr = htonl(group);
        request.imr_interface.s_addr = htonl(interface);
        return ::setsockopt(descriptor_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request) == 0;
    }
    void send(enip::Endpoint to, const cip::Bytes& octets) const {
        const auto address = native(to);
        EXPECT_EQ(::sendto(descriptor_, octets.data(), octets.size(), 0, reinterpret_cast<const sockaddr*>(&address),
                           sizeof address),
                  static_cast<ssize_t>(octets.size()));
    }
    struct Received {
        enip::Endpoint from;
        cip::Bytes octets;
    };
    std::optional<Received> receive() const {
        pollfd entry{descriptor_, POLLIN, 0};
        if (::poll(&entry, 1, patience_ms) <= 0) return std::nullopt;
        cip::Bytes octets(2000);
        sockaddr_in from{};
        socklen_t size = sizeof from;
        const auto got =
            ::recvfrom(descriptor_, octets.data(), octets.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
        if (got < 0) return std::nullopt;
        octets.resize(static_cast<std::size_t>(got));
        return Received{{ntohl(from.sin_addr.s_addr), ntohs(from.sin_port)}, octets};
    }

private:
    int descriptor_;
    bool bound_ = false;
    enip::Endpoint local_{};
};

/// A TCP connection from an address of one's own.
class Stream {
public:
    explicit Stream(enip::Endpoint device, std::uint32_t from = originator)
        : descriptor_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        const auto own = native({from, 0});
        const auto peer = native(device);
        connected_ = ::bind(descriptor_, reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0 &&
                     ::connect(descriptor_, reinterpret_cast<const sockaddr*>(&peer), sizeof peer) == 0;
    }
    ~Stream() { ::close(descriptor_); }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    bool send(const cip::Bytes& octets) const {
        return connected_ &&
               ::send(descriptor_, octets.data(), octets.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(octets.size());
    }
    /// The next frame, which nothing follows.
    std::optional<enip::Frame> receive() const {
        cip::Bytes answer;
        while (true) {
            const auto frame = enip::Frame::parse(answer);
            if (frame) return *frame;
            pollfd entry{descriptor_, POLLIN, 0};
            std::array<std::uint8_t, 4096> part{};
            if (::poll(&entry, 1, patience_ms) <= 0) return std::nullopt;
            const auto got = ::recv(descriptor_, part.data(), part.size(), 0);
            if (got <= 0) return std::nullopt;
            answer.insert(answer.end(), part.begin(), part.begin() + got);
        }
    }

private:
    int descriptor_;
    bool connected_ = false;
};

/// A session on such a connection.
class Session {
public:
    explicit Session(enip::Endpoint device) : stream_(device) {
        const auto reply =
            exchange({.command = enip::Command::register_session, .data = enip::RegisterSession{}.encode()});
        if (reply) session_ = reply->session;
    }

    struct Answer {
        cip::Bytes message;
        std::vector<enip::Item> items;
    };
    Answer ask(const cip::Bytes& message, const std::vector<enip::Item>& items = {}) {
        auto data = enip::SendData::unconnected(message);
        data.packet.items.insert(data.packet.items.end(), items.begin(), items.end());
        const auto reply =
            exchange({.command = enip::Command::send_rr_data, .session = session_, .data = data.encode()});
        const auto answer = reply ? enip::SendData::parse(reply->data) : cip::DecodeError::truncated;
        if (!answer || answer->packet.items.size() < 2) return {};
        return {answer->packet.items[1].data, {answer->packet.items.begin() + 2, answer->packet.items.end()}};
    }
    std::string call(std::string_view text) { return hex(ask(octets(text)).message); }

    struct Opened {
        cip::ForwardOpenReply reply;
        std::optional<enip::SocketAddress> o_to_t;
        std::optional<enip::SocketAddress> t_to_o;
    };
    /// 101/100 or 254/100, every 10 ms.
    std::optional<Opened> open(std::uint16_t serial, bool owner, bool multicast, std::uint16_t receive_port) {
        cip::ForwardOpen open;
        open.triad = {serial, 0x4D, 0x11223344};
        open.t_to_o_id = 0x0A110000U | serial;
        open.timeout_multiplier = 7;
        open.o_to_t_rpi = open.t_to_o_rpi = 10'000;
        open.o_to_t.size = owner ? 24 : 2;
        open.t_to_o.size = 30;
        open.t_to_o.type = multicast ? cip::ConnectionType::multicast : cip::ConnectionType::point_to_point;
        open.transport = {.transport_class = 1};
        open.path = octets(owner ? "20 04 24 01 2C 65 2C 64" : "20 04 24 01 2C FE 2C 64");
        std::vector<enip::Item> items;
        if (receive_port != 0) {
            items.push_back({enip::ItemType::sockaddr_t_to_o, enip::SocketAddress{.port = receive_port}.encode()});
        }
        const auto answer = ask(cip::Request{0x54, cip::Path::to(6, 1), open.encode()}.encode(), items);
        const auto response = cip::Response::parse(answer.message);
        if (!response || !response->status.ok()) return std::nullopt;
        Opened opened{cip::ForwardOpenReply::parse(response->data).value(), std::nullopt, std::nullopt};
        for (const auto& item : answer.items) {
            auto& place = item.type == enip::ItemType::sockaddr_o_to_t ? opened.o_to_t : opened.t_to_o;
            place = enip::SocketAddress::parse(item.data).value();
        }
        return opened;
    }

private:
    std::optional<enip::Frame> exchange(const enip::Frame& request) const {
        if (!stream_.send(request.encode())) return std::nullopt;
        return stream_.receive();
    }

    Stream stream_;
    std::uint32_t session_ = 0;
};

cip::Bytes owner_datagram(std::uint32_t id, std::uint32_t sequence, std::uint32_t position) {
    cip::Bytes bytes;
    cip::Writer writer(bytes);
    writer.u16(2);
    writer.u16(0x8002);
    writer.u16(8);
    writer.u32(id);
    writer.u32(sequence);
    writer.u16(0x00B1);
    writer.u16(24);
    writer.u16(static_cast<std::uint16_t>(sequence));
    writer.u32(1);
    writer.u32(position);
    bytes.resize(42);
    return bytes;
}

class IoOverSockets : public testing::Test {
protected:
    struct Station {
        explicit Station(std::uint64_t seed) : adapter(device, {}, seed) {}
        drive::Device device{drive::xenax_models().front()};
        adapter::Adapter adapter;
        enip::asio::Listening place;
    };

    /// `port`: of messages; 0 takes one that is free.
    void listen(std::uint32_t address, std::optional<std::uint16_t> io_port = std::nullopt, std::uint16_t port = 0) {
        auto& station = *stations_.emplace_back(std::make_unique<Station>(stations_.size() + 1));
        const auto place =
            server_.listen(station.adapter, {.address = text_of(address), .port = port, .io_port = io_port});
        ASSERT_TRUE(place) << place.error().reason;
        station.place = *place;
        auto& network = station.adapter.network().state;
        network.interface.address = place->local.address;
        network.interface.mask = place->subnet_mask;
        network.io_port = place->io_port;
    }
    void start() {
        thread_ = std::thread([this] { server_.run(); });
    }
    void TearDown() override {
        if (!thread_.joinable()) return;
        server_.stop();
        thread_.join();
    }
    /// With a port by number the port of I/O is 2222, if it can be had.
    static std::uint16_t port_nobody_has() { return Udp({first_device, 0}).local().port; }
    enip::Endpoint io(std::size_t station) const {
        return {stations_[station]->place.local.address, stations_[station]->place.io_port};
    }
    /// Waits until the drive has the target position: it is asked by messages, one after another.
    static bool has_target(Session& session, std::uint32_t position) {
        const auto wanted = hex(cip::Response{0x0E,
                                              {},
                                              [&] {
                                                  cip::Bytes value;
                                                  cip::Writer(value).u32(position);
                                                  return value;
                                              }()}
                                    .encode());
        const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(patience_ms);
        while (std::chrono::steady_clock::now() < end) {
            if (session.call("0E 03 20 66 24 01 30 3A") == wanted) return true;
        }
        return false;
    }
    /// The next of this connection; others are looked at too.
    static std::optional<Udp::Received> next_of(const Udp& socket, std::uint32_t id) {
        for (int i = 0; i < 50; ++i) {
            auto datagram = socket.receive();
            if (!datagram) return std::nullopt;
            const auto packet = enip::IoPacket::parse(datagram->octets);
            if (packet && packet->connection_id == id) return datagram;
        }
        return std::nullopt;
    }

    std::vector<std::unique_ptr<Station>> stations_;
    std::vector<std::string> problems_;
    enip::asio::TargetServer server_{[this](const std::string& line) { problems_.push_back(line); }};
    std::thread thread_;
};

TEST_F(IoOverSockets, R_IO_11_TwoDevicesInOneServerKeepTheirDataApart) {
    listen(first_device);
    listen(second_device, stations_[0]->place.io_port);  // the same port, as many drives of one program have it
    start();
    const Udp socket({originator, 0});
    ASSERT_TRUE(socket.bound());
    std::vector<std::unique_ptr<Session>> sessions;
    std::vector<Session::Opened> opened;
    for (std::size_t i = 0; i < 2; ++i) {
        sessions.push_back(std::make_unique<Session>(stations_[i]->place.local));
        const auto link = sessions[i]->open(static_cast<std::uint16_t>(i + 1), true, false, socket.local().port);
        ASSERT_TRUE(link);
        ASSERT_TRUE(link->o_to_t);
        EXPECT_EQ(link->o_to_t->port, stations_[i]->place.io_port);
        opened.push_back(*link);
    }
    socket.send(io(0), owner_datagram(opened[0].reply.o_to_t_id, 1, 1111));
    socket.send(io(1), owner_datagram(opened[1].reply.o_to_t_id, 1, 2222));
    EXPECT_TRUE(has_target(*sessions[0], 1111));
    EXPECT_TRUE(has_target(*sessions[1], 2222));
    // At the other's address it is nobody's; the good one behind it shows that both have been looked at.
    socket.send(io(1), owner_datagram(opened[0].reply.o_to_t_id, 2, 9999));
    socket.send(io(0), owner_datagram(opened[1].reply.o_to_t_id, 2, 9999));
    socket.send(io(0), owner_datagram(opened[0].reply.o_to_t_id, 3, 3333));
    socket.send(io(1), owner_datagram(opened[1].reply.o_to_t_id, 3, 4444));
    EXPECT_TRUE(has_target(*sessions[0], 3333));
    EXPECT_TRUE(has_target(*sessions[1], 4444));
    for (std::size_t i = 0; i < 2; ++i) {
        const auto datagram = next_of(socket, 0x0A110001U + static_cast<std::uint32_t>(i));
        ASSERT_TRUE(datagram);
        EXPECT_EQ(datagram->octets.size(), 48U);
        EXPECT_EQ(datagram->from, io(i)) << "from its own address and the port of I/O";
    }
}

TEST_F(IoOverSockets, R_IO_7_AnotherAddressIsNotTheOriginator) {
    listen(first_device);
    start();
    const Udp socket({originator, 0});
    const Udp foreign({originator + 1, 0});
    Session session(stations_[0]->place.local);
    const auto link = session.open(1, true, false, socket.local().port);
    ASSERT_TRUE(link);
    foreign.send(io(0), owner_datagram(link->reply.o_to_t_id, 1, 9999));
    for (const auto* bad : {"", "02", "02 00", "FF FF FF FF"}) socket.send(io(0), octets(bad));
    socket.send(io(0), owner_datagram(link->reply.o_to_t_id, 1, 1));
    EXPECT_TRUE(has_target(session, 1)) << "the first number was not used up, and an empty datagram ends nothing";
    EXPECT_TRUE(next_of(socket, 0x0A110001));
}

// More datagrams than a server wakes for one by one. How fast they come is the machine's business; what they bring is not.
TEST_F(IoOverSockets, ABusyServerLosesNothingAndAnswersWithWhatHasCome) {
    listen(first_device);
    start();
    const Udp socket({originator, 0});
    Session session(stations_[0]->place.local);
    const auto link = session.open(1, true, false, socket.local().port);
    ASSERT_TRUE(link);
    std::uint32_t sequence = 0;
    for (int round = 0; round < 10; ++round) {
        for (int i = 0; i < 100; ++i, std::this_thread::sleep_for(50us)) {
            ++sequence;
            socket.send(io(0), owner_datagram(link->reply.o_to_t_id, sequence, 1000 + sequence));
        }
        EXPECT_TRUE(has_target(session, 1000 + sequence)) << "round " << round;
    }
    EXPECT_TRUE(next_of(socket, 0x0A110001)) << "the connection is still there";
    std::this_thread::sleep_for(100ms);  // calm again
    socket.send(io(0), owner_datagram(link->reply.o_to_t_id, sequence + 1, 77));
    EXPECT_TRUE(has_target(session, 77));
}

TEST_F(IoOverSockets, R_MC_3_MulticastArrivesWhereSomebodyHasJoined) {
    listen(first_device);
    listen(second_device, stations_[0]->place.io_port);
    start();
    Session first(stations_[0]->place.local);
    Session second(stations_[1]->place.local);
    const auto link = first.open(1, false, true, 0);
    const auto other = second.open(2, false, true, 0);
    ASSERT_TRUE(link && other);
    ASSERT_TRUE(link->t_to_o && other->t_to_o);
    EXPECT_NE(link->t_to_o->address, other->t_to_o->address) << "each device has its own groups";
    EXPECT_EQ(link->t_to_o->port, 2222);
    EXPECT_EQ(link->t_to_o->address >> 16, 0xEFC0U);
    const Udp socket({link->t_to_o->address, 2222}, true);
    ASSERT_TRUE(socket.bound());
    ASSERT_TRUE(socket.join(link->t_to_o->address, first_device));
    std::uint32_t last = 0;
    for (int i = 0; i < 3; ++i) {
        const auto datagram = socket.receive();
        ASSERT_TRUE(datagram);
        const auto packet = enip::IoPacket::parse(datagram->octets);
        ASSERT_TRUE(packet);
        EXPECT_EQ(packet->connection_id, link->reply.t_to_o_id) << "only the group that was joined";
        EXPECT_EQ(datagram->from, io(0));
        if (i > 0) {
            EXPECT_EQ(packet->sequence, last + 1);
        }
        last = packet->sequence;
    }
}

TEST_F(IoOverSockets, R_CPF_8_APortThatAnotherProgramHasIsReplacedAndTold) {
    // Without a wish it is 2222, which here is ours, or that of whoever was faster.
    const Udp taken({first_device, enip::io_port});
    listen(first_device, std::nullopt, port_nobody_has());
    ASSERT_EQ(stations_.size(), 1U);
    EXPECT_NE(stations_[0]->place.io_port, enip::io_port);
    ASSERT_EQ(problems_.size(), 1U);
    EXPECT_THAT(problems_[0], testing::HasSubstr("UDP 127.0.42.1:2222 is in use by another program"));
    EXPECT_THAT(problems_[0], testing::HasSubstr(std::to_string(stations_[0]->place.io_port)));
    start();
    const Udp socket({originator, 0});
    Session session(stations_[0]->place.local);
    const auto link = session.open(1, true, false, socket.local().port);
    ASSERT_TRUE(link && link->o_to_t);
    EXPECT_EQ(link->o_to_t->port, stations_[0]->place.io_port);
    socket.send(io(0), owner_datagram(link->reply.o_to_t_id, 1, 5));
    EXPECT_TRUE(has_target(session, 5));
    const auto datagram = next_of(socket, 0x0A110001);
    ASSERT_TRUE(datagram);
    EXPECT_EQ(datagram->from, io(0));
}

TEST_F(IoOverSockets, R_CPF_8_APortThatIsWishedForAndTakenIsAnError) {
    const Udp taken({first_device, 0});
    Station station(1);
    const auto place =
        server_.listen(station.adapter, {.address = text_of(first_device), .port = 0, .io_port = taken.local().port});
    ASSERT_FALSE(place);
    EXPECT_THAT(place.error().reason,
                testing::HasSubstr(fmt::format("cannot listen at UDP 127.0.42.1:{}: Address already "
                                               "in use; another program listens there",
                                               taken.local().port)));
}

/// A target with one deadline. Its second message keeps the thread until the deadline has passed, after a datagram has
/// come in time.
class StalledTarget final : public enip::Target {
public:
    explicit StalledTarget(const Udp& sender) : sender_(sender) {}

    std::optional<ConnectionId> on_open(enip::Endpoint, enip::Endpoint local, enip::Time) override {
        local_ = {local.address, io_port};
        return 1;
    }
    std::size_t on_octets(ConnectionId, cip::ByteView octets, enip::Time) override {
        sender_.send(local_, {});
        if (++messages_ == 2) {
            due_ = std::chrono::steady_clock::now() + 1ms;
            while (std::chrono::steady_clock::now() < *due_ + 2ms) {
            }
        }
        return octets.size();
    }
    cip::Bytes take_replies(ConnectionId) override { return {}; }
    bool wants_close(ConnectionId) const override { return false; }
    void on_closed(ConnectionId, enip::Time) override {}
    void on_datagram(enip::Endpoint, enip::Endpoint, bool, cip::ByteView, enip::Time) override {}
    std::vector<enip::Datagram> take_datagrams() override { return {}; }
    void on_io(enip::Endpoint, enip::Endpoint, cip::ByteView, enip::Time now) override {
        went_back = went_back || now < last_;
        last_ = now;
        if (due_ && now < *due_) in_time = true;
        ++datagrams;
    }
    enip::IoQueue& io_queue() override { return queue_; }
    void on_timer(enip::Time now) override {
        went_back = went_back || now < last_;
        last_ = now;
        if (!due_ || now < *due_) return;
        due_.reset();
        known_in_time = in_time.load();
        done = true;
    }
    std::optional<enip::Time> next_deadline() const override { return due_; }
    std::vector<ConnectionId> take_expired() override { return {}; }

    std::uint16_t io_port = 0;
    std::atomic<unsigned> datagrams = 0;
    std::atomic<bool> in_time = false;
    std::atomic<bool> known_in_time = false;
    std::atomic<bool> went_back = false;
    std::atomic<bool> done = false;

private:
    const Udp& sender_;
    enip::Endpoint local_{};
    unsigned messages_ = 0;
    std::optional<enip::Time> due_;
    enip::Time last_{};
    enip::IoQueue queue_;
};

bool comes_true(const std::function<bool()>& condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(patience_ms);
    while (!condition()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::yield();
    }
    return true;
}

// A process that was held up has not lost its peer: the datagrams that the kernel took in time count as such.
TEST(TargetStation, R_CON_18_WhatCameInTimeCountsAlsoWhenTheProcessWasHeldUp) {
    const Udp sender({originator, 0});
    StalledTarget target(sender);
    enip::asio::TargetServer server;
    const auto place = server.listen(target, {.address = text_of(first_device), .port = 0});
    ASSERT_TRUE(place);
    target.io_port = place->io_port;
    std::thread thread([&] { server.run(); });
    const Stream stream(place->local);
    EXPECT_TRUE(stream.send(octets("00")));
    EXPECT_TRUE(comes_true([&] { return target.datagrams == 1; })) << "from here on the kernel stamps";
    EXPECT_TRUE(stream.send(octets("00")));
    EXPECT_TRUE(comes_true([&] { return target.done.load(); }));
    EXPECT_TRUE(target.known_in_time) << "the deadline came first";
    EXPECT_FALSE(target.went_back) << "time never goes back";
    server.stop();
    thread.join();
}

}  // namespace
}  // namespace servobus::test
