#include "diagnosis/reference/steadiness.h"

#include <cmath>

namespace stillpoint::diag {
namespace {

constexpr Eigen::Index kParts = 12;
constexpr double kClearlyUnsteadyNats = 30.0;
constexpr double kLeastShare = 0.25;  // of the delay: a smaller change is what an unmodelled filter leaves

/// Whether `size` times what is `shown` on each axis is left over, now more, now less, in parts of the recording.
template <class Shown>
bool changes(const SensorSearch& search, const Finished& finished, const Shown& shown, double size) {
  const Layout& layout = search.target.layout;
  const NoiseModel noise(layout, finished.fit.leftover);
  Eigen::ArrayXd with_left = Eigen::ArrayXd::Zero(kParts), with_itself = Eigen::ArrayXd::Constant(kParts, 1e-300);
  for (int axis = 0; axis < 3; ++axis) {
    const auto on = shown(axis);
    if (!on) continue;
    const Series x = noise.whiten(layout, *on, axis), r = noise.whiten(layout, finished.fit.leftover.col(axis), axis);
    for (Eigen::Index part = 0; part < kParts; ++part) {
      const Eigen::Index begin = part * layout.n / kParts, length = (part + 1) * layout.n / kParts - begin;
      with_left[part] += x.segment(begin, length).dot(r.segment(begin, length));
      with_itself[part] += x.segment(begin, length).squaredNorm();
    }
  }
  const Eigen::ArrayXd off = with_left / with_itself;
  const double gain = 0.5 * (off.square() * with_itself).sum() - static_cast<double>(kParts);
  const double spread = std::sqrt((off.square() * with_itself).sum() / with_itself.sum());
  return gain > kClearlyUnsteadyNats && spread > kLeastShare * size;
}

}  // namespace

bool delay_varies(const SensorSearch& search, std::size_t index, const Finished& finished) {
  const Found& f = search.found[index];
  if (!is_delay(f.id) || f.timing.size() != 1 || f.columns.size() != 1) return false;
  const auto shown = [&f](int axis) { return shown_in(f.columns.front(), axis); };
  return changes(search, finished, shown, std::abs(f.timing[0]));
}

bool is_late_elsewhere(const SensorSearch& search, const Series3& late) {
  return changes(
      search, finish(search), [&late](int axis) { return std::optional<Series>(late.col(axis)); }, 1.0);
}

bool was_moved(const Found& f, Eigen::Index rows) {
  if (f.id != "acc_lever" && f.id != "acc_size") return false;
  return f.window.local && (f.window.begin == 0 || f.window.end >= rows);
}

}  // namespace stillpoint::diag
