/// Two hypotheses about one sensor: the one that is published, and a rival that is opened when evidence is refused.
/// Independent attitudes decide between them: what one attitude shows may be an acceleration or a turn, however often
/// it is seen; what many show is the sensor's own (docs/decisions/082-two-hypotheses.md).
#pragma once
#include <array>
#include <cstdint>

#include "core/types.h"

namespace stillpoint::calib {

/// A few directions of gravity in the body, each well apart from the others.
struct Attitudes {
  static constexpr std::size_t kMost = 8;
  std::array<Array3, kMost> up{};
  std::uint32_t count = 0;
  /// True when the direction is well apart from those before; beyond kMost nothing is new.
  bool add(const Vec3& up_body) noexcept;
};

/// Squared error over variance of a prediction, with the logarithm of that variance.
struct Fit {
  double chi2 = 0.0, log_variance = 0.0, variance = 0.0;
};

class Rivalry {
 public:
  /// Plain, as part of what is kept.
  struct State {
    std::uint32_t open = 0;    ///< a rival is there
    std::uint32_t former = 0;  ///< the rival is what was published before
    double log_odds = 0.0;     ///< of the rival, nats
    Attitudes voted;           ///< attitudes that have voted
  };

  /// A rival that nothing speaks for yet; `needed` attitudes have to speak before it may win.
  void open(const Vec3& up_body) noexcept;
  void close() noexcept { s_ = State{}; }
  [[nodiscard]] bool is_open() const noexcept { return s_.open != 0; }
  [[nodiscard]] bool rival_is_former() const noexcept { return s_.former != 0; }

  /// How an attitude speaks, by what each hypothesis predicted of it before it was learnt from: above zero for the
  /// rival. Bounded: no attitude decides alone.
  [[nodiscard]] static double vote(const Fit& published, const Fit& rival) noexcept;
  void add_vote(double vote, const Vec3& up_body) noexcept;

  enum class Verdict : std::uint8_t { kOpen, kRivalWins, kPublishedStays };
  [[nodiscard]] Verdict verdict(std::uint32_t attitudes_needed) const noexcept;
  /// The rival takes the place of what was published, which stays beside it.
  void exchanged() noexcept;
  /// Probability of the rival, for the stated deviation; zero below two in a hundred. `pending`: the vote of an
  /// attitude that is not over.
  [[nodiscard]] double weight(double pending = 0.0) const noexcept;

  [[nodiscard]] const State& state() const noexcept { return s_; }
  void restore(const State& s) noexcept { s_ = s; }

 private:
  State s_;
};

}  // namespace stillpoint::calib
