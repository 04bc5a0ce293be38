#include "cip/message.hpp"

#include "cip/services.hpp"
#include "cip/wire.hpp"

namespace servobus::cip {

Bytes Request::encode() const {
    const auto segments = path.encode();
    Bytes bytes;
    Writer writer(bytes);
    writer.u8(service);
    writer.u8(static_cast<std::uint8_t>(segments.size() / 2));
    writer.bytes(segments);
    writer.bytes(data);
    return bytes;
}

Decoded<Request> Request::parse(ByteView message) {
    const auto view = RequestView::parse(message);
    if (!view) return view.error();
    auto path = Path::parse(view->path);
    if (!path) return path.error();
    return Request{view->service, std::move(*path), {view->data.begin(), view->data.end()}};
}

Decoded<RequestView> RequestView::parse(ByteView message) {
    Reader reader(message);
    RequestView view;
    view.service = reader.u8();
    const std::size_t path_octets = reader.u8() * std::size_t{2};
    if (!reader.ok()) return DecodeError::truncated;
    view.path = reader.take(path_octets);
    if (!reader.ok()) return DecodeError::path_too_long;
    view.data = reader.rest();
    return view;
}

Bytes Response::encode() const {
    Bytes bytes;
    bytes.reserve(encoded_size());
    Writer writer(bytes);
    write(writer);
    return bytes;
}

void Response::write(Writer& writer) const {
    writer.u8(service | service::reply_bit);
    writer.u8(0);
    writer.field(status.general);
    writer.u8(static_cast<std::uint8_t>(status.extended.size()));
    for (const auto word : status.extended) writer.u16(word);
    writer.bytes(data);
}

Decoded<Response> Response::parse(ByteView message) {
    Reader reader(message);
    Response response;
    const auto service = reader.u8();
    reader.reserved(1);
    reader.field(response.status.general);
    for (auto words = reader.u8(); words > 0 && reader.ok(); --words) response.status.extended.push_back(reader.u16());
    if (!reader.ok()) return DecodeError::truncated;
    if ((service & service::reply_bit) == 0) return DecodeError::bad_value;
    response.service = service & 0x7F;
    const auto data = reader.rest();
    response.data.assign(data.begin(), data.end());
    return response;
}

}  // namespace servobus::cip
