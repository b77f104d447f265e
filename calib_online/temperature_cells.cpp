#include "calib_online/temperature_cells.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "calib_online/temperature_filter.h"

namespace stillpoint::calib {
namespace {

/// What one cell says of the nine entries: information J and J p.
struct CellEvidence {
  Mat9 J;
  Vec9 Jp;
};

/// (T12): the bias entries of another temperature differ by `difference` more than the polynomial says. For one cell
/// J = (I^-1 + D)^-1 with D on the three bias entries only, so three rows are all that has to be inverted.
CellEvidence evidence(const Moments& sums, double window_variance, double difference) {
  const Moments::Mat10 P = sums.normal_matrix();
  CellEvidence out{Mat9(P.topLeftCorner<9, 9>() / window_variance), Vec9(P.block<9, 1>(0, 9) / window_variance)};
  if (difference <= 0.0) return out;
  const Eigen::Matrix<double, 9, 3> bias = out.J.rightCols<3>();
  const Mat3 inner = Mat3::Identity() / difference + bias.bottomRows<3>();
  const Eigen::Matrix<double, 9, 3> gain = bias * inner.inverse();
  const Vec3 Jp_bias = out.Jp.tail<3>();
  out.J -= gain * bias.transpose();
  out.Jp -= gain * Jp_bias;
  return out;
}

/// Rows: the nine entries at tau as a function of the trend.
Eigen::Matrix<double, 9, TemperatureCells::kTrend> trend_rows(double tau) {
  Eigen::Matrix<double, 9, TemperatureCells::kTrend> G = Eigen::Matrix<double, 9, TemperatureCells::kTrend>::Zero();
  G.leftCols<9>().setIdentity();
  G.middleCols<9>(9).diagonal().setConstant(tau);
  G.bottomRightCorner<3, 3>().diagonal().setConstant(tau * tau);
  return G;
}

}  // namespace

void TemperatureCells::add(const Vec3& x, const Mat3& C, double temp_degC, double weight) noexcept {
  const double position = (temp_degC - params_.first_degC) / params_.spacing_K;
  Cell& cell = cells_[static_cast<std::size_t>(std::clamp(position, 0.0, kCells - 1.0))];
  cell.sums.forget(params_.keep);
  cell.sums.add_adjusted(x, C, weight);
  cell.temp_sum = params_.keep * cell.temp_sum + weight * temp_degC;
}

TemperatureCells::Estimate TemperatureCells::at(double temp_degC, const Prior& prior) const noexcept {
  using Information = Eigen::Matrix<double, kTrend, kTrend>;
  Information N = prior.variance.cwiseInverse().asDiagonal();
  Trend b = Trend::Zero();
  b.head<3>() = prior.variance.head<3>().cwiseInverse();  // times one: the unit sphere
  for (const Cell& cell : cells_) {
    if (!(cell.sums.weight() > 0.0)) continue;
    const double at_degC = cell.temp_sum / cell.sums.weight();
    const double apart = std::abs(at_degC - temp_degC) / params_.alike_K;
    // Even the same temperature is another on the way up than on the way down: one part of three at no distance.
    const double difference = prior.local_variance * (1.0 + 2.0 * (1.0 - std::exp(-apart)));
    const CellEvidence e = evidence(cell.sums, prior.window_variance, difference);
    const auto G = trend_rows((at_degC - prior.temp_ref_degC) / kTempScale_K);
    N.noalias() += G.transpose() * e.J * G;
    b.noalias() += G.transpose() * e.Jp;
  }
  const Eigen::LDLT<Information> solver(N);
  Estimate out;
  if (!solver.isPositive()) return out;
  const auto G = trend_rows((temp_degC - prior.temp_ref_degC) / kTempScale_K);
  out.p = G * solver.solve(b);
  out.covariance = G * solver.solve(Information::Identity()) * G.transpose();
  out.valid = out.p.allFinite() && out.covariance.allFinite();
  return out;
}

Moments TemperatureCells::all() const noexcept {
  Moments sum;
  for (const Cell& cell : cells_) sum.merge(cell.sums);
  return sum;
}

}  // namespace stillpoint::calib
