#include "tests/fuzz/mutator.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace stillpoint::fuzz {
namespace {

/// Where lengths, counts and times go wrong.
constexpr std::array<std::uint64_t, 18> kNumbers{0,
                                                 1,
                                                 0x7f,
                                                 0x80,
                                                 0xff,
                                                 0x100,
                                                 0x7fff,
                                                 0x8000,
                                                 0xffff,
                                                 0x10000,
                                                 0x7fffffff,
                                                 0x80000000,
                                                 0xffffffff,
                                                 0x100000000,
                                                 1'000'000'000,
                                                 0x7fffffffffffffff,
                                                 0x8000000000000000,
                                                 0xffffffffffffffff};
constexpr std::array<std::string_view, 20> kDecimals{"0",
                                                     "-0",
                                                     "1",
                                                     "-1",
                                                     "0.5",
                                                     "1e-9",
                                                     "1e5",
                                                     "-3e8",
                                                     "1e308",
                                                     "-1e308",
                                                     "1e999",
                                                     "1e-320",
                                                     "nan",
                                                     "inf",
                                                     "-inf",
                                                     "",
                                                     "4600000000000000000",
                                                     "9223372036854775807",
                                                     "-9223372036854775808",
                                                     "99999999999999999999"};
constexpr std::string_view kOfDecimals = "0123456789+-.eE";

}  // namespace

std::string Mutator::mutant(const std::vector<std::string>& inputs) {
  std::string text = inputs[below(inputs.size())];
  for (std::size_t edits = 1 + below(std::size_t{1} << below(4)); edits > 0; --edits) edit(text, inputs);
  if (text.size() > most_bytes_) text.resize(most_bytes_);
  return text;
}

void Mutator::edit(std::string& text, const std::vector<std::string>& inputs) {
  if (text.empty()) {
    text = tokens_.empty() ? "0" : tokens_[below(tokens_.size())];
    return;
  }
  const std::size_t at = below(text.size()), length = length_from(text, at);
  switch (below(12)) {
    case 0:
      text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
      break;
    case 1:
      text[at] = static_cast<char>(below(256));
      break;
    case 2:
      text[at] = static_cast<char>(static_cast<std::size_t>(text[at]) + below(33) - 16);
      break;
    case 3:
      put_binary_number(text);
      break;
    case 4:
      put_decimal_number(text);
      break;
    case 5:
      text.erase(at, length);
      break;
    case 6:
      text.insert(below(text.size()), text.substr(at, length));
      break;
    case 7:
      overwrite(text, text.substr(at, length));
      break;
    case 8:
      splice(text, inputs[below(inputs.size())]);
      break;
    case 9:
      text.resize(at);
      break;
    case 10:
      if (!tokens_.empty()) text.insert(at, tokens_[below(tokens_.size())]);
      break;
    default:
      if (!tokens_.empty()) overwrite(text, tokens_[below(tokens_.size())]);
  }
}

void Mutator::overwrite(std::string& text, const std::string& by) {
  const std::size_t at = below(text.size());
  text.replace(at, std::min(by.size(), text.size() - at), by);
}

/// Of one to eight bytes, either byte order.
void Mutator::put_binary_number(std::string& text) {
  std::uint64_t number = kNumbers[below(kNumbers.size())];
  std::string bytes(std::size_t{1} << below(4), '\0');
  for (char& byte : bytes) {
    byte = static_cast<char>(number & 0xffU);
    number >>= 8U;
  }
  if (below(2) == 0) std::reverse(bytes.begin(), bytes.end());
  overwrite(text, bytes);
}

/// In place of one that stands there.
void Mutator::put_decimal_number(std::string& text) {
  const std::size_t begin = text.find_first_of("0123456789", below(text.size()));
  if (begin == std::string::npos) return;
  const std::size_t end = std::min(text.find_first_not_of(kOfDecimals, begin), text.size());
  text.replace(begin, end - begin, kDecimals[below(kDecimals.size())]);
}

/// The tail, or a stretch, of another input.
void Mutator::splice(std::string& text, const std::string& other) {
  if (other.empty()) return;
  const std::size_t from = below(other.size()), at = below(text.size());
  if (below(2) == 0)
    text.replace(at, std::string::npos, other, from);
  else
    text.insert(at, other, from, length_from(other, from));
}

}  // namespace stillpoint::fuzz
