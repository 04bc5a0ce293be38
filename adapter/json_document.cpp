#include "adapter/json_document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <vector>

namespace servobus::adapter {
namespace {

using nlohmann::json;

// How far the parser has read. The library copies its iterators, so they share this through a pointer.
struct Cursor {
    Position next;
    std::size_t octets = 0;

    void pass(char c) {
        ++octets;
        if (c == '\n') {
            ++next.line;
            next.column = 1;
        } else {
            ++next.column;
        }
    }
};

class CountingIterator {
public:
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    CountingIterator(const char* at, Cursor& cursor) : at_(at), cursor_(&cursor) {}
    reference operator*() const { return *at_; }
    CountingIterator& operator++() {
        cursor_->pass(*at_++);
        return *this;
    }
    CountingIterator operator++(int) {
        auto before = *this;
        ++*this;
        return before;
    }
    bool operator==(const CountingIterator& other) const { return at_ == other.at_; }

private:
    const char* at_;
    Cursor* cursor_;
};

// Deeper than any setting stands.
constexpr std::size_t max_depth = 8;

// Follows the parser through objects, and notes where each key begins. Objects inside arrays have no settings.
class Positions {
public:
    explicit Positions(const Cursor& cursor) : cursor_(cursor) {}

    // False: the library drops the value, as it may all values behind an error.
    bool on_event(int depth, json::parse_event_t event, const json& parsed) {
        if (error) return false;
        using Event = json::parse_event_t;
        const bool opens = event == Event::object_start || event == Event::array_start;
        if (opens && static_cast<std::size_t>(depth) >= max_depth) {
            error = JsonError{back(1), "objects and arrays stand too deep in each other here"};
            return false;
        }
        if (event == Event::array_start) ++arrays_;
        if (event == Event::array_end) --arrays_;
        if (event == Event::key && arrays_ == 0) on_key(depth, parsed);
        return true;
    }

    std::map<std::string, Position> found;
    std::optional<JsonError> error;

private:
    void on_key(int depth, const json& parsed) {
        const auto level = static_cast<std::size_t>(depth);
        path_.resize(level);
        path_.back() = parsed.get<std::string>();
        json::json_pointer pointer;
        for (const auto& part : path_) pointer /= part;
        const auto position = back(parsed.get_ref<const std::string&>().size() + 2);
        if (!found.emplace(pointer.to_string(), position).second) {
            error = JsonError{position, fmt::format("'{}' stands here a second time", parsed.get<std::string>())};
        }
    }

    // Where the token begins that the parser has just read.
    [[nodiscard]] Position back(std::size_t width) const {
        auto position = cursor_.next;
        position.column -= std::min(position.column - 1, width);
        return position;
    }

    const Cursor& cursor_;
    std::vector<std::string> path_;
    std::size_t arrays_ = 0;
};

// The library's text begins with its own tag in brackets, and perhaps the position; what follows is for people.
std::string plain_reason(const std::string& what) {
    auto reason = what.substr(std::min(what.find("] ") + 2, what.size()));
    const auto colon = reason.find(": ");
    return reason.starts_with("parse error") && colon != std::string::npos ? reason.substr(colon + 2) : reason;
}

// The position of an octet, for errors that name one.
Position position_of(const std::string& text, std::size_t octet) {
    Cursor cursor;
    for (std::size_t i = 0; i + 1 < octet && i < text.size(); ++i) cursor.pass(text[i]);
    return cursor.next;
}

}  // namespace

std::variant<JsonDocument, JsonError> parse_json(const std::string& text) {
    Cursor cursor;
    Positions positions(cursor);
    const auto* begin = text.data();
    try {
        auto root = json::parse(CountingIterator(begin, cursor), CountingIterator(begin + text.size(), cursor),
                                [&](int depth, json::parse_event_t event, json& parsed) {
                                    return positions.on_event(depth, event, parsed);
                                });
        if (positions.error) return *positions.error;
        return JsonDocument{std::move(root), std::move(positions.found)};
    } catch (const json::parse_error& error) {
        return JsonError{position_of(text, error.byte), plain_reason(error.what())};
    } catch (const json::out_of_range& error) {
        // A number that no type holds; the parser knows its end once it has read one octet more.
        return JsonError{position_of(text, cursor.octets - 1), plain_reason(error.what())};
    }
}

}  // namespace servobus::adapter
