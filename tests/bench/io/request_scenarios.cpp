// Explicit requests against a bare epoll server that answers as many octets with as many: rate, waits, CPU.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cip/forward_open.hpp"
#include "cip/services.hpp"
#include "enip/encapsulation.hpp"
#include "enip/messages.hpp"
#include "tests/bench/io/adapter_process.hpp"
#include "tests/bench/io/image.hpp"
#include "tests/bench/io/request_run.hpp"
#include "tests/bench/io/scenarios.hpp"

namespace servobus::bench {
namespace {

constexpr std::size_t rounds = 5;

struct Case {
    std::string name;
    std::size_t sessions;
    std::size_t depth;
    bool connected;
};

/// Product and floor take turns, so that both meet the machine as it is.
struct Side {
    const Child& server;
    std::vector<RequestStream> streams;
    std::vector<double> rates{};
    std::vector<double> cpu_us{};
    std::vector<double> waits_us{};

    void run(const Case& each, std::size_t reply_octets, double seconds) {
        const auto before = server.cpu();
        auto run = run_requests(streams, each.depth, reply_octets, seconds);
        cpu_us.push_back(static_cast<double>(server.cpu() - before) / 1000 / static_cast<double>(run.waits_us.size()));
        rates.push_back(run.rate());
        waits_us.insert(waits_us.end(), run.waits_us.begin(), run.waits_us.end());
    }
};

double median(std::vector<double> values) {
    std::ranges::sort(values);
    return values[values.size() / 2];
}

double median_ratio(const std::vector<double>& product, const std::vector<double>& floor) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < product.size(); ++i) ratios.push_back(product[i] / floor[i]);
    return std::round(median(std::move(ratios)) * 1000) / 1000;
}

Row row_of(const std::string& what, const Case& each, const Side& side) {
    Row row{{"what", what},
            {"condition", each.name},
            {"count", side.waits_us.size()},
            {"per_second", std::round(median(side.rates))}};
    put(row, Distribution::of(side.waits_us));
    row["cpu_us"] = rounded(median(side.cpu_us));
    return row;
}

struct ProductStream {
    RequestStream stream;
    std::size_t reply_octets;
};

ProductStream unconnected(const Settings& settings) {
    ExplicitClient client(explicit_endpoint(settings));
    auto frame = client.frame(read_position());
    const auto reply_octets = client.exchange(frame).size();
    return {{.socket = client.release(), .frame = std::move(frame)}, reply_octets};
}

// A class 3 connection to the Message Router (R-CON-60).
ProductStream connected(const Settings& settings) {
    ExplicitClient client(explicit_endpoint(settings));
    auto frame = client.connected_frame(read_position());
    const auto at =
        enip::header_bytes + 4 + 2 + 2 + 8 + 4;  // interface handle, timeout, items up to the sequence count
    put16(frame, at, 1);
    const auto reply_octets = client.exchange(frame).size();
    return {{.socket = client.release(), .frame = std::move(frame), .sequence_at = at, .sequence = 1}, reply_octets};
}

void compare(const Settings& settings, const Child& adapter, const Case& each, Report& report) {
    Side product{adapter, {}};
    std::size_t reply_octets = 0;
    for (std::size_t i = 0; i < each.sessions; ++i) {
        auto opened = each.connected ? connected(settings) : unconnected(settings);
        reply_octets = opened.reply_octets;
        product.streams.push_back(std::move(opened.stream));
    }
    const auto request_octets = product.streams[0].frame.size();
    const auto server = Child::in_role({"tcp-reply", to_string(enip::Endpoint{settings.address, 0}),
                                        std::to_string(request_octets), std::to_string(reply_octets)});
    Side floor{server, {}};
    const enip::Endpoint at{settings.address, static_cast<std::uint16_t>(std::stoul(server.first_line()))};
    for (std::size_t i = 0; i < each.sessions; ++i) {
        floor.streams.push_back({.socket = tcp_connect(at), .frame = cip::Bytes(request_octets)});
    }
    for (std::size_t i = 0; i < rounds; ++i) {
        floor.run(each, reply_octets, settings.seconds / rounds);
        product.run(each, reply_octets, settings.seconds / rounds);
    }
    report.add(row_of(fmt::format("epoll server, {} to {} octets", request_octets, reply_octets), each, floor));
    report.add(row_of("adapter", each, product));
    report.add({{"what", "adapter / epoll server"},
                {"condition", each.name},
                {"rate_x_floor", median_ratio(product.rates, floor.rates)},
                {"cpu_x_floor", median_ratio(product.cpu_us, floor.cpu_us)}});
}

}  // namespace

void measure_request_rates(const Settings& settings, Report& report) {
    report.table(
        "requests", "Explicit requests",
        fmt::format("Get_Attribute_Single, against a bare epoll server that answers as many octets with as many. Both "
                    "take turns {} times; rates and CPU are medians, and so are the ratios.",
                    rounds));
    const auto adapter = start_adapter(settings);
    for (const auto& each :
         {Case{"1 session", 1, 1, false}, Case{"8 sessions", 8, 1, false},
          Case{"1 session, 16 in flight", 1, 16, false}, Case{"class 3, 1 connection", 1, 1, true}}) {
        compare(settings, adapter, each, report);
    }
}

}  // namespace servobus::bench
