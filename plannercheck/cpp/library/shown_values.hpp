// Numbers and names in errors, as Python's errors have them: the same fault has the same sentence in both.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plannercheck {

// A number as Python writes it: with the fewest digits that give it back.
inline std::string shown(double x) {
  if (!std::isfinite(x)) return std::isnan(x) ? "nan" : x > 0 ? "inf" : "-inf";
  const double size = std::fabs(x);
  const bool is_fixed = size == 0 || (size >= 1e-4 && size < 1e16);
  std::array<char, 32> text{};
  char* const end = std::to_chars(text.data(), text.data() + text.size(), x,
                                  is_fixed ? std::chars_format::fixed : std::chars_format::scientific)
                        .ptr;
  const std::string out(text.data(), end);
  return is_fixed && out.find('.') == std::string::npos ? out + ".0" : out;
}

// The number with so many digits.
inline std::string rounded(double x, int digits) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, x);
  return text.data();
}

inline std::string listed(std::span<const double> row) {
  std::string out = "[";
  for (std::size_t k = 0; k < row.size(); ++k) out += (k > 0 ? ", " : "") + shown(row[k]);
  return out + ']';
}

// How many characters difflib's SequenceMatcher finds in common: those of the longest block, and left and right of it.
inline std::size_t in_common(std::string_view a, std::string_view b) {
  std::size_t longest = 0, in_a = 0, in_b = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      std::size_t length = 0;
      while (i + length < a.size() && j + length < b.size() && a[i + length] == b[j + length]) ++length;
      if (length > longest) longest = length, in_a = i, in_b = j;
    }
  }
  if (longest == 0) return 0;
  return longest + in_common(a.substr(0, in_a), b.substr(0, in_b)) +
         in_common(a.substr(in_a + longest), b.substr(in_b + longest));
}

inline std::string shortened(const std::string& name) {
  constexpr std::size_t kLongestName = 100;
  return name.size() <= kLongestName ? name : name.substr(0, kLongestName - 3) + "...";
}

// `unknown_name` of plannercheck/common/errors.py.
inline std::string unknown_name(const std::string& kind, std::string name, std::vector<std::string> valid) {
  constexpr double kAlike = 0.6;
  constexpr std::size_t kHints = 3;
  name = shortened(name);
  std::vector<std::pair<double, std::string>> close;
  std::string listed;
  for (std::string& each : valid) {
    each = shortened(each);
    listed += (listed.empty() ? "" : ", ") + each;
    const double alike =
        2.0 * static_cast<double>(in_common(each, name)) / static_cast<double>(each.size() + name.size());
    if (alike >= kAlike) close.emplace_back(alike, each);
  }
  std::sort(close.rbegin(), close.rend());
  std::string hint;
  for (std::size_t k = 0; k < std::min(close.size(), kHints); ++k)
    hint += (k > 0 ? " or '" : "did you mean '") + close[k].second + "'";
  return "unknown " + kind + " '" + name + "': " + hint + (hint.empty() ? "" : "? ") + "valid are " +
         (listed.empty() ? "none" : listed);
}

}  // namespace plannercheck
