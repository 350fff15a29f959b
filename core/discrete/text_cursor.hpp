#pragma once
// Walks through text in memory, word by word. Private to core/discrete.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

namespace tetloom::detail {

/// Facets or lines between two looks at whether the run is cancelled.
inline constexpr std::size_t kCancelEvery = std::size_t{1} << 16;

inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

/// Whether `word` equals `lower`, which is in lower case, whatever the case of `word`.
inline bool equals_ignoring_case(std::string_view word, std::string_view lower) {
  return std::equal(word.begin(), word.end(), lower.begin(), lower.end(),
                    [](char a, char b) { return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b; });
}

/// The whole of `word` as a number. Accepts a leading '+', "nan" and "inf"; false if it is none.
inline bool parse_number(std::string_view word, double& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range && end == word.data() + word.size()) {
    const bool tiny = word.find("e-") != word.npos || word.find("E-") != word.npos;
    value = tiny ? 0.0 : HUGE_VAL;
    return true;
  }
  return error == std::errc() && end == word.data() + word.size() && !word.empty();
}

/// A place in a text, which it refers to.
class TextCursor {
 public:
  explicit TextCursor(std::string_view text) : text_(text) {}

  bool at_end() const { return position_ >= text_.size(); }
  /// The next word on any line; empty at the end of the text.
  std::string_view next_word() {
    while (!at_end() && (is_blank(text_[position_]) || text_[position_] == '\n')) ++position_;
    return take_word();
  }
  /// The next word on this line; empty at the end of the line.
  std::string_view next_word_on_line() {
    while (!at_end() && is_blank(text_[position_])) ++position_;
    return take_word();
  }
  /// What is left of this line without blanks around it.
  std::string_view peek_rest_of_line() const {
    std::string_view line = text_.substr(position_, end_of_line() - position_);
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
    return line;
  }
  /// The same; moves to the next line.
  std::string_view rest_of_line() {
    const std::string_view line = peek_rest_of_line();
    position_ = std::min(end_of_line() + 1, text_.size());
    return line;
  }
  /// 1-based; costs a scan, meant for messages.
  std::size_t line() const {
    return 1 +
           static_cast<std::size_t>(std::count(text_.begin(), text_.begin() + std::min(position_, text_.size()), '\n'));
  }

 private:
  std::size_t end_of_line() const { return std::min(text_.find('\n', position_), text_.size()); }
  std::string_view take_word() {
    const std::size_t begin = position_;
    while (!at_end() && !is_blank(text_[position_]) && text_[position_] != '\n') ++position_;
    return text_.substr(begin, position_ - begin);
  }

  std::string_view text_;
  std::size_t position_ = 0;
};

}  // namespace tetloom::detail
