// An assembly bound to one device: its rows and their cells are looked up once, so that the datagrams of a cyclic
// connection cost no search and no memory (docs/motion.md, Process images).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "assemblies/layout.hpp"
#include "cip/bytes.hpp"
#include "drive/device.hpp"
#include "drive/store.hpp"

namespace servobus::assemblies {

class Image {
public:
    /// What has become of the members of a datagram (R-IO-9).
    struct Outcome {
        std::uint32_t refused = 0;                      ///< bit n: member n of the layout was left out
        std::optional<drive::Refusal> first_refusal{};  ///< why the first of them was
        bool start_held = false;                        ///< bit 4 of the Controlword was taken as 0

        friend bool operator==(const Outcome&, const Outcome&) = default;
    };

    /// The device stays where it is for as long as the image is used.
    Image(const Layout& layout, drive::Device& device);

    [[nodiscard]] const Layout& layout() const { return *layout_; }
    [[nodiscard]] std::size_t size() const { return size_; }
    /// The row of member `index`; nullptr for what is no parameter, or none that this variant has.
    [[nodiscard]] const drive::Parameter* row(std::size_t index) const { return members_[index].row; }

    /// Writes the members' present values into `octets`, which has size() octets. Time stamps are microseconds since
    /// the epoch (R-IO-10).
    void pack(std::int64_t time_stamp, std::span<std::uint8_t> octets) const;

    /// What a controller has sent: members that the drive takes are written in the order of the assembly, others are
    /// left out. While any is, the Controlword starts nothing. `octets` has size() octets; of any other number nothing is
    /// applied and all is refused.
    Outcome apply(cip::ByteView octets);

private:
    enum class Role : std::uint8_t {
        nothing,  ///< padding, or a row that the variant does not have
        time_stamp,
        setting,
        command,  ///< each write does something, also of the same value
        control_word,
    };
    struct Bound {
        Role role = Role::nothing;
        std::uint8_t octets = 0;
        const drive::Parameter* row = nullptr;
        drive::Variable cell{};
    };

    [[nodiscard]] static Bound bind(const Member& member, drive::Device& device);
    void refuse(std::size_t index, drive::Refusal refusal, Outcome& outcome) const;
    [[nodiscard]] Outcome check(cip::ByteView octets) const;
    [[nodiscard]] std::int64_t guarded(std::int64_t word, const Bound& control_word, Outcome& outcome);

    const Layout* layout_;
    drive::Device* device_;
    std::size_t size_;
    std::vector<Bound> members_;
    bool start_held_ = false;  ///< until the controller shows bit 4 as 0
};

}  // namespace servobus::assemblies
