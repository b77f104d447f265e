/// Quantiles of a positive quantity that may lie anywhere in eighteen decades, in bins of a sixteenth octave (4.4 %).
/// Of 65535 values at most: it travels with the stages, which are copied.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace stillpoint {

class LogHistogram {
 public:
  void add(double x) noexcept {
    ++count_;
    ++bins_[bin_of(x)];
  }
  void clear() noexcept { *this = {}; }
  [[nodiscard]] std::uint32_t count() const noexcept { return count_; }
  /// Middle of the bin below which that share lies; 0 for none and for nothing at all.
  [[nodiscard]] double quantile(double share) const noexcept {
    const double wanted = share * count_;
    double below = 0.0;
    for (std::size_t i = 0; i < bins_.size(); ++i)
      if ((below += bins_[i]) > wanted) return i == 0 ? 0.0 : std::exp2((static_cast<double>(i) - 0.5) / 16.0 - 30.0);
    return 0.0;
  }

 private:
  static constexpr std::size_t kBins = 961;  // 2^-30 to 2^30; the first one is for what is smaller
  static std::size_t bin_of(double x) noexcept {
    if (!(x > 0.0)) return 0;
    return static_cast<std::size_t>(std::clamp(16.0 * (std::log2(x) + 30.0) + 1.0, 0.0, double{kBins - 1}));
  }
  std::array<std::uint16_t, kBins> bins_{};
  std::uint32_t count_ = 0;
};

}  // namespace stillpoint
