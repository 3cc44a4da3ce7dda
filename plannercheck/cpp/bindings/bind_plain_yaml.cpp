// YAML whose lines can be read one by one, as programs and most people write it.
//
// In: the text of one document, and a Python function that reads a word without quotes that is no plain number. Out:
// the document's value, or None for everything that this small part of YAML does not cover; nothing is guessed.
//
// Covered are block mappings and sequences of printable ASCII, one item a line. A value is one word or text without
// quotes, a text in quotes without escapes, or a flow sequence or mapping that ends on its line. Keys are identifiers.
// Comments may follow what is not in quotes. A line that is indented deeper than what it could continue is not covered,
// since it may continue the text before it.
#include <nanobind/nanobind.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

struct NotCovered {};

// Levels of blocks and of a flow collection within; both together are DEEPEST_LINES in common/plain_yaml.py.
constexpr std::size_t kDeepestBlocks = 48;
constexpr int kDeepestFlow = 16;
// Texts of more characters are not kept by `word`, nor are longer numbers read here.
constexpr std::size_t kLongestWord = 64;
constexpr std::size_t kMostDigits = 16;  // of a whole number

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool begins_name(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_of_name(char c) { return begins_name(c) || is_digit(c); }
// Characters that mean nothing by themselves, here or in a flow collection.
bool is_of_word(char c) { return is_of_name(c) || c == '/' || c == '.' || c == '+' || c == '-'; }

// The character at a place, 0 behind the end.
char at_or_end(std::string_view text, std::size_t place) { return place < text.size() ? text[place] : '\0'; }

std::size_t past_spaces(std::string_view text, std::size_t place) {
  while (at_or_end(text, place) == ' ') ++place;
  return place;
}

// Characters that go on a text without quotes. Commas and colons mean something in flow collections.
bool goes_on_word(char c, bool in_flow) {
  return is_of_word(c) || c == '(' || c == ')' || c == '%' || (c == ',' && !in_flow);
}

// Where the text without quotes that begins at a place ends.
std::size_t end_of_word(std::string_view text, std::size_t place, bool in_flow) {
  const char first = at_or_end(text, place), second = at_or_end(text, place + 1);
  if (!is_of_word(first) || (first == '-' && !is_of_name(second) && second != '.')) throw NotCovered{};
  for (++place; place < text.size(); ++place) {
    const char c = text[place];
    const bool joins = (c == ' ' || (c == ':' && !in_flow)) && goes_on_word(at_or_end(text, place + 1), in_flow);
    if (!goes_on_word(c, in_flow) && !joins) break;
  }
  return place;
}

// Where the text in quotes that begins at a place ends.
std::size_t end_of_quoted(std::string_view text, std::size_t place) {
  const char quote = text[place];
  for (++place; place < text.size() && text[place] != quote; ++place) {
    if (text[place] == '\\') throw NotCovered{};
  }
  if (place == text.size() || at_or_end(text, place + 1) == quote) throw NotCovered{};
  return place + 1;
}

std::size_t end_of_digits(std::string_view text, std::size_t place) {
  while (is_digit(at_or_end(text, place))) ++place;
  return place;
}

nb::object text_of(std::string_view text) { return nb::str(text.data(), text.size()); }

class BlockReader {
 public:
  explicit BlockReader(nb::object word) : word_(std::move(word)) {}

  nb::object document(std::string_view text) {
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      read(without_comment(text.substr(begin, end - begin)));
      begin = end + 1;
    }
    close_key();
    if (open_.empty()) throw NotCovered{};
    return open_.front().value;
  }

 private:
  struct Open {
    std::size_t column;
    nb::object value;
    bool is_list;
  };

  nb::object word_;
  std::vector<Open> open_;   // collections, the outer ones first
  bool is_waiting_ = false;  // whether the value of the last key or item comes on the next lines
  nb::object key_;           // the last key, if the innermost collection is a mapping

  // The line without its comment and without blanks behind it.
  static std::string_view without_comment(std::string_view line) {
    for (const char c : line) {
      if (c < ' ' || c > '~') throw NotCovered{};
    }
    const std::size_t mark = line.find('#');
    if (mark != std::string_view::npos) {
      const std::string_view before = line.substr(0, mark);
      if (before.find_first_of("\"'") != std::string_view::npos || (mark > 0 && before.back() != ' '))
        throw NotCovered{};
      line = before;
    }
    while (!line.empty() && line.back() == ' ') line.remove_suffix(1);
    return line;
  }

  void read(std::string_view line) {
    if (line.empty()) return;
    const std::size_t indent = past_spaces(line, 0);
    std::size_t column = indent;
    while (line[column] == '-' && at_or_end(line, column + 1) == ' ') column += 2;
    const bool is_dash = line[column] == '-' && column + 1 == line.size();
    const bool is_item = is_dash || column > indent;
    std::size_t colon = column;
    while (is_of_name(at_or_end(line, colon))) ++colon;
    const char after = at_or_end(line, colon + 1);
    const bool is_key = begins_name(line[column]) && at_or_end(line, colon) == ':' && (after == ' ' || after == '\0');
    if (!is_key && !is_item) throw NotCovered{};
    settle(indent, is_item);
    for (std::size_t inner = indent + 2; inner < column + (is_dash ? 2 : 0); inner += 2) begin(inner, true);
    if (is_dash) {
      is_waiting_ = true;
    } else if (!is_key) {
      put(value(line.substr(column)));
    } else {
      if (is_item) begin(column, false);
      key_ = plain(line.substr(column, colon - column));
      is_waiting_ = true;
      if (after == ' ') put(value(line.substr(past_spaces(line, colon + 1))));
    }
  }

  // Makes the collection at a column that a line continues or begins the innermost one.
  void settle(std::size_t column, bool is_item) {
    if (open_.empty()) return begin(column, is_item);
    if (is_waiting_) {
      const Open& last = open_.back();
      // An item may be in the column of the key whose value it begins.
      if (column > last.column || (column == last.column && is_item && !last.is_list)) return begin(column, is_item);
      close_key();
    } else if (column > open_.back().column) {
      throw NotCovered{};
    }
    while (!open_.empty() && open_.back().column > column) open_.pop_back();
    if (!open_.empty() && !is_item && open_.back().column == column && open_.back().is_list)
      open_.pop_back();  // which was in the column of its key
    if (open_.empty() || open_.back().column != column || open_.back().is_list != is_item) throw NotCovered{};
  }

  void begin(std::size_t column, bool is_list) {
    if (open_.size() == kDeepestBlocks) throw NotCovered{};
    nb::object made = is_list ? nb::object(nb::list()) : nb::object(nb::dict());
    if (!open_.empty()) {
      put(made);
    } else if (column > 0) {
      throw NotCovered{};
    }
    open_.push_back({column, std::move(made), is_list});
  }

  // Puts a value into the innermost collection.
  void put(const nb::object& value) {
    const Open& last = open_.back();
    if (last.is_list) {
      nb::borrow<nb::list>(last.value).append(value);
    } else {
      nb::borrow<nb::dict>(last.value)[key_] = value;
    }
    is_waiting_ = false;
  }

  // A key or an item without a value.
  void close_key() {
    if (is_waiting_) put(nb::none());
  }

  // The value that is the whole of a text.
  nb::object value(std::string_view text) {
    std::size_t place = 0;
    nb::object out;
    if (text[0] == '[' || text[0] == '{') {
      out = flow(text, place, 0);
    } else if (text[0] == '"' || text[0] == '\'') {
      place = end_of_quoted(text, 0);
      out = text_of(text.substr(1, place - 2));
    } else {
      place = end_of_word(text, 0, false);
      out = plain(text.substr(0, place));
    }
    if (place != text.size()) throw NotCovered{};
    return out;
  }

  // The value in a flow collection that begins at a place, which goes on behind it.
  nb::object flow(std::string_view text, std::size_t& place, int depth) {
    place = past_spaces(text, place);
    if (place == text.size() || depth >= kDeepestFlow) throw NotCovered{};
    const std::size_t begin = place;
    switch (text[begin]) {
      case '[':
        return flow_items(text, place, depth);
      case '{':
        return flow_entries(text, place, depth);
      case '"':
      case '\'':
        place = end_of_quoted(text, begin);
        return text_of(text.substr(begin + 1, place - begin - 2));
      default:
        place = end_of_word(text, begin, true);
        return plain(text.substr(begin, place - begin));
    }
  }

  nb::object flow_items(std::string_view text, std::size_t& place, int depth) {
    nb::list items;
    place = past_spaces(text, place + 1);
    for (bool goes_on = at_or_end(text, place) != ']'; goes_on;) {
      items.append(flow(text, place, depth + 1));
      goes_on = goes_on_behind(text, place, ']');
    }
    ++place;
    return items;
  }

  nb::object flow_entries(std::string_view text, std::size_t& place, int depth) {
    nb::dict entries;
    place = past_spaces(text, place + 1);
    for (bool goes_on = at_or_end(text, place) != '}'; goes_on;) {
      const std::size_t begin = place = past_spaces(text, place);
      while (is_of_name(at_or_end(text, place))) ++place;
      if (!begins_name(at_or_end(text, begin)) || text.substr(place, 2) != ": ") throw NotCovered{};
      const nb::object key = plain(text.substr(begin, place - begin));
      entries[key] = flow(text, ++place, depth + 1);
      goes_on = goes_on_behind(text, place, '}');
    }
    ++place;
    return entries;
  }

  // Whether a comma follows, behind which `place` is then, not the end of the collection, at which it is else.
  static bool goes_on_behind(std::string_view text, std::size_t& place, char end) {
    place = past_spaces(text, place);
    const char mark = at_or_end(text, place);
    if (mark != ',' && mark != end) throw NotCovered{};
    if (mark == ',') ++place;
    return mark == ',';
  }

  // The value of a text without quotes.
  nb::object plain(std::string_view text) {
    if (text.size() > kLongestWord) throw NotCovered{};
    const std::size_t first = text[0] == '-' ? 1 : 0, point = end_of_digits(text, first), digits = point - first;
    if (digits > 0 && point == text.size() && digits <= kMostDigits && (digits == 1 || text[first] != '0'))
      return whole(text.substr(first), first > 0);
    if (digits > 0 && at_or_end(text, point) == '.') {
      std::size_t end = end_of_digits(text, point + 1);
      const char mark = at_or_end(text, end), sign = at_or_end(text, end + 1);
      if ((mark == 'e' || mark == 'E') && (sign == '-' || sign == '+') && is_digit(at_or_end(text, end + 2)))
        end = end_of_digits(text, end + 2);
      if (end == text.size()) return decimal(text);
    }
    return word_(text_of(text));
  }

  static nb::object whole(std::string_view digits, bool is_negative) {
    long long number = 0;
    for (const char digit : digits) number = 10 * number + (digit - '0');
    return nb::int_(is_negative ? -number : number);
  }

  // As Python's `float` reads it.
  static nb::object decimal(std::string_view text) {
    const std::string ended(text);
    const double number = PyOS_string_to_double(ended.c_str(), nullptr, nullptr);
    if (PyErr_Occurred() != nullptr) throw nb::python_error();
    return nb::float_(number);
  }
};

nb::object plain_yaml(const nb::bytes& text, nb::object word) {
  try {
    return BlockReader(std::move(word)).document({text.c_str(), text.size()});
  } catch (const NotCovered&) {
    return nb::none();
  }
}

}  // namespace

void bind_plain_yaml(nb::module_& m) {
  m.def("plain_yaml", &plain_yaml, nb::arg("text"), nb::arg("word"), plain_floats);
}

}  // namespace plannercheck
