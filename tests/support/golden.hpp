// The golden vectors of tests/golden/golden_vectors.json.
#pragma once

#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/octets.hpp"
#include "tests/support/places.hpp"

namespace servobus::test {

struct GoldenVector {
    std::string name;
    unsigned scene = 0;
    std::string transport;  ///< tcp, udp or eth
    unsigned port = 0;      ///< 0 for eth
    std::string direction;  ///< `O->T` or `T->O`
    std::string layer;
    std::string meaning;
    std::string reply_to;  ///< name of the request; empty when this is none
    bool broadcast = false;
    bool malformed = false;  ///< damaged on purpose
    cip::Bytes octets;

    bool is_request() const { return direction == "O->T"; }
    bool is_encapsulation() const { return layer == "encapsulation message"; }
    bool is_io_datagram() const { return layer == "class 0/1 datagram (CPF)"; }
};

inline void PrintTo(const GoldenVector& vector, std::ostream* out) { *out << vector.name << ": " << vector.meaning; }

/// In the order of the file, which is that of the conversations. Empty when the file cannot be read.
inline const std::vector<GoldenVector>& golden_vectors() {
    static const auto vectors = [] {
        std::ifstream file(data_path("golden/golden_vectors.json"));
        std::vector<GoldenVector> list;
        const auto document = nlohmann::json::parse(file, nullptr, false);
        if (document.is_discarded()) return list;
        for (const auto& entry : document.at("vectors")) {
            GoldenVector vector;
            vector.name = entry.at("name");
            vector.scene = entry.at("scene");
            vector.transport = entry.at("transport");
            vector.port = entry.at("port").is_number() ? entry.at("port").get<unsigned>() : 0;
            vector.direction = entry.at("direction");
            vector.layer = entry.at("layer");
            vector.meaning = entry.at("meaning");
            vector.reply_to = entry.value("reply_to", "");
            vector.broadcast = entry.value("destination", "") == "255.255.255.255";
            vector.malformed = entry.value("deliberately_malformed", false);
            vector.octets = octets(entry.at("hex").get<std::string>());
            list.push_back(std::move(vector));
        }
        return list;
    }();
    return vectors;
}

inline const GoldenVector* find_golden_vector(std::string_view name) {
    for (const auto& vector : golden_vectors()) {
        if (vector.name == name) return &vector;
    }
    return nullptr;
}

}  // namespace servobus::test
