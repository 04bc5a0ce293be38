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

// Follows the parser, and notes where each key begins, and each object or array that stands in an array.
class Positions {
public:
    explicit Positions(const Cursor& cursor) : cursor_(cursor) {}

    // False: the library drops the value, as it may all values behind an error.
    bool on_event(int depth, json::parse_event_t event, const json& parsed) {
        if (error) return false;
        using Event = json::parse_event_t;
        switch (event) {
            case Event::object_start:
            case Event::array_start:
                return open(static_cast<std::size_t>(depth), event == Event::array_start);
            case Event::object_end:
            case Event::array_end:
                levels_.pop_back();
                return true;
            case Event::key:
                on_key(parsed);
                return true;
            case Event::value:
                if (in_array()) ++levels_.back().elements;
                return true;
        }
        return true;
    }

    std::map<std::string, Position> found;
    std::optional<JsonError> error;

private:
    // An object or array that the parser is in, and the member of it that is being read.
    struct Level {
        bool is_array = false;
        std::size_t elements = 0;  // the last one included
        std::string key{};
    };

    [[nodiscard]] bool in_array() const { return !levels_.empty() && levels_.back().is_array; }

    bool open(std::size_t depth, bool is_array) {
        if (depth >= max_depth) {
            error = JsonError{back(1), "objects and arrays stand too deep in each other here"};
            return false;
        }
        if (in_array()) {
            ++levels_.back().elements;
            found.emplace(pointer(), back(1));
        }
        levels_.push_back({is_array});
        return true;
    }

    void on_key(const json& parsed) {
        const auto& key = parsed.get_ref<const std::string&>();
        levels_.back().key = key;
        const auto position = back(key.size() + 2);
        if (!found.emplace(pointer(), position).second) {
            error = JsonError{position, fmt::format("'{}' stands here a second time", key)};
        }
    }

    // Of what is being read.
    [[nodiscard]] std::string pointer() const {
        json::json_pointer pointer;
        for (const auto& level : levels_) {
            pointer /= level.is_array ? std::to_string(level.elements - 1) : level.key;
        }
        return pointer.to_string();
    }

    // Where the token begins that the parser has just read.
    [[nodiscard]] Position back(std::size_t width) const {
        auto position = cursor_.next;
        position.column -= std::min(position.column - 1, width);
        return position;
    }

    const Cursor& cursor_;
    std::vector<Level> levels_;
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
