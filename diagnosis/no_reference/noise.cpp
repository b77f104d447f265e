/// The noise of the self-consistency model: from within the rests, where no law and no misfit of the attitude can
/// enter.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/median.h"
#include "diagnosis/no_reference/model.h"

namespace stillpoint::diag::detail {
namespace {

constexpr int kArOrder = 6;
constexpr std::size_t kNoisePiece = 150;  // readings: many times the order, and short beside a disturbance
constexpr double kMoreThanNoise = 3.0;    // variance of a piece over the usual one

}  // namespace

/// From pieces of the rests, less those that hold more than noise: a magnet that comes, a current that is switched on.
void SelfConsistency::find_field_noise() {
  struct Piece {
    Eigen::VectorXd covariance = Eigen::VectorXd::Zero(kArOrder + 1);  ///< by lag
    double count = 0.0;
  };
  std::array<std::vector<Piece>, 3> pieces;
  for (const auto& w : rest_) {
    std::vector<Vec3> v;
    for (std::size_t at = 0; at < mag_rows_.size(); ++at) {
      const std::size_t row = mag_rows_[at];
      if (row >= w.first && row <= w.last) v.push_back(mag_[row]);
      const bool ends = at + 1 == mag_rows_.size() || mag_rows_[at + 1] > w.last;
      if (v.empty() || (v.size() < kNoisePiece && !ends)) continue;
      if (v.size() >= 3 * kArOrder)
        for (int k = 0; k < 3; ++k) {
          Piece p;
          double mean = 0.0;
          for (const Vec3& m : v) mean += m[k] / static_cast<double>(v.size());
          for (std::size_t i = 0; i < v.size(); ++i)
            for (std::size_t lag = 0; lag <= std::min<std::size_t>(kArOrder, i); ++lag)
              p.covariance[static_cast<long>(lag)] += (v[i][k] - mean) * (v[i - lag][k] - mean);
          p.count = static_cast<double>(v.size() - 1);
          pieces[static_cast<std::size_t>(k)].push_back(std::move(p));
        }
      v.clear();
      if (ends) break;
    }
  }
  for (int k = 0; k < 3; ++k) {
    auto& ar = mag_ar_[static_cast<std::size_t>(k)];
    ar = Eigen::VectorXd::Zero(kArOrder);
    mag_sd_[k] = simulation_.magnetometer ? std::max(simulation_.magnetometer->noise_sd, 1e-9) : 1.0;
    std::vector<double> variances;
    for (const Piece& p : pieces[static_cast<std::size_t>(k)]) variances.push_back(p.covariance[0] / p.count);
    if (variances.empty()) continue;
    const double limit = kMoreThanNoise * median(variances);
    Piece sum;
    for (const Piece& p : pieces[static_cast<std::size_t>(k)])
      if (p.covariance[0] <= limit * p.count) sum.covariance += p.covariance, sum.count += p.count;
    if (sum.count < 20 * kArOrder) continue;
    const Eigen::VectorXd c = sum.covariance / sum.count;
    Eigen::MatrixXd toeplitz(kArOrder, kArOrder);
    for (int i = 0; i < kArOrder; ++i)
      for (int j = 0; j < kArOrder; ++j) toeplitz(i, j) = c[std::abs(i - j)] + (i == j ? 1e-6 * c[0] : 0.0);
    ar = toeplitz.ldlt().solve(c.tail(kArOrder));
    mag_sd_[k] = std::sqrt(std::max(c[0] - ar.dot(c.tail(kArOrder)), 1e-6 * c[0] + 1e-18));
    mag_sd_[k] *= std::max(1.0, leg_s_ / even_leg_s());  // a walk that no knot takes out
  }
}

/// Noise from within the rests only, where no law and no misfit of the attitude can enter it: an autoregressive model
/// of the field, and the scatter of the cell means about their window's mean.
void SelfConsistency::find_noise() {
  find_field_noise();
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
  if (freedom < 3) return;
  force_sd_ = (force2 / freedom).cwiseSqrt().array() + 1e-9;
  rate_sd_ = (rate2 / freedom).cwiseSqrt().array() + 1e-12;
}

}  // namespace stillpoint::diag::detail
