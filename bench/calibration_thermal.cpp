/// A sensor at rest through a chamber cycle: what is learnt on one half says of the other.
#include <algorithm>
#include <cstdio>

#include "bench/calibration_tables.h"
#include "calib_online/temperature_filter.h"
#include "io/recording.h"

namespace stillpoint::bench {
namespace {

/// Twenty rows of the chamber together: their noise is white, the filter's windows are few.
struct Block {
  Vec3 mean = Vec3::Zero();
  double temp_degC = 0.0;
};
std::vector<Block> blocks(const io::Recording& r, const std::vector<Vec3>& y, std::size_t from, std::size_t to) {
  constexpr std::size_t kRows = 20;
  std::vector<Block> out;
  for (std::size_t k = from; k + kRows <= to; k += kRows) {
    Block b;
    for (std::size_t i = k; i < k + kRows; ++i) {
      b.mean += y[i] / double(kRows);
      b.temp_degC += r.temp_degC[i] / double(kRows);
    }
    out.push_back(b);
  }
  return out;
}

/// Prior sizes of consumer sensors, with 25 K of hysteresis as wander.
calib::GyrFilterParams chamber_prior(bool gyro) {
  const double unit = gyro ? kRadPerDeg : 0.3;
  calib::GyrFilterParams p;
  p.bias_sd_radps = 100 * unit;
  p.bias_per_K_sd_radps = 0.03 * unit;
  p.bias_curvature_sd_radps = 0.2 * unit;
  p.wander_sd_radps = 0.1 * unit;
  p.wander_s = 25.0;  // K
  p.bias_walk_radps_rts = 0.0;
  return p;
}

/// A bias over temperature as the calibration would publish it: held inside the range that was seen, and by a constant
/// where hysteresis explains the change. Time does not serve (the rows were decimated): the wander fades along the way
/// of the temperature.
class FrozenBias {
 public:
  FrozenBias(bool gyro, const std::vector<Block>& fitted) : filter_(chamber_prior(gyro)) {
    const double unit = gyro ? kRadPerDeg : 0.3;
    const Mat3 noise = std::pow(0.02 * unit, 2) * Mat3::Identity();
    double before_degC = fitted.front().temp_degC;
    low_ = high_ = tau(before_degC);
    for (const Block& b : fitted) {
      const double t = tau(b.temp_degC);
      filter_.predict(std::abs(b.temp_degC - before_degC));
      filter_.update(b.mean, noise, t, t * t);
      before_degC = b.temp_degC;
      low_ = std::min(low_, t);
      high_ = std::max(high_, t);
      present_ += filter_.at(t, t * t) / double(fitted.size());
    }
    filter_.predict(1e6);  // what is left of the wander says nothing of the other half
    if (gyro) follows_ = filter_.follows_temperature(low_, high_);  // the accelerometer's filter has no such guard
  }
  [[nodiscard]] bool seen(double temp_degC) const { return tau(temp_degC) >= low_ && tau(temp_degC) <= high_; }
  [[nodiscard]] Vec3 at(double temp_degC) const {
    const double t = std::clamp(tau(temp_degC), low_, high_);
    Vec3 out = filter_.at(t, t * t);
    for (int axis = 0; axis < 3; ++axis)
      if (!follows_[static_cast<std::size_t>(axis)]) out[axis] = present_[axis];
    return out;
  }

 private:
  static double tau(double temp_degC) { return (temp_degC - 25.0) / calib::kTempScale_K; }
  calib::GyrFilter filter_;
  double low_ = 0.0, high_ = 0.0;
  Vec3 present_ = Vec3::Zero();  ///< what is published along the way where the temperature is not followed, in the mean
  std::array<bool, 3> follows_{true, true, true};
};

/// Fits one half and predicts the other without learning from it.
void predict_half(bool gyro, bool fit_falling, const std::vector<Block>& fitted, const std::vector<Block>& other,
                  Figures& figures) {
  const double shown = gyro ? kDegPerRad : 1.0;
  const FrozenBias bias(gyro, fitted);
  Vec3 mean_fitted = Vec3::Zero();
  for (const Block& b : fitted) mean_fitted += b.mean / double(fitted.size());
  std::vector<double> before[3], after[3], inside[3];
  for (const Block& b : other)
    for (int axis = 0; axis < 3; ++axis) {
      before[axis].push_back(shown * (b.mean - mean_fitted)[axis]);
      after[axis].push_back(shown * (b.mean - bias.at(b.temp_degC))[axis]);
      if (bias.seen(b.temp_degC)) inside[axis].push_back(after[axis].back());
    }
  std::printf("  %s, fit on the %s half:", gyro ? "gyro, deg/s" : "acc, m/s^2", fit_falling ? "falling" : "rising");
  for (int axis = 0; axis < 3; ++axis) {
    std::printf("   %.3f -> %.3f", rms(before[axis]), rms(after[axis]));
    figures[std::string("chamber.") + (gyro ? "gyr_" : "acc_") + "xyz"[axis] + (fit_falling ? "_falling" : "_rising")] =
        rms(after[axis]) / rms(before[axis]);
  }
  std::printf("   (%zu of %zu blocks at temperatures that the fitted half saw: %.3f %.3f %.3f)\n", inside[0].size(),
              other.size(), rms(inside[0]), rms(inside[1]), rms(inside[2]));
}

}  // namespace

void thermal_chamber(const std::string& folder, Figures& figures) {
  const auto r = io::read_recording(folder + "/thermal_chamber/imu_thermal.csv");
  if (!r) return;
  const auto coldest =
      static_cast<std::size_t>(std::min_element(r->temp_degC.begin(), r->temp_degC.end()) - r->temp_degC.begin());
  std::printf(
      "thermal_chamber, %.1f to %.1f to %.1f degC: fit one half, predict the other without learning from it; rms x y "
      "z, the fitted half's mean -> what is published\n",
      r->temp_degC.front(), r->temp_degC[coldest], r->temp_degC.back());
  for (const bool gyro : {true, false}) {
    const auto& y = gyro ? r->gyr_radps : r->acc_mps2;
    const auto falling = blocks(*r, y, 0, coldest), rising = blocks(*r, y, coldest, r->size());
    predict_half(gyro, true, falling, rising, figures);
    predict_half(gyro, false, rising, falling, figures);
  }
}

}  // namespace stillpoint::bench
