// General and extended status of a reply, with their texts (R-ERR-12, R-CON-40).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace servobus::cip {

/// Each value: when a target answers it. The connection stays open after every one of them.
enum class GeneralStatus : std::uint8_t {
    success = 0x00,
    connection_failure = 0x01,  ///< Connection Manager only; the extended word tells
    resource_unavailable = 0x02,
    path_segment_error = 0x04,        ///< R-ERR-2
    path_destination_unknown = 0x05,  ///< R-ERR-3: class or instance
    partial_transfer = 0x06,
    service_not_supported = 0x08,    ///< R-ERR-4
    invalid_attribute_value = 0x09,  ///< R-ERR-9
    attribute_list_error = 0x0A,     ///< R-MSG-14
    object_state_conflict = 0x0C,    ///< R-ERR-7
    attribute_not_settable = 0x0E,   ///< R-ERR-6
    privilege_violation = 0x0F,      ///< R-CON-36
    device_state_conflict = 0x10,    ///< R-ERR-7
    reply_data_too_large = 0x11,     ///< R-ENC-27
    not_enough_data = 0x13,          ///< R-ERR-8
    attribute_not_supported = 0x14,  ///< R-ERR-5
    too_much_data = 0x15,            ///< R-ERR-8
    object_does_not_exist = 0x16,
    store_operation_failure = 0x19,       ///< what was written could not be made to last
    missing_attribute_list_entry = 0x1C,  ///< R-MSG-15
    embedded_service_error = 0x1E,        ///< R-MSG-16
    vendor_specific = 0x1F,               ///< R-DEV-3
    invalid_parameter = 0x20,             ///< R-ERR-9: of a service, not of an attribute
    key_failure_in_path = 0x25,
    path_size_invalid = 0x26,       ///< R-ERR-1
    attribute_not_gettable = 0x2C,  ///< R-ERR-6
};

/// Extended words of general status 0x01 that this project sends (R-CON-40); it reads all others too.
enum class ConnectionFailure : std::uint16_t {
    duplicate_forward_open = 0x0100,
    class_trigger_not_supported = 0x0103,
    ownership_conflict = 0x0106,
    connection_not_found = 0x0107,
    invalid_connection_parameter = 0x0108,
    rpi_not_supported = 0x0111,
    rpi_not_acceptable = 0x0112,
    out_of_connections = 0x0113,
    vendor_or_product_mismatch = 0x0114,
    device_type_mismatch = 0x0115,
    revision_mismatch = 0x0116,
    invalid_application_path = 0x0117,
    no_non_listen_only_connection = 0x0119,
    target_out_of_connections = 0x011A,
    rpi_below_inhibit_time = 0x011B,
    invalid_o_to_t_type = 0x0123,
    invalid_t_to_o_type = 0x0124,
    redundant_owner_not_supported = 0x0125,
    invalid_configuration_size = 0x0126,
    invalid_o_to_t_size = 0x0127,
    invalid_t_to_o_size = 0x0128,
    invalid_configuration_path = 0x0129,
    invalid_consuming_path = 0x012A,
    invalid_producing_path = 0x012B,
    inconsistent_path_combination = 0x012F,
    null_forward_open_not_supported = 0x0132,
    timeout_multiplier_not_acceptable = 0x0133,
    producer_has_other_fixed_variable = 0x0135,
    producer_has_other_priority = 0x0136,
    producer_has_other_class = 0x0137,
    producer_has_other_trigger = 0x0138,
    producer_has_other_inhibit_time = 0x0139,
    unconnected_request_timed_out = 0x0204,
    unconnected_parameter_error = 0x0205,
    port_not_available = 0x0311,
    link_address_not_valid = 0x0312,
    invalid_path_segment = 0x0315,
    not_configured_for_off_subnet_multicast = 0x0813,
};

/// The one extended word of general status 0x1F here: the drive refuses (000 §2.3.2, R-DEV-3).
inline constexpr std::uint16_t drive_refuses = 0x0001;

struct Status {
    GeneralStatus general = GeneralStatus::success;
    std::vector<std::uint16_t> extended{};

    Status() = default;
    Status(GeneralStatus code) : general(code) {}  // NOLINT(google-explicit-constructor): a code is a status
    Status(GeneralStatus code, std::vector<std::uint16_t> words) : general(code), extended(std::move(words)) {}
    Status(ConnectionFailure failure)  // NOLINT(google-explicit-constructor): a failure is a status
        : general(GeneralStatus::connection_failure), extended{static_cast<std::uint16_t>(failure)} {}

    [[nodiscard]] bool ok() const { return general == GeneralStatus::success; }
    friend bool operator==(const Status&, const Status&) = default;
};

/// "attribute not settable"; "reserved" for codes that are not defined.
[[nodiscard]] std::string_view text(GeneralStatus code);

/// The extended word in words, as far as the general status gives it a meaning; empty when it gives none.
[[nodiscard]] std::string_view extended_text(GeneralStatus general, std::uint16_t word);

/// `0x01 connection failure, 0x0106 ownership conflict`.
[[nodiscard]] std::string describe(const Status& status);

}  // namespace servobus::cip
