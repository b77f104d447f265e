#include "diagnosis/reference/lines.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "diagnosis/reference/columns.h"
#include "diagnosis/reference/golden_section.h"
#include "diagnosis/reference/line_evidence.h"
#include "diagnosis/reference/peaks.h"

namespace stillpoint::diag {
namespace {

constexpr double kSlowestLine_Hz = 0.5;  // slower is motion and drift
constexpr double kOwnPhaseNats = 8.0;    // phases of their own that are worth three numbers more
constexpr int kRefinements = 24;
constexpr double kSameVibration = 0.1;  // of its frequency
constexpr double kBeats = 2.0;          // bins from half the rate

Found flip(const Target& t) {
  Found f;
  f.id = "mag_flip";
  f.unit = kSensorUnit[t.sensor];
  f.names = {"b_x", "b_y", "b_z"};
  f.equation = "delta = b (-1)^k";
  f.driver = "sample parity";
  Series parity(t.layout.n);
  for (Eigen::Index i = 0; i < parity.size(); ++i) parity[i] = i % 2 == 0 ? 1.0 : -1.0;
  f.columns = on_each_axis(parity);
  return f;
}

struct Unexplained {
  Target target;  ///< of white noise
  Series3 left;   ///< 0 where a row is absent
};

Unexplained unexplained(const SensorSearch& search) {
  Target plain = search.target;
  plain.layout.order = 0;
  Series3 left = fit_with(plain, search.explained(), NoiseModel(plain.layout, plain.residual), {}).leftover;
  for (int axis = 0; axis < 3; ++axis) left.col(axis).array() *= plain.layout.present;
  return {std::move(plain), std::move(left)};
}

/// Of the frequency, where the line stands so many times above its background.
double deviation_Hz(double over_background, const Window& window, const Target& t) {
  const double lasts_s = window.local ? static_cast<double>(window.end - window.begin) * t.rows.step_s : t.duration_s;
  return std::sqrt(12.0) / (2.0 * std::numbers::pi * lasts_s * std::sqrt(over_background));
}

/// Sine and cosine of each axis.
Columns swings(const SensorSearch& search, const Window& window, double frequency_Hz) {
  const Eigen::ArrayXd angle = 2.0 * std::numbers::pi * frequency_Hz * search.t_s.array();
  Columns out = on_each_axis(angle.sin());
  const Columns cosines = on_each_axis(angle.cos());
  out.insert(out.end(), cosines.begin(), cosines.end());
  return in_window(std::move(out), window);
}

struct Swing {
  double frequency_Hz = 0.0, gain_nats = 0.0;
  Eigen::Matrix<double, 3, 2> amplitude;  ///< of sine and cosine
};

/// A periodogram is blind to the noise's own spectrum: where a reference is quiet, near half its rate, the likelihood
/// knows the frequency a hundred times better.
Swing sharpened(const SensorSearch& search, const Window& window, double frequency_Hz, double deviation_Hz) {
  const Target& t = search.target;
  const Columns explained = search.explained();
  const auto columns = [&](double f) { return joined(explained, swings(search, window, f)); };
  const NoiseModel noise(t.layout, fit_profile(t, columns(frequency_Hz)).leftover);
  const double f =
      highest_by_golden_section(frequency_Hz - 3.0 * deviation_Hz, frequency_Hz + 3.0 * deviation_Hz, kRefinements,
                                [&](double tried) { return fit_with(t, columns(tried), noise, {}).log_likelihood; });
  const Fit fit = fit_with(t, columns(f), noise, {});
  const Eigen::VectorXd six = fit.theta.tail(6);
  return {f, fit.log_likelihood - fit_with(t, explained, noise, {}).log_likelihood,
          Eigen::Map<const Eigen::Matrix<double, 3, 2>>(six.data())};
}

/// One phase for all axes where that explains as much, sine and cosine of each axis else.
Found line(const SensorSearch& search, const Window& window, const Swing& swing) {
  const Sensor k = search.sensor;
  Found f;
  f.id = std::string(kSensorName[k]) + (k == kMag ? "_line" : "_alias");
  f.unit = kSensorUnit[k];
  f.equation = "delta = b sin(2 pi f t + phase)";
  f.driver = "time: a line at one frequency, or folded to it from beyond half the sampling rate";
  f.window = window;
  f.shape = swing.frequency_Hz;
  f.shape_sd = deviation_Hz(std::max(swing.gain_nats, 1.0), window, search.target);
  f.shape_name = "f";
  f.shape_unit = "Hz";
  f.fixed["f_hz"] = swing.frequency_Hz;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(swing.amplitude, Eigen::ComputeThinV);
  const double strong = svd.singularValues()[0], weak = svd.singularValues()[1];
  if (swing.gain_nats * weak * weak / (strong * strong) < kOwnPhaseNats) {
    const double phase = std::atan2(svd.matrixV()(1, 0), svd.matrixV()(0, 0));
    f.fixed["phase_rad"] = phase;
    f.names = {"b_x", "b_y", "b_z"};
    const Eigen::ArrayXd angle = 2.0 * std::numbers::pi * swing.frequency_Hz * search.t_s.array() + phase;
    f.columns = in_window(on_each_axis(angle.sin()), window);
    return f;
  }
  if (k == kGyr) f.id = "gyr_coning";
  f.equation = "delta_i = s_i sin(2 pi f t) + c_i cos(2 pi f t)";
  f.names = {"s_x", "s_y", "s_z", "c_x", "c_y", "c_z"};
  f.columns = swings(search, window, swing.frequency_Hz);
  return f;
}

/// Where a line stands, 0 elsewhere.
struct Located {
  Series3 left;
  Window window;
  double frequency_Hz;
};

Located located(const Series3& left, const Layout& layout, const Series& t_s, const Peak& peak, double step_s) {
  const double half_rate_Hz = 0.5 / step_s;
  const double lasting_Hz = refined_Hz(left, t_s, peak.frequency_Hz, peak.bin_Hz, half_rate_Hz);
  const Window window = stretch_of_line(left, layout, t_s, peak.frequency_Hz, step_s);
  if (!window.local) return {left, window, lasting_Hz};
  Series3 inside = left;
  inside.topRows(window.begin).setZero(), inside.bottomRows(left.rows() - window.end).setZero();
  const double bin_Hz = bin_width_Hz(left.rows(), step_s);
  const double local_Hz = refined_Hz(inside, t_s, peak.frequency_Hz, bin_Hz, half_rate_Hz);
  // Beside half the rate of the rows a line that lasts beats with its own fold, as if it were switched.
  const bool beats = half_rate_Hz - lasting_Hz < kBeats * bin_Hz;
  if (beats && power_at(left, t_s, lasting_Hz) > power_at(inside, t_s, local_Hz)) return {left, {}, lasting_Hz};
  return {std::move(inside), window, local_Hz};
}

/// What tells a line of the body, where the reference may not see it, from one of the sensor.
std::optional<std::string> why_the_bodys(const Signals& s, const SensorSearch& search, const Window& window,
                                         double frequency_Hz) {
  if (s.exact_reference) return std::nullopt;
  // What is left of a vibration that swells and turns with the body stands beside it.
  const bool beside = std::any_of(search.found.begin(), search.found.end(), [frequency_Hz](const Found& told) {
    return told.id == kBodyVibration && std::abs(told.shape - frequency_Hz) < kSameVibration * frequency_Hz;
  });
  if (beside) return "more and less";
  if (others_swing_too(s, search.sensor, window, frequency_Hz)) return "and so does another sensor";
  if (search.sensor == kMag) return std::nullopt;  // a magnetic line is that of a room, through which the body goes
  if (swells(s, search.sensor, window, frequency_Hz)) return "more and less";
  if (shakes_beside(s, search.sensor, window, frequency_Hz)) return "and at all frequencies beside";
  return std::nullopt;
}

/// The sharpest line of what is left, from this frequency on.
std::optional<Found> line_left(const Signals& s, const SensorSearch& search, const Unexplained& what,
                               double lowest_Hz) {
  const Target& plain = what.target;
  const auto peak = sharpest_peak(what.left, search.t_s, plain.rows.step_s, lowest_Hz);
  if (!peak) return std::nullopt;
  const double bin_Hz = bin_width_Hz(what.left.rows(), plain.rows.step_s), half_rate_Hz = 0.5 / plain.rows.step_s;
  const auto [left, window, frequency_Hz] = located(what.left, plain.layout, search.t_s, *peak, plain.rows.step_s);
  if (!s.exact_reference && !stands_in_reading(s, plain.sensor, left, window, frequency_Hz)) return std::nullopt;
  Found f;
  if (is_flip(frequency_Hz, bin_Hz, half_rate_Hz)) {
    if (plain.sensor != kMag) return std::nullopt;
    f = flip(plain);
  } else {
    f = line(search, window,
             sharpened(search, window, frequency_Hz, deviation_Hz(peak->over_background, window, plain)));
  }
  f.kind = Kind::kNamed;
  if (const auto why = why_the_bodys(s, search, window, frequency_Hz)) {
    f.kind = Kind::kConfiguration;
    f.id = kBodyVibration;
    f.driver = *why;
  }
  f.units.assign(f.names.size(), f.unit);
  return f;
}

}  // namespace

std::optional<double> sharpest_line_Hz(const Series3& left, const Series& t_s, double step_s) {
  const auto peak = sharpest_peak(left, t_s, step_s, kSlowestLine_Hz);
  return peak ? std::optional(peak->frequency_Hz) : std::nullopt;
}

std::string vibration_notice(Sensor sensor, const Found& line) {
  return fmt::format(
      "{}: swings at {:.4g} Hz, {}: the body vibrates there, or at a frequency that the rows fold there, and the "
      "reference does not see it; allowed for",
      kSensorName[sensor], line.shape, line.driver);
}

std::optional<double> line_in_world(const Signals& s, const SensorSearch& search) {
  if (s.world_axis[0].rows() != s.n) return std::nullopt;
  const Unexplained body = unexplained(search);
  return sharpest_line_Hz(in_world(s, body.left), search.t_s, body.target.rows.step_s);
}

void sharpen_line(const SensorSearch& without_it, Found& f) {
  const double lasts_s = static_cast<double>(f.window.end - f.window.begin) * without_it.target.rows.step_s;
  const double bin_Hz = 1.0 / (f.window.local ? lasts_s : without_it.target.duration_s);
  Found sharp = line(without_it, f.window, sharpened(without_it, f.window, f.shape, bin_Hz / 6.0));
  if (f.id != kBodyVibration) f.id = std::move(sharp.id), f.equation = std::move(sharp.equation);
  f.shape = sharp.shape, f.shape_sd = sharp.shape_sd, f.fixed = std::move(sharp.fixed);
  f.names = std::move(sharp.names), f.columns = std::move(sharp.columns);
  f.units.assign(f.names.size(), f.unit);
}

std::optional<Found> line_in(const Signals& s, const SensorSearch& search) {
  return line_left(s, search, unexplained(search), kSlowestLine_Hz);
}

std::optional<Found> line_beyond(const Signals& s, const SensorSearch& search, double lowest_Hz) {
  constexpr double kHigher = 1.25;
  const Unexplained what = unexplained(search);
  for (; lowest_Hz < 0.5 / s.dt_s; lowest_Hz *= kHigher)
    if (auto line = line_left(s, search, what, lowest_Hz)) return line;
  return std::nullopt;
}

}  // namespace stillpoint::diag
