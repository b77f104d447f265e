#include "diagnosis/reference/folded_vibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/cross_rows.h"
#include "diagnosis/reference/differences.h"
#include "diagnosis/reference/lines.h"
#include "diagnosis/reference/response.h"

namespace stillpoint::diag {
namespace {

constexpr int kMostLines = 6;      // a rotor and its harmonics
constexpr double kHalfBand = 0.1;  // of the frequency, on either side: size and speed of a rotor change
constexpr double kLeastHalfBand_Hz = 1.0;
constexpr double kUnlike = 0.1;          // of the line's power, that the reference does not show in its own proportions
constexpr double kOffAFold = 0.05;       // of the rate of the rows: noise
constexpr double kFallsShort = 0.98;     // of the true derivative: beyond a third of the rate of the rows
constexpr double kLeastOfTheLine = 0.1;  // in what is left near its frequency, whatever noise is configured

double half_band_Hz(double frequency_Hz) { return std::max(kHalfBand * frequency_Hz, kLeastHalfBand_Hz); }

/// The rows near one frequency.
Response near(double frequency_Hz) { return band_pass(frequency_Hz, half_band_Hz(frequency_Hz)); }

/// What was not heard counts as nothing.
Series3 heard(const Signals& s, Sensor k, Series3 x) {
  for (Eigen::Index i = 0; i < s.n; ++i)
    if (s.muted[k][static_cast<std::size_t>(i)]) x.row(i).setZero();
  return x;
}

/// What the reference predicts of the body's motion alone.
Series3 motion(const Signals& s, Sensor k) {
  return k == kAcc ? Series3(s.predicted[kAcc] - s.gravity_mps2 * s.world_axis[2]) : s.predicted[k];
}

/// Of the derivative of a swing, by the differences of the rows.
double seen_of(Sensor k, double frequency_Hz, double dt_s) {
  constexpr double kLeast = 0.05;  // the first one vanishes at half the rate
  return std::max(gain_of_difference(k == kAcc ? 2 : 1, frequency_Hz, dt_s), kLeast);
}

/// The body moves at n fs +- f, the rows at f. Near half their rate the differences of the rows fall short, which is
/// all there is to it for n = 0.
struct Fold {
  double from_Hz, sign;

  [[nodiscard]] double body_Hz(double f) const { return from_Hz + sign * f; }
  /// True derivative over that of the rows.
  [[nodiscard]] double times(Sensor k, double f, double dt_s) const {
    const double ratio = body_Hz(f) / f;
    return (k == kAcc ? ratio * ratio : sign * ratio) / seen_of(k, f, dt_s);
  }
};

/// The fold of which the derivatives are so many times those of the rows, if there is one.
std::optional<Fold> fold_of(Sensor k, double times, double frequency_Hz, double dt_s) {
  const double rate_Hz = 1.0 / dt_s, seen = seen_of(k, frequency_Hz, dt_s), ratio = times * seen;
  if (k == kAcc && ratio <= 0.0) return std::nullopt;
  const double body_Hz = (k == kAcc ? std::sqrt(ratio) : std::abs(ratio)) * frequency_Hz;
  std::optional<Fold> nearest;
  double least = kOffAFold * rate_Hz;
  for (const double sign : {-1.0, 1.0}) {
    const Fold fold{rate_Hz * std::round((body_Hz - sign * frequency_Hz) / rate_Hz), sign};
    const bool falls_short = fold.from_Hz == 0.0 && sign > 0.0 && seen < kFallsShort;
    const bool same_way = k == kAcc || ratio * sign > 0;
    const double off_Hz = std::abs(fold.body_Hz(frequency_Hz) - body_Hz);
    if ((fold.from_Hz > 0.0 || falls_short) && same_way && off_Hz < least) least = off_Hz, nearest = fold;
  }
  return nearest;
}

/// What the derivatives lack, in the axes of the world: in the body's, the slow turn bends what vibrates.
Series3 lacking(const Signals& s, Sensor k, const Fold& fold, double frequency_Hz) {
  const auto lack = [&](const Series3& x) {
    return apply_response(x, s.rows, [&, band = near(frequency_Hz)](double f) {
      return f > 0.0 ? band(f) * (fold.times(k, f, s.dt_s) - 1.0) : 0.0;
    });
  };
  if (k == kAcc) return in_body(s, lack(in_world(s, motion(s, kAcc))));
  Series3 out = Series3::Zero(s.n, 3);
  // An axis x of the world moves as dx/dt = x cross w in the body, so that w = sum (dx/dt cross x) / 2.
  for (const Series3& axis : s.world_axis) out += 0.5 * cross_rows(lack(derivative(axis, s.rows)), axis);
  return out;
}

/// Unfolds one line; false where it is no fold.
bool unfold(Signals& s, Sensor k, const Series3& left, double frequency_Hz) {
  const Series3 moved = apply_response(heard(s, k, motion(s, k)), s.rows, near(frequency_Hz));
  const Series3 residual = apply_response(left, s.rows, near(frequency_Hz));
  const double power = moved.squaredNorm(), both = moved.cwiseProduct(residual).sum();
  const double band = 4.0 * half_band_Hz(frequency_Hz) * s.dt_s;  // of all frequencies
  const double left2 = residual.squaredNorm();
  const double noise = band * s.noise_sd[k] * s.noise_sd[k] * static_cast<double>(residual.size());
  const double line = std::max(left2 - noise, kLeastOfTheLine * left2);
  if (power <= 0.0 || both * both < (1.0 - kUnlike) * line * power) return false;
  const auto fold = fold_of(k, 1.0 + both / power, frequency_Hz, s.dt_s);
  if (!fold) return false;
  s.predicted[k] += lacking(s, k, *fold, frequency_Hz);
  const std::string what = fold->from_Hz > 0.0 ? fmt::format("fold to {:.3g} Hz", frequency_Hz) : "hardly resolve";
  s.notices.push_back(
      fmt::format("{}: the body vibrates at {:.4g} Hz, which {:.4g} rows a second {}: predicted with its own frequency",
                  kSensorName[k], fold->body_Hz(frequency_Hz), 1.0 / s.dt_s, what));
  return true;
}

}  // namespace

void unfold_vibrations(Signals& s) {
  for (const Sensor k : {kAcc, kGyr}) {
    if (!s.present[k] || (k == kAcc && !s.has_position)) continue;
    for (int line = 0; line < kMostLines; ++line) {
      Series3 left = s.reading[k] - s.predicted[k];
      left.rowwise() -= left.colwise().mean().eval();
      left = heard(s, k, std::move(left));
      const auto frequency_Hz = sharpest_line_Hz(left, s.t_s, s.dt_s);
      if (!frequency_Hz || !unfold(s, k, left, *frequency_Hz)) break;
    }
  }
}

}  // namespace stillpoint::diag
