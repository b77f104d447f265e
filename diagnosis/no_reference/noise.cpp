/// The noise of the self-consistency model: from within the rests, where no law and no misfit of the attitude can
/// enter.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/median.h"
#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {
namespace {

constexpr int kArOrder = 6;
constexpr std::size_t kNoisePiece = 150;  // readings: many times the order, and short beside a disturbance
constexpr double kLeastInMotion_mps2 = 0.5, kUntold_radps = 1e3;  // cells in motion say which way is up, and no rate
constexpr double kMoreThanNoise = 3.0;                            // variance of a piece over the usual one

struct Autocovariance {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(kArOrder + 1);  ///< by lag
  double count = 0.0;

  Autocovariance() = default;
  Autocovariance(const std::vector<Vec3>& x, int axis) : count(static_cast<double>(x.size() - 1)) {
    double mean = 0.0;
    for (const Vec3& v : x) mean += v[axis] / static_cast<double>(x.size());
    for (std::size_t i = 0; i < x.size(); ++i)
      for (std::size_t lag = 0; lag <= std::min<std::size_t>(kArOrder, i); ++lag)
        sum[static_cast<long>(lag)] += (x[i][axis] - mean) * (x[i - lag][axis] - mean);
  }
};

}  // namespace

/// The field's readings in pieces, none over the end of a rest.
std::vector<std::vector<Vec3>> SelfConsistency::field_at_rest(std::size_t most_rows) const {
  std::vector<std::vector<Vec3>> pieces;
  std::size_t at = 0;
  for (const auto& w : rest_) {
    std::vector<Vec3> piece;
    for (; at < mag_rows_.size() && mag_rows_[at] <= w.last; ++at) {
      if (mag_rows_[at] < w.first) continue;
      piece.push_back(mag_[mag_rows_[at]]);
      if (piece.size() == most_rows) pieces.push_back(std::exchange(piece, {}));
    }
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

/// From pieces of the rests, less those that hold more than noise: a magnet that comes, a current that is switched on.
void SelfConsistency::find_field_noise() {
  auto pieces = field_at_rest(kNoisePiece);
  std::erase_if(pieces, [](const auto& piece) { return piece.size() < 3 * kArOrder; });
  for (int k = 0; k < 3; ++k) {
    auto& ar = mag_ar_[static_cast<std::size_t>(k)];
    ar = Eigen::VectorXd::Zero(kArOrder);
    const double walked = std::max(1.0, leg_s_ / even_leg_s());  // a walk that no knot takes out
    mag_sd_[k] = simulation_.magnetometer ? walked * std::max(simulation_.magnetometer->noise_sd, 1e-9) : 1.0;
    std::vector<Autocovariance> each;
    std::vector<double> variances;
    for (const auto& piece : pieces) {
      each.emplace_back(piece, k);
      variances.push_back(each.back().sum[0] / each.back().count);
    }
    if (each.empty()) continue;
    const double limit = kMoreThanNoise * median(variances);
    Autocovariance usual;
    for (const Autocovariance& a : each)
      if (a.sum[0] <= limit * a.count) usual.sum += a.sum, usual.count += a.count;
    if (usual.count < 20 * kArOrder) continue;
    const Eigen::VectorXd c = usual.sum / usual.count;
    Eigen::MatrixXd toeplitz(kArOrder, kArOrder);
    for (int i = 0; i < kArOrder; ++i)
      for (int j = 0; j < kArOrder; ++j) toeplitz(i, j) = c[std::abs(i - j)] + (i == j ? 1e-6 * c[0] : 0.0);
    ar = toeplitz.ldlt().solve(c.tail(kArOrder));
    mag_sd_[k] = walked * std::sqrt(std::max(c[0] - ar.dot(c.tail(kArOrder)), 1e-6 * c[0] + 1e-18));
  }
}

/// Takes the memory out of the readings and puts them into units of their noise, row for row.
SparseRows SelfConsistency::whitener() const {
  const auto nm = static_cast<long>(mag_rows_.size()), nc = static_cast<long>(cells_.size());
  Triplets entries;
  const auto put = [&entries](long row, long column, double value) {
    entries.emplace_back(static_cast<int>(row), static_cast<int>(column), value);
  };
  for (int k = 0; k < 3; ++k) {
    const auto& ar = mag_ar_[static_cast<std::size_t>(k)];
    for (long i = 0; i < nm; ++i) {
      put(k * nm + i, k * nm + i, 1.0 / mag_sd_[k]);
      for (long lag = 1; lag <= std::min<long>(ar.size(), i); ++lag)
        put(k * nm + i, k * nm + i - lag, -ar[lag - 1] / mag_sd_[k]);
    }
    for (long c = 0; c < nc; ++c) {
      const long force = 3 * nm + k * nc + c, rate = force + 3 * nc;
      put(force, force, 1.0 / force_sd_[k]), put(rate, rate, 1.0 / rate_sd_[k]);
    }
  }
  return assembled<SparseRows>(3 * nm + 6 * nc, 3 * nm + 6 * nc, entries);
}

/// Noise from within the rests only, where no law and no misfit of the attitude can enter it: an autoregressive model
/// of the field, and the scatter of the cell means about their window's mean.
void SelfConsistency::find_noise() {
  find_field_noise();
  if (rest_.empty()) {
    double square = 0.0;
    for (const Cell& c : cells_) square += std::pow(cell_mean(force_, c).norm() - simulation_.gravity_mps2, 2);
    const double beside_gravity =
        std::sqrt(3.0 * square / static_cast<double>(std::max<std::size_t>(cells_.size(), 1)));
    force_sd_.setConstant(std::max(beside_gravity, kLeastInMotion_mps2));
    rate_sd_.setConstant(kUntold_radps);
    return;
  }
  Vec3 force2 = Vec3::Zero(), rate2 = Vec3::Zero();
  double freedom = 0;
  for (const auto& w : rest_) {
    std::vector<Vec3> f, g;
    for (const auto& c : cells_)
      if (c.first >= w.first && c.last <= w.last) f.push_back(cell_mean(force_, c)), g.push_back(cell_mean(rate_, c));
    for (std::size_t i = 1; i < f.size(); ++i) {
      force2 += 0.5 * (f[i] - f[i - 1]).cwiseAbs2(), rate2 += 0.5 * (g[i] - g[i - 1]).cwiseAbs2();
      freedom += 1;
    }
  }
  if (freedom < 3) {  // too few to tell: as configured
    rate_sd_.setConstant(cell_radps());
    force_sd_.setConstant(simulation_.accelerometer->noise_sd * std::sqrt(recording_.median_step_s() / kRestCell_s));
    return;
  }
  force_sd_ = (force2 / freedom).cwiseSqrt().array() + 1e-9;
  rate_sd_ = (rate2 / freedom).cwiseSqrt().array() + 1e-12;
}

}  // namespace stillpoint::diag::detail
