#include "io/plausibility_text.h"

#include <fmt/format.h>

#include "core/units.h"

namespace stillpoint::io {
namespace {

const char* likely(Mistake mistake) {
  switch (mistake) {
    case Mistake::kNone:
      return "check its scale";
    case Mistake::kGAsMps2:
      return "likely g given as m/s^2: name the columns acc_x_g ...";
    case Mistake::kMilliGAsMps2:
      return "likely thousandths of g given as m/s^2";
    case Mistake::kMps2AsG:
      return "likely m/s^2 given as g: name the columns acc_x_mps2 ...";
    case Mistake::kRange:
      return "likely the scale of another range setting of the sensor";
    case Mistake::kCounts:
      return "likely raw counts: name the columns ..._counts and give the scale";
    case Mistake::kDegpsAsRadps:
      return "likely deg/s given as rad/s: name the columns gyr_x_dps ...";
    case Mistake::kRadpsAsDegps:
      return "likely rad/s given as deg/s: name the columns gyr_x_radps ...";
    case Mistake::kGaussAsUT:
      return "likely gauss given as uT: name the columns mag_x_gauss ...";
    case Mistake::kMilliTeslaAsUT:
      return "likely mT given as uT";
    case Mistake::kTeslaAsUT:
      return "likely tesla given as uT: name the columns mag_x_T ...";
    case Mistake::kUTAsGauss:
      return "likely uT given as gauss: name the columns mag_x_uT ...";
    case Mistake::kNanoTeslaAsUT:
      return "likely nT given as uT";
    case Mistake::kMilliGaussAsUT:
      return "likely mG given as uT: divide by 10";
    case Mistake::kMsAsS:
      return "likely ms given as s: name the column time_ms";
    case Mistake::kUsAsS:
      return "likely us given as s: name the column time_us";
    case Mistake::kSAsMs:
      return "likely s given as ms: name the column time_s";
    case Mistake::kKelvinAsDegC:
      return "likely kelvin";
    case Mistake::kMilliDegCAsDegC:
      return "likely thousandths of a degree, or raw counts";
  }
  return "";
}

std::string seen(const Finding& f) {
  switch (f.oddity) {
    case Oddity::kAccScale:
      return fmt::format("the accelerometer reads {:.4g} m/s^2 where gravity is {:.2f}", f.value,
                         kStandardGravity_mps2);
    case Oddity::kGyrScale:
      return f.value == 0.0 ? "the gyroscope turns, or is loud, while gravity stands still"
                            : fmt::format("the gyroscope turns {:.3g} times as far as gravity does", f.value);
    case Oddity::kGyrSilent:
      return fmt::format("gravity turned by {:.0f} degrees, the gyroscope hardly at all", kDegPerRad * f.value);
    case Oddity::kMagScale:
      return fmt::format("the magnetometer reads {:.3g} uT; the Earth's field is 22 to 67", f.value);
    case Oddity::kTimeScale:
      return fmt::format("the readings are {:.3g} s apart", f.value);
    case Oddity::kTempScale:
      return fmt::format("the temperature is {:.4g} degC", f.value);
    case Oddity::kRepeated:
      return fmt::format("{:.0f} % of the readings repeat the one before", 100.0 * f.value);
    case Oddity::kTimeStopped:
      return fmt::format("{:.0f} readings in a row have one time", f.value);
    case Oddity::kTimeBackward:
      return fmt::format("the time went back by {:.3g} s", f.value);
    case Oddity::kTimeJumped:
      return fmt::format("the time jumped on by {:.3g} s", f.value);
    case Oddity::kTempDead:
      return fmt::format("the temperature stands at {:.2f} degC", f.value);
    case Oddity::kTooSlow:
      return fmt::format("the gyroscope reads {:.3g} times a second", 1.0 / f.value);
  }
  return "";
}

const char* advice(const Finding& f) {
  switch (f.oddity) {
    case Oddity::kGyrSilent:
      return "likely a gyroscope that is off, or rad/s given as deg/s: name the columns gyr_x_radps ...";
    case Oddity::kRepeated:
      return "likely a driver that is asked faster than the sensor measures, or a bus that hangs";
    case Oddity::kTimeStopped:
    case Oddity::kTimeBackward:
    case Oddity::kTimeJumped:
      return "likely a clock that was set, or a stamp that is not taken for each reading";
    case Oddity::kTempDead:
      return "likely a column that nobody fills: leave it out";
    case Oddity::kTooSlow:
      return "how it turned in between is not known: sample it 10 times a second at least, better 100";
    default:
      return likely(f.mistake);
  }
}

}  // namespace

std::string describe(const Finding& finding) {
  return fmt::format("{} (at {:.2f} s); {}", seen(finding), in_seconds(finding.t_ns), advice(finding));
}

std::vector<Finding> find_implausible(const Recording& recording) {
  const std::uint8_t counts =
      static_cast<std::uint8_t>((recording.acc_in_counts ? kAcc : 0) | (recording.gyr_in_counts ? kGyr : 0) |
                                (recording.mag_in_counts ? kMag : 0));
  PlausibilityCheck check;
  for (std::size_t row = 0; row < recording.size(); ++row) {
    RawSample sample = recording.sample(row);
    sample.has = static_cast<std::uint8_t>(sample.has & ~counts);
    check.push(sample);
  }
  return {check.findings().begin(), check.findings().end()};
}

}  // namespace stillpoint::io
