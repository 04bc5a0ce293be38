// A PTP node of which everything is known: a slave of a grandmaster that GPS keeps right, as ptp4l 3.1.1 words it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "adapter/ptp_management.hpp"
#include "cip/wire.hpp"
#include "tests/support/octets.hpp"

namespace servobus::test {

class FakePtpNode {
public:
    using Id = adapter::ManagementId;

    /// What it tells, in hex; of a port by its number, of itself by all_ports. What is missing is refused.
    std::map<std::pair<Id, std::uint16_t>, std::string> told{
        {{Id::default_data_set, adapter::all_ports}, "03 00 0001 80 F8FEFFFF 81 5E88D9FFFE77A0B1 07 00"},
        {{Id::current_data_set, adapter::all_ports}, "0002 FFFFFFFFFE0C0000 00000000061A0000"},
        {{Id::parent_data_set, adapter::all_ports},
         "E6DF21FFFE788278 0003 00 00 1234 7FFFFFFE 0A 06214E5D 0B E6DF21FFFE788277"},
        {{Id::time_properties_data_set, adapter::all_ports}, "0025 3C 20"},
        {{Id::port_data_set, 1}, "5E88D9FFFE77A0B1 0001 09 00 0000000000000000 FE 03 FD 01 00 02"},
        {{Id::clock_description, 1},
         "8000 0A 49454545203830322E33 0006 5E88D977A0B1 0001 0004 0A010102 000000 00 02 3B3B 02 3B3B 05 5072657373 "
         "001B19000100 00"},
    };

    /// What it answers to a question.
    cip::Bytes answer(cip::ByteView question) const {
        cip::Reader reader(question.subspan(message_octets));
        reader.take(4);
        const auto id = reader.big<Id>();
        reader = cip::Reader(question.subspan(target_port));
        const auto found = told.find({id, reader.big<std::uint16_t>()});
        return found != told.end() ? message(question, 1, octets(found->second), id)
                                   : message(question, 2, octets("00000000"), id);
    }

private:
    static constexpr std::size_t message_octets = 48;
    static constexpr std::size_t target_port = 42;
    static constexpr std::size_t action = 46;

    static cip::Bytes message(cip::ByteView question, std::uint16_t tlv, const cip::Bytes& data, Id id) {
        cip::Bytes body;
        cip::Writer writer(body);
        if (tlv == 2) writer.big(std::uint16_t{4});  // it is not supported
        writer.big(id);
        writer.bytes(data);
        cip::Bytes whole(question.begin(), question.begin() + message_octets);
        whole[2] = 0;
        whole[3] = static_cast<std::uint8_t>(message_octets + 4 + body.size());
        whole[action] = 2;
        cip::Writer end(whole);
        end.big(tlv);
        end.big(static_cast<std::uint16_t>(body.size()));
        end.bytes(body);
        return whole;
    }
};

}  // namespace servobus::test
