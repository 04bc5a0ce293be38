// Watches the position of a drive over an I/O connection for three seconds: io_connection HOST[:PORT]
#include <iostream>

#include "assemblies/layout.hpp"
#include "cip/wire.hpp"
#include "drive/lookup.hpp"
#include "enip/asio/asio.hpp"
#include "scanner/host.hpp"
#include "scanner/originator.hpp"

using namespace servobus;

std::size_t offset_of(const assemblies::Layout& layout, drive::Key key) {
    std::size_t offset = 0;
    for (const auto& member : layout.members) {
        if (member.key == key) break;
        offset += member.octets;
    }
    return offset;
}

int main(int argc, char** argv) {
    const auto host = scanner::parse_host(argc > 1 ? argv[1] : "");
    if (!host) return 2;
    const auto& connection = *assemblies::find_connection("standard");
    const auto& position =
        *drive::find_by_name(drive::parameters(), drive::parameter_classes(), "PositionActualValue").front();
    net::io_context context;
    scanner::Originator originator(context.get_executor());
    std::uint64_t count = 0;
    int result = 1;

    scanner::IoOptions options{
        .host = host->name, .port = host->port, .plan = scanner::plan_of(connection), .reopen = false};

    scanner::IoEvents events;
    events.opened = [](const scanner::IoOpened& opened) {
        std::cout << "open, T->O every " << opened.t_to_o_interval().count() << " us" << std::endl;
    };
    events.input = [&](const scanner::IoInput& input) {
        if (count++ % 50 != 0) return;
        cip::Reader reader(input.data.subspan(offset_of(*connection.inputs(), position.key())));
        std::cout << "position " << reader.little<std::int32_t>() << std::endl;
    };
    events.output = [](std::span<std::uint8_t>) { return false; };  // idle: we only watch
    events.closed = [&](const scanner::IoClosed& closed) {
        std::cout << "closed: " << name(closed.reason) << ", " << count << " datagrams" << std::endl;
        if (closed.reason == scanner::CloseReason::refused) std::cout << cip::describe(closed.status) << std::endl;
        if (closed.reason == scanner::CloseReason::asked) result = 0;
    };
    auto& io = originator.add(options, events);
    io.open();

    net::steady_timer timer(context, std::chrono::seconds(3));
    timer.async_wait([&](const auto&) { io.close(); });
    context.run();
    return result;
}
