// The rows that the XENAX's behaviour reads and writes, by what they mean to it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "drive/parameter.hpp"
#include "drive/store.hpp"

namespace servobus::drive {

/// A row's variable.
template <std::uint16_t Class, std::uint16_t Attribute>
struct Row : Variable {
    static constexpr Key key{Class, Attribute};
    explicit Row(Store& store) : Variable(store.variable(*store.find(key))) {}
};

/// The variables of a row that a selector (NIX, NSEC, ...) chooses from, all of them.
template <std::uint16_t Class, std::uint16_t Attribute, std::size_t Count>
struct Rows : std::array<Variable, Count> {
    static constexpr Key key{Class, Attribute};
    explicit Rows(Store& store) {
        for (std::size_t i = 0; i < Count; ++i) (*this)[i] = store.variable(*store.find(key), i);
    }
};

/// A group of rows with attributes one after the other (TCP1 to TCP8).
template <std::uint16_t Class, std::uint16_t First, std::size_t Count>
struct RowGroup : std::array<Variable, Count> {
    explicit RowGroup(Store& store) {
        for (std::size_t i = 0; i < Count; ++i) {
            (*this)[i] = store.variable(*store.find({Class, static_cast<std::uint16_t>(First + i)}));
        }
    }
};

/// Every member is bound to the store that it is made with.
struct XenaxVariables {
    explicit XenaxVariables(Store& rows) : store(rows) {}

    Store& store;

    Row<0x64, 0x00> scurve{store};                         ///< SCRV
    Row<0x64, 0x04> error_number{store};                   ///< TE
    Row<0x64, 0x05> force_current{store};                  ///< IFA
    Row<0x64, 0x06> process_status{store};                 ///< TPSR
    Row<0x64, 0x07> cycle_time{store};                     ///< PCT
    Row<0x64, 0x09> limit_force{store};                    ///< LF
    Row<0x64, 0x0A> force_actual{store};                   ///< FA
    Row<0x65, 0x02> tell_status{store};                    ///< TS
    Row<0x65, 0x05> temperature{store};                    ///< TT
    Row<0x65, 0x06> output_state{store};                   ///< TOX
    Row<0x65, 0x07> input_state{store};                    ///< TIX
    Row<0x65, 0x09> motion_time{store};                    ///< TMT
    RowGroup<0x65, 0x0A, 8> captured{store};               ///< TCP1 to TCP8
    Row<0x65, 0x12> reference_state{store};                ///< TH
    Row<0x65, 0x14> jerk{store};                           ///< ACV
    Row<0x65, 0x15> i2t_limit{store};                      ///< I2TM
    Row<0x65, 0x16> i2t{store};                            ///< I2T
    Row<0x65, 0x17> force_peak{store};                     ///< IFPK
    Row<0x65, 0x18> safety_error{store};                   ///< TESM
    Row<0x65, 0x19> gantry_offset{store};                  ///< DGMSO
    Row<0x65, 0x1A> failed_sectors{store};                 ///< SIFF
    Rows<0x65, 0x1B, 10> sector_peak{store};               ///< IFPKn
    Row<0x65, 0x1C> calibration_valid{store};              ///< FCV
    Row<0x65, 0x1D> velocity{store};                       ///< TV
    Row<0x65, 0x1E> process_time{store};                   ///< TPT
    RowGroup<0x65, 0x20, 8> capture_buffer{store};         ///< TCPB1 to TCPB8
    Rows<0x65, 0x3D, 8> output_function{store};            ///< TYOF
    Rows<0x65, 0x3F, 8> input_function{store};             ///< TYIF
    Rows<0x65, 0x40, 8> input_parameter_a{store};          ///< PAIF
    Rows<0x65, 0x41, 8> input_parameter_b{store};          ///< PBIF
    Rows<0x65, 0x42, 8> input_parameter_c{store};          ///< PCIF
    Rows<0x65, 0x44, 10> drive_force{store};               ///< FDF
    Rows<0x65, 0x45, 10> force_high{store};                ///< FH
    Row<0x65, 0x4B> way{store};                            ///< WA
    Row<0x65, 0x4D> direction_reference{store};            ///< DRHR
    Row<0x65, 0x50> input_low_active_selective{store};     ///< ILAS
    Row<0x65, 0x51> input_low_active{store};               ///< ILA
    Row<0x65, 0x52> stop_current{store};                   ///< IS
    Row<0x65, 0x55> pulse_mode{store};                     ///< MD
    Row<0x65, 0x56> payload{store};                        ///< ML
    Row<0x65, 0x57> current_bandwidth{store};              ///< BWC
    Row<0x65, 0x58> position_bandwidth{store};             ///< BWP
    Row<0x65, 0x59> run_current{store};                    ///< IR
    Rows<0x65, 0x5B, 50> index_acceleration{store};        ///< AIX
    Rows<0x65, 0x5C, 50> index_speed{store};               ///< SIX
    Rows<0x65, 0x5D, 50> index_distance{store};            ///< DIX
    Row<0x65, 0x5F> gantry_slave{store};                   ///< GSID
    Row<0x65, 0x62> increments_per_pulse{store};           ///< ICP
    Row<0x65, 0x63> home_input{store};                     ///< INH
    Row<0x65, 0x64> override{store};                       ///< OVRD
    Row<0x65, 0x66> output_activity{store};                ///< SOA
    Row<0x65, 0x67> output_type{store};                    ///< SOT
    Row<0x65, 0x68> synchronous_ratio{store};              ///< SR
    Rows<0x65, 0x6D, 10> sector_start{store};              ///< SIFS
    Rows<0x65, 0x6E, 10> sector_end{store};                ///< SIFE
    Rows<0x65, 0x6F, 10> current_low{store};               ///< IFL
    Rows<0x65, 0x70, 10> current_high{store};              ///< IFH
    Row<0x65, 0x71> mechanical_limit_negative{store};      ///< MLPN
    Row<0x65, 0x72> mechanical_limit_positive{store};      ///< MLPP
    Row<0x65, 0x73> preset_gantry_offset{store};           ///< PGMSO
    Row<0x65, 0x74> brake_delay{store};                    ///< BRKD
    Rows<0x65, 0x77, 50> index_type{store};                ///< TYIX
    Rows<0x65, 0x79, 10> sector_transitions{store};        ///< STCX
    Rows<0x65, 0x7B, 10> force_drive_acceleration{store};  ///< ADIF
    Rows<0x65, 0x7C, 10> force_drive_speed{store};         ///< SDIF
    Rows<0x65, 0x7D, 10> force_drive_current{store};       ///< IDIF
    Rows<0x65, 0x7E, 10> force_drive_direction{store};     ///< DDIF
    Row<0x65, 0x7F> sectors{store};                        ///< SSEC
    Row<0x65, 0x80> sector_offset{store};                  ///< SSO
    Row<0x65, 0x82> set_point_acknowledge_disable{store};  ///< SPAD
    Row<0x65, 0x84> home_direction{store};                 ///< DRH
    Row<0x65, 0x85> z_mark_direction{store};               ///< DRZ
    Row<0x65, 0x8A> dynamic_acceleration{store};           ///< AIXD
    Row<0x65, 0x8B> dynamic_speed{store};                  ///< SIXD
    Row<0x65, 0x8C> dynamic_distance{store};               ///< DIXD
    Row<0x65, 0x8D> dynamic_type{store};                   ///< TYIXD
    Row<0x65, 0x95> preset_gantry_offset_enable{store};    ///< EGMSO
    Row<0x65, 0x97> pole_pairs{store};                     ///< POL
    Row<0x65, 0x98> encoder_increments{store};             ///< ENC
    Row<0x65, 0x9B> motor_mass{store};                     ///< MAMO
    Row<0x65, 0x9C> force_constant{store};                 ///< FCM
    Row<0x65, 0x9D> inductance{store};                     ///< LPH
    Row<0x65, 0x9E> resistance{store};                     ///< RPH
    Row<0x65, 0x9F> friction_dynamic{store};               ///< FFDY
    Row<0x65, 0xA0> friction_static{store};                ///< FFST
    Row<0x65, 0xA1> detected_limit_positive{store};        ///< DMLPP
    Row<0x65, 0xA4> automatic_reference{store};            ///< AREF
    Row<0x65, 0xA7> stage_temperature{store};              ///< TTPS
    Row<0x65, 0xA8> supply_voltage{store};                 ///< TVPSM
    Row<0x65, 0xAB> safety_version{store};                 ///< VERS
    Row<0x65, 0xAC> sls_timeout{store};                    ///< SLS
    Row<0x65, 0xAD> sls_speed{store};                      ///< SpeedLimitSMU
    Row<0x65, 0xAE> safe_stop_timeout{store};              ///< StopTimeoutSMU
    Row<0x65, 0xAF> safe_position_window{store};           ///< PositionWindowSMU
    Row<0x65, 0xB0> safety_inputs{store};                  ///< SFTRD
    Rows<0x65, 0xC4, 10> force_low{store};                 ///< FL
    Row<0x65, 0xC5> forceteq_mode{store};                  ///< FTM
    Row<0x66, 0x00> control_word{store};                   ///< Controlword
    Row<0x66, 0x01> status_word{store};                    ///< Statusword
    Row<0x66, 0x20> mode_requested{store};                 ///< ModesOfOperationRequested
    Row<0x66, 0x21> mode_displayed{store};                 ///< ModesOfOperationDisplayed
    Row<0x66, 0x24> position{store};                       ///< TP
    Row<0x66, 0x25> following_error_window{store};         ///< DP
    Row<0x66, 0x27> target_window{store};                  ///< DTP
    Row<0x66, 0x28> target_window_time{store};             ///< TargetPositionWindowTime
    Row<0x66, 0x33> limit_current{store};                  ///< LIF
    Row<0x66, 0x38> motor_current{store};                  ///< TMC
    Row<0x66, 0x3A> target{store};                         ///< PO
    Row<0x66, 0x3E> soft_limit_negative{store};            ///< SLPN
    Row<0x66, 0x3F> soft_limit_positive{store};            ///< SLPP
    Row<0x66, 0x41> speed{store};                          ///< SP
    Row<0x66, 0x43> acceleration{store};                   ///< AC
    Row<0x66, 0x45> quick_stop_deceleration{store};        ///< ED
    Row<0x66, 0x58> reference_method{store};               ///< ReferenceMethods
    Row<0x66, 0x5A> sensor_speed{store};                   ///< SPH
    Row<0x66, 0x5B> z_mark_speed{store};                   ///< SPZ
    Row<0x66, 0xB4> following_error{store};                ///< ActualPositionFollowingError
    Row<0x66, 0xBD> digital_inputs{store};                 ///< DigitalInputsXENAX
    Row<0x66, 0xBF> digital_outputs{store};                ///< DigitalOutputsXENAX
    Row<0x67, 0x01> axis_resolution{store};                ///< LARES
    Row<0x67, 0x02> axis_stroke{store};                    ///< LAST
    Row<0x67, 0x03> trajectory_state{store};               ///< TTGS
    Row<0x68, 0x01> absolute_reference{store};             ///< ENAR
    Row<0x68, 0x03> auto_program{store};                   ///< APSN
    Row<0x68, 0x04> auto_program_delay{store};             ///< APSD
    Row<0x68, 0x07> switch_on_disable{store};              ///< SOD
    Row<0x68, 0x09> force_buffered_csp{store};             ///< FBCM
    Row<0x6E, 0x01> force_bandwidth{store};                ///< SQBW
    Row<0x6E, 0x09> force_reached_speed{store};            ///< LFRMS
    Row<0x6E, 0x0C> force_controller_bandwidth{store};     ///< BWFP
};

}  // namespace servobus::drive
