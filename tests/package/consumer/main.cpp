// Somebody else's project: it sees what is installed, and nothing else. It puts a drive of its own on the network and
// reads from it.
#include <cstdio>
#include <thread>

#include "adapter/adapter.hpp"
#include "drive/lookup.hpp"
#include "drive/xenax.hpp"
#include "enip/asio/asio.hpp"
#include "enip/asio/target_server.hpp"
#include "scanner/client.hpp"

using namespace servobus;

int main() {
    drive::Device device(drive::xenax_models().front());
    adapter::Adapter adapter(device, adapter::Limits{}, 1);
    enip::asio::TargetServer server;
    const auto listening = server.listen(adapter, {.port = 0});
    if (!listening) return 1;
    std::thread serving([&] { server.run(); });

    net::io_context context;
    scanner::Client client(context.get_executor());
    const auto& row = *drive::find_by_name(drive::parameters(), drive::parameter_classes(), "SCurve").front();
    bool read = false;
    client.async_connect("127.0.0.1", listening->local.port, [&](boost::system::error_code) {
        client.async_read(row, [&](boost::system::error_code, scanner::ReadOutcome outcome) {
            read = outcome.value == drive::Value(std::int64_t{20});
        });
    });
    context.run_for(std::chrono::seconds(5));
    server.stop();
    serving.join();
    std::puts(read ? "SCurve = 20" : "nothing was read");
    return read ? 0 : 1;
}
