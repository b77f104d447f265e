#include "sources/json_line.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace stillpoint::sources {
namespace {

constexpr int kDeepest = 8;

class Scanner {
 public:
  Scanner(std::string_view text, const OnNumber& on_number) noexcept : text_(text), on_number_(on_number) {}

  bool object_alone() noexcept {
    skip_blanks();
    if (!object(0)) return false;
    skip_blanks();
    return at_ == text_.size();
  }

 private:
  void skip_blanks() noexcept {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\r')) ++at_;
  }
  bool take(char c) noexcept {
    skip_blanks();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }

  /// A name with an escape is kept as it is written: none of ours has one.
  bool string(std::string_view& out) noexcept {
    if (!take('"')) return false;
    const std::size_t start = at_;
    while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2U : 1U;
    if (at_ >= text_.size()) return false;
    out = text_.substr(start, at_ - start);
    ++at_;
    return true;
  }

  /// Appends to the path; false when it would grow too long.
  bool enter(std::string_view name) noexcept {
    const std::size_t dot = length_ > 0 ? 1 : 0;
    if (length_ + dot + name.size() > path_.size()) return false;
    if (dot != 0) path_[length_++] = '.';
    std::copy(name.begin(), name.end(), path_.begin() + static_cast<std::ptrdiff_t>(length_));
    length_ += name.size();
    return true;
  }

  bool object(int depth) noexcept {
    if (depth == kDeepest || !take('{')) return false;
    if (take('}')) return true;
    do {
      std::string_view name;
      const std::size_t before = length_;
      if (!string(name) || !take(':') || !enter(name) || !value(depth)) return false;
      length_ = before;
    } while (take(','));
    return take('}');
  }

  bool array(int depth) noexcept {
    if (depth == kDeepest || !take('[')) return false;
    if (take(']')) return true;
    int index = 0;
    do {
      std::array<char, 12> digits{};
      const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), index++).ptr;
      const std::size_t before = length_;
      if (!enter({digits.data(), static_cast<std::size_t>(end - digits.data())}) || !value(depth)) return false;
      length_ = before;
    } while (take(','));
    return take(']');
  }

  bool word(std::string_view expected) noexcept {
    if (text_.substr(at_, expected.size()) != expected) return false;
    at_ += expected.size();
    return true;
  }

  bool value(int depth) noexcept {
    skip_blanks();
    if (at_ >= text_.size()) return false;
    switch (text_[at_]) {
      case '{':
        return object(depth + 1);
      case '[':
        return array(depth + 1);
      case '"':
        return number_in_quotes();
      case 't':
        return word("true");
      case 'f':
        return word("false");
      case 'n':
        return word("null");
      default:
        return number();
    }
  }

  /// Loggers of phones write every value as a string. A text that is no number is passed over.
  bool number_in_quotes() noexcept {
    std::string_view text;
    if (!string(text)) return false;
    const char* const end = text.data() + text.size();
    double x = 0.0;
    const bool begins_as_one = !text.empty() && (text[0] == '-' || (text[0] >= '0' && text[0] <= '9'));
    if (const auto [stop, code] = std::from_chars(text.data(), end, x);
        begins_as_one && stop == end && code == std::errc{})
      on_number_({path_.data(), length_}, x);
    return true;
  }

  bool number() noexcept {
    double x = 0.0;
    const char* begin = text_.data() + at_;
    const auto [stop, code] = std::from_chars(begin, text_.data() + text_.size(), x);
    if (code == std::errc::invalid_argument) return false;
    at_ += static_cast<std::size_t>(stop - begin);
    if (code == std::errc{}) on_number_({path_.data(), length_}, x);
    return true;
  }

  std::string_view text_;
  const OnNumber& on_number_;
  std::size_t at_ = 0, length_ = 0;
  std::array<char, 128> path_{};
};

}  // namespace

bool for_each_number_of(std::string_view line, const OnNumber& on_number) noexcept {
  return Scanner(line, on_number).object_alone();
}

}  // namespace stillpoint::sources
