#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/reference/blocks_left_out.h"
#include "diagnosis/reference/evidence.h"

namespace stillpoint::diag {
namespace {

constexpr double kFold_s = 4.0;  // blocks beside each other, every second one left out
constexpr double kAstray = 1.5;  // times what the whole leaves
constexpr int kFolds = 8;        // where halves go astray
// What acts for a while, but for so long and so strongly, in so many pieces, one left out: half of it may not show all
// coefficients.
constexpr double kLongWindow_s = 8.0, kStrong_nats = 100.0;
constexpr int kPiecesOfAWindow = 3;
constexpr double kRegime_s = 1.0;  // a motion, a pose
constexpr int kRegimes = 4, kRounds = 20;
constexpr double kLeastRegime = 0.08;  // of the blocks; fewer are no test

/// Which fold a row is left out in.
struct Folds {
  std::vector<int> of_row;
  int count = 2;
  Eigen::Index block = 1;
  bool of_regimes = false;
};

double rms_over(const Series3& x, const Eigen::ArrayXd& counts) {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) sum += (x.col(axis).array().square() * counts).sum();
  return std::sqrt(sum / std::max(3.0 * counts.sum(), 1.0));
}

/// The model without some effects (ascending): their columns gone, their offsets put back.
std::pair<Target, Columns> without_effects(const SensorSearch& search, const std::vector<std::size_t>& effects) {
  std::pair<Target, Columns> out{search.target, {}};
  for (std::size_t i = 0; i < search.found.size(); ++i) {
    const Found& f = search.found[i];
    if (!std::binary_search(effects.begin(), effects.end(), i))
      out.second = joined(std::move(out.second), f.columns);
    else if (f.offset.size())
      out.first.residual += f.offset;
  }
  return out;
}

/// Residual of the whole recording, with the coefficients of the samples that `train` counts.
Series3 left_by(const Target& full, const Columns& columns, const NoiseModel& noise, const Eigen::ArrayXd& train) {
  Target part = full;
  part.layout.counts = train;
  return fit_with(part, columns, noise, {}).leftover;
}

Folds beside_each_other(const Target& t, double block_s = kFold_s, int count = 2) {
  Folds f;
  f.count = count;
  f.block = std::max<Eigen::Index>(1, std::lround(block_s / t.rows.step_s));
  for (Eigen::Index i = 0; i < t.layout.n; ++i) f.of_row.push_back(static_cast<int>((i / f.block) % count));
  return f;
}

/// A row a block: mean and scatter of the measured vector, what the effects do and how much, each over its spread.
Eigen::MatrixXd looks_of(const Target& t, const Columns& columns, Eigen::Index block) {
  const Eigen::Index blocks = (t.layout.n + block - 1) / block;
  Eigen::MatrixXd driven = Eigen::MatrixXd::Zero(t.layout.n, 1);
  for (const Column& c : columns) driven.col(0) += c.x.rowwise().norm() / std::max(c.x.norm(), 1e-300);
  Eigen::MatrixXd look(blocks, 5);
  for (Eigen::Index b = 0; b < blocks; ++b) {
    const Eigen::Index begin = b * block, length = std::min(block, t.layout.n - begin);
    const Eigen::MatrixXd v = t.nuisance.middleRows(begin, length).rightCols(3);
    const Eigen::RowVectorXd mean = v.colwise().mean();
    look.row(b) << mean, (v.rowwise() - mean).norm() / std::sqrt(static_cast<double>(length)),
        driven.middleRows(begin, length).mean();
  }
  for (Eigen::Index c = 0; c < look.cols(); ++c) {
    look.col(c).array() -= look.col(c).mean();
    look.col(c) /= std::max(look.col(c).norm(), 1e-300);
  }
  return look;
}

/// Regimes by k-means from the farthest points; the same input gives the same ones. Empty where one holds nearly all.
std::vector<int> regimes_of(const Eigen::MatrixXd& look) {
  Eigen::MatrixXd centre = look.topRows(1);
  const auto distance = [&](Eigen::Index b) { return (centre.rowwise() - look.row(b)).rowwise().squaredNorm().eval(); };
  while (centre.rows() < kRegimes) {
    Eigen::Index farthest = 0;
    double most = -1.0;
    for (Eigen::Index b = 0; b < look.rows(); ++b)
      if (const double d = distance(b).minCoeff(); d > most) most = d, farthest = b;
    centre.conservativeResize(centre.rows() + 1, Eigen::NoChange);
    centre.bottomRows(1) = look.row(farthest);
  }
  std::vector<int> of_block(static_cast<std::size_t>(look.rows()), 0);
  Eigen::VectorXd size;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(kRegimes, look.cols());
    size = Eigen::VectorXd::Zero(kRegimes);
    for (Eigen::Index b = 0; b < look.rows(); ++b) {
      int& regime = of_block[static_cast<std::size_t>(b)];
      distance(b).minCoeff(&regime);
      sum.row(regime) += look.row(b), size[regime] += 1.0;
    }
    for (Eigen::Index k = 0; k < kRegimes; ++k)
      if (size[k] > 0) centre.row(k) = sum.row(k) / size[k];
  }
  if ((size.array() > kLeastRegime * static_cast<double>(look.rows())).count() < 2) return {};
  return of_block;
}

/// A regime of more than half of the blocks in two folds, of pieces beside each other: the rest alone, a few seconds of
/// motion, would have to tell what the whole recording reads at rest.
void split_the_largest(std::vector<int>& of_block) {
  const auto piece = static_cast<std::size_t>(kFold_s / kRegime_s);
  for (int regime = 0; regime < kRegimes; ++regime) {
    if (2 * std::count(of_block.begin(), of_block.end(), regime) <= std::ssize(of_block)) continue;
    for (std::size_t b = 0; b < of_block.size(); ++b)
      if (of_block[b] == regime && (b / piece) % 2 == 1) of_block[b] = kRegimes;
  }
}

/// Kinds of motion rather than pieces of it: what goes along with the true driver in one motion still does so half a
/// second later, in another it need not.
Folds by_regime(const Target& t, const Columns& columns) {
  Folds f;
  f.block = std::max<Eigen::Index>(1, std::lround(kRegime_s / t.rows.step_s));
  std::vector<int> of_block = regimes_of(looks_of(t, columns, f.block));
  if (of_block.empty()) return f;
  f.of_regimes = true;
  split_the_largest(of_block);
  f.count = 1 + *std::max_element(of_block.begin(), of_block.end());
  for (Eigen::Index i = 0; i < t.layout.n; ++i) f.of_row.push_back(of_block[static_cast<std::size_t>(i / f.block)]);
  return f;
}

/// Pieces of the shortest window, for what acts for a while; else kinds of motion where there are several.
Folds folds_for(const SensorSearch& search, const std::vector<std::size_t>& effects, const Columns& own) {
  const Target& t = search.target;
  double shortest_s = HUGE_VAL, weakest_nats = HUGE_VAL;
  for (const std::size_t e : effects) {
    const Found& f = search.found[e];
    if (!f.window.local) continue;
    shortest_s = std::min(shortest_s, static_cast<double>(f.window.end - f.window.begin) * t.rows.step_s);
    weakest_nats = std::min(weakest_nats, f.gain_nats);
  }
  if (shortest_s < kLongWindow_s || weakest_nats < kStrong_nats) return beside_each_other(t);
  if (shortest_s < HUGE_VAL)
    return beside_each_other(t, std::min(shortest_s / kPiecesOfAWindow, kFold_s), kPiecesOfAWindow);
  Folds folds = by_regime(t, own);
  return folds.of_regimes ? folds : beside_each_other(t);
}

/// Squared whitened deviations a row, of the three axes, each row with coefficients of the folds that it is not in.
struct Judged {
  Series3 before, after;
  Series square_before, square_after;
};

Judged judge_on(const SensorSearch& search, const std::vector<std::size_t>& effects, const NoiseModel& noise,
                const Folds& folds) {
  const Target& t = search.target;
  const auto [less, fewer] = without_effects(search, effects);
  const Columns all = search.explained();
  Judged out{Series3::Zero(t.layout.n, 3), Series3::Zero(t.layout.n, 3), Series::Zero(t.layout.n),
             Series::Zero(t.layout.n)};
  for (int fold = 0; fold < folds.count; ++fold) {
    Eigen::ArrayXd train = t.layout.counts;
    for (Eigen::Index i = 0; i < t.layout.n; ++i)
      if (folds.of_row[static_cast<std::size_t>(i)] == fold) train[i] = 0.0;
    const Series3 with = left_by(t, all, noise, train), without = left_by(less, fewer, noise, train);
    for (int axis = 0; axis < 3; ++axis) {
      const Series a = noise.whiten(t.layout, with.col(axis), axis),
                   b = noise.whiten(t.layout, without.col(axis), axis);
      for (Eigen::Index i = 0; i < t.layout.n; ++i) {
        if (folds.of_row[static_cast<std::size_t>(i)] != fold) continue;
        out.square_before[i] += b[i] * b[i], out.square_after[i] += a[i] * a[i];
        out.before(i, axis) = without(i, axis), out.after(i, axis) = with(i, axis);
      }
    }
  }
  return out;
}

/// Share of the removable power, whitened, that is gone; its interval from the scatter of blocks about the share.
void share_of(const Judged& j, const Series& floor, Eigen::Index block, HeldOut& out) {
  const double removed = (j.square_before - j.square_after).sum(), removable = (j.square_before - floor).sum();
  if (!(removable > 0)) return;
  out.removable_share_removed = removed / removable;
  double scatter = 0.0, blocks = 0.0;
  for (Eigen::Index begin = 0; begin < floor.size(); begin += block) {
    const Eigen::Index length = std::min(block, floor.size() - begin);
    const auto sum = [&](const Series& x) { return x.segment(begin, length).sum(); };
    const double off =
        sum(j.square_before) - sum(j.square_after) - out.removable_share_removed * (sum(j.square_before) - sum(floor));
    scatter += off * off, blocks += 1.0;
  }
  const double half = 1.96 * std::sqrt(scatter * blocks / std::max(blocks - 1.0, 1.0)) / removable;
  out.share_ci95 = {out.removable_share_removed - half, out.removable_share_removed + half};
}

/// Whether half of the blocks do not tell what the sensor reads without the effects: the half of a dozen turns from
/// pose to pose is no matrix.
bool halves_go_astray(const Judged& halves, const Target& less, const Columns& fewer, const NoiseModel& noise) {
  const Eigen::ArrayXd& counts = less.layout.counts;
  return rms_over(halves.before, counts) > kAstray * rms_over(fit_with(less, fewer, noise, {}).leftover, counts);
}

/// What blocks gain, and the rows with coefficients of others: of halves, or where those go astray of all other blocks
/// and with what they leave open.
struct Blocks {
  Eigen::VectorXd gain_nats;
  Series3 before, after;
  bool of_halves = true;
};

Blocks blocks_of(const SensorSearch& search, const std::vector<std::size_t>& effects, const NoiseModel& noise) {
  const Target& t = search.target;
  const Folds folds = beside_each_other(t);
  const Judged halves = judge_on(search, effects, noise, folds);
  const auto [less, fewer] = without_effects(search, effects);
  if (halves_go_astray(halves, less, fewer, noise)) {
    LeftOut with = blocks_left_out(t, search.explained(), noise, folds.block),
            without = blocks_left_out(less, fewer, noise, folds.block);
    return {with.nats - without.nats, std::move(without.residual), std::move(with.residual), false};
  }
  Blocks out{Eigen::VectorXd((t.layout.n + folds.block - 1) / folds.block), halves.before, halves.after};
  for (Eigen::Index b = 0; b < out.gain_nats.size(); ++b) {
    const Eigen::Index begin = b * folds.block, length = std::min(folds.block, t.layout.n - begin);
    out.gain_nats[b] = 0.5 * (halves.square_before - halves.square_after).segment(begin, length).sum();
  }
  return out;
}

/// `floor`: what the best coefficients leave, those of the whole recording.
HeldOut summary_of(const Target& t, const Blocks& blocks, const Series3& floor) {
  HeldOut out;
  out.blocks = static_cast<int>(blocks.gain_nats.size());
  out.blocks_better = static_cast<int>((blocks.gain_nats.array() > 0).count());
  out.gain_nats = blocks.gain_nats.sum();
  out.told_by_others_nats = out.gain_nats - (blocks.of_halves ? 0.0 : blocks.gain_nats.maxCoeff());
  out.rms_before = rms_over(blocks.before, t.layout.counts);
  out.rms_after = rms_over(blocks.after, t.layout.counts);
  out.noise_floor = rms_over(floor, t.layout.counts);
  const double removable = out.rms_before * out.rms_before - out.noise_floor * out.noise_floor;
  if (removable > 0)
    out.removable_share_removed = (out.rms_before * out.rms_before - out.rms_after * out.rms_after) / removable;
  out.unit = kSensorUnit[t.sensor];
  return out;
}

}  // namespace

HeldOut held_out(const SensorSearch& search, const std::vector<std::size_t>& effects) {
  const Target& t = search.target;
  const Columns all = search.explained();
  const NoiseModel noise(t.layout, fit_profile(t, all).leftover);
  return summary_of(t, blocks_of(search, effects, noise), fit_with(t, all, noise, {}).leftover);
}

HeldOut held_out_by_regime(const SensorSearch& search, const std::vector<std::size_t>& effects) {
  const Target& t = search.target;
  const Columns all = search.explained();
  const NoiseModel noise(t.layout, fit_profile(t, all).leftover);
  const Blocks blocks = blocks_of(search, effects, noise);
  const Series3 best = fit_with(t, all, noise, {}).leftover;
  HeldOut out = summary_of(t, blocks, best);
  Columns own;
  for (const std::size_t e : effects) own = joined(std::move(own), search.found[e].columns);
  Folds folds = folds_for(search, effects, own);
  if (folds.count == 2 && !folds.of_regimes && !blocks.of_halves) folds = beside_each_other(t, kFold_s, kFolds);
  out.on = folds.of_regimes ? "regimes"
                            : fmt::format("blocks of {:.2g} s", static_cast<double>(folds.block) * t.rows.step_s);
  Series floor = Series::Zero(t.layout.n);
  for (int axis = 0; axis < 3; ++axis) floor += noise.whiten(t.layout, best.col(axis), axis).cwiseAbs2();
  share_of(judge_on(search, effects, noise, folds), floor, folds.block, out);
  return out;
}

bool predicts(const HeldOut& h) {
  constexpr double kLeast_nats = 1.0, kLeastShare = 0.05;  // half a second of four and a half
  return h.told_by_others_nats >= std::max(kLeast_nats, kLeastShare * h.gain_nats);
}

bool is_judged(const HeldOut& h) { return h.share_ci95[1] > h.share_ci95[0]; }

bool is_unsure(const HeldOut& h) { return is_judged(h) && h.share_ci95[0] < 0.5; }

bool fails_elsewhere(const HeldOut& h, const std::string& id) {
  constexpr double kOfACause = 0.65, kTellsIt_nats = 40.0;  // of less the noise leaves as little
  const bool no_cause = !is_unknown(id) && h.gain_nats > kTellsIt_nats && h.removable_share_removed < kOfACause;
  return is_judged(h) && (h.share_ci95[1] < 0.5 || no_cause);
}

}  // namespace stillpoint::diag
