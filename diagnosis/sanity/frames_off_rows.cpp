#include "diagnosis/sanity/frames_off_rows.h"

#include <algorithm>
#include <cmath>

#include "core/median.h"

namespace stillpoint::diag {
namespace {

constexpr double kLeastRowsAFrame = 1.4;  // with less there are hardly more rows than frames
constexpr double kLongest_s = 1.0 / 15;   // rows_with_reference.cpp: slower frames do not show how the body moved
constexpr double kClockStep = 0.002;      // of the step: 0.04 of a frame from the middle of a block to its end
constexpr int kPhases = 16;               // of a frame
constexpr Eigen::Index kBlock = 48;       // rows
constexpr std::size_t kBlocks = 4;        // those that bend most
constexpr std::size_t kBlocksSharpened = 60;
// rms off the chords over that with frames half a step off: 1 for any curve. Of attitudes by themselves less: a
// vibration comes near that, but not in place and attitude with one clock.
constexpr double kMeets = 0.3, kTurnsMeet = 0.1;
constexpr double kAmplified = 30.0;  // variance of a frame over that of a row: left out beyond
constexpr int kShapes = 2;           // rounds in which the chord's form follows from how far frames are apart

struct Clock {
  double middle_s, step_s;  ///< a frame stands at middle_s
};

template <int N>
using Column = Eigen::Matrix<double, Eigen::Dynamic, N>;

/// Rows of a reference without a break.
template <int N>
struct Stretch {
  Eigen::ArrayXd t_s;
  Column<N> value;
};

template <int N>
Stretch<N> part(const Stretch<N>& s, Eigen::Index begin, Eigen::Index rows) {
  return {s.t_s.segment(begin, rows), s.value.middleRows(begin, rows)};
}

/// Where a row lies between its two frames: value = before x_k + after x_(k+1).
struct Share {
  Eigen::Index k;
  double before, after;
};

struct Layout {
  double first_s = 0.0;
  Eigen::Index frames = 0;
  std::vector<Share> rows;
};

template <int N>
Layout layout_of(const Stretch<N>& s, const Clock& clock) {
  Layout out;
  const double first = std::floor((s.t_s[0] - clock.middle_s) / clock.step_s);
  out.first_s = clock.middle_s + first * clock.step_s;
  out.rows.reserve(static_cast<std::size_t>(s.t_s.size()));
  for (Eigen::Index i = 0; i < s.t_s.size(); ++i) {
    const double at = (s.t_s[i] - out.first_s) / clock.step_s, k = std::max(std::floor(at), 0.0);
    out.rows.push_back({static_cast<Eigen::Index>(k), 1.0 - (at - k), at - k});
  }
  out.frames = out.rows.back().k + 2;
  return out;
}

template <int N>
struct Fitted {
  Column<N> value;
  Eigen::ArrayXd variance;  ///< over that of a row
  double off = 0.0;         ///< sum of squares of what the chords leave
};

/// Least squares; the normal equations are tridiagonal, and sweeps from both ends give values and variances at once.
template <int N>
Fitted<N> fit(const Stretch<N>& s, const Layout& layout) {
  constexpr double kTiny = 1e-9;  // frames at the ends may have no row
  const Eigen::Index n = layout.frames;
  Eigen::ArrayXd own = Eigen::ArrayXd::Constant(n, kTiny), next = Eigen::ArrayXd::Zero(n);
  Column<N> right = Column<N>::Zero(n, s.value.cols());
  for (Eigen::Index i = 0; i < s.t_s.size(); ++i) {
    const Share& w = layout.rows[static_cast<std::size_t>(i)];
    own[w.k] += w.before * w.before, own[w.k + 1] += w.after * w.after, next[w.k] += w.before * w.after;
    right.row(w.k) += w.before * s.value.row(i), right.row(w.k + 1) += w.after * s.value.row(i);
  }
  Eigen::ArrayXd ahead = own, behind = own;
  Column<N> from_left = right, from_right = right;
  for (Eigen::Index k = 1; k < n; ++k) {
    const double share = next[k - 1] / ahead[k - 1];
    ahead[k] -= share * next[k - 1], from_left.row(k) -= share * from_left.row(k - 1);
    const Eigen::Index m = n - 1 - k;
    const double back = next[m] / behind[m + 1];
    behind[m] -= back * next[m], from_right.row(m) -= back * from_right.row(m + 1);
  }
  Fitted<N> out;
  out.variance = 1.0 / (ahead + behind - own).max(kTiny);
  out.value = (from_left + from_right - right).array().colwise() * out.variance;
  for (Eigen::Index i = 0; i < s.t_s.size(); ++i) {
    const Share& w = layout.rows[static_cast<std::size_t>(i)];
    out.off += (s.value.row(i) - w.before * out.value.row(w.k) - w.after * out.value.row(w.k + 1)).squaredNorm();
  }
  return out;
}

/// How the values between two frames were made; the first is the only one for positions.
enum class Chord { kLine, kLineOfLengthOne, kGreatCircle };

/// Shares of a row on a chord whose ends are `angle` apart (of the quaternions: half that of the body).
Share shaped(Share w, Chord chord, double angle) {
  const double a = w.after, line = 1.0 - a;
  if (chord == Chord::kLineOfLengthOne) {
    const double length = std::sqrt(line * line + a * a + 2.0 * line * a * std::cos(angle));
    return {w.k, line / length, a / length};
  }
  if (chord == Chord::kGreatCircle && angle > 1e-6)
    return {w.k, std::sin(line * angle) / std::sin(angle), std::sin(a * angle) / std::sin(angle)};
  return w;
}

template <int N>
Fitted<N> fit_chord(const Stretch<N>& s, const Layout& lines, Chord chord) {
  Fitted<N> frames = fit(s, lines);
  for (int round = 0; chord != Chord::kLine && round < kShapes; ++round) {
    Layout curved = lines;
    for (Share& w : curved.rows) {
      const auto a = frames.value.row(w.k).normalized(), b = frames.value.row(w.k + 1).normalized();
      w = shaped(w, chord, std::acos(std::clamp(a.dot(b), -1.0, 1.0)));
    }
    frames = fit(s, curved);
  }
  return frames;
}

/// What the chords leave of the rows. Any chord of quaternions is shorter than the arc, whoever joined the frames.
template <int N>
double off(const std::vector<Stretch<N>>& all, const Clock& clock,
           Chord chord = N == 4 ? Chord::kGreatCircle : Chord::kLine) {
  double sum = 0.0;
  for (const Stretch<N>& s : all) sum += fit_chord(s, layout_of(s, clock), chord).off;
  return sum;
}

Clock half_a_step_later(const Clock& clock) { return {clock.middle_s + 0.5 * clock.step_s, clock.step_s}; }

/// Downhill in the phase and in the step, over rows that reach `reach_s` from the frame in the middle.
template <int N>
Clock sharpened(const std::vector<Stretch<N>>& all, Clock best, double reach_s) {
  double phase_s = 0.05 * best.step_s, step_s = phase_s * best.step_s / reach_s, least = off(all, best);
  for (int round = 0; round < 40 && phase_s > 1e-5 * best.step_s; ++round) {
    bool lower = false;
    for (const auto& [dp, ds] : {std::pair{phase_s, 0.0}, {-phase_s, 0.0}, {0.0, step_s}, {0.0, -step_s}}) {
      const Clock tried{best.middle_s + dp, best.step_s + ds};
      if (const double here = off(all, tried); here < least) least = here, best = tried, lower = true;
    }
    if (!lower) phase_s *= 0.5, step_s *= 0.5;
  }
  return best;
}

/// The slowest clock that meets the rows of one block, wherever its frames are; twice its rate would meet them too.
template <int N>
std::optional<Clock> clock_of_block(const Stretch<N>& block, double row_s) {
  const std::vector<Stretch<N>> rows{block};
  const double middle = block.t_s[block.t_s.size() / 2];
  std::optional<Clock> best;
  double least = kMeets * kMeets;
  for (double step = kLongest_s; step >= kLeastRowsAFrame * row_s; step /= 1.0 + kClockStep) {
    if (best && step < (1.0 - 10 * kClockStep) * best->step_s) break;
    std::vector<double> by_phase;
    by_phase.reserve(kPhases);
    for (int phase = 0; phase < kPhases; ++phase)
      by_phase.push_back(off(rows, {middle + step * phase / kPhases, step}));
    const auto here = std::min_element(by_phase.begin(), by_phase.end());
    const double ratio = *here / std::max(median(by_phase), 1e-300);  // a longer step leaves more, in any phase
    if (ratio < least)
      least = ratio, best = {middle + step * static_cast<double>(here - by_phase.begin()) / kPhases, step};
  }
  if (best) best = sharpened(rows, *best, 0.5 * row_s * static_cast<double>(block.t_s.size()));
  return best;
}

/// Rows that reach so far from the frame in the middle; of many, blocks that are spread evenly over them.
template <int N>
std::vector<Stretch<N>> within(const std::vector<Stretch<N>>& all, double middle_s, double reach_s) {
  std::vector<Stretch<N>> blocks;
  for (const Stretch<N>& s : all) {
    const auto first = std::lower_bound(s.t_s.begin(), s.t_s.end(), middle_s - reach_s);
    const auto last = std::upper_bound(first, s.t_s.end(), middle_s + reach_s);
    const Eigen::Index end = last - s.t_s.begin();
    for (Eigen::Index begin = first - s.t_s.begin(); begin + 4 <= end; begin += kBlock)
      blocks.push_back(part(s, begin, std::min(kBlock, end - begin)));
  }
  const std::size_t every = blocks.size() / kBlocksSharpened + 1;
  std::vector<Stretch<N>> out;
  for (std::size_t i = 0; i < blocks.size(); i += every) out.push_back(std::move(blocks[i]));
  return out;
}

template <int N>
bool meets(const std::vector<Stretch<N>>& all, const Clock& clock, double least) {
  return off(all, clock) < least * least * off(all, half_a_step_later(clock));
}

template <int N>
Column<N> bends(const Stretch<N>& s) {
  const Column<N> step = s.value.bottomRows(kBlock - 1) - s.value.topRows(kBlock - 1);
  return step.bottomRows(kBlock - 2) - step.topRows(kBlock - 2);
}

/// Blocks of rows that bend most; what hardly moves has no chords.
template <int N>
std::vector<Stretch<N>> bent_blocks(const std::vector<Stretch<N>>& all) {
  std::vector<std::pair<double, Stretch<N>>> blocks;
  for (const Stretch<N>& s : all)
    for (Eigen::Index begin = 0; begin + kBlock <= s.t_s.size(); begin += kBlock) {
      Stretch<N> block = part(s, begin, kBlock);
      const double bend = bends(block).squaredNorm();
      blocks.emplace_back(bend, std::move(block));
    }
  std::sort(blocks.begin(), blocks.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Stretch<N>> out;
  for (std::size_t i = 0; i < std::min(kBlocks, blocks.size()); ++i) out.push_back(std::move(blocks[i].second));
  return out;
}

/// A curve's bend changes slowly; that of chords up and down. Tells most references that were never drawn apart.
template <int N>
bool jumps(const Stretch<N>& block) {
  const Column<N> bend = bends(block), change = bend.bottomRows(kBlock - 3) - bend.topRows(kBlock - 3);
  return (change.bottomRows(kBlock - 4) - change.topRows(kBlock - 4)).squaredNorm() > 0.5 * change.squaredNorm();
}

template <int N>
std::optional<Clock> clock_of(const std::vector<Stretch<N>>& all, double row_s) {
  if (all.empty()) return std::nullopt;
  const double whole_s = all.back().t_s[all.back().t_s.size() - 1] - all.front().t_s[0];
  for (const Stretch<N>& block : bent_blocks(all)) {
    if (!jumps(block)) continue;
    const std::optional<Clock> found = clock_of_block(block, row_s);
    if (!found) continue;
    Clock clock = *found;
    // The step is known to a part of a frame over the rows seen: twice as many each time keeps count of the frames.
    for (double reach = row_s * kBlock; reach < 2.0 * whole_s; reach *= 2.0)
      clock = sharpened(within(all, clock.middle_s, reach), clock, reach);
    if (meets(all, clock, N == 4 ? kTurnsMeet : kMeets)) return clock;
  }
  return std::nullopt;
}

template <int N, class Value>
std::vector<Stretch<N>> stretches_of(const io::Recording& r, const std::vector<Value>& column, double row_s) {
  std::vector<Stretch<N>> out;
  std::size_t begin = 0;
  const auto close = [&](std::size_t end) {
    if (end >= begin + 4) {
      Stretch<N> s{Eigen::ArrayXd(end - begin), Column<N>(end - begin, N)};
      for (std::size_t i = begin; i < end; ++i) {
        const auto row = static_cast<Eigen::Index>(i - begin);
        s.t_s[row] = r.t_s(i), s.value.row(row) = column[i];
        if (N == 4 && row > 0 && s.value.row(row).dot(s.value.row(row - 1)) < 0) s.value.row(row) *= -1.0;
      }
      out.push_back(std::move(s));
    }
  };
  for (std::size_t i = 0; i < column.size(); ++i) {
    const bool there = column[i].allFinite();
    if (there && i > begin && r.t_s(i) - r.t_s(i - 1) < 1.5 * row_s) continue;
    if (i > begin) close(i);
    begin = there ? i : i + 1;
  }
  if (begin < column.size()) close(column.size());
  return out;
}

/// The frames on a clock whose chords meet the column.
template <int N, class Value>
void read_frames(const std::vector<Stretch<N>>& all, const Clock& clock, std::vector<double>& t_s,
                 std::vector<Value>& values) {
  Chord chord = Chord::kLine;
  if (N == 4) {
    double least = off(all, clock, chord);
    for (const Chord tried : {Chord::kLineOfLengthOne, Chord::kGreatCircle})
      if (const double here = off(all, clock, tried); here < least) least = here, chord = tried;
  }
  for (const Stretch<N>& s : all) {
    const Layout layout = layout_of(s, clock);
    const Fitted<N> frames = fit_chord(s, layout, chord);
    for (Eigen::Index k = 0; k < layout.frames; ++k) {
      const double at = layout.first_s + static_cast<double>(k) * clock.step_s;
      if (frames.variance[k] > kAmplified || (!t_s.empty() && at < t_s.back() + 0.5 * clock.step_s)) continue;
      t_s.push_back(at), values.emplace_back(frames.value.row(k).transpose());
    }
  }
}

}  // namespace

std::optional<FramesOffRows> frames_off_rows(const io::Recording& r) {
  const double row_s = r.median_step_s();
  if (!(row_s > 0.0) || kLeastRowsAFrame * row_s > kLongest_s) return std::nullopt;
  const auto turns = stretches_of<4>(r, r.ref_q_world_body, row_s);
  const auto places = stretches_of<3>(r, r.ref_position_m, row_s);
  std::optional<Clock> clock = clock_of(places, row_s);  // its lines are straight
  if (!clock || !meets(turns, *clock, kMeets)) clock = clock_of(turns, row_s);
  if (!clock) return std::nullopt;
  FramesOffRows out;
  out.step_s = clock->step_s;
  read_frames(turns, *clock, out.turns_t_s, out.turns_world_body);
  if (out.turns_t_s.empty()) return std::nullopt;  // rows too few between gaps to tell any frame
  if (meets(places, *clock, kMeets)) read_frames(places, *clock, out.places_t_s, out.places_m);
  return out;
}

}  // namespace stillpoint::diag
