#include "scanner/conformance/suite.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <thread>

#include "enip/asio/discovery.hpp"

namespace servobus::scanner::conformance {
namespace {

using Clock = std::chrono::steady_clock;

/// How long a device that does not answer after a failure is waited for, in times of the usual patience.
constexpr int patience_after_failure = 2;

/// What is asked behind the scenes: neither recorded nor held against a case.
constexpr Case background{"", Group::encapsulation, "", "", "", Manner::reads, nullptr};

bool answers(Subject& subject) {
    Bench bench(subject, background);
    Session session(bench);
    return session.is_open() && session.wire().is_alive();
}

/// One case on its way.
struct Trial {
    Trial(Subject& subject, const Case& which) : bench(subject, which) {}
    Bench bench;
    Clock::time_point begin = Clock::now();
    std::optional<Bench::Later> later{};
};

class Run {
public:
    Run(Subject& subject, const Progress& progress, const Interrupted& interrupted)
        : subject_(subject), progress_(progress), interrupted_(interrupted) {}

    Report go(std::span<const Case* const> cases) {
        const auto begin = Clock::now();
        std::size_t next = 0;
        while (next < cases.size()) {
            const auto group = cases[next]->group;
            const auto end = std::find_if(cases.begin() + static_cast<std::ptrdiff_t>(next), cases.end(),
                                          [&](const Case* each) { return each->group != group; });
            run_group(cases.subspan(next, static_cast<std::size_t>(end - cases.begin()) - next));
            next = static_cast<std::size_t>(end - cases.begin());
        }
        report_.took = since(begin);
        return std::move(report_);
    }

private:
    static std::chrono::milliseconds since(Clock::time_point begin) {
        return std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - begin);
    }

    /// Their results are told in their order, however long some take.
    void run_group(std::span<const Case* const> cases) {
        trials_.clear();
        results_.assign(cases.size(), std::nullopt);
        told_ = 0;
        for (std::size_t i = 0; i < cases.size(); ++i) {
            go_on(Clock::now());
            start(i, *cases[i]);
            tell();
        }
        while (std::ranges::any_of(trials_, [](const auto& each) { return each != nullptr; })) {
            Clock::time_point first = Clock::time_point::max();
            for (const auto& each : trials_) {
                if (each) first = std::min(first, each->later->due);
            }
            if (!is_interrupted()) std::this_thread::sleep_until(std::min(first, Clock::now() + look_interval));
            go_on(is_interrupted() ? Clock::time_point::max() : Clock::now());
            tell();
        }
    }

    static constexpr std::chrono::milliseconds look_interval{100};

    void start(std::size_t index, const Case& which) {
        trials_.emplace_back();
        if (auto why = skip_reason(which); !why.empty()) {
            results_[index] = Result{.which = &which, .outcome = Outcome::skipped, .reason = std::move(why)};
            return;
        }
        auto trial = std::make_unique<Trial>(subject_, which);
        which.run(trial->bench);
        trials_.back() = std::move(trial);
        settle(index);
    }

    std::string skip_reason(const Case& which) {
        if (is_interrupted()) return "interrupted";
        if (report_.lost) return lost_words_;
        if (which.manner == Manner::writes && !subject_.writes()) return "needs --allow-writes";
        return {};
    }

    /// Those whose time has come.
    void go_on(Clock::time_point now) {
        for (std::size_t i = 0; i < trials_.size(); ++i) {
            if (!trials_[i] || !trials_[i]->later || trials_[i]->later->due > now) continue;
            continue_with(*trials_[i]);
            settle(i);
        }
    }

    /// What the case has kept for this ends here, since it needs the bench for its end.
    void continue_with(Trial& trial) {
        const auto then = std::move(trial.later->then);
        trial.later.reset();
        if (is_interrupted()) {
            trial.bench.skip("interrupted");
        } else {
            then();
        }
    }

    /// It is over, or it goes on later.
    void settle(std::size_t index) {
        auto& trial = trials_[index];
        trial->later = trial->bench.take_later();
        if (trial->later) return;
        auto& bench = trial->bench;
        Result result{.which = &bench.which(),
                      .outcome = bench.outcome(),
                      .reason = bench.reason(),
                      .findings = bench.findings(),
                      .record = std::move(bench.record),
                      .took = since(trial->begin)};
        trial.reset();
        if (result.outcome == Outcome::fail) look_after(*result.which);
        results_[index] = std::move(result);
    }

    /// A device that no longer answers fails everything else too, which tells nobody anything.
    void look_after(const Case& which) {
        if (report_.lost) return;
        const auto end = Clock::now() + patience_after_failure * subject_.options().timeout;
        while (!answers(subject_)) {
            if (Clock::now() >= end || is_interrupted()) {
                report_.lost = true;
                lost_words_ = fmt::format("the device has not answered since {}", which.id);
                return;
            }
            std::this_thread::sleep_for(look_interval);
        }
    }

    void tell() {
        for (; told_ < results_.size() && results_[told_]; ++told_) {
            if (progress_) progress_(*results_[told_]);
            report_.results.push_back(std::move(*results_[told_]));
        }
    }

    bool is_interrupted() {
        if (interrupted_ && interrupted_()) report_.interrupted = true;
        return report_.interrupted;
    }

    Subject& subject_;
    const Progress& progress_;
    const Interrupted& interrupted_;
    Report report_;
    std::string lost_words_;
    std::vector<std::unique_ptr<Trial>> trials_;
    std::vector<std::optional<Result>> results_;
    std::size_t told_ = 0;
};

}  // namespace

std::size_t Report::count(Outcome outcome) const {
    return static_cast<std::size_t>(std::ranges::count(results, outcome, &Result::outcome));
}

Report run_cases(Subject& subject, std::span<const Case* const> cases, const Progress& progress,
                 const Interrupted& interrupted) {
    return Run(subject, progress, interrupted).go(cases);
}

std::string get_acquainted(Subject& subject) {
    Bench bench(subject, background);
    Wire wire(bench);
    if (!wire.is_open()) return bench.findings().front().words;
    static_cast<void>(wire.send(make_frame(bench, enip::Command::list_identity)));
    const auto reply = wire.receive();
    if (!reply) return "it accepts TCP connections, and does not answer ListIdentity";
    if (const auto item = enip::asio::read_identity_reply(*reply)) subject.identity = identity_of(*item);
    return {};
}

}  // namespace servobus::scanner::conformance
