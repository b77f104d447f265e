/// How much of the turning of gravity the gyroscope tells: both are sums over blocks of 0.2 s, the last 32 of them.
/// d f / dt = -w x f holds for a body that turns and is hardly accelerated; offsets of the gyroscope do not count.
#pragma once
#include <array>
#include <cstdint>

#include "core/differences.h"
#include "core/types.h"

namespace stillpoint {

struct TurnsFit {
  double scale = 0.0;             ///< gravity's turning over the gyroscope's: 1 when the units are right
  double explained = 0.0;         ///< share of the gravity's turning that the gyroscope explains at that scale, 0 to 1
  double turned_rad2 = 0.0;       ///< sum of the squared changes of gravity's direction
  double held = 0.0;              ///< length of the mean of gravity's directions: 1 where it stands still
  double level_rate_radps = 0.0;  ///< mean rate across the mean of gravity, less what circling would put there
  double unrest_radps = 0.0;      ///< of the rate, from block to block
  double gravity_turn_rad = 0.0;  ///< from the first quarter to the last; 0 unless both are about as strong as gravity
  double gyr_turn_rad = 0.0;      ///< the way that the gyroscope tells meanwhile
  double gyr_noise_radps = 0.0;   ///< that no smooth motion explains, in half of the blocks at least
  double acc_noise_share = 0.0;   ///< the same of the accelerometer, over gravity
};

class GravityTurns {
 public:
  void push_acc(const Array3& reading) noexcept;
  void push_gyr(const Array3& reading, std::int64_t t_ns) noexcept;
  void clear() noexcept { *this = {}; }
  /// True once for every eight new blocks, when the last 32 have no hole.
  [[nodiscard]] bool ready() noexcept;
  [[nodiscard]] TurnsFit fit() const noexcept;

 private:
  struct Block {
    Array3 force{};     ///< mean
    Array3 turn_rad{};  ///< integral of the rate
    double seconds = 0.0;
    double acc_noise2 = 0.0, gyr_noise2 = 0.0;  ///< variance of an axis that its smooth motion does not explain
  };
  struct Noise {
    static constexpr std::size_t kOrder = 3;
    Differences<kOrder> differences;
    double sum2 = 0.0;
    std::uint32_t n = 0;
    void push(const Array3& reading) noexcept;
    [[nodiscard]] double take() noexcept;
  };
  static constexpr std::size_t kBlocks = 32;
  void close_block(std::int64_t t_ns) noexcept;
  /// 0 is the oldest.
  [[nodiscard]] const Block& block(std::size_t i) const noexcept { return blocks_[(newest_ + 1 + i) % kBlocks]; }
  [[nodiscard]] double gravity_turn_rad() const noexcept;
  /// Of the median block: a knock is no noise.
  [[nodiscard]] double usual_gyr_noise2() const noexcept;

  std::array<Block, kBlocks> blocks_{};
  std::size_t filled_ = 0, newest_ = 0, fresh_ = 0;
  Array3 force_sum_{}, turn_{}, last_rate_{};
  std::uint32_t forces_ = 0, rates_ = 0;
  std::int64_t block_start_ns_ = 0, last_gyr_ns_ = 0;
  Noise acc_noise_, gyr_noise_;
  bool started_ = false;
};

}  // namespace stillpoint
