#include "diagnosis/sanity/frames_between.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/forensics/lattice.h"

namespace stillpoint::diag {
namespace {

/// What a straight line is, from the arithmetic of files.
struct Straightness {
  double roundings = 2.0;   ///< steps of the last decimal that three rounded values bend a line by, at most
  double of_a_step = 2e-4;  ///< of the motion over two rows: what interpolating on the sphere leaves
  double regular = 0.97;    ///< of the gaps between bends that are whole frames; lost rows break the count
  double usual = 0.5;       ///< of the gaps that are one frame
  std::size_t least_bends = 100;
  std::size_t longest_frame = 40;  ///< rows: 5 Hz at 200 Hz, slower than any tracking
};

double step_of_decimals(const io::Recording& r, int axis, bool position) {
  std::vector<double> x;
  for (std::size_t i = 0; i < r.size(); ++i)
    x.push_back(position ? r.ref_position_m[i][axis] : r.ref_q_world_body[i][axis]);
  return printing_step(x);
}

template <class Vector>
bool bends(const Vector& before, const Vector& here, const Vector& after, double step, const Straightness& p) {
  const double off = (here - 0.5 * (before + after)).cwiseAbs().maxCoeff();
  return off > p.roundings * step + p.of_a_step * (after - before).norm();
}

/// Rows at which the reference bends by more than its decimals; a row without both neighbours is none.
std::vector<std::size_t> bent_rows(const io::Recording& r, const Straightness& p, bool turns_count) {
  const bool placed = !r.ref_position_m.empty();
  double turn_step = 0.0, place_step = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    turn_step = std::max(turn_step, step_of_decimals(r, axis + 1, false));
    if (placed) place_step = std::max(place_step, step_of_decimals(r, axis, true));
  }
  std::vector<std::size_t> out;
  for (std::size_t i = 1; i + 1 < r.size(); ++i) {
    const auto& q = r.ref_q_world_body;
    if (!q[i - 1].allFinite() || !q[i].allFinite() || !q[i + 1].allFinite()) continue;
    const Eigen::Vector4d before = q[i - 1].dot(q[i]) < 0 ? -q[i - 1] : q[i - 1];
    const Eigen::Vector4d after = q[i + 1].dot(q[i]) < 0 ? -q[i + 1] : q[i + 1];
    const bool turn = turns_count && bends(before, q[i], Eigen::Vector4d(after), turn_step, p);
    const auto& x = r.ref_position_m;
    if (turn || (placed && bends(x[i - 1], x[i], x[i + 1], place_step, p))) out.push_back(i);
  }
  return out;
}

/// Rows from frame to frame; 1 where the bends keep no such step.
std::size_t usual_gap(const std::vector<std::size_t>& bent, const Straightness& p) {
  std::map<std::size_t, std::size_t> gaps;
  for (std::size_t k = 1; k < bent.size(); ++k) ++gaps[bent[k] - bent[k - 1]];
  const auto usual =
      std::max_element(gaps.begin(), gaps.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  if (bent.size() < p.least_bends || usual->first < 2 || usual->first > p.longest_frame) return 1;
  double whole = 0.0;
  for (const auto& [gap, count] : gaps) whole += gap % usual->first == 0 ? static_cast<double>(count) : 0.0;
  const auto all = static_cast<double>(bent.size() - 1);
  return whole > p.regular * all && static_cast<double>(usual->second) > p.usual * all ? usual->first : 1;
}

}  // namespace

DrawnRows rows_drawn_between_frames(const io::Recording& r) {
  constexpr Straightness kStraight;
  DrawnRows out;
  if (r.ref_q_world_body.size() < 3) return out;
  std::vector<std::size_t> bent = bent_rows(r, kStraight, true);
  out.rows_a_frame = usual_gap(bent, kStraight);
  if (out.rows_a_frame == 1 && !r.ref_position_m.empty()) {
    // Quaternions drawn as a line and set to length one again turn fastest half way: in fast turns that is a bend.
    bent = bent_rows(r, kStraight, false);
    out.rows_a_frame = usual_gap(bent, kStraight);
  }
  if (out.rows_a_frame == 1) return out;
  // Frames keep their step from each bend to the next; before the first and over breaks the nearest bend counts.
  out.drawn.assign(r.size(), false);
  std::size_t next = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    while (next + 1 < bent.size() && bent[next + 1] <= i) ++next;
    const std::size_t apart = i > bent[next] ? i - bent[next] : bent[next] - i;
    out.drawn[i] = apart % out.rows_a_frame != 0;
  }
  return out;
}

}  // namespace stillpoint::diag
