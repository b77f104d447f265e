#include "diagnosis/discovery/open_numbers.h"

#include <algorithm>
#include <cctype>

namespace stillpoint::diag {
namespace {

/// The function in whose brackets `at` stands; empty: in plain brackets.
std::string function_around(const std::string& text, std::size_t at) {
  int depth = 0;
  while (at > 0 && (text[--at] != '(' || depth > 0)) depth += text[at] == ')' ? 1 : text[at] == '(' ? -1 : 0;
  std::size_t begin = at;
  while (begin > 0 && std::isalpha(static_cast<unsigned char>(text[begin - 1])) != 0) --begin;
  return text.substr(begin, at - begin);
}

OpenNumber named(const std::string& text, std::size_t at, std::string digits) {
  const std::string function = function_around(text, at);
  if (function == "lag" || function == "exp" || function == "log") return {std::move(digits), "tau", "s"};
  if (function == "delay") return {std::move(digits), "delay", "s"};
  if (function == "sin" || function == "cos") return {std::move(digits), "period / 2 pi", ""};
  if (function != "step") return {std::move(digits), function == "tanh" ? "level" : "width", ""};
  if (text.substr(0, at).ends_with("step(t")) return {std::move(digits), "at", "s"};
  return {std::move(digits), "threshold", ""};
}

}  // namespace

std::vector<OpenNumber> open_numbers(const std::string& text) {
  std::vector<OpenNumber> out;
  for (const std::string lead : {", ", " / "})
    for (std::size_t at = text.find(lead); at != std::string::npos; at = text.find(lead, at + 1)) {
      const std::size_t from = at + lead.size(), to = text.find_first_not_of("0123456789.e-+", from);
      std::string digits = text.substr(from, to - from);
      const bool known =
          std::any_of(out.begin(), out.end(), [&digits](const OpenNumber& n) { return n.digits == digits; });
      if (digits.empty() || known || to == std::string::npos || text[to] != ')') continue;
      out.push_back(named(text, at, std::move(digits)));
    }
  return out;
}

std::string with_number(std::string text, const std::string& digits, const std::string& other) {
  for (const std::string& before : {", " + digits + ")", " / " + digits + ")", "- " + digits + ")"})
    for (std::size_t at = text.find(before); at != std::string::npos; at = text.find(before, at + 1))
      text.replace(at + before.size() - digits.size() - 1, digits.size(), other);
  return text;
}

std::string form_of(std::string text) {
  for (const OpenNumber& n : open_numbers(text)) text = with_number(std::move(text), n.digits, "{}");
  return text;
}

}  // namespace stillpoint::diag
