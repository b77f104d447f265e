#include "diagnosis/validation.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/forensics/forensics.h"
#include "diagnosis/reference/apparatus.h"
#include "diagnosis/reference/given_effects.h"
#include "diagnosis/sanity/readings.h"
#include "diagnosis/sanity/rows_with_reference.h"

namespace stillpoint::diag {
namespace {

constexpr double kBlock_s = 2.0;
constexpr double kLeastRemovable = 0.02;  // of the noise power: less is not excited
constexpr Eigen::Index kLeastJudged = 500;

/// Residual without the bias and the matrix that fit it best; muted rows are zero.
Series3 left_over(const Signals& s, Sensor k) {
  Eigen::MatrixXd design(s.n, 4);
  design << Eigen::VectorXd::Ones(s.n), s.vector[k];
  Eigen::MatrixXd y = s.residual[k];
  for (Eigen::Index i = 0; i < s.n; ++i)
    if (s.muted[k][static_cast<std::size_t>(i)]) design.row(i).setZero(), y.row(i).setZero();
  return y - design * design.colPivHouseholderQr().solve(y);
}

/// Variance of one row that no law removes: half of what neighbours differ by.
double white_part(const Series3& x, const Mask& muted) {
  double sum = 0.0, count = 1e-9;
  for (Eigen::Index i = 1; i < x.rows(); ++i) {
    if (muted[static_cast<std::size_t>(i)] || muted[static_cast<std::size_t>(i) - 1]) continue;
    sum += 0.5 * (x.row(i) - x.row(i - 1)).squaredNorm(), count += 1.0;
  }
  return sum / count;
}

Validation judged(const Signals& before, const Signals& after, Sensor k) {
  const Series3 left_before = left_over(before, k), left_after = left_over(after, k);
  const Mask& muted = after.muted[k];
  const auto rows = static_cast<double>(std::count(muted.begin(), muted.end(), 0));
  const Series square_before = left_before.rowwise().squaredNorm(), square_after = left_after.rowwise().squaredNorm();
  const double floor = std::min(white_part(left_after, muted), square_after.sum() / rows);
  const double removable = square_before.sum() - rows * floor;
  Validation v;
  v.sensor = kSensorName[k];
  v.unit = kSensorUnit[k];
  v.rms_before = std::sqrt(square_before.sum() / rows / 3.0), v.rms_after = std::sqrt(square_after.sum() / rows / 3.0);
  v.share = std::numeric_limits<double>::quiet_NaN();
  v.ci95 = {v.share, v.share};
  if (removable < kLeastRemovable * rows * floor && v.rms_after < 1.01 * v.rms_before) return v;
  v.share = (square_before - square_after).sum() / std::max(removable, kLeastRemovable * rows * floor);
  const auto block = std::max<Eigen::Index>(1, std::lround(kBlock_s / after.dt_s));
  double scatter = 0.0, blocks = 0.0;
  for (Eigen::Index b = 0; b < after.n; b += block) {
    const Eigen::Index length = std::min(block, after.n - b);
    const auto here = static_cast<double>(std::count(muted.begin() + b, muted.begin() + b + length, 0));
    const double gone = (square_before - square_after).segment(b, length).sum();
    scatter += std::pow(gone - v.share * (square_before.segment(b, length).sum() - here * floor), 2), blocks += 1.0;
  }
  const double half = 1.96 * std::sqrt(scatter * blocks / std::max(blocks - 1.0, 1.0)) /
                      std::max(removable, kLeastRemovable * rows * floor);
  v.ci95 = {v.share - half, v.share + half};
  return v;
}

}  // namespace

bool acts_on(const std::string& effect, const std::string& sensor) {
  return effect.starts_with(sensor + "_") || effect.starts_with("sys_") || effect.starts_with("ref_");
}

std::vector<Validation> validate(const std::string& file, const io::Recording& other,
                                 const sim::SimulationConfig& given, const sim::SimulationConfig& improved) {
  std::vector<Validation> out;
  if (other.ref_q_world_body.empty()) return out;
  std::vector<std::string> notices;
  const auto clean = without_false_values(other, notices);
  const io::Recording& usable = clean ? *clean : other;
  const RowsWithReference framed = rows_with_reference(usable, notices);
  const io::Recording& rows = framed.changed ? *framed.changed : usable;
  const Forensics raw = examine_raw_values(rows, given);
  std::array<Mask, kSensors> muted;
  for (std::size_t k = 0; k < kSensors; ++k) muted[k] = raw.sensor[k].muted;
  const Result<Signals> made =
      make_signals(rows, given, muted, nullptr, static_cast<Eigen::Index>(framed.rows_a_frame));
  if (!made || !made->has_orientation) return out;
  Signals before = *made, after = *made;
  set_reference_on_time(before, given.reference), set_reference_on_time(after, improved.reference);
  static_cast<void>(subtract_effects(before, given.effects));
  static_cast<void>(subtract_effects(after, improved.effects));
  for (const Sensor k : {kAcc, kGyr, kMag}) {
    if (!made->compared(k)) continue;
    const auto& mask = made->muted[k];
    if (std::count(mask.begin(), mask.end(), 0) < kLeastJudged) continue;
    out.push_back(judged(before, after, k));
    out.back().file = file;
  }
  return out;
}

}  // namespace stillpoint::diag
