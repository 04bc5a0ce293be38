// An upload over a client: FileUpload with its requests sent.
#pragma once

#include <chrono>
#include <functional>
#include <utility>
#include <variant>

#include "scanner/client.hpp"
#include "scanner/error.hpp"
#include "scanner/file_upload.hpp"

namespace servobus::scanner {

struct UploadManners {
    std::chrono::milliseconds timeout{2000};  ///< until a request is sent again
    /// Called after each piece, on the executor of the client: octets so far, and of all.
    std::function<void(std::size_t, std::uint32_t)> progress{};
};

using UploadOutcome = std::variant<UploadFailure, UploadedFile>;

namespace detail {
using UploadDone = enip::asio::Completion<void(error_code, UploadOutcome)>;
void start_upload(Client& client, FileUploadOptions options, UploadManners manners, UploadDone done);
}  // namespace detail

/// Completes with void(error_code, UploadOutcome): an error when the connection is no more or answers make no sense at
/// all, otherwise the file or why there is none. The client outlives the operation.
template <class Token>
auto async_upload_file(Client& client, FileUploadOptions options, UploadManners manners, Token&& token) {
    return enip::asio::initiate<void(error_code, UploadOutcome)>(
        client.get_executor(),
        [&client, options, manners = std::move(manners)](detail::UploadDone done) mutable {
            detail::start_upload(client, options, std::move(manners), std::move(done));
        },
        std::forward<Token>(token));
}

}  // namespace servobus::scanner
