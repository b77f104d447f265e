/// Whether a recording lies still throughout.
#include <algorithm>
#include <cmath>

#include "diagnosis/no_reference/still.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kStillMotion = 0.3;  // rad/s
constexpr double kSwayCell_s = 0.5;
constexpr double kSwayTogether = 0.4;  // correlation of leaning and turning: of noise alone it is a tenth

/// Slow turns, as of a ship: gravity leans as the gyroscope turns. Where it leans alone the accelerometer drifts.
bool sways(const io::Recording& r) {
  if (r.acc_mps2.size() != r.gyr_radps.size()) return false;
  const auto length =
      std::max<std::size_t>(2, static_cast<std::size_t>(kSwayCell_s / std::max(r.median_step_s(), 1e-6)));
  std::vector<Vec3> up, rate;
  for (std::size_t i = 0; i + length <= r.size(); i += length) {
    Vec3 force = Vec3::Zero(), turn = Vec3::Zero();
    for (std::size_t k = i; k < i + length; ++k)
      if (r.acc_mps2[k].allFinite() && r.gyr_radps[k].allFinite()) force += r.acc_mps2[k], turn += r.gyr_radps[k];
    if (force.isZero()) continue;
    up.push_back(force.normalized()), rate.push_back(turn / static_cast<double>(length));
  }
  if (up.size() < 8) return false;
  Vec3 mean_rate = Vec3::Zero();
  for (const Vec3& w : rate) mean_rate += w / static_cast<double>(rate.size());
  double together = 0.0, leans = 0.0, turns = 0.0;
  for (std::size_t i = 1; i < up.size(); ++i) {
    const Vec3 lean = up[i] - up[i - 1], turn = -(0.5 * (rate[i] + rate[i - 1]) - mean_rate).cross(up[i - 1]);
    together += lean.dot(turn), leans += lean.squaredNorm(), turns += turn.squaredNorm();
  }
  return together > kSwayTogether * std::sqrt(leans * turns);
}

}  // namespace

bool lies_still(const io::Recording& r) {
  if (r.gyr_radps.size() < 200) return false;
  std::size_t moving = 0;
  const Vec3 typical = r.gyr_radps[r.size() / 2];
  for (const Vec3& w : r.gyr_radps)
    moving += w.allFinite() && typical.allFinite() && (w - typical).norm() > kStillMotion;
  return moving * 500 < r.size() && !sways(r);
}

}  // namespace stillpoint::diag::detail
