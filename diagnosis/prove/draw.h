/// Random numbers of one sealed case: the same salt and index give the same numbers.
#pragma once
#include <fmt/format.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "diagnosis/prove/sha256.h"

namespace stillpoint::diag {

class Draw {
 public:
  Draw(const std::string& salt, std::size_t index) {
    const std::string digest = sha256(fmt::format("{}/{}", salt, index));
    std::seed_seq seed(digest.begin(), digest.end());
    engine_.seed(seed);
  }
  double uniform(double a, double b) { return a + (b - a) * std::uniform_real_distribution<double>()(engine_); }
  double log_uniform(double a, double b) { return std::exp(uniform(std::log(a), std::log(b))); }
  double normal() { return normal_(engine_); }
  std::uint64_t bits() { return engine_(); }
  template <class T>
  const T& one_of(const std::vector<T>& list) {
    return list[engine_() % list.size()];
  }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

}  // namespace stillpoint::diag
