#include "core/plausibility.h"

#include <algorithm>
#include <cmath>

#include "core/types.h"
#include "core/units.h"

namespace stillpoint {
namespace {

constexpr std::int64_t kWindow_ns = 4'000'000'000;
constexpr std::uint32_t kLeastReadings = 50, kMostReadings = 60'000;
constexpr int kWindowsInARow = 2;

// Accelerometer. A consumer part that nobody calibrated reads gravity within some 20 % at rest.
constexpr double kGravityLow = 0.7, kGravityHigh = 1.43;
constexpr double kSteady = 1.12;         // 95 % over 5 % of the norms: at rest
constexpr double kMovingSpread = 6.0;    // 90 % over 10 %: in use, but not a body that falls or is hurled
constexpr double kUnitTolerance = 1.35;  // of a median in use about the unit that explains it
constexpr double kCountsFrom = 180.0;    // times gravity: more than any high-g part measures for seconds
constexpr double kWeightlessBelow = 0.02;

// Gyroscope.
constexpr double kExplained = 0.6, kWellExplained = 0.8, kLeastTurned_rad2 = 0.02;
constexpr double kToldRight = 0.3;            // explained: enough to see that a scale is not off by kFactor
constexpr double kFactor = 8.0;               // off by more: no scale error, no lever arm
constexpr double kLargestOffset_radps = 1.0;  // 57 deg/s; the worst data sheets say 40
constexpr double kTurned_rad = 0.8;
constexpr double kNoAcceleration = 0.9;  // `held` of gravity whose directions spread by 25 degrees: it has turned
constexpr double kHeld = 0.95, kStill = 0.999;
constexpr double kLoudGyr_radps = 0.03, kQuietAccShare = 0.02;
constexpr double kLargestRate_radps = 72.0;  // beyond 4000 deg/s, the largest range there is
constexpr int kTurnsInARow = 2;

// Magnetometer: 22 to 67 uT on Earth; iron of 1500 uT beside it is no unit.
constexpr double kGauss_low = 0.15, kGauss_high = 1.0;
constexpr double kUTAsGauss_low = 2200.0, kNanoTesla_low = 15'000.0, kNanoTesla_high = 100'000.0;
constexpr double kFieldMoves = 1.3;  // 95 % over 5 %
// A field of such a size that turns and keeps its norm is no iron's, which turns with the body.
constexpr double kMilliGauss_low = 200.0, kMilliGauss_high = 700.0;

// Time and repeats.
constexpr double kSlowestStep_s = 0.7, kFastestStep_s = 2e-5;
constexpr std::uint32_t kFewSteps = 12;
constexpr std::int64_t kJump_ns = 3'600'000'000'000, kBack_ns = 1'000'000'000;
constexpr std::uint32_t kSameTimes = 20, kBackwards = 3;
constexpr double kRepeatedShare = 0.45;

// Temperature.
constexpr double kColdest_degC = -60.0, kHottest_degC = 200.0;
constexpr double kStandsStill_s = 600.0, kZeroFor_s = 8.0;

bool near(double x, double unit, double tolerance) noexcept { return x > unit / tolerance && x < unit * tolerance; }

Mistake acc_mistake(double ratio) noexcept {
  if (near(ratio, 1.0 / kStandardGravity_mps2, kUnitTolerance)) return Mistake::kGAsMps2;
  if (near(ratio, kStandardGravity_mps2, kUnitTolerance)) return Mistake::kMps2AsG;
  if (near(ratio, 1000.0 / kStandardGravity_mps2, kUnitTolerance)) return Mistake::kMilliGAsMps2;
  if (ratio > kCountsFrom) return Mistake::kCounts;
  for (const double range : {0.125, 0.25, 0.5, 2.0, 4.0, 8.0})
    if (near(ratio, range, 1.1)) return Mistake::kRange;
  return Mistake::kNone;
}

/// `scale`: gravity's turning over the gyroscope's.
Mistake gyr_mistake(double scale) noexcept {
  if (near(scale, kRadPerDeg, 1.6)) return Mistake::kDegpsAsRadps;
  if (near(scale, kDegPerRad, 1.6)) return Mistake::kRadpsAsDegps;
  return scale > 0.0 && scale < 0.005 ? Mistake::kCounts : Mistake::kNone;
}

}  // namespace

Finding* PlausibilityCheck::found(Oddity oddity) noexcept {
  const auto all = std::span(findings_).first(found_);
  const auto found = std::find_if(all.begin(), all.end(), [oddity](const Finding& f) { return f.oddity == oddity; });
  return found == all.end() ? nullptr : &*found;
}

void PlausibilityCheck::find(Oddity oddity, Mistake mistake, double value, std::int64_t t_ns) noexcept {
  Finding* const before = found(oddity);
  if (before == nullptr)
    findings_[found_++] = {oddity, mistake, value, t_ns};
  else if (!before->stands)
    *before = {oddity, mistake, value, t_ns};
}

void PlausibilityCheck::clear(Oddity oddity) noexcept {
  if (Finding* const before = found(oddity)) before->stands = false;
}

void PlausibilityCheck::restart() noexcept {
  acc_ = gyr_ = mag_ = {};
  turns_.clear();
  odd_turns_ = 0;
}

void PlausibilityCheck::push(const RawSample& sample) noexcept {
  if (std::abs(static_cast<double>(sample.t_ns)) > kLatest_ns) return;  // no two such times can be told apart
  if (sample.holds(kAcc)) {
    push_part(acc_, sample.acc_mps2, sample.t_ns, kAcc);
    turns_.push_acc(sample.acc_mps2);
  }
  if (sample.holds(kGyr)) {
    push_part(gyr_, sample.gyr_radps, sample.t_ns, kGyr);
    turns_.push_gyr(sample.gyr_radps, sample.t_ns);
    if (turns_.ready()) judge_gravity_turns(sample.t_ns);
  }
  if (sample.holds(kMag)) push_part(mag_, sample.mag_uT, sample.t_ns, kMag);
  if (sample.holds(kTemp)) push_temp(sample.temp_degC, sample.t_ns);
}

void PlausibilityCheck::Part::note_extent(const Array3& reading) noexcept {
  if (norms.count() == 0) least = most = reading;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    least[axis] = std::min(least[axis], reading[axis]);
    most[axis] = std::max(most[axis], reading[axis]);
  }
}

void PlausibilityCheck::push_part(Part& part, const Array3& reading, std::int64_t t_ns, SamplePart kind) noexcept {
  if (part.started) {
    judge_time(part, t_ns);
    if (reading == part.last) ++part.repeats;
  } else {
    part.window_start_ns = t_ns;
  }
  if (kind == kMag) part.note_extent(reading);
  part.norms.add(vec(reading).norm());
  part.last = reading;
  part.last_ns = t_ns;
  part.started = true;
  if (t_ns < part.window_start_ns) part.window_start_ns = t_ns;
  const bool long_enough = t_ns - part.window_start_ns >= kWindow_ns && part.norms.count() >= kLeastReadings;
  if (!long_enough && part.norms.count() < kMostReadings) return;
  judge_steps(part, t_ns);
  judge_window(part, kind, t_ns);
  part.norms.clear();
  part.steps.clear();
  part.repeats = 0;
  part.window_start_ns = t_ns;
}

void PlausibilityCheck::judge_time(Part& part, std::int64_t t_ns) noexcept {
  const double step_s = kSecondsPerNs * (static_cast<double>(t_ns) - static_cast<double>(part.last_ns));
  part.same_time = step_s == 0.0 ? part.same_time + 1 : 0;
  if (part.same_time == kSameTimes) find(Oddity::kTimeStopped, Mistake::kNone, kSameTimes, t_ns);
  if (step_s < 0.0 && (++part.backward == kBackwards || -step_s * kNsPerSecond > kBack_ns))
    find(Oddity::kTimeBackward, Mistake::kNone, -step_s, t_ns);
  if (step_s * kNsPerSecond > static_cast<double>(kJump_ns) && part.steps.count() > 0 &&
      step_s > 1e3 * part.steps.quantile(0.5))
    find(Oddity::kTimeJumped, Mistake::kNone, step_s, t_ns);
  if (step_s > 0.0) part.steps.add(step_s);
  if (part.steps.count() == kLeastReadings) judge_steps(part, t_ns);
  if (part.steps.count() == kFewSteps && &part == &gyr_) {
    const double usual_s = part.steps.quantile(0.5);
    if (usual_s > kLongestGyrStep_s && usual_s <= kSlowestStep_s)
      find(Oddity::kTooSlow, Mistake::kNone, usual_s, t_ns);
    else
      clear(Oddity::kTooSlow);
  }
}

void PlausibilityCheck::judge_steps(const Part& part, std::int64_t t_ns) noexcept {
  if (part.steps.count() + 1 < kLeastReadings || &part == &mag_) return;
  const double step_s = part.steps.quantile(0.5);
  if (step_s > kSlowestStep_s)
    find(Oddity::kTimeScale, step_s < 700.0 ? Mistake::kMsAsS : Mistake::kUsAsS, step_s, t_ns);
  else if (step_s < kFastestStep_s)
    find(Oddity::kTimeScale, Mistake::kSAsMs, step_s, t_ns);
  else
    clear(Oddity::kTimeScale);
}

void PlausibilityCheck::judge_window(Part& part, SamplePart kind, std::int64_t t_ns) noexcept {
  const double median = part.norms.quantile(0.5);
  const double low = part.norms.quantile(0.05), high = part.norms.quantile(0.95);
  const auto judge = [&](bool odd, bool right, Oddity oddity, Mistake mistake) {
    if (odd)
      part.odd_windows = std::max(0, part.odd_windows) + 1;
    else if (right)
      part.odd_windows = std::min(0, part.odd_windows) - 1;
    else if (kind != kMag)  // a field that does not turn says nothing of mG, and what was seen stays
      part.odd_windows = 0;
    if (part.odd_windows >= kWindowsInARow) find(oddity, mistake, median, t_ns);
    if (part.odd_windows <= -kWindowsInARow) clear(oddity);
  };
  if (kind == kAcc) {
    const double ratio = median / kStandardGravity_mps2;
    const bool gravity = ratio > kGravityLow && ratio < kGravityHigh;
    part.gravity_seen = part.gravity_seen || gravity;
    const Mistake mistake = acc_mistake(ratio);
    const bool at_rest = high < kSteady * low && !gravity && ratio > kWeightlessBelow;
    const bool in_use = !part.gravity_seen && mistake != Mistake::kNone && mistake != Mistake::kRange &&
                        part.norms.quantile(0.9) < kMovingSpread * part.norms.quantile(0.1);
    judge(at_rest || in_use, gravity, Oddity::kAccScale, mistake);
  } else if (kind == kGyr) {  // that it is right only the turning of gravity can tell
    judge(part.norms.quantile(0.9) > kLargestRate_radps, false, Oddity::kGyrScale,
          median > 4000.0 ? Mistake::kCounts : Mistake::kDegpsAsRadps);
  } else {
    Mistake mistake = Mistake::kNone;
    if (median > kGauss_low && median < kGauss_high) mistake = Mistake::kGaussAsUT;
    if (median > 0.015 && median < 0.1) mistake = Mistake::kMilliTeslaAsUT;
    if (median > 1.5e-5 && median < 1e-4) mistake = Mistake::kTeslaAsUT;
    if (median > kUTAsGauss_low && median < 7000.0 && high > kFieldMoves * low) mistake = Mistake::kUTAsGauss;
    if (median > kNanoTesla_low && median < kNanoTesla_high) mistake = Mistake::kNanoTeslaAsUT;
    const bool may_be_milli_gauss = median > kMilliGauss_low && median < kMilliGauss_high;
    const double turned = (vec(part.most) - vec(part.least)).maxCoeff();
    if (may_be_milli_gauss && high < kFieldMoves * low && turned > median) mistake = Mistake::kMilliGaussAsUT;
    const bool right = median > kGauss_high && median < kUTAsGauss_low && !may_be_milli_gauss;
    judge(mistake != Mistake::kNone, right, Oddity::kMagScale, mistake);
  }
  if (kind == kMag) return;  // many drivers hold a slow magnetometer's readings
  const double share = static_cast<double>(part.repeats) / part.norms.count();
  part.repeating_windows = share > kRepeatedShare ? part.repeating_windows + 1 : 0;
  const bool other = !acc_.started || !gyr_.started || std::min(acc_.repeating_windows, gyr_.repeating_windows) > 0;
  if (part.repeating_windows >= kWindowsInARow && other) find(Oddity::kRepeated, Mistake::kNone, share, t_ns);
  if (part.repeating_windows == 0) clear(Oddity::kRepeated);
}

void PlausibilityCheck::judge_gravity_turns(std::int64_t t_ns) noexcept {
  if (const Finding* const time = found(Oddity::kTimeScale); time != nullptr && time->stands) return;
  const TurnsFit fit = turns_.fit();
  const bool related = fit.explained > kExplained && fit.turned_rad2 > kLeastTurned_rad2;
  // A car that gathers speed dips by a tenth of the angle by which its acceleration tilts the force.
  const bool too_little = std::abs(fit.scale) > kFactor && fit.held < kNoAcceleration;
  const bool off = related && (std::abs(fit.scale) < 1.0 / kFactor || too_little);
  // At such a rate gravity would have gone all the way round in the 6.4 s.
  const bool spins = fit.held > kHeld && fit.level_rate_radps > kLargestOffset_radps;
  const bool loud = fit.held > kStill && fit.gyr_noise_radps > std::max(kLoudGyr_radps, fit.unrest_radps) &&
                    fit.acc_noise_share < kQuietAccShare;
  const bool silent = fit.gravity_turn_rad > kTurned_rad && kFactor * fit.gyr_turn_rad < fit.gravity_turn_rad;
  const bool odd = off || spins || loud || silent;
  const bool right = fit.explained > kToldRight && fit.turned_rad2 > kLeastTurned_rad2 &&
                     std::abs(fit.scale) > 1.0 / kFactor && std::abs(fit.scale) < kFactor;
  if (odd)
    odd_turns_ = std::max(0, odd_turns_) + (fit.explained > kWellExplained ? 2 : 1);
  else
    odd_turns_ = std::min(0, odd_turns_) - (right ? 1 : 0);
  if (odd_turns_ <= -kTurnsInARow) {
    clear(Oddity::kGyrScale);
    clear(Oddity::kGyrSilent);
  }
  if (odd_turns_ < kTurnsInARow) return;
  if (silent) return find(Oddity::kGyrSilent, Mistake::kRadpsAsDegps, fit.gravity_turn_rad, t_ns);
  const Mistake mistake = off ? gyr_mistake(fit.scale) : Mistake::kDegpsAsRadps;
  find(Oddity::kGyrScale, mistake, off ? 1.0 / fit.scale : 0.0, t_ns);
}

void PlausibilityCheck::push_temp(double temp_degC, std::int64_t t_ns) noexcept {
  if (temps_++ == 0) {
    first_temp_degC_ = temp_degC;
    first_temp_ns_ = t_ns;
  }
  if (temp_degC < kColdest_degC || temp_degC > kHottest_degC) {
    const bool kelvin = temp_degC > 230.0 && temp_degC < 400.0;
    const Mistake likely = kelvin                         ? Mistake::kKelvinAsDegC
                           : std::abs(temp_degC) > 1000.0 ? Mistake::kMilliDegCAsDegC
                                                          : Mistake::kNone;
    return find(Oddity::kTempScale, likely, temp_degC, t_ns);
  }
  clear(Oddity::kTempScale);
  temp_moved_ = temp_moved_ || temp_degC != first_temp_degC_;
  if (temp_moved_) clear(Oddity::kTempDead);
  const double stood_s = kSecondsPerNs * (static_cast<double>(t_ns) - static_cast<double>(first_temp_ns_));
  const double patience_s = first_temp_degC_ == 0.0 ? kZeroFor_s : kStandsStill_s;
  if (!temp_moved_ && temps_ >= kLeastReadings && stood_s > patience_s)
    find(Oddity::kTempDead, Mistake::kNone, temp_degC, t_ns);
}

}  // namespace stillpoint
