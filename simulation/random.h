/// Random numbers with one independent stream per (seed, source): switching one source on or off leaves every other
/// source's numbers as they were, so that twin simulations differ by one effect alone.
#pragma once
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "core/types.h"

namespace stillpoint::sim {

/// xoshiro256++ of Blackman, Vigna, "Scrambled linear pseudorandom number generators", ACM TOMS 47 (2021), seeded by
/// splitmix64 from the seed and the FNV-1a hash of the source's name.
class Stream {
 public:
  Stream(std::uint64_t seed, std::string_view source) {
    std::uint64_t hash = 0xcbf29ce484222325U;
    for (const char c : source) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
    std::uint64_t x = seed ^ std::rotl(hash, 17);
    for (auto& word : state_) {
      x += 0x9e3779b97f4a7c15U;
      std::uint64_t z = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
      z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
      word = z ^ (z >> 31U);
    }
  }

  std::uint64_t bits() noexcept {
    const std::uint64_t out = std::rotl(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t t = state_[1] << 17U;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= t;
    state_[3] = std::rotl(state_[3], 45);
    return out;
  }

  /// In [0, 1), 53 bits.
  double uniform() noexcept { return static_cast<double>(bits() >> 11U) * 0x1.0p-53; }
  double uniform(double low, double high) noexcept { return low + (high - low) * uniform(); }

  /// Standard normal: the polar method of Marsaglia, Bray (1964); two numbers a round, the second is kept.
  double normal() noexcept {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    double u, v, s;
    do {
      u = 2.0 * uniform() - 1.0;
      v = 2.0 * uniform() - 1.0;
      s = u * u + v * v;
    } while (s >= 1.0 || s == 0.0);
    const double k = std::sqrt(-2.0 * std::log(s) / s);
    spare_ = v * k;
    has_spare_ = true;
    return u * k;
  }

  Vec3 normal3() noexcept {
    const double x = normal(), y = normal(), z = normal();
    return {x, y, z};
  }

  Vec3 direction() noexcept { return normal3().normalized(); }

 private:
  std::array<std::uint64_t, 4> state_{};
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace stillpoint::sim
