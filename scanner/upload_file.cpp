#include "scanner/upload_file.hpp"

#include <memory>

#include "enip/asio/asio.hpp"

namespace servobus::scanner::detail {
namespace {

/// Lives as long as a request is out. Everything runs on its strand.
class Upload : public std::enable_shared_from_this<Upload> {
public:
    Upload(Client& client, FileUploadOptions options, UploadManners manners, UploadDone done)
        : client_(client),
          strand_(net::make_strand(client.get_executor())),
          upload_(options),
          manners_(std::move(manners)),
          done_(std::move(done)) {}

    void start() {
        done_.on_cancel([weak = weak_from_this()] {
            const auto self = weak.lock();
            if (!self) return;
            net::post(self->strand_, [self] { self->cancel_.emit(net::cancellation_type::terminal); });
        });
        net::dispatch(strand_, [self = shared_from_this()] { self->ask(); });
    }

private:
    using Strand = net::strand<net::any_io_executor>;

    /// Where an answer comes to, with its executor and its cancellation.
    struct Answer {
        using executor_type = Strand;
        using cancellation_slot_type = net::cancellation_slot;
        std::shared_ptr<Upload> upload;

        [[nodiscard]] executor_type get_executor() const noexcept { return upload->strand_; }
        [[nodiscard]] cancellation_slot_type get_cancellation_slot() const noexcept { return upload->cancel_.slot(); }
        void operator()(error_code error, const cip::Response& response) const { upload->on_answer(error, response); }
    };

    void ask() { client_.async_call(upload_.request(), CallOptions{manners_.timeout}, Answer{shared_from_this()}); }

    void on_answer(const error_code& error, const cip::Response& response) {
        if (error == make_error_code(Error::timeout)) {
            upload_.on_silence();
        } else if (error) {
            done_(error, UploadFailure{});
            return;
        } else {
            upload_.on_response(response);
            if (manners_.progress) manners_.progress(upload_.received(), upload_.announced());
        }
        if (!upload_.done()) {
            ask();
        } else if (upload_.failure()) {
            done_({}, *upload_.failure());
        } else {
            done_({}, upload_.file());
        }
    }

    Client& client_;
    Strand strand_;
    FileUpload upload_;
    UploadManners manners_;
    UploadDone done_;
    net::cancellation_signal cancel_;
};

}  // namespace

void start_upload(Client& client, FileUploadOptions options, UploadManners manners, UploadDone done) {
    std::make_shared<Upload>(client, options, std::move(manners), std::move(done))->start();
}

}  // namespace servobus::scanner::detail
