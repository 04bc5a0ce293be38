// Reads one parameter of a drive: read_attribute HOST[:PORT]
#include <iostream>

#include "drive/lookup.hpp"
#include "drive/text.hpp"
#include "enip/asio/asio.hpp"
#include "scanner/client.hpp"
#include "scanner/host.hpp"

using namespace servobus;

net::awaitable<void> read_attribute(scanner::Host host) {
    const auto& row = *drive::find_by_name(drive::parameters(), drive::parameter_classes(), "SCurve").front();
    scanner::Client client(co_await net::this_coro::executor);
    co_await client.async_connect(host.name, host.port, net::use_awaitable);
    const auto outcome = co_await client.async_read(row, net::use_awaitable);
    if (outcome.value) std::cout << row.name << " = " << drive::format(row, *outcome.value) << ' ' << row.unit << '\n';
    if (!outcome.value) std::cout << "refused: " << cip::describe(outcome.status) << '\n';
    co_await client.async_close(net::use_awaitable);
}

int main(int argc, char** argv) try {
    net::io_context context;
    auto done = net::co_spawn(context, read_attribute(*scanner::parse_host(argc > 1 ? argv[1] : "")), net::use_future);
    context.run();
    done.get();
} catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
