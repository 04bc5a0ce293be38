#include "tests/fuzz/mutation.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace servobus::fuzz {
namespace {

using cip::Bytes;
using cip::ByteView;

constexpr std::size_t longest = 8192;

/// Values at which counts and lengths go wrong.
constexpr std::array<std::uint8_t, 9> edges{0x00, 0x01, 0x02, 0x7F, 0x80, 0x81, 0xFD, 0xFE, 0xFF};

class Mutator {
public:
    Mutator(Bytes& octets, std::span<const Bytes> others, std::mt19937_64& random)
        : octets_(octets), others_(others), random_(random) {}

    void change() {
        switch (below(octets_.empty() ? 1 : 7)) {
            case 0:
                insert(Bytes(1 + below(4), static_cast<std::uint8_t>(random_())));
                break;
            case 1:
                octets_[below(octets_.size())] ^= static_cast<std::uint8_t>(1U << below(8));
                break;
            case 2:
                octets_[below(octets_.size())] = edges[below(edges.size())];
                break;
            case 3:
                octets_[below(octets_.size())] += static_cast<std::uint8_t>(below(2) == 0 ? 1 : 0xFF);
                break;
            case 4:
                octets_.resize(below(octets_.size() + 1));
                break;
            case 5: {
                const auto first = octets_.begin() + static_cast<std::ptrdiff_t>(below(octets_.size()));
                octets_.erase(first, first + std::min<std::ptrdiff_t>(octets_.end() - first,
                                                                      1 + static_cast<std::ptrdiff_t>(below(8))));
                break;
            }
            default:
                insert(part_of(others_[below(others_.size())]));
        }
    }

private:
    std::size_t below(std::size_t count) { return static_cast<std::size_t>(random_() % count); }

    Bytes part_of(const Bytes& other) {
        if (other.empty()) return {};
        const auto first = below(other.size());
        const auto part = ByteView(other).subspan(first, std::min<std::size_t>(other.size() - first, 1 + below(64)));
        return {part.begin(), part.end()};
    }
    void insert(const Bytes& part) {
        if (octets_.size() + part.size() > longest) return;
        octets_.insert(octets_.begin() + static_cast<std::ptrdiff_t>(below(octets_.size() + 1)), part.begin(),
                       part.end());
    }

    Bytes& octets_;
    std::span<const Bytes> others_;
    std::mt19937_64& random_;
};

}  // namespace

Bytes mutate(ByteView input, std::span<const Bytes> others, std::mt19937_64& random) {
    Bytes octets(input.begin(), input.end());
    Mutator mutator(octets, others, random);
    for (auto changes = 1 + random() % 4; changes > 0; --changes) mutator.change();
    octets.shrink_to_fit();
    return octets;
}

}  // namespace servobus::fuzz
