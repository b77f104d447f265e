#include "diagnosis/reference/noise_model.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/median.h"

namespace stillpoint::diag {
namespace {

constexpr double kFewestRegime_s = 3.0, kFewestRegime = 300.0;  // fewer rows give no autoregression of their own
constexpr double kBurst = 4.0;                                  // times the usual power of a block
// Of the valid samples: a filter that leaves fewer between the holes is too long, one that is longer than usual sooner.
constexpr double kLeastCounted = 0.5, kLeastCountedOfLong = 0.8;

/// Levinson-Durbin on autocorrelations of lag 0..order. Returns the prediction coefficients.
Eigen::VectorXd levinson(const Eigen::VectorXd& r) {
  const Eigen::Index order = r.size() - 1;
  Eigen::VectorXd a = Eigen::VectorXd::Zero(order);
  double error = r[0];
  for (Eigen::Index k = 0; k < order && error > 0; ++k) {
    double acc = r[k + 1];
    for (Eigen::Index j = 0; j < k; ++j) acc -= a[j] * r[k - j];
    const double reflection = acc / error;
    const Eigen::VectorXd old = a;
    a[k] = reflection;
    for (Eigen::Index j = 0; j < k; ++j) a[j] = old[j] - reflection * old[k - 1 - j];
    error *= 1.0 - reflection * reflection;
  }
  return a;
}

/// Of lag 0..order, over the recording; missing samples are 0. That keeps the filter stable and takes nothing away
/// while holes are few. Where so many are that the filter had to be shortened, it is over the pairs that are there
/// (Parzen, Sankhya A 25, 1963): without that the memory of a camera's noise is underestimated, and the rest passes for
/// physics.
Eigen::VectorXd autocorrelation(const Layout& layout, const Eigen::ArrayXd& x) {
  const Eigen::ArrayXd there = (x != 0.0).cast<double>();
  Eigen::VectorXd r(layout.order + 1);
  for (Eigen::Index lag = 0; lag <= layout.order; ++lag) {
    r[lag] = (x.head(layout.n - lag) * x.tail(layout.n - lag)).sum();
    if (layout.shortened)
      r[lag] *= there.sum() / std::max((there.head(layout.n - lag) * there.tail(layout.n - lag)).sum(), 1.0);
  }
  return r;
}

/// Whether the holes are rows that were lost for every sensor, not those that one sensor's held or clipped values
/// leave: between the latter, what a short filter would find is their pattern.
bool rows_are_lost(const Signals& s, Sensor sensor) {
  std::size_t holes = 0, shared = 0;
  for (std::size_t i = 0; i < s.muted[sensor].size(); ++i) {
    if (!s.muted[sensor][i]) continue;
    ++holes;
    shared += std::all_of(s.muted.begin(), s.muted.end(), [i](const Mask& muted) { return muted.empty() || muted[i]; });
  }
  return 2 * shared > holes;
}

/// Of a camera's error the residual holds derivatives, next to nothing of them below a hertz: to know that takes a
/// memory of a third of a second.
int order_for(const Signals& s, Sensor sensor) {
  constexpr double kMemory_s = 0.32;
  constexpr long kLongest = 64;
  if (sensor == kMag || s.exact_reference || s.from_log) return kAutoregressiveOrder;
  return static_cast<int>(std::clamp<long>(std::lround(kMemory_s / s.dt_s), kAutoregressiveOrder, kLongest));
}

/// A sample counts when it is there with all that the filter takes before it.
void count_samples(Layout& layout) {
  layout.counts = layout.present;
  for (const Segment& g : layout.segments) {
    Eigen::Index since_break = 0;
    for (Eigen::Index i = g.begin; i < g.end; ++i) {
      if (layout.present[i] == 0.0) since_break = -1;
      if (since_break < layout.order) layout.counts[i] = 0.0;
      ++since_break;
    }
  }
}

}  // namespace

Layout make_layout(const Signals& s, Sensor sensor) {
  Layout layout;
  layout.n = s.n;
  layout.block = std::max<Eigen::Index>(20, static_cast<Eigen::Index>(std::lround(kScaleBlock_s / s.dt_s)));
  layout.present = Eigen::ArrayXd::Ones(s.n);
  for (Eigen::Index i = 0; i < s.n; ++i)
    if (s.muted[sensor][static_cast<std::size_t>(i)]) layout.present[i] = 0.0;
  Eigen::Index resting = 0;
  for (const char r : s.rest) resting += r;
  const double fewest = std::max(kFewestRegime_s / s.dt_s, kFewestRegime);
  const bool split =
      !s.exact_reference && static_cast<double>(resting) > fewest && static_cast<double>(s.n - resting) > fewest;
  layout.regimes = split ? 2 : 1;
  const auto regime_of = [&](Eigen::Index i) { return split && s.rest[static_cast<std::size_t>(i)] ? 1 : 0; };
  for (Eigen::Index i = 0; i < s.n; ++i) {
    if (i > 0 && regime_of(i) == layout.segments.back().regime) continue;
    if (i > 0) layout.segments.back().end = i;
    layout.segments.push_back({i, s.n, regime_of(i)});
  }
  layout.order = order_for(s, sensor);
  while (layout.order > 0) {
    const bool usual = layout.order <= kAutoregressiveOrder;
    count_samples(layout);
    if (layout.used() >= (usual ? kLeastCounted : kLeastCountedOfLong) * layout.present.sum()) return layout;
    layout.shortened = usual;
    layout.order = !usual || rows_are_lost(s, sensor) ? layout.order / 2 : 0;
  }
  layout.counts = layout.present;
  return layout;
}

Layout without_bursts(const Layout& layout, const Series3& leftover) {
  Layout out = layout;
  for (int regime = 0; regime < layout.regimes; ++regime) {
    std::vector<std::pair<double, Segment>> blocks;  // with their power; long enough to have one
    for (const Segment& g : layout.segments)
      for (Eigen::Index b = g.begin; g.regime == regime && b < g.end; b += layout.block) {
        const Eigen::Index length = std::min(layout.block, g.end - b);
        const double here = layout.present.segment(b, length).sum();
        if (here < kLeastCounted * static_cast<double>(layout.block)) continue;
        const double power =
            (leftover.middleRows(b, length).rowwise().squaredNorm().array() * layout.present.segment(b, length)).sum();
        blocks.push_back({power / here, {b, b + length, regime}});
      }
    if (blocks.empty()) continue;
    std::vector<double> powers;
    powers.reserve(blocks.size());
    for (const auto& block : blocks) powers.push_back(block.first);
    const double usual = median(std::move(powers));
    for (const auto& [power, g] : blocks)
      if (power > kBurst * usual) out.present.segment(g.begin, g.end - g.begin).setZero();
  }
  count_samples(out);
  return out;
}

NoiseModel::NoiseModel(const Layout& layout, const Series3& leftover) : inverse_scale_(layout.n, 3) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int regime = 0; regime < layout.regimes; ++regime) {
      Eigen::ArrayXd x = Eigen::ArrayXd::Zero(layout.n);
      for (const Segment& g : layout.segments)
        if (g.regime == regime)
          x.segment(g.begin, g.end - g.begin) = leftover.col(axis).segment(g.begin, g.end - g.begin).array() *
                                                layout.present.segment(g.begin, g.end - g.begin);
      Eigen::VectorXd r = autocorrelation(layout, x);
      r[0] = r[0] * (1.0 + 1e-9) + 1e-300;
      coefficients_[static_cast<std::size_t>(regime)][static_cast<std::size_t>(axis)] = levinson(r);
    }
    const Eigen::ArrayXd e = filter(layout, leftover.col(axis), axis).array() * layout.counts;
    std::array<double, 2> sum{}, count{};
    for (const Segment& g : layout.segments) {
      sum[static_cast<std::size_t>(g.regime)] += e.segment(g.begin, g.end - g.begin).square().sum();
      count[static_cast<std::size_t>(g.regime)] += layout.counts.segment(g.begin, g.end - g.begin).sum();
    }
    innovation_sd_[static_cast<std::size_t>(axis)] = std::sqrt((sum[0] + sum[1]) / std::max(count[0] + count[1], 1.0));
    for (std::size_t c = 0; c < 2; ++c)
      variance_[c][static_cast<std::size_t>(axis)] = std::max(sum[c] / std::max(count[c], 1.0), 1e-24);
    for (const Segment& g : layout.segments) {
      const double typical = variance_[static_cast<std::size_t>(g.regime)][static_cast<std::size_t>(axis)];
      for (Eigen::Index b = g.begin; b < g.end; b += layout.block) {
        const Eigen::Index length = std::min(layout.block, g.end - b);
        const double here = layout.counts.segment(b, length).sum();
        // Half of the evidence for a block's scale is the recording's: a local effect must not hide as local noise.
        const double prior = static_cast<double>(layout.block);
        const double variance = (e.segment(b, length).square().sum() + prior * typical) / (here + prior);
        inverse_scale_.col(axis).segment(b, length).setConstant(1.0 / std::sqrt(variance));
        log_scale_sum_ -= 0.5 * std::log(variance) * here;
      }
    }
  }
}

Series NoiseModel::filter(const Layout& layout, const Eigen::Ref<const Series>& x, int axis) const {
  constexpr Eigen::Index kAtOnce = 8;  // so many sums stay in registers
  Series out(x.size());
  for (const Segment& g : layout.segments) {
    const Eigen::VectorXd& a = coefficients_[static_cast<std::size_t>(g.regime)][static_cast<std::size_t>(axis)];
    const auto one = [&](Eigen::Index i, Eigen::Index memory) {
      out[i] = x[i];
      for (Eigen::Index j = 0; j < memory; ++j) out[i] -= a[j] * x[i - j - 1];
    };
    Eigen::Index i = g.begin;
    for (; i < std::min(g.begin + a.size(), g.end); ++i) one(i, i - g.begin);  // it does not reach before the segment
    for (; i + kAtOnce <= g.end; i += kAtOnce) {
      Eigen::Array<double, kAtOnce, 1> sum = x.segment<kAtOnce>(i);
      for (Eigen::Index j = 0; j < a.size(); ++j) sum -= a[j] * x.segment<kAtOnce>(i - j - 1).array();
      out.segment<kAtOnce>(i) = sum;
    }
    for (; i < g.end; ++i) one(i, a.size());
  }
  return out;
}

Series NoiseModel::whiten(const Layout& layout, const Eigen::Ref<const Series>& x, int axis) const {
  Series out = filter(layout, x, axis);
  out.array() *= scale(layout, axis).array();
  return out;
}

Series NoiseModel::coloured(const Layout& layout, const Series& white, int axis) const {
  Series out = white.array() / inverse_scale_.col(axis).array();
  for (const Segment& g : layout.segments) {
    const Eigen::VectorXd& a = coefficients_[static_cast<std::size_t>(g.regime)][static_cast<std::size_t>(axis)];
    for (Eigen::Index i = g.begin; i < g.end; ++i)
      for (Eigen::Index j = 0; j < std::min(a.size(), i - g.begin); ++j) out[i] += a[j] * out[i - j - 1];
  }
  return out;
}

Series NoiseModel::density(const Layout& layout, const Series& frequency_hz, double dt_s, int axis) const {
  std::array<double, 2> share{};
  for (const Segment& g : layout.segments)
    share[static_cast<std::size_t>(g.regime)] += static_cast<double>(g.end - g.begin) / static_cast<double>(layout.n);
  Series out = Series::Zero(frequency_hz.size());
  for (std::size_t regime = 0; regime < share.size(); ++regime) {
    const Eigen::VectorXd& a = coefficients_[regime][static_cast<std::size_t>(axis)];
    const double level = 2.0 * dt_s * share[regime] * variance_[regime][static_cast<std::size_t>(axis)];
    for (Eigen::Index i = 0; i < out.size(); ++i) {
      std::complex<double> filter = 1.0;
      for (Eigen::Index j = 0; j < a.size(); ++j)
        filter -= std::polar(1.0, -2.0 * std::numbers::pi * frequency_hz[i] * dt_s * static_cast<double>(j + 1)) * a[j];
      out[i] += level / std::norm(filter);
    }
  }
  return out;
}

}  // namespace stillpoint::diag
