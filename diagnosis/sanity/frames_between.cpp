#include "diagnosis/sanity/frames_between.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "core/median.h"
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
  double noise = 0.3;              ///< of the bends that changes from each to the next: smooth motion keeps them
  double neighbours = 0.8;         ///< of the bends that follow one another by a frame, where lost ones are to be told
  double moves = 20.0;             ///< roundings over a line: what stands still was measured to stand
};

double step_of_decimals(const io::Recording& r, int axis, bool position) {
  std::vector<double> x;
  for (std::size_t i = 0; i < r.size(); ++i)
    x.push_back(position ? r.ref_position_m[i][axis] : r.ref_q_world_body[i][axis]);
  return printing_step(x);
}

/// One of the reference's two columns: where it is at a row, and how it moves from one row to another.
template <class Move>
struct Path {
  std::size_t rows = 0;
  double step = 0.0;  ///< of the last decimal
  Move move;          ///< (from, to); not finite where one of them is missing
  [[nodiscard]] Vec3 bend(std::size_t i) const { return -0.5 * (move(i, i - 1) + move(i, i + 1)); }
  [[nodiscard]] double moved(std::size_t from, std::size_t to) const { return move(from, to).cwiseAbs().maxCoeff(); }
};

/// Half of the turns: one of constant rate is straight.
auto turns_of(const io::Recording& r) {
  const auto move = [&q = r.ref_q_world_body](std::size_t from, std::size_t to) -> Vec3 {
    const auto quaternion = [&q](std::size_t i) { return Quat(q[i][0], q[i][1], q[i][2], q[i][3]); };
    const Quat turn = quaternion(from).conjugate() * quaternion(to);
    return turn.w() < 0 ? Vec3(-turn.vec()) : Vec3(turn.vec());
  };
  double step = 0.0;
  for (int axis = 1; axis < 4; ++axis) step = std::max(step, step_of_decimals(r, axis, false));
  return Path<decltype(move)>{r.ref_q_world_body.size(), step, move};
}

auto places_of(const io::Recording& r) {
  const auto move = [&x = r.ref_position_m](std::size_t from, std::size_t to) -> Vec3 { return x[to] - x[from]; };
  double step = 0.0;
  for (int axis = 0; axis < 3 && !r.ref_position_m.empty(); ++axis)
    step = std::max(step, step_of_decimals(r, axis, true));
  return Path<decltype(move)>{r.ref_position_m.size(), step, move};
}

/// Rows at which it bends by more than its decimals; a row without both neighbours is none.
std::vector<std::size_t> bent_rows(const auto& path, const Straightness& p) {
  std::vector<std::size_t> out;
  for (std::size_t i = 1; i + 1 < path.rows; ++i) {
    const Vec3 bend = path.bend(i);
    if (!bend.allFinite()) continue;
    if (bend.cwiseAbs().maxCoeff() > p.roundings * path.step + p.of_a_step * path.move(i - 1, i + 1).norm())
      out.push_back(i);
  }
  return out;
}

std::vector<std::size_t> either(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) {
  std::vector<std::size_t> out;
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
  return out;
}

/// Whether noise bends it, too: from row to row the bends of smooth motion hardly change.
bool is_noisy(const auto& path, const std::vector<std::size_t>& bent, const Straightness& p) {
  std::vector<double> size, change;
  for (std::size_t k = 1; k + 1 < bent.size(); ++k) {
    if (bent[k] - bent[k - 1] != bent[k + 1] - bent[k]) continue;
    const Vec3 here = path.bend(bent[k]);
    size.push_back(here.norm());
    change.push_back((path.bend(bent[k + 1]) - 2.0 * here + path.bend(bent[k - 1])).norm());
  }
  return size.size() > p.least_bends && median(std::move(change)) > p.noise * median(std::move(size));
}

/// Whether every row between two was seen not to bend: beside a row that is missing nothing was.
bool is_seen_between(const auto& path, std::size_t a, std::size_t b) {
  for (std::size_t i = a + 1; i < b; ++i)
    if (!path.bend(i).allFinite()) return false;
  return true;
}

/// Marks the frames over which one line was drawn although the body moved: they were lost.
void mark_lost_frames(const auto& path, const std::vector<std::size_t>& bent, const Straightness& p, DrawnRows& out) {
  std::size_t neighbours = 0;
  for (std::size_t k = 1; k < bent.size(); ++k) neighbours += bent[k] - bent[k - 1] == out.rows_a_frame ? 1 : 0;
  // Frames that fall on no rows bend it at uneven steps (frames_off_rows.h).
  if (static_cast<double>(neighbours) < p.neighbours * static_cast<double>(bent.size()) || !is_noisy(path, bent, p))
    return;
  const std::size_t least = std::max<std::size_t>(2 * out.rows_a_frame, 4);
  for (std::size_t k = 1; k < bent.size(); ++k) {
    const std::size_t a = bent[k - 1], b = bent[k];
    if (b - a < least || !(path.moved(a, b) > p.moves * path.step) || !is_seen_between(path, a, b)) continue;
    for (std::size_t i = a + 1; i < b; ++i) {
      out.lost_rows += out.drawn[i] ? 0 : 1;
      out.drawn[i] = true;
    }
  }
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
  const auto turns = turns_of(r);
  const auto places = places_of(r);
  const std::vector<std::size_t> turned = bent_rows(turns, kStraight), moved = bent_rows(places, kStraight);
  std::vector<std::size_t> bent = either(turned, moved);
  out.rows_a_frame = usual_gap(bent, kStraight);
  if (out.rows_a_frame == 1) {
    // Quaternions drawn as a line and set to length one again turn fastest half way: in fast turns that is a bend.
    bent = moved;
    out.rows_a_frame = usual_gap(bent, kStraight);
  }
  out.drawn.assign(r.size(), false);
  // Frames keep their step from each bend to the next; before the first and over breaks the nearest bend counts.
  std::size_t next = 0;
  for (std::size_t i = 0; i < r.size() && out.rows_a_frame > 1; ++i) {
    while (next + 1 < bent.size() && bent[next + 1] <= i) ++next;
    const std::size_t apart = i > bent[next] ? i - bent[next] : bent[next] - i;
    out.drawn[i] = apart % out.rows_a_frame != 0;
  }
  mark_lost_frames(turns, turned, kStraight, out);
  mark_lost_frames(places, moved, kStraight, out);
  return out;
}

}  // namespace stillpoint::diag
