/// The position of a reference: what it says of the acceleration in the world, against what the accelerometer felt.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "diagnosis/sanity/reference_checks.h"
#include "diagnosis/sanity/units.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kStencil_s = 0.15;  // half of the second difference: slow enough for the noise of a camera
constexpr double kSeen_mps2 = 0.5;   // less may be tilt, and offsets of the accelerometer
constexpr double kMovesTogether = 0.8;
constexpr double kAway = 0.3;
constexpr double kMostLate_s = 2.0, kLateness_s = 0.1;

/// Accelerations in the world on a common grid; not finite where one is missing.
struct Accelerations {
  std::vector<Vec3> position, felt;
  double step_s = 0.0;
};

/// The second difference of the position is the acceleration under a triangle; the accelerometer is averaged under the
/// same.
Accelerations accelerations(const io::Recording& r, const sim::SimulationConfig& config) {
  const auto* acc = triad(config, kAcc);
  const double dt_s = std::max(r.median_step_s(), 1e-9);
  const auto half = static_cast<std::size_t>(std::clamp(std::round(kStencil_s / dt_s), 1.0, 400.0));
  const std::size_t stride = std::max<std::size_t>(1, half / 3);
  Accelerations out{.position = {}, .felt = {}, .step_s = static_cast<double>(stride) * dt_s};
  const double h_s = static_cast<double>(half) * dt_s;
  for (std::size_t i = half; i + half < r.size(); i += stride) {
    const auto& p = r.ref_position_m;
    out.position.push_back((p[i + half] - 2 * p[i] + p[i - half]) / (h_s * h_s));
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = i - half + 1; k < i + half; ++k) {
      const double weight = 1.0 - std::abs(static_cast<double>(k) - static_cast<double>(i)) / static_cast<double>(half);
      sum += weight * (as_expected(r.ref_q_world_body[k]) * (acc->matrix * (r.acc_mps2[k] - acc->bias)));
    }
    out.felt.emplace_back(sum / static_cast<double>(half) - Vec3(0, 0, config.gravity_mps2));
  }
  return out;
}

/// Position (x) and accelerometer (y), the position read `late` grid steps later.
Relation relation(const Accelerations& a, std::ptrdiff_t late) {
  Relation out;
  const auto n = static_cast<std::ptrdiff_t>(a.felt.size());
  for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, -late); i < std::min(n, n - late); ++i) {
    const Vec3 &x = a.position[static_cast<std::size_t>(i + late)], &y = a.felt[static_cast<std::size_t>(i)];
    if (x.allFinite() && y.allFinite()) out.add(x, y);
  }
  return out.about_means();  // gravity of the wrong size stands in the means alone
}

std::string lateness(const Accelerations& a) {
  const auto reach = static_cast<std::ptrdiff_t>(kMostLate_s / a.step_s);
  double highest = kMovesTogether;
  std::ptrdiff_t best = 0;
  for (std::ptrdiff_t late = -reach; late <= reach; ++late)
    if (const double q = relation(a, late).correlation(); q > highest) highest = q, best = late;
  const double late_s = static_cast<double>(best) * a.step_s;
  if (std::abs(late_s) < kLateness_s) return {};
  return fmt::format("it is {:.2f} s {} the orientation and the sensors; align their clocks", std::abs(late_s),
                     late_s > 0 ? "behind" : "ahead of");
}

/// What is wrong with the position, in words; empty where nothing is.
std::string fault(const Accelerations& a) {
  const Relation now = relation(a, 0);
  if (now.rows < 100) return {};
  const auto rows = static_cast<double>(now.rows);
  const double felt_mps2 = std::sqrt(now.yy / rows), moved_mps2 = std::sqrt(now.xx / rows);
  if (felt_mps2 < kSeen_mps2) return {};
  if (moved_mps2 == 0) return "it never changes although the accelerometer feels motion: the columns were filled in";
  if (now.coherence() > kMovesTogether && now.spans_space()) {
    if (const UnitMistake* unit = unit_of(moved_mps2 / felt_mps2, kLengthUnits, 1.25))
      return fmt::format("it moves {:.3g} times as far as the accelerometer feels: it looks like {}",
                         moved_mps2 / felt_mps2, unit->words);
    const Mat3 turn = now.turn();
    if (const std::string words = axes_in_words(turn, "world", "position"); !words.empty())
      return fmt::format(
          "it agrees with the accelerometer only with other axes ({}); expected is the world of the "
          "orientation, ENU",
          words);
    const double off_rad = std::acos(std::clamp(0.5 * (turn.trace() - 1.0), -1.0, 1.0));
    if (off_rad > 0.35)
      return fmt::format("its world is turned by {:.0f} degrees against that of the orientation", off_rad * kDegPerRad);
    return {};
  }
  if (now.correlation() > kAway || moved_mps2 < 2 * kSeen_mps2) return {};
  if (std::string late = lateness(a); !late.empty()) return late;
  return "it has nothing in common with what the accelerometer feels: another body, clock or frame";
}

}  // namespace

void check_position(const io::Recording& r, const sim::SimulationConfig& config, Sanity& out) {
  if (r.ref_position_m.empty()) return;
  const auto present =
      std::count_if(r.ref_position_m.begin(), r.ref_position_m.end(), [](const Vec3& p) { return p.allFinite(); });
  std::string what;
  if (present < 100)
    what = "present in fewer than 100 rows";
  else if (!out.unusable[kAcc])
    what = fault(accelerations(r, config));
  if (what.empty()) return;
  out.mistake("reference position: " + what + ". It is not used; of the accelerometer only rest is examined");
  out.position_unusable = true;
}

}  // namespace stillpoint::diag::detail
