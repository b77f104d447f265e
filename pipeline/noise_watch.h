/// Has a sensor become far noisier than it was? White noise is the same all the time and at every order of differences;
/// what a motion shakes comes and goes, and gets less with the order.
/// docs/decisions/172-noise-that-was-not-there.md
#pragma once
#include <type_traits>

#include "core/differences.h"
#include "core/types.h"

namespace stillpoint::pipeline {

/// Of one triad. Plain state, some forty operations a sample; works in blocks of about a second.
class NoiseWatch {
 public:
  /// \param least in the unit of the reading: deviation of a sound consumer part; less is never called noisy.
  explicit NoiseWatch(double least) noexcept : least2_(least * least) {}

  /// `under_way`: the body is not at rest. Only what it showed then says what is usual.
  void note(const Array3& reading, double dt_s, bool under_way) noexcept;
  /// What comes next is not connected with what was: a gap.
  void interrupt() noexcept { differences_.interrupt(); }

  /// Noise of two blocks in a row over the limit; above 1 the sensor is noisy.
  [[nodiscard]] double excess() const noexcept { return excess_; }

 private:
  struct Orders {  ///< mean squares by the second, third and fifth differences, per axis
    Array3 second{}, third{}, fifth{};
    void add(const Orders& o, double weight) noexcept;
  };
  struct Block {
    Orders sum;
    Array3 least2{}, most2{};  ///< of its parts, third differences
    double time_s = 0.0;
    int parts = 0;
    bool under_way = false;
  };
  void end_part() noexcept;
  void end_block() noexcept;
  [[nodiscard]] bool white(const Block& block, std::size_t axis) const noexcept;

  Differences<5> differences_;
  Orders part_;
  int readings_ = 0;
  double part_s_ = 0.0;
  Block block_;
  Array3 usual2_{};  ///< largest that the calmest part of a block has shown
  double least2_, known_s_ = 0.0, last_excess_ = 0.0, excess_ = 0.0;
};

static_assert(std::is_trivially_copyable_v<NoiseWatch>);

}  // namespace stillpoint::pipeline
