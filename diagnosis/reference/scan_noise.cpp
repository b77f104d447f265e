#include "diagnosis/reference/scan_noise.h"

#include <algorithm>

#include "diagnosis/reference/differences.h"

namespace stillpoint::diag {
namespace {

constexpr int kQuietRounds = 4;

}  // namespace

NoiseModel scan_noise(const Target& target, const Columns& explained, const Eigen::MatrixXd& walk) {
  // A flexible smooth model in ordinary least squares: slow cosines, and second and third powers of the measured
  // vector.
  Columns flexible = explained;
  const Eigen::MatrixXd v = target.nuisance.rightCols(3);
  const Series3 rate = derivative(v, target.rows);
  const Series3 second = second_derivative(v, target.rows);
  for (int axis = 0; axis < 3; ++axis) {
    for (Eigen::Index k = 0; k < std::min<Eigen::Index>(walk.cols(), 16); ++k) flexible.push_back({axis, walk.col(k)});
    for (int i = 0; i < 3; ++i) {
      flexible.push_back({axis, v.col(i).cwiseAbs2()});
      flexible.push_back({axis, rate.col(i)});
      flexible.push_back({axis, second.col(i)});
    }
    flexible.push_back({axis, v.col(axis).array().cube()});
  }
  // What lasts for a while only, the model takes half for lasting: fitted anew beside it until the rest is quiet.
  Target plain = target;
  plain.layout.order = 0;
  Fit fit;
  Layout quiet;
  for (int round = 0; round < kQuietRounds; ++round) {
    fit = fit_with(plain, flexible, NoiseModel(plain.layout, plain.residual), {});
    quiet = without_bursts(target.layout, fit.leftover);
    if ((quiet.present == plain.layout.present).all()) break;
    plain.layout.present = plain.layout.counts = quiet.present;
  }
  return NoiseModel(quiet, fit.leftover);
}

}  // namespace stillpoint::diag
