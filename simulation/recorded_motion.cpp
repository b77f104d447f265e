#include "simulation/recorded_motion.h"

#include <algorithm>
#include <cmath>

#include "core/median.h"
#include "core/so3.h"
#include "simulation/reference_noise.h"

namespace stillpoint::sim {
namespace {

constexpr double kWindow_s = 0.5;  // stillness is judged over this time
constexpr double kShortestRest_s = 1.0;
constexpr double kRestWeight = 100.0;   // a rest's mean is known far better than one sample
constexpr double kBridgeWeight = 1e-3;  // pseudo-samples in a gap only keep the curve from swinging
constexpr double kGap_s = 0.5;
constexpr double kMostKnots = 1e7;                           // 0.2 kB of memory each while they are solved
constexpr double kStillest_rad = 0.01, kStillest_m = 0.003;  // no rest is noisier than this

double median_step(const std::vector<double>& t_s) {
  std::vector<double> steps(t_s.size() - 1);
  for (std::size_t i = 1; i < t_s.size(); ++i) steps[i - 1] = t_s[i] - t_s[i - 1];
  return median(std::move(steps));
}

/// Largest distance from sample i within half a window on either side, rotation (rad) and translation (m).
std::pair<double, double> spread(const ReferenceTrack& track, std::size_t i) {
  double turn = 0.0, shift = 0.0;
  const auto look = [&](std::size_t j) {
    turn = std::max(turn, track.q_world_body[i].angularDistance(track.q_world_body[j]));
    if (!track.position_m.empty()) shift = std::max(shift, (track.position_m[i] - track.position_m[j]).norm());
  };
  for (std::size_t j = i; j-- > 0 && track.t_s[i] - track.t_s[j] <= 0.5 * kWindow_s;) look(j);
  for (std::size_t j = i + 1; j < track.t_s.size() && track.t_s[j] - track.t_s[i] <= 0.5 * kWindow_s; ++j) look(j);
  return {turn, shift};
}

/// Still samples: within three times the spread of the stillest tenth of the recording, which is the reference's noise
/// where there is rest at all, and never beyond the absolute limits.
std::vector<bool> recognise_rest(const ReferenceTrack& track) {
  const std::size_t n = track.t_s.size();
  std::vector<double> turn(n), shift(n);
  for (std::size_t i = 0; i < n; ++i) std::tie(turn[i], shift[i]) = spread(track, i);
  const auto limit = [n](std::vector<double> values, double most) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(n / 10), values.end());
    return std::min(most, std::max(3.0 * values[n / 10], 1e-5));
  };
  const double turn_limit = limit(turn, kStillest_rad), shift_limit = limit(shift, kStillest_m);
  std::vector<bool> still(n);
  for (std::size_t i = 0; i < n; ++i) still[i] = turn[i] <= turn_limit && shift[i] <= shift_limit;
  return still;
}

/// Whether its pieces lie apart by far more than they scatter within: `x`, samples of one span.
bool wanders(const std::vector<Vec3>& x, std::size_t piece, double floor) {
  const auto pieces = static_cast<double>(x.size() / piece);
  if (pieces < 2.0) return false;
  Vec3 mean = Vec3::Zero();
  double within = 0.0, apart = 0.0;
  for (std::size_t first = 0; first + piece <= x.size(); first += piece) {
    Vec3 own = Vec3::Zero();
    for (std::size_t i = first; i < first + piece; ++i) own += x[i] / static_cast<double>(piece);
    for (std::size_t i = first; i < first + piece; ++i)
      within += (x[i] - own).squaredNorm() / static_cast<double>(piece);
    apart += own.squaredNorm();
    mean += own;
  }
  return apart - mean.squaredNorm() / pieces > 4.0 * within + pieces * floor * floor;
}

/// Who stands still sways. Held to a mean he would be thrown from there to where he next is.
bool sways(const ReferenceTrack& track, const Span& span, double step_s) {
  constexpr double kPiece_s = 0.25, kSway_rad = 5e-4, kSway_m = 3e-4;
  const auto piece = std::max<std::size_t>(2, static_cast<std::size_t>(std::lround(kPiece_s / step_s)));
  std::vector<Vec3> turns, places;
  for (std::size_t i = span.first; i <= span.second; ++i) {
    turns.push_back(log_quat(track.q_world_body[i] * track.q_world_body[span.first].conjugate()));
    if (!track.position_m.empty()) places.push_back(track.position_m[i] - track.position_m[span.first]);
  }
  return wanders(turns, piece, kSway_rad) || wanders(places, piece, kSway_m);
}

std::vector<Span> rest_spans(const ReferenceTrack& track, double step_s) {
  std::vector<bool> still = track.moving.empty() ? recognise_rest(track) : track.moving;
  if (!track.moving.empty()) still.flip();
  std::vector<Span> spans;
  for (std::size_t i = 0; i < still.size(); ++i) {
    if (!still[i]) continue;
    std::size_t last = i;
    while (last + 1 < still.size() && still[last + 1] && track.t_s[last + 1] - track.t_s[last] < kGap_s) ++last;
    if (track.t_s[last] - track.t_s[i] >= kShortestRest_s) spans.emplace_back(i, last);
    i = last;
  }
  if (track.moving.empty()) std::erase_if(spans, [&](const Span& span) { return sways(track, span, step_s); });
  return spans;
}

/// Every sample of a rest takes the rest's mean.
template <int Columns>
void flatten(CurveSamples<Columns>& curve, const std::vector<Span>& rests) {
  for (const auto& [first, last] : rests) {
    Eigen::Matrix<double, Columns, 1> mean = Eigen::Matrix<double, Columns, 1>::Zero();
    for (std::size_t i = first; i <= last; ++i) mean += curve.value[i];
    mean /= static_cast<double>(last - first + 1);
    for (std::size_t i = first; i <= last; ++i) {
      curve.value[i] = mean;
      curve.weight[i] = kRestWeight;
    }
  }
}

/// Pseudo-samples of little weight on a smooth way across each gap.
template <int Columns>
CurveSamples<Columns> bridged(const CurveSamples<Columns>& in, double step_s) {
  CurveSamples<Columns> out;
  const auto add = [&out](double t, double weight, const auto& value) {
    out.t_s.push_back(t);
    out.weight.push_back(weight);
    out.value.push_back(value);
  };
  for (std::size_t i = 0; i < in.t_s.size(); ++i) {
    if (i > 0 && in.t_s[i] - in.t_s[i - 1] > kGap_s) {
      const double length = in.t_s[i] - in.t_s[i - 1];
      for (double t = step_s; t < length - 0.5 * step_s; t += step_s) {
        const double share = smooth_step({t / length, 0.0, 0.0}).x;
        add(in.t_s[i - 1] + t, kBridgeWeight, in.value[i - 1] + share * (in.value[i] - in.value[i - 1]));
      }
    }
    add(in.t_s[i], in.weight[i], in.value[i]);
  }
  return out;
}

/// The spline through the flattened curve, exactly still where the body rested. Cross-validation sees errors that are
/// white, the rounding of the file among them; `least_penalty` knows the coloured noise that was measured at rest.
template <int Columns>
SmoothingSpline<Columns> smoothed(const CurveSamples<Columns>& flat, const std::vector<Span>& rests, double step_s,
                                  double least_penalty) {
  const auto samples = bridged(flat, step_s);
  const double penalty = std::max(least_penalty, cross_validated_penalty(samples, step_s));
  SmoothingSpline<Columns> spline(samples, step_s, penalty);
  for (const auto& [first, last] : rests) spline.hold(flat.t_s[first], flat.t_s[last], flat.value[first]);
  return spline;
}

/// Three knots inside either end of a rest nothing but held coefficients acts.
std::vector<std::pair<double, double>> spans_s(const std::vector<double>& t_s, const std::vector<Span>& rests,
                                               double step_s) {
  std::vector<std::pair<double, double>> out;
  out.reserve(rests.size());
  for (const auto& [first, last] : rests) out.emplace_back(t_s[first] + 3.0 * step_s, t_s[last] - 3.0 * step_s);
  return out;
}

}  // namespace

Result<std::unique_ptr<Motion>> RecordedMotion::from(ReferenceTrack track) {
  const std::size_t n = track.t_s.size();
  if (n < 10) return fail(ErrorKind::kBadData, "fewer than ten rows with a reference orientation: no motion to take");
  const double step_s = median_step(track.t_s), length_s = track.t_s.back() - track.t_s.front();
  if (!(length_s / step_s < kMostKnots))
    return fail(ErrorKind::kBadData, "the reference spans " + std::to_string(length_s) + " s in steps of " +
                                         std::to_string(step_s) +
                                         " s, more than can be smoothed at once; is there a wrong time stamp?");
  CurveSamples<4> turns;
  CurveSamples<3> places;
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::Vector4d q = track.q_world_body[i].normalized().coeffs();
    if (i > 0 && q.dot(turns.value.back()) < 0.0) q = -q;
    turns.value.push_back(q);
    places.value.push_back(track.position_m.empty() ? Vec3::Zero() : track.position_m[i]);
    turns.t_s.push_back(track.t_s[i] - track.t_s[0]);
  }
  turns.weight.assign(n, 1.0);
  places.t_s = turns.t_s;
  places.weight = turns.weight;
  const auto rests = rest_spans(track, step_s);
  // Sensors feel the second derivative of the place and the first of the orientation.
  const double turn_penalty = penalty_against_noise(turns, rests, step_s, 1);
  const double place_penalty = penalty_against_noise(places, rests, step_s, 2);
  flatten(turns, rests);
  flatten(places, rests);
  return std::unique_ptr<Motion>(new RecordedMotion(smoothed(turns, rests, step_s, turn_penalty),
                                                    smoothed(places, rests, step_s, place_penalty),
                                                    spans_s(turns.t_s, rests, step_s), turns.t_s.back() + step_s));
}

MotionState RecordedMotion::at(double t_s) const noexcept {
  const auto q = orientation_.at(t_s);
  const auto p = position_.at(t_s);
  const auto after = std::upper_bound(rests_s_.begin(), rests_s_.end(), t_s,
                                      [](double t, const auto& rest) { return t < rest.first; });
  const bool still = after != rests_s_.begin() && t_s <= (after - 1)->second;
  const Taylor scale = rsqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  MotionState s = motion_state({p}, {scale * q[3], scale * q[0], scale * q[1], scale * q[2]}, !still);
  if (!still) return s;
  s.velocity_mps = s.acceleration_mps2 = s.rate_radps = s.angular_acceleration_radps2 = Vec3::Zero();
  return s;
}

}  // namespace stillpoint::sim
