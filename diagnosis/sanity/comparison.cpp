#include "diagnosis/sanity/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/directions.h"
#include "core/median.h"
#include "core/so3.h"

namespace stillpoint::diag::detail {
namespace {

constexpr std::size_t kParts = 4;
constexpr double kPositionStencil_s = 0.06;  // second differences over this long, against the noise of the position
constexpr double kTurning_radps = 0.2;
constexpr std::size_t kLeastAngles = 20;
constexpr std::size_t kMostRows = 4000;  // of those that are looked at

}  // namespace

Quat as_expected(const Eigen::Vector4d& q) { return Quat(q[0], q[1], q[2], q[3]).normalized(); }

Relation Relation::about_means() const {
  Relation out = *this;
  if (rows == 0) return out;
  const auto n = static_cast<double>(rows);
  out.product -= x_sum * y_sum.transpose() / n;
  out.xx -= x_sum.squaredNorm() / n, out.yy -= y_sum.squaredNorm() / n;
  out.x_sum.setZero(), out.y_sum.setZero();
  return out;
}

Mat3 Relation::turn() const { return nearest_orthogonal(product, product.determinant()); }

double Relation::coherence() const {
  if (!(xx > 0) || !(yy > 0)) return 0.0;
  return singular_values(product).sum() / std::sqrt(xx * yy);
}

bool Relation::spans_space() const {
  const Vec3 sizes = singular_values(product);
  return sizes[2] > 0.02 * sizes[0];
}

Comparison::Comparison(const io::Recording& r, const sim::SimulationConfig& config) : r_(r), config_(config) {
  step_s_ = std::max(r.median_step_s(), 1e-9);
  stencil_ = static_cast<std::size_t>(std::clamp(std::round(kPositionStencil_s / step_s_), 1.0, 0.1 * kMostRows));
  stride_ = std::max<std::size_t>(1, r.size() / kMostRows);
}

bool Comparison::corrected(std::size_t i, Sensor s, Vec3& out) const {
  const auto* config = triad(config_, s);
  const auto& column = triad(r_, s);
  if (config == nullptr || column.empty() || !column[i].allFinite()) return false;
  out = config->matrix * (column[i] - config->bias);
  return true;
}

double Comparison::force_angle(const Convention& to_enu, bool with_position) const {
  std::vector<double> angles;
  each_row([&](std::size_t i) {
    Vec3 measured, predicted;
    if (force(i, to_enu, with_position, measured, predicted)) angles.push_back(angle_rad(measured, predicted));
  });
  return angles.size() < kLeastAngles ? -1.0 : median(std::move(angles));
}

double Comparison::field_angle() const {
  std::vector<double> angles;
  each_row([&](std::size_t i) {
    Vec3 measured, predicted;
    if (field(i, measured, predicted)) angles.push_back(angle_rad(measured, predicted));
  });
  return angles.size() < kLeastAngles ? -1.0 : median(std::move(angles));
}

double Comparison::rate_agreement(const Convention& to_enu) const {
  std::array<double, kParts> residual{}, total{}, rows{};
  std::array<Vec3, kParts> offset{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  each_row([&](std::size_t i) {
    Vec3 measured, predicted;
    if (!rate(i, to_enu, measured, predicted)) return;
    const std::size_t part = i * kParts / r_.size();
    residual[part] += (measured - predicted).squaredNorm(), total[part] += measured.squaredNorm();
    offset[part] += measured - predicted, rows[part] += 1.0;
  });
  // An offset, even one that grows, is no wrong convention.
  for (std::size_t part = 0; part < kParts; ++part)
    if (rows[part] > 0) residual[part] -= offset[part].squaredNorm() / rows[part];
  double best = -1.0;
  bool any = false;
  for (std::size_t part = 0; part < kParts; ++part)
    if (total[part] > 0) best = std::max(best, 1.0 - residual[part] / total[part]), any = true;
  return any ? best : 1.0;
}

bool Comparison::force(std::size_t i, const Convention& to_enu, bool with_position, Vec3& measured,
                       Vec3& predicted) const {
  if (!corrected(i, kAcc, measured) || !r_.ref_q_world_body[i].allFinite()) return false;
  Vec3 a_world = Vec3::Zero();
  if (with_position) {
    const double h = static_cast<double>(stencil_) * step_s_;
    a_world = (r_.ref_position_m[i + stencil_] - 2 * r_.ref_position_m[i] + r_.ref_position_m[i - stencil_]) / (h * h);
  } else if (std::abs(measured.norm() / config_.gravity_mps2 - 1.0) > 0.05) {
    return false;
  }
  predicted = to_enu(r_.ref_q_world_body[i]).conjugate() * (a_world + Vec3(0, 0, config_.gravity_mps2));
  return predicted.allFinite();
}

bool Comparison::rate(std::size_t i, const Convention& to_enu, Vec3& measured, Vec3& predicted) const {
  const auto &before = r_.ref_q_world_body[i - 1], &after = r_.ref_q_world_body[i + 1];
  if (!corrected(i, kGyr, measured) || !before.allFinite() || !after.allFinite()) return false;
  predicted = log_quat(to_enu(before).conjugate() * to_enu(after)) / (r_.t_s(i + 1) - r_.t_s(i - 1));
  return predicted.allFinite() && measured.norm() > kTurning_radps;
}

bool Comparison::field(std::size_t i, Vec3& measured, Vec3& predicted) const {
  if (!corrected(i, kMag, measured) || !r_.ref_q_world_body[i].allFinite()) return false;
  predicted = as_expected(r_.ref_q_world_body[i]).conjugate() * config_.field_world_uT;
  return true;
}

Relation Comparison::relation(Sensor s) const {
  Relation out;
  each_row([&](std::size_t i) {
    Vec3 measured, predicted;
    const bool there = s == kAcc   ? force(i, as_expected, !r_.ref_position_m.empty(), measured, predicted)
                       : s == kGyr ? rate(i, as_expected, measured, predicted)
                                   : field(i, measured, predicted);
    if (there) out.add(predicted, measured);
  });
  return out;
}

Relation Comparison::slow_rates() const {
  const auto rows = static_cast<std::size_t>(std::clamp(std::round(0.1 / step_s_), 1.0, 20.0));
  Relation out;
  for (std::size_t i = 0; i + rows < r_.size(); i += rows) {
    const auto &before = r_.ref_q_world_body[i], &after = r_.ref_q_world_body[i + rows];
    Vec3 mean = Vec3::Zero(), measured;
    bool there = before.allFinite() && after.allFinite();
    for (std::size_t k = i; k < i + rows && there; ++k) {
      there = corrected(k, kGyr, measured);
      mean += measured / static_cast<double>(rows);
    }
    if (!there) continue;
    const Vec3 predicted =
        log_quat(as_expected(before).conjugate() * as_expected(after)) / (r_.t_s(i + rows) - r_.t_s(i));
    if (predicted.allFinite() && mean.allFinite()) out.add(predicted, mean);
  }
  return out;
}

std::optional<Vec3> Comparison::field_in_world() const {
  Vec3 sum = Vec3::Zero();
  double count = 0;
  each_row([&](std::size_t i) {
    Vec3 measured, predicted;
    if (!field(i, measured, predicted)) return;
    sum += as_expected(r_.ref_q_world_body[i]) * measured;
    count += 1;
  });
  if (count < 100) return std::nullopt;
  return sum / count;
}

std::string axes_in_words(const Mat3& turn, const char* to, const char* from) {
  std::string words;
  bool identity = true;
  for (int row = 0; row < 3; ++row) {
    int column = 0;
    if (turn.row(row).cwiseAbs().maxCoeff(&column) < 0.85) return {};
    const bool minus = turn(row, column) < 0;
    identity = identity && column == row && !minus;
    words += fmt::format("{}{} {} is {} {}{}", row ? ", " : "", to, "xyz"[row], from, minus ? "-" : "+", "xyz"[column]);
  }
  return identity ? std::string{} : words;
}

}  // namespace stillpoint::diag::detail
