#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/so3.h"
#include "diagnosis/certainty.h"
#include "diagnosis/reference/apparatus.h"
#include "diagnosis/sanity/comparison.h"

namespace stillpoint::diag {
namespace {

constexpr double kLeastRest_s = 1.0;
constexpr double kOverStated = 1.3;
constexpr double kLeast_nats = 10.0;                  // two numbers and the name
constexpr double kLeast_rad = 1e-5, kLeast_m = 1e-6;  // below is rounding of the file

/// Scatter within rests and its correlation from row to row, three axes together.
struct Scatter {
  double sum = 0.0, lagged = 0.0, count = 0.0;
  void add(const std::vector<Vec3>& x) {
    Vec3 mean = Vec3::Zero();
    for (const Vec3& v : x) mean += v / static_cast<double>(x.size());
    for (std::size_t i = 1; i < x.size(); ++i) {
      sum += (x[i] - mean).squaredNorm(), lagged += (x[i] - mean).dot(x[i - 1] - mean);
      count += 3.0;
    }
  }
  [[nodiscard]] double sd() const { return count > 0 ? std::sqrt(sum / count) : 0.0; }
  /// Of a first-order low-pass.
  [[nodiscard]] double band_hz(double dt_s) const {
    const double rho = sum > 0 ? std::clamp(lagged / sum, 1e-3, 0.9999) : 1e-3;
    return -std::log(rho) / (2.0 * std::numbers::pi * dt_s);
  }
};

struct Measured {
  Scatter orientation, position;
};

Measured measure(const Signals& s, const io::Recording& r) {
  Measured out;
  const auto least = static_cast<std::size_t>(kLeastRest_s / s.dt_s);
  const auto shows = [&](Eigen::Index i) {
    const auto row = static_cast<std::size_t>(i);
    return s.rest[row] && r.ref_q_world_body[row].allFinite();
  };
  each_run(s.n, shows, [&](Eigen::Index first, Eigen::Index last) {
    const auto begin = static_cast<std::size_t>(first), end = static_cast<std::size_t>(last);
    if (end - begin < least) return;
    std::vector<Vec3> turns, places;
    const auto at = [&](std::size_t i) { return detail::as_expected(r.ref_q_world_body[i]); };
    for (std::size_t i = begin; i < end; ++i) {
      turns.push_back(log_quat(at(begin).conjugate() * at(i)));
      if (s.has_position && r.ref_position_m[i].allFinite()) places.push_back(r.ref_position_m[i]);
    }
    out.orientation.add(turns);
    if (places.size() > least) out.position.add(places);
  });
  return out;
}

/// Nats of n^2 independent samples for this scatter over the stated one.
double gain_of(double sd, double stated, double n) {
  if (sd <= stated) return 0.0;
  const double ratio = std::pow(sd / std::max(stated, 1e-3 * sd), 2);
  return 0.5 * n * n * (ratio - 1.0 - std::log(ratio));
}

/// What the simulation says its reference is wrong by: rad, m.
std::array<double, 2> stated_of(const sim::SimulationConfig& given) {
  std::array<double, 2> square{};
  const auto add = [&square](double rad, double m) { square[0] += rad * rad, square[1] += m * m; };
  if (given.reference.kind == "mocap") add(given.reference.orientation_sd_rad, given.reference.position_sd_m);
  for (const auto& e : given.effects)
    if (e.id == "ref_error") add(e.parameters.at("orientation_sd_rad")[0], e.parameters.at("position_sd_m")[0]);
  return {std::sqrt(square[0]), std::sqrt(square[1])};
}

}  // namespace

void find_reference_error(const Signals& s, const io::Recording& recording, const sim::SimulationConfig& given,
                          Answer& answer) {
  const Measured m = measure(s, recording);
  if (m.orientation.count < 300) return;
  const double turn = m.orientation.sd(), place = m.position.sd();
  const auto [stated_rad, stated_m] = stated_of(given);
  if (turn <= std::max(kOverStated * stated_rad, kLeast_rad) && place <= std::max(kOverStated * stated_m, kLeast_m))
    return;
  const double band = m.orientation.band_hz(s.dt_s);
  if (!given.reference.stated) {
    answer.diagnosis.notices.push_back(fmt::format(
        "reference: at rest it errs by {:.2g} rad and {:.2g} m (band {:.2g} Hz). To have it held to what it should be, "
        "say so in the simulation: reference: {{kind: mocap, orientation_sd_rad: ..., position_sd_m: ...}}",
        turn, place, band));
    return;
  }
  const double n = std::sqrt(m.orientation.count * std::min(1.0, 2.0 * band * s.dt_s));
  const double gain = gain_of(turn, stated_rad, n) + gain_of(place, stated_m, n);
  if (gain < kLeast_nats) return;
  const auto interval = [n](double sd) { return std::array{sd * (1.0 - 1.4 / n), sd * (1.0 + 1.4 / n)}; };
  const auto beyond = [](double sd, double stated) { return std::sqrt(std::max(sd * sd - stated * stated, 0.0)); };
  const double rad = beyond(turn, stated_rad), metre = beyond(place, stated_m);
  Finding f;
  f.effect = "ref_error";
  f.equation = "reference = true + noise of a first-order band";
  f.driver = "none: it is there at rest too, where the motion is known to be none";
  f.regime = "always; at rest it is all that the reference shows";
  f.interval_s = {0.0, s.duration_s()};
  for (const char* what : {"ref_orientation", "ref_position"}) f.channels.emplace_back(what);
  f.parameters = {{"orientation", rad, interval(rad), "rad"},
                  {"position", metre, interval(metre), "m"},
                  {"band", band, interval(band), "Hz"}};
  f.held_out.rms_before = f.held_out.rms_after = turn;
  f.held_out.noise_floor = stated_rad;
  f.held_out.unit = "rad";
  f.held_out.gain_nats = gain;
  f.p_value = chance_of(f.held_out.gain_nats);
  f.runner_up_effect = "a body that trembles";
  f.runner_up_why_rejected = "gyroscope and accelerometer are at rest meanwhile";
  f.decided_by = "the same reference on a body that is clamped down";
  answer.diagnosis.findings.push_back(std::move(f));
  answer.effects.push_back(
      {.id = "ref_error",
       .parameters = {{"orientation_sd_rad", {rad}}, {"position_sd_m", {metre}}, {"band_hz", {band}}},
       .axes = {},
       .window_s = {}});
}

}  // namespace stillpoint::diag
