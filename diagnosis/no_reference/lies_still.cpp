/// Whether a recording lies still throughout, and whether what seems to lie still does.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/so3.h"
#include "diagnosis/no_reference/still.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kStillMotion = 0.3;  // rad/s
constexpr double kSwayCell_s = 0.25;
constexpr double kLeastSteps = 8.0;
constexpr double kTurned = 0.4;  // of what gravity leans, in squares: of noise alone a fifth at most

}  // namespace

bool sways(const io::Recording& r, const std::vector<RestWindow>& windows) {
  if (r.acc_mps2.size() != r.gyr_radps.size()) return false;
  const auto length =
      std::max<std::size_t>(2, static_cast<std::size_t>(kSwayCell_s / std::max(r.median_step_s(), 1e-6)));
  const double step_s = static_cast<double>(length) * r.median_step_s();
  // From cell to cell the direction of the force leans by (offset - rate) x up; the offset that suits best is allowed.
  Mat3 information = 1e-12 * Mat3::Identity();
  Vec3 sum = Vec3::Zero();
  double without_turns = 0.0, with_turns = 0.0, steps = 0.0;
  for (const RestWindow& w : windows) {
    std::optional<std::pair<Vec3, Vec3>> before;  // up and rate
    for (std::size_t i = w.first; i + length <= w.last + 1; i += length) {
      Vec3 force = Vec3::Zero(), rate = Vec3::Zero();
      for (std::size_t k = i; k < i + length; ++k)
        if (r.acc_mps2[k].allFinite() && r.gyr_radps[k].allFinite()) force += r.acc_mps2[k], rate += r.gyr_radps[k];
      if (force.isZero()) continue;
      const std::pair<Vec3, Vec3> now{force.normalized(), rate / static_cast<double>(length)};
      if (before) {
        const auto& [up, rate_before] = *before;
        const Vec3 lean = now.first - up, left = lean + step_s * (0.5 * (rate_before + now.second)).cross(up);
        const Mat3 by_offset = -step_s * skew(up);
        information += by_offset.transpose() * by_offset, sum += by_offset.transpose() * left;
        without_turns += lean.squaredNorm(), with_turns += left.squaredNorm(), steps += 1.0;
      }
      before = now;
    }
  }
  with_turns -= sum.dot(information.ldlt().solve(sum));
  return steps >= kLeastSteps && with_turns < (1.0 - kTurned) * without_turns;
}

bool lies_still(const io::Recording& r) {
  if (r.gyr_radps.size() < 200) return false;
  std::size_t moving = 0;
  const Vec3 typical = r.gyr_radps[r.size() / 2];
  for (const Vec3& w : r.gyr_radps)
    moving += w.allFinite() && typical.allFinite() && (w - typical).norm() > kStillMotion;
  return moving * 500 < r.size() && !sways(r, {{0, r.size() - 1}});
}

}  // namespace stillpoint::diag::detail
