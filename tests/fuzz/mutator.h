/// Damages inputs at random, the same way for the same seed.
#pragma once
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace stillpoint::fuzz {

class Mutator {
 public:
  /// `tokens` are words that the reader of the inputs knows; no mutant is longer than `most_bytes`.
  Mutator(std::vector<std::string> tokens, std::uint64_t seed, std::size_t most_bytes)
      : tokens_(std::move(tokens)), random_(seed), most_bytes_(most_bytes) {}

  /// One of the inputs with one to eight edits.
  [[nodiscard]] std::string mutant(const std::vector<std::string>& inputs);

 private:
  std::size_t below(std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(random_() % n); }
  std::size_t length_from(const std::string& text, std::size_t at) {
    return 1 + below(std::min<std::size_t>(text.size() - at, 1 + below(64)));
  }
  void edit(std::string& text, const std::vector<std::string>& inputs);
  void overwrite(std::string& text, const std::string& by);
  void put_binary_number(std::string& text);
  void put_decimal_number(std::string& text);
  void splice(std::string& text, const std::string& other);

  std::vector<std::string> tokens_;
  std::mt19937_64 random_;
  std::size_t most_bytes_;
};

}  // namespace stillpoint::fuzz
