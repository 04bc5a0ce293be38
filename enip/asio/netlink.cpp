#include "enip/asio/netlink.hpp"

#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace servobus::enip::asio::netlink {
namespace {

using boost::system::error_code;

// Reads of one answer; the tables of a machine that needs more are not looked at to their end.
constexpr int max_reads = 64;
// The kernel answers within the call; this is for one that does not.
constexpr timeval patience{1, 0};

error_code error_of(int number) { return {number, boost::system::system_category()}; }

class Descriptor {
public:
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor() {
        if (number_ >= 0) ::close(number_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    [[nodiscard]] int number() const { return number_; }

private:
    int number_;
};

}  // namespace

std::span<const std::byte> Request::octets() {
    const auto length = static_cast<std::uint32_t>(octets_.size());
    std::memcpy(octets_.data(), &length, sizeof length);  // the first field of the header
    return octets_;
}

std::optional<std::span<const std::byte>> Answer::attribute_octets(std::size_t behind, std::uint16_t type) const {
    auto rest = body.subspan(std::min<std::size_t>(NLMSG_ALIGN(behind), body.size()));
    while (rest.size() >= sizeof(rtattr)) {
        rtattr attribute{};
        std::memcpy(&attribute, rest.data(), sizeof attribute);
        const std::size_t length = attribute.rta_len;
        if (length < sizeof attribute || length > rest.size()) return std::nullopt;
        if (attribute.rta_type == type) return rest.subspan(RTA_LENGTH(0), length - RTA_LENGTH(0));
        rest = rest.subspan(std::min<std::size_t>(RTA_ALIGN(length), rest.size()));
    }
    return std::nullopt;
}

int open(unsigned groups) {
    const int socket = ::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    if (socket < 0) return socket;
    sockaddr_nl own{};
    own.nl_family = AF_NETLINK;
    own.nl_groups = groups;
    // NOLINTNEXTLINE(*-reinterpret-cast): what the call takes
    if (::bind(socket, reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0) return socket;
    const int error = errno;
    ::close(socket);
    errno = error;
    return -1;
}

void split(std::span<const std::byte> octets, const Take& take) {
    while (octets.size() >= sizeof(nlmsghdr)) {
        Answer answer;
        std::memcpy(&answer.header, octets.data(), sizeof answer.header);
        const std::size_t length = answer.header.nlmsg_len;
        if (length < NLMSG_HDRLEN || length > octets.size()) return;
        answer.body = octets.subspan(NLMSG_HDRLEN, length - NLMSG_HDRLEN);
        take(answer);
        octets = octets.subspan(std::min<std::size_t>(NLMSG_ALIGN(length), octets.size()));
    }
}

error_code ask(Request request, const Take& take) {
    const Descriptor socket(open(0));
    if (socket.number() < 0) return error_of(errno);
    ::setsockopt(socket.number(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    const auto octets = request.octets();
    if (::send(socket.number(), octets.data(), octets.size(), 0) < 0) return error_of(errno);
    std::vector<std::byte> buffer(answer_octets);
    std::optional<error_code> result;
    for (int i = 0; i < max_reads && !result; ++i) {
        const auto size = ::recv(socket.number(), buffer.data(), buffer.size(), 0);
        if (size < 0) return error_of(errno);
        split(std::span(buffer).first(static_cast<std::size_t>(size)), [&](const Answer& answer) {
            if (answer.header.nlmsg_type == NLMSG_DONE) {
                result = error_code();
            } else if (answer.header.nlmsg_type == NLMSG_ERROR) {
                const auto error = answer.as<nlmsgerr>();
                result = error_of(error ? -error->error : EBADMSG);
            } else if (take) {
                take(answer);
            }
        });
    }
    return result.value_or(error_of(EOVERFLOW));
}

}  // namespace servobus::enip::asio::netlink
