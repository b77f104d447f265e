/// `--turn` and `--rate` of `stillpoint calibrate --recording`: turns whose angle somebody vouches for, from their text
/// to what the calibration made of them.
#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calib_online/known_turn.h"
#include "core/calibration.h"
#include "core/result.h"
#include "core/units.h"
#include "io/recording.h"

namespace stillpoint::app {

inline constexpr auto kTurnType = "BEGIN_S:END_S:DEG[:SD_DEG]";
inline constexpr auto kRateType = "BEGIN_S:END_S:DEG_PER_S[:SD]";

struct KnownTurnReport {
  std::string option;  ///< as it was given
  calib::StatedTurn stated;
  calib::KnownTurn turn;
  calib::AngleSeen before, after;  ///< by the matrix at first, and by the one that was learnt

  /// The unit of the option: deg, or deg/s for a rate.
  [[nodiscard]] const char* unit() const { return stated.steady ? "deg/s" : "deg"; }
  [[nodiscard]] double in_unit(double angle_rad) const {
    return angle_rad * kDegPerRad / (stated.steady ? stated.end_s - stated.begin_s : 1.0);
  }
  [[nodiscard]] double residual_sd() const { return after.residual_sd(turn.angle_rad); }
};

/// Fail with what is wrong and an example (64).
[[nodiscard]] Result<calib::StatedTurn> parse_turn(const std::string& text);
[[nodiscard]] Result<calib::StatedTurn> parse_rate(const std::string& text);

/// What is known of the gyroscope at a moment of the recording, its bias with a covariance.
using GyrAt = std::function<TriadCalibration(double t_s)>;

/// All turns as the recording shows them, or the first that it does not show (65). `options` name them in messages.
[[nodiscard]] Result<std::vector<KnownTurnReport>> measure(const std::vector<std::string>& turns,
                                                           const std::vector<std::string>& rates,
                                                           const io::Recording& recording, const GyrAt& gyr_at);

/// What somebody should look at: turns that what is known contradicts, and scales far from the factory's; a line each.
[[nodiscard]] std::vector<std::string> remarks(const std::vector<KnownTurnReport>& turns);

/// "stated 360 +- 1.5 deg, read 370.0 before, 360.2 after (+0.1 sd)"
[[nodiscard]] std::string describe(const KnownTurnReport& turn);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<KnownTurnReport>& turns);

}  // namespace stillpoint::app
