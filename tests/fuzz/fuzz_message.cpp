// Requests and responses of the message router, the packets of several of them, and the strings of CIP.
#include <algorithm>

#include "cip/message.hpp"
#include "cip/multiple_service.hpp"
#include "cip/strings.hpp"
#include "cip/wire.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using test::require;

void request(cip::ByteView octets) {
    const auto view = cip::RequestView::parse(octets);
    if (view) {
        require(2 + view->path.size() + view->data.size() == octets.size(), "path and data are the message", octets);
        require(view->path.size() == std::size_t{2} * octets[1], "the path has the words that it says", octets);
    }
    const auto whole = cip::Request::parse(octets);
    if (!whole) return;
    require(view && whole->service == view->service && std::ranges::equal(whole->data, view->data),
            "both ways to read a request agree", octets);
}

void response(cip::ByteView octets) {
    const auto response = cip::Response::parse(octets);
    if (!response) return;
    const auto encoded = response->encode();
    require(encoded.size() == response->encoded_size() && encoded.size() == octets.size(), "the size is told right",
            octets);
    require(!cip::describe(response->status).empty(), "a status has words", octets);
}

void parts(cip::ByteView octets) {
    const auto parts = cip::read_parts(octets);
    if (!parts) return;
    std::size_t total = cip::parts_head(parts->size());
    require(total <= octets.size(), "the offsets are there", octets);
    std::vector<cip::Bytes> copies;
    for (const auto& part : *parts) {
        total += part.size();
        copies.emplace_back(part.begin(), part.end());
    }
    // Between head and first part there may be a gap that belongs to nobody.
    require(total <= octets.size(), "no octet is in two parts", octets);
    const auto written = cip::write_parts(copies);
    const auto again = cip::read_parts(written);
    require(again && std::ranges::equal(*again, copies, std::ranges::equal), "parts come out the same", octets);
}

void strings(cip::ByteView octets) {
    cip::Reader reader(octets);
    const auto strings = cip::read_stringi(reader);
    if (!reader.ok()) return;
    cip::Bytes written;
    cip::Writer writer(written);
    cip::write_stringi(writer, strings);
    cip::Reader again(written);
    require(cip::read_stringi(again) == strings && again.done(), "strings come out the same", octets);
}

}  // namespace

void message(cip::ByteView octets) {
    request(octets);
    response(octets);
    parts(octets);
    strings(octets);
    test::decode_everything(octets);
}

}  // namespace servobus::fuzz
