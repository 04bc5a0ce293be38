// Paths: as segments, as the target of a request, as a route and a key, and for people.
#include "adapter/forward_open_checks.hpp"
#include "cip/forward_open.hpp"
#include "cip/path.hpp"
#include "cip/request_path.hpp"
#include "scanner/connection_path.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using test::require;

constexpr cip::NodeIdentity node{1389, 43, 0x7509, 1, 1};

void use(const cip::Path& path, cip::ByteView octets) {
    const auto encoded = path.encode();
    require(encoded.size() <= octets.size(), "a path is not written longer than it was read", octets);
    require(encoded.size() == 2 * path.words(), "a path says how many words it has", octets);
    const auto again = cip::Path::parse(encoded);
    require(again && *again == path, "a path comes out the same", octets);
    require(path.segments.empty() || !cip::describe(path).empty(), "a path has words", octets);
    (void)cip::production_inhibit_time(path);
    if (const auto rest = adapter::check_key(path, node)) {
        require(rest->size() <= path.segments.size(), "key and hop are in the path", octets);
    }
}

}  // namespace

void path(cip::ByteView octets) {
    const auto path = cip::Path::parse(octets);
    if (path) use(*path, octets);
    const auto target = cip::RequestPath::parse(octets);
    require(!target || path, "what a request is addressed to is a path", octets);
    if (target && target->key) (void)cip::mismatch(*target->key, node);
    const auto route = adapter::check_route(octets);
    require(!route.ok() || path, "a route that leads here is a path", octets);
    (void)scanner::ConnectionPath::read(octets);
}

}  // namespace servobus::fuzz
