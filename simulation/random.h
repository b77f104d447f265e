/// Random numbers with one independent stream per (seed, source): switching one source on or off leaves every other
/// source's numbers as they were, so that twin simulations differ by one effect alone.
#pragma once
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "core/fnv1a.h"
#include "core/types.h"

namespace stillpoint::sim {

/// Layers of equal area under the normal density: Doornik, "An improved ziggurat method to generate normal random
/// samples" (2005), 256 layers.
struct Ziggurat {
  static constexpr double kEnd = 3.6541528853610088, kArea = 0.00492867323399;
  std::array<double, 257> edge{};
  std::array<double, 256> inside{};  ///< share of a layer that lies under the density without a test

  Ziggurat() {
    double density = std::exp(-0.5 * kEnd * kEnd);
    edge[0] = kArea / density;
    edge[1] = kEnd;
    for (std::size_t i = 2; i < 256; ++i) {
      edge[i] = std::sqrt(-2.0 * std::log(kArea / edge[i - 1] + density));
      density = std::exp(-0.5 * edge[i] * edge[i]);
    }
    for (std::size_t i = 0; i < 256; ++i) inside[i] = edge[i + 1] / edge[i];
  }
};
inline const Ziggurat kZiggurat;

/// xoshiro256++ of Blackman, Vigna, "Scrambled linear pseudorandom number generators", ACM TOMS 47 (2021), seeded by
/// splitmix64 from the seed and the FNV-1a hash of the source's name.
class Stream {
 public:
  Stream(std::uint64_t seed, std::string_view source) {
    std::uint64_t x = seed ^ std::rotl(fnv1a(source), 17);
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

  /// Standard normal.
  double normal() noexcept {
    for (;;) {
      const std::uint64_t word = bits();
      const std::size_t i = word & 0xFFU;
      const double u = 2.0 * (static_cast<double>(word >> 11U) * 0x1.0p-53) - 1.0;
      const double x = u * kZiggurat.edge[i];
      if (std::abs(u) < kZiggurat.inside[i]) return x;
      if (i == 0) return tail(u < 0.0);
      const double above = std::exp(-0.5 * (kZiggurat.edge[i] * kZiggurat.edge[i] - x * x));
      const double below = std::exp(-0.5 * (kZiggurat.edge[i + 1] * kZiggurat.edge[i + 1] - x * x));
      if (below + uniform() * (above - below) < 1.0) return x;
    }
  }

  Vec3 normal3() noexcept {
    const double x = normal(), y = normal(), z = normal();
    return {x, y, z};
  }

  Vec3 direction() noexcept { return normal3().normalized(); }

 private:
  /// Beyond the last layer (Marsaglia 1964).
  double tail(bool negative) noexcept {
    double x, y;
    do {
      x = -std::log(1.0 - uniform()) / Ziggurat::kEnd;
      y = -std::log(1.0 - uniform());
    } while (2.0 * y < x * x);
    return negative ? -(Ziggurat::kEnd + x) : Ziggurat::kEnd + x;
  }

  std::array<std::uint64_t, 4> state_{};
};

}  // namespace stillpoint::sim
