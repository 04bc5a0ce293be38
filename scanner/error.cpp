#include "scanner/error.hpp"

#include <fmt/format.h>

#include <boost/system/errc.hpp>
#include <string>

namespace servobus::scanner {
namespace {

const char* text(Error error) {
    switch (error) {
        case Error::timeout:
            return "the device did not answer in time";
        case Error::closed:
            return "the device closed the connection";
        case Error::closed_in_message:
            return "the device closed the connection in the middle of a message";
        case Error::not_connected:
            return "there is no connection to a device";
        case Error::already_connected:
            return "there is a connection already";
        case Error::too_many_requests:
            return "too many requests wait to be sent";
        case Error::request_too_large:
            return "the request is too long to be sent";
        case Error::foreign_protocol:
            return "what answers there does not speak EtherNet/IP";
        case Error::oversize_reply:
            return "the reply is longer than any reply may be";
        case Error::wrong_command:
            return "the device answered, but not to what was asked";
        case Error::malformed_packet:
            return "the reply's list of items (common packet format) is malformed";
        case Error::malformed_response:
            return "the reply is no CIP response";
        case Error::wrong_service:
            return "the reply belongs to another CIP service";
        case Error::missing_data:
            return "the value in the reply is shorter than its type";
        case Error::unexpected_data:
            return "the data in the reply does not have the shape that its service gives it";
        case Error::wrong_connection:
            return "the reply is about another connection than the one asked for";
        case Error::bad_interval:
            return "the device grants a packet interval that cannot be kept";
        case Error::bad_socket_address:
            return "the reply does not say properly where the data goes (sockaddr item)";
    }
    return "unknown error";
}

// Boost keeps the destructor of the base non-virtual; nobody destroys a category through it.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wnon-virtual-dtor"

class ClientCategory final : public boost::system::error_category {
public:
    ClientCategory() = default;
    ClientCategory(const ClientCategory&) = delete;
    ClientCategory& operator=(const ClientCategory&) = delete;
    virtual ~ClientCategory() = default;
    [[nodiscard]] const char* name() const noexcept override { return "servobus.scanner"; }
    [[nodiscard]] std::string message(int value) const override { return text(static_cast<Error>(value)); }
};

class EncapsulationCategory final : public boost::system::error_category {
public:
    EncapsulationCategory() = default;
    EncapsulationCategory(const EncapsulationCategory&) = delete;
    EncapsulationCategory& operator=(const EncapsulationCategory&) = delete;
    virtual ~EncapsulationCategory() = default;
    [[nodiscard]] const char* name() const noexcept override { return "servobus.encapsulation"; }
    [[nodiscard]] std::string message(int value) const override {
        const auto status = static_cast<enip::EncapsulationStatus>(value);
        return fmt::format("the device refused the message: encapsulation status 0x{:04X} {}",
                           static_cast<std::uint32_t>(status), enip::describe(status));
    }
};

#pragma GCC diagnostic pop

const ClientCategory client_category;
const EncapsulationCategory encapsulation_category;

Trouble trouble_of(Error error) {
    switch (error) {
        case Error::timeout:
        case Error::closed:
        case Error::closed_in_message:
            return Trouble::connection;
        case Error::not_connected:
        case Error::already_connected:
        case Error::too_many_requests:
        case Error::request_too_large:
            return Trouble::usage;
        case Error::foreign_protocol:
        case Error::oversize_reply:
        case Error::wrong_command:
        case Error::malformed_packet:
        case Error::malformed_response:
        case Error::wrong_service:
        case Error::missing_data:
        case Error::unexpected_data:
        case Error::wrong_connection:
        case Error::bad_interval:
        case Error::bad_socket_address:
            return Trouble::nonsense;
    }
    return Trouble::nonsense;
}

}  // namespace

error_code make_error_code(Error error) { return {static_cast<int>(error), client_category}; }

error_code make_error_code(enip::EncapsulationStatus status) {
    return {static_cast<int>(status), encapsulation_category};
}

Trouble trouble_of(const error_code& error) {
    if (error.category() == client_category) return trouble_of(static_cast<Error>(error.value()));
    if (error.category() == encapsulation_category) return Trouble::refusal;
    if (error == boost::system::errc::bad_message) return Trouble::nonsense;
    return Trouble::connection;
}

}  // namespace servobus::scanner
