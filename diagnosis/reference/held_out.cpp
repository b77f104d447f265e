#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/reference/blocks_left_out.h"
#include "diagnosis/reference/evidence.h"
#include "diagnosis/reference/folds.h"

namespace stillpoint::diag {
namespace {

constexpr double kAstray = 1.5;  // times what the whole leaves
constexpr int kFolds = 8;        // where halves go astray
// What acts for a while, but for so long and so strongly, in so many pieces, one left out: half of it may not show all
// coefficients.
constexpr double kLongWindow_s = 8.0, kStrong_nats = 100.0;
constexpr int kPiecesOfAWindow = 3;
constexpr double kMostCost = 0.5;  // of what is removable: kinds of motion that the others tell less of are no test

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

/// A product may be one term of several, and what it leaves is not the cost of its coefficients.
bool claims_to_be_the_cause(const SensorSearch& search, const std::vector<std::size_t>& effects) {
  return std::none_of(effects.begin(), effects.end(), [&](std::size_t e) { return is_unknown(search.found[e].id); });
}

/// A row: what is left by the coefficients of other folds beyond what the best ones leave, where the model is true.
Series cost_of_others(const Target& t, const Columns& columns, const NoiseModel& noise, const Folds& folds) {
  const Eigen::VectorXd excess = excess_of_others(t, columns, noise, folds.block, fold_of_blocks(folds));
  Eigen::VectorXd rows = Eigen::VectorXd::Zero(excess.size());
  for (const int fold : folds.of_row) rows[fold] += 1.0;
  Series out(t.layout.n);
  for (Eigen::Index i = 0; i < out.size(); ++i) {
    const int fold = folds.of_row[static_cast<std::size_t>(i)];
    out[i] = excess[fold] / rows[fold];
  }
  return out;
}

/// Share of the removable power, whitened, that is gone; its interval from the scatter of blocks about the share.
/// `cost`: what coefficients of other folds leave beyond the floor where the model is true; nothing removes that.
void share_of(const Judged& j, Series floor, const Series& cost, Eigen::Index block, HeldOut& out) {
  if (cost.sum() > 0.0) floor += std::clamp((j.square_after - floor).sum() / cost.sum(), 0.0, 1.0) * cost;
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
  out.share_ci95 = {out.removable_share_removed - half, std::min(out.removable_share_removed + half, 1.0)};
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
  Series floor = Series::Zero(t.layout.n);
  for (int axis = 0; axis < 3; ++axis) floor += noise.whiten(t.layout, best.col(axis), axis).cwiseAbs2();
  const bool cause = claims_to_be_the_cause(search, effects);
  const auto cost_on = [&](const Folds& f) {
    return cause ? cost_of_others(t, all, noise, f) : Series(Series::Zero(t.layout.n));
  };
  Judged judged = judge_on(search, effects, noise, folds);
  Series cost = cost_on(folds);
  if (cause && folds.of_regimes && cost.sum() > kMostCost * (judged.square_before - floor).sum()) {
    folds = beside_each_other(t);
    judged = judge_on(search, effects, noise, folds);
    cost = cost_on(folds);
  }
  out.on = folds.of_regimes ? "regimes"
                            : fmt::format("blocks of {:.2g} s", static_cast<double>(folds.block) * t.rows.step_s);
  share_of(judged, floor, cost, folds.block, out);
  return out;
}

bool predicts(const HeldOut& h) {
  constexpr double kLeast_nats = 1.0, kLeastShare = 0.05;  // half a second of four and a half
  return h.told_by_others_nats >= std::max(kLeast_nats, kLeastShare * h.gain_nats);
}

bool is_judged(const HeldOut& h) { return h.share_ci95[1] > h.share_ci95[0]; }

bool is_unsure(const HeldOut& h) { return is_judged(h) && h.share_ci95[0] < 0.5; }

bool fails_elsewhere(const HeldOut& h, const std::string& id) {
  constexpr double kOfACause = 0.75, kTellsIt_nats = 20.0;  // of less the noise leaves as little
  const bool no_cause = !is_unknown(id) && h.gain_nats > kTellsIt_nats && h.removable_share_removed < kOfACause;
  return is_judged(h) && (h.share_ci95[1] < 0.5 || no_cause);
}

}  // namespace stillpoint::diag
