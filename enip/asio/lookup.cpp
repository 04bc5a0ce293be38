#include "enip/asio/lookup.hpp"

#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

namespace servobus::enip::asio {
namespace {

using boost::system::error_code;
using net::ip::tcp;

// What the searching thread and the searcher share. Once abandoned, the thread touches nothing else.
struct Search {
    std::mutex mutex;
    Found found;
    net::any_io_executor executor;

    void abandon() {
        const std::lock_guard lock(mutex);
        found = nullptr;
        executor = {};
    }

    void finish(error_code error, Addresses addresses) {
        const std::lock_guard lock(mutex);
        if (!found) return;
        net::post(std::exchange(executor, {}),
                  [found = std::exchange(found, nullptr), error, addresses = std::move(addresses)]() mutable {
                      found(error, std::move(addresses));
                  });
    }
};

void search(Search& search, const std::string& host, std::uint16_t port) {
    net::io_context context;
    tcp::resolver resolver(context);
    error_code error;
    const auto results = resolver.resolve(host, std::to_string(port), error);
    Addresses addresses;
    for (const auto& result : results) addresses.push_back(result.endpoint());
    if (!error && addresses.empty()) error = net::error::host_not_found;
    search.finish(error, std::move(addresses));
}

}  // namespace

std::function<void()> look_up(const net::any_io_executor& executor, const std::string& host, std::uint16_t port,
                              Found found) {
    const auto shared = std::make_shared<Search>();
    shared->found = std::move(found);
    // Work that is tracked keeps the executor's run() from returning while the thread searches.
    shared->executor = net::prefer(executor, net::execution::outstanding_work_t::tracked);
    error_code error;
    if (const auto address = net::ip::make_address(host, error); !error) {
        shared->finish({}, {tcp::endpoint(address, port)});
        return [] {};
    }
    try {
        std::thread([shared, host, port] { search(*shared, host, port); }).detach();
    } catch (const std::system_error&) {
        shared->finish(net::error::no_memory, {});
    }
    return [shared] { shared->abandon(); };
}

}  // namespace servobus::enip::asio
