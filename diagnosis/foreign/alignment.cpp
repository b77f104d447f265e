#include "diagnosis/foreign/alignment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string_view>

#include "core/directions.h"
#include "core/median.h"
#include "core/so3.h"
#include "diagnosis/foreign/clocks.h"
#include "diagnosis/foreign/linear_map.h"
#include "diagnosis/sanity/comparison.h"
#include "diagnosis/sanity/rows.h"

namespace stillpoint::diag {
namespace {

constexpr double kSlowest_hz = 0.5, kFastest_hz = 2e4;  // of readings of a motion
constexpr double kMostAsLong = 500.0;                   // one of the two as the other
constexpr double kSameMotion = 0.7;                     // correlation of the norms
constexpr double kShortest_s = 10.0;                    // of the overlap
constexpr double kDrift = 2e-3;                         // of two clocks; beyond, it is no clock
constexpr double kParted = 0.5;                         // of the block's own scatter left over by the best linear map
constexpr double kStill = 4.0;                          // times the noise: no motion
constexpr double kBlock_s = 2.0;
constexpr double kLongestStep_s = 0.1;  // between two frames of a reference that say how it turned
constexpr Eigen::Index kFewestFrames = 200;

const std::vector<Vec3>& column(const io::Recording& r, Sensor k) {
  return k == kAcc ? r.acc_mps2 : k == kGyr ? r.gyr_radps : r.mag_uT;
}

bool holds(const io::Recording& r, Sensor k) {
  return std::any_of(column(r, k).begin(), column(r, k).end(), [](const Vec3& v) { return v.allFinite(); });
}

Course course_of(const io::Recording& r, Sensor k) {
  Course c{filled3(column(r, k)), {r.median_step_s(), Series(static_cast<Eigen::Index>(r.size()))}};
  for (std::size_t i = 0; i < r.size(); ++i) c.rows.t_s[static_cast<Eigen::Index>(i)] = r.t_s(i) - r.t_s(0);
  return c;
}

/// The readings alone, each at its time.
Course readings_of(const io::Recording& r, Sensor k) {
  std::vector<Vec3> read;
  std::vector<double> at;
  for (std::size_t i = 0; i < r.size(); ++i)
    if (const Vec3& v = column(r, k)[i]; v.allFinite()) read.push_back(v), at.push_back(r.t_s(i) - r.t_s(0));
  const auto n = static_cast<Eigen::Index>(at.size());
  const double step_s = (at.back() - at.front()) / std::max(1.0, static_cast<double>(n - 1));
  return {filled3(read), {std::max(step_s, 1e-9), Eigen::Map<const Series>(at.data(), n)}};
}

/// Why the times of the two cannot be of one motion, in words; empty: they can. What follows would work on rows without
/// end.
std::string wrong_unit_of_time(const Course& log, const Course& recording) {
  const auto of_a_motion = [](const Course& c) {
    return c.rows.step_s > 1.0 / kFastest_hz && c.rows.step_s < 1.0 / kSlowest_hz;
  };
  const double times = log.end_s() / std::max(recording.end_s(), 1e-9);
  if (of_a_motion(log) && of_a_motion(recording) && times < kMostAsLong && times > 1.0 / kMostAsLong) return {};
  return fmt::format(
      "the simulated log is of {:.4g} s at {:.4g} Hz, the recording of {:.4g} s at {:.4g} Hz: the time column of one "
      "is likely in another unit (s, ms, us or ns) than it is taken for; for the log write time: {{column: ..., unit: "
      "...}} into --map",
      log.end_s(), 1.0 / log.rows.step_s, recording.end_s(), 1.0 / recording.rows.step_s);
}

/// What neighbours scatter, in the quietest tenth of the seconds.
double quiet_noise(const Series3& x, double step_s) {
  const auto block = std::max<Eigen::Index>(10, std::lround(1.0 / step_s));
  std::vector<double> sd;
  for (Eigen::Index b = 0; b + block <= x.rows(); b += block) {
    double sum = 0.0;
    for (Eigen::Index i = b + 2; i + 2 < b + block; ++i)  // fourth differences: no motion is left in them
      sum += (x.row(i - 2) - 4.0 * x.row(i - 1) + 6.0 * x.row(i) - 4.0 * x.row(i + 1) + x.row(i + 2)).squaredNorm();
    sd.push_back(std::sqrt(sum / (70.0 * 3.0 * static_cast<double>(block - 4))));
  }
  return sd.empty() ? 0.0 : quantile(std::move(sd), 0.1);
}

/// White noise of one reading, of the rows in which it was read: what stands between them in a filled column has none
/// of its own.
double noise_of(const io::Recording& r, Sensor k) {
  std::vector<Vec3> read;
  const auto is_read = [](const Vec3& v) { return v.allFinite(); };
  std::copy_if(column(r, k).begin(), column(r, k).end(), std::back_inserter(read), is_read);
  const auto times = io::sensor_times(r);
  const auto own = std::find_if(times.begin(), times.end(),
                                [k](const auto& t) { return std::string_view(t.name) == kSensorName[k]; });
  return own == times.end() || !(own->median_step_s > 0.0) ? 0.0 : quiet_noise(filled3(read), own->median_step_s);
}

/// The rate between neighbouring frames of the reference, at the middle between them.
Course turning_of_reference(const io::Recording& r) {
  std::vector<Vec3> rate;
  std::vector<double> at;
  std::optional<std::size_t> last;
  for (std::size_t i = 0; i < r.ref_q_world_body.size(); ++i) {
    const auto attitude = [&r](std::size_t k) { return detail::as_expected(r.ref_q_world_body[k]); };
    if (!r.ref_q_world_body[i].allFinite()) continue;
    if (const double step = last ? r.t_s(i) - r.t_s(*last) : 0.0; step > 0.0 && step < kLongestStep_s) {
      rate.push_back(log_quat(attitude(*last).conjugate() * attitude(i)) / step);
      at.push_back(0.5 * (r.t_s(i) + r.t_s(*last)) - r.t_s(0));
    }
    last = i;
  }
  const auto n = static_cast<Eigen::Index>(at.size());
  return {filled3(rate), {r.median_step_s(), Eigen::Map<const Series>(at.data(), n)}};
}

/// Where the motions part for good: the time of the first block after which hardly any agrees. Negative: nowhere. Where
/// both rest there is nothing but noise to agree on.
double parts_at_s(const Course& motion, const Course& log, const Clocks& clocks) {
  const auto block = std::max<Eigen::Index>(1, std::lround(kBlock_s / motion.rows.step_s));
  const double noise = std::hypot(quiet_noise(motion.x, motion.rows.step_s), quiet_noise(log.x, log.rows.step_s));
  const double still = kStill * noise * std::sqrt(3.0 * static_cast<double>(block));
  const Mask outside = unread_at_rows_of(motion, log, clocks);
  const LinearMap map = map_of_the_better_half(at_rows_of(motion, log, clocks, outside), motion.x, outside);
  std::vector<std::pair<double, bool>> agreed;
  for (Eigen::Index b = 0; b + block <= motion.x.rows(); b += block) {
    if (std::any_of(outside.begin() + b, outside.begin() + b + block, [](auto o) { return o != 0; })) continue;
    const auto scatter = [b, block](const Series3& x) {
      return (x.middleRows(b, block).rowwise() - x.middleRows(b, block).colwise().mean()).norm();
    };
    const double own = scatter(motion.x), left = scatter(map.left);
    if (own < still && left < still) continue;
    agreed.emplace_back(motion.rows.at(b), left < std::max(kParted * own, still));
  }
  std::size_t good = 0, best = agreed.size();
  for (std::size_t i = 0; i < agreed.size(); ++i) good += agreed[i].second ? 1 : 0;
  if (static_cast<double>(good) > 0.75 * static_cast<double>(agreed.size())) return -1.0;
  double most = -1.0;
  double score = 0.0;
  for (std::size_t i = 0; i < agreed.size(); ++i) {
    score += agreed[i].second ? 1.0 : -1.0;
    if (score > most) most = score, best = i + 1;
  }
  return best < agreed.size() ? agreed[best].first : -1.0;
}

/// What the log says of a sensor, and where it says nothing, what was read.
Series3 said_or_read(const AlignedLog& log, Sensor k) {
  Series3 out = log.reading[k];
  for (std::size_t i = 0; i < log.unread[k].size(); ++i)
    if (log.unread[k][i] && detail::there(column(log.reference, k), i))
      out.row(static_cast<Eigen::Index>(i)) = column(log.reference, k)[i].transpose();
  return out;
}

/// The attitude: the recording's own, else the log's, else the log's rate summed up from where gravity says it began.
void add_reference(const io::Recording& log, const Course& recording, const Clocks& clocks, AlignedLog& out) {
  io::Recording& r = out.reference;
  if (!r.ref_q_world_body.empty()) return;
  if (out.reading[kGyr].rows() == 0) return;
  out.summed_up = true;
  const Series3 w = said_or_read(out, kGyr);
  Quat q = Quat::Identity();
  if (!log.ref_q_world_body.empty()) {
    const double t0 = clocks.offset_s;
    std::size_t row = 0;
    while (row + 1 < log.size() && log.t_s(row) - log.t_s(0) < t0) ++row;
    const Eigen::Vector4d& g = log.ref_q_world_body[row];
    if (g.allFinite()) q = detail::as_expected(g);
  } else if (out.reading[kAcc].rows() > 0) {
    q = turn_between(Vec3(said_or_read(out, kAcc).topRows(std::min<Eigen::Index>(20, w.rows())).colwise().mean()),
                     Vec3::UnitZ());
  }
  for (Eigen::Index i = 0; i < w.rows(); ++i) {
    if (i > 0) {
      const double step = recording.rows.at(i) - recording.rows.at(i - 1);
      q = (q * exp_quat(0.5 * step * Vec3(w.row(i) + w.row(i - 1)))).normalized();
    }
    r.ref_q_world_body.emplace_back(q.w(), q.x(), q.y(), q.z());
  }
}

}  // namespace

Result<AlignedLog> align(const io::Recording& log, const io::Recording& recording) {
  const Sensor lead = holds(log, kGyr) && holds(recording, kGyr) ? kGyr : kAcc;
  if (!holds(log, lead) || !holds(recording, lead))
    return fail(ErrorKind::kBadData,
                "the simulated log and the recording share neither a gyroscope nor an accelerometer");
  const Course theirs = readings_of(log, lead), ours = course_of(recording, lead);
  if (theirs.x.rows() <= 2 * kStencilReach)
    return fail(ErrorKind::kBadData,
                fmt::format("the simulated log holds {} readings of its {} only", theirs.x.rows(), kSensorName[lead]));
  if (const std::string why = wrong_unit_of_time(theirs, readings_of(recording, lead)); !why.empty())
    return fail(ErrorKind::kBadData, why);
  const Course turning = turning_of_reference(recording);
  const bool has_reference = lead == kGyr && turning.x.rows() >= kFewestFrames;
  Clocks clocks = coarse_clocks(theirs, ours);
  if (has_reference)
    if (const Clocks seen = coarse_clocks(theirs, turning); seen.correlation > clocks.correlation) clocks = seen;
  if (clocks.overlap_s < kShortest_s)
    return fail(ErrorKind::kBadData,
                fmt::format("the simulated log and the recording overlap by {:.1f} s only; at least "
                            "{:.0f} s of the same motion are needed",
                            clocks.overlap_s, kShortest_s));
  if (clocks.correlation < kSameMotion)
    return fail(ErrorKind::kBadData,
                fmt::format("the simulated log is of another motion: at no offset do its {} and the recording's go "
                            "together (best correlation {:.2f}); replay the recording's motion in the simulator",
                            kSensorName[lead], clocks.correlation));
  refine_clocks(theirs, ours, clocks);
  if (has_reference) clocks = clocks_of_reference(theirs, turning, clocks);
  if (std::abs(clocks.drift) > kDrift)
    return fail(ErrorKind::kBadData,
                fmt::format("the clock of the simulated log runs {:+.2f} % against the recording's: "
                            "its time column has another unit or the motion another speed",
                            100.0 * clocks.drift));
  const double t = parts_at_s(ours, theirs, clocks);
  if (t >= 0.0 && !(has_reference && parts_at_s(turning, theirs, clocks) < 0.0))
    return fail(ErrorKind::kBadData,
                fmt::format("the simulated log and the recording part at {:.1f} s: from there on the motion is "
                            "another; give both up to there",
                            t));
  AlignedLog out;
  out.offset_s = clocks.offset_s, out.drift = clocks.drift;
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (!holds(log, k) || !holds(recording, k)) continue;
    const Course c = readings_of(log, k), own = course_of(recording, k);
    out.unread[k] = unread_at_rows_of(own, c, clocks);
    out.reading[k] = at_rows_of(own, c, clocks, out.unread[k]);
    out.noise_sd[k] = noise_of(log, k);
    out.own_noise_sd[k] = noise_of(recording, k);
    if (const std::string what = difference(k, linear_map(out.reading[k], own.x, out.unread[k])); !what.empty())
      return fail(ErrorKind::kBadData, what);
    if (const double noise = out.own_noise_sd[k]; out.noise_sd[k] > 1.3 * noise && noise > 0)
      out.notices.push_back(
          fmt::format("{}: the simulated log is noisier ({:.2g} {}) than the recording ({:.2g}): the "
                      "noise may be in it twice",
                      kSensorName[k], out.noise_sd[k], kSensorUnit[k], noise));
  }
  out.reference = recording;
  add_reference(log, ours, clocks, out);
  out.notices.push_back(fmt::format(
      "the recording's first row is at {:.4f} s of the simulated log, whose clock runs {:+.1f} ppm against it; {}",
      clocks.offset_s, 1e6 * clocks.drift,
      has_reference ? "a delay common to all sensors is told by the recording's reference"
                    : "a delay common to all sensors would be taken for this offset"));
  return out;
}

}  // namespace stillpoint::diag
