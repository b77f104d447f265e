/// The pieces of a line of text: its fields, and names in whatever letters they were written.
#pragma once
#include <algorithm>
#include <string>
#include <string_view>

#include "io/recording_header.h"

namespace stillpoint::sources {

inline char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// Without blanks, and without the mark that some programs set before a text in UTF-8.
inline std::string_view bare(std::string_view line) noexcept {
  line = io::strip(line);
  if (line.substr(0, 3) == "\xEF\xBB\xBF") line = io::strip(line.substr(3));
  return line;
}

inline std::string_view unquoted(std::string_view name) noexcept {
  const bool quoted = name.size() > 1 && name.front() == '"' && name.back() == '"';
  return quoted ? name.substr(1, name.size() - 2) : name;
}

/// A name as we write it, whatever letters it was written in. Allocates.
inline std::string in_our_letters(std::string_view name) {
  std::string out(name);
  std::transform(out.begin(), out.end(), out.begin(), lower);
  for (const std::string_view unit : {"_uT", "_T", "_degC"}) {
    const std::size_t stem = out.size() - std::min(out.size(), unit.size());
    const auto same = [](char a, char b) { return a == lower(b); };
    if (std::equal(out.begin() + static_cast<std::ptrdiff_t>(stem), out.end(), unit.begin(), unit.end(), same))
      out.replace(stem, unit.size(), unit);
  }
  return out;
}

/// Commas, semicolons and tabs separate; where there is none, blanks do.
inline bool separates(char c, bool blanks) noexcept {
  return c == ',' || c == ';' || c == '\t' || (blanks && c == ' ');
}

class Fields {
 public:
  explicit Fields(std::string_view line) noexcept
      : rest_(line), blanks_(line.find_first_of(",;\t") == std::string_view::npos) {}
  bool next(std::string_view& field) noexcept {
    if (done_) return false;
    std::size_t end = 0;
    while (end < rest_.size() && !separates(rest_[end], blanks_)) ++end;
    field = io::strip(rest_.substr(0, end));
    done_ = end == rest_.size();
    if (done_) return true;
    rest_.remove_prefix(end + 1);
    while (blanks_ && !rest_.empty() && rest_[0] == ' ') rest_.remove_prefix(1);
    return true;
  }

 private:
  std::string_view rest_;
  bool blanks_, done_ = false;
};

}  // namespace stillpoint::sources
