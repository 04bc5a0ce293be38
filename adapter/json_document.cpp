#include "adapter/json_document.hpp"

#include <fmt/format.h>

#include <iterator>
#include <optional>
#include <vector>

namespace servobus::adapter {
namespace {

using nlohmann::json;

// How far the parser has read. The library copies its iterators, so they share this through a pointer.
struct Cursor {
    Position next;

    void pass(char c) {
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

// Follows the parser through objects and arrays, and notes where each key begins.
class Positions {
public:
    explicit Positions(const Cursor& cursor) : cursor_(cursor) {}

    bool on_event(int depth, json::parse_event_t event, const json& parsed) {
        if (event != json::parse_event_t::key) return true;
        const auto level = static_cast<std::size_t>(depth);
        path_.resize(level);
        path_.back() = parsed.get<std::string>();
        json::json_pointer pointer;
        for (const auto& part : path_) pointer /= part;
        auto position = cursor_.next;  // just behind the closing quote
        const auto width = parsed.get_ref<const std::string&>().size() + 2;
        position.column -= std::min(position.column - 1, width);
        if (!found.emplace(pointer.to_string(), position).second && !repeated) {
            repeated = JsonError{position, fmt::format("'{}' stands here a second time", parsed.get<std::string>())};
        }
        return true;
    }

    std::map<std::string, Position> found;
    std::optional<JsonError> repeated;

private:
    const Cursor& cursor_;
    std::vector<std::string> path_;
};

// The library's text begins with its own tags and position; what follows is for people.
std::string plain_reason(const std::string& what) {
    const auto colon = what.find(": ");
    return colon == std::string::npos ? what : what.substr(colon + 2);
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
        if (positions.repeated) return *positions.repeated;
        return JsonDocument{std::move(root), std::move(positions.found)};
    } catch (const json::parse_error& error) {
        return JsonError{position_of(text, error.byte), plain_reason(error.what())};
    }
}

}  // namespace servobus::adapter
