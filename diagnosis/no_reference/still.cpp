#include "diagnosis/no_reference/still.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/median.h"
#include "diagnosis/certainty.h"
#include "diagnosis/finding_effect.h"
#include "diagnosis/forensics/forensics.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag::detail {
namespace {

constexpr std::size_t kCells = 240;
constexpr double kAbstainAtRest_nats = 10.0;
constexpr double kWalkOverWhite = 3.0;  // spread of the cell means over what white noise leaves, before it is a drift
constexpr std::array<double, 5> kLagShares{0.01, 0.02, 0.04, 0.08, 0.16};  // of the recording's length

struct Still {
  std::vector<double> t_s;
  Eigen::MatrixXd mean;  ///< cell by axis
  Eigen::VectorXd temp;  ///< per cell; empty: not recorded
  double cell_sd = 0.0;  ///< of a cell mean if the noise were white
};

Still cells_of(const io::Recording& r, Sensor s) {
  const auto& y = triad(r, s);
  const std::size_t n = std::min(kCells, y.size() / 10), length = y.size() / std::max<std::size_t>(n, 1);
  Still out;
  out.mean = Eigen::MatrixXd::Zero(static_cast<long>(n), 3);
  if (!r.temp_degC.empty()) out.temp = Eigen::VectorXd::Zero(static_cast<long>(n));
  double difference = 0.0;
  for (std::size_t c = 0; c < n; ++c) {
    const auto row = static_cast<long>(c);
    for (int k = 0; k < 3; ++k) {  // medians: a start-up transient of one row must not become a cell
      std::vector<double> v;
      for (std::size_t i = c * length; i < (c + 1) * length; ++i)
        if (y[i].allFinite()) v.push_back(y[i][k]);
      if (v.empty()) v.push_back(c ? out.mean(row - 1, k) : 0.0);
      out.mean(row, k) = median(std::move(v));
    }
    double temp_sum = 0.0, temp_count = 0.0;
    for (std::size_t i = c * length; i < (c + 1) * length; ++i) {
      if (!r.temp_degC.empty() && std::isfinite(r.temp_degC[i])) temp_sum += r.temp_degC[i], temp_count += 1.0;
      if (i > 0 && y[i].allFinite() && y[i - 1].allFinite()) difference += (y[i] - y[i - 1]).squaredNorm() / 6.0;
    }
    if (out.temp.size() > 0) out.temp[row] = temp_count > 0 ? temp_sum / temp_count : c ? out.temp[row - 1] : 0.0;
    out.t_s.push_back(r.t_s(c * length));
  }
  out.cell_sd = 1.25 * std::sqrt(difference / static_cast<double>(n * length) / static_cast<double>(length));
  return out;
}

Eigen::MatrixXd increments(const Eigen::MatrixXd& m) { return m.bottomRows(m.rows() - 1) - m.topRows(m.rows() - 1); }

struct StillLaw {
  std::string id, equation, unit;  ///< unit of the reading
  std::vector<std::string> symbols;
  Eigen::MatrixXd columns;
  double tau_s = 0.0;
};

struct Judged {
  double gain = 0.0, held_out = 0.0;
  Eigen::MatrixXd value, sd;  ///< coefficient by axis
  Eigen::MatrixXd fitted;
  Eigen::Vector3d before, after;
};

/// Levels give the coefficients, increments the evidence: in them a walk is white noise.
Judged judge(const Still& s, const Eigen::MatrixXd& columns) {
  Judged j;
  const long n = s.mean.rows(), p = columns.cols();
  Eigen::MatrixXd X(n, p + 1);
  X << Eigen::VectorXd::Ones(n), columns;
  const Eigen::MatrixXd all = X.colPivHouseholderQr().solve(s.mean);
  j.fitted = X * all;
  j.value = all.bottomRows(p);
  j.before = ((s.mean.rowwise() - s.mean.colwise().mean()).colwise().squaredNorm() / static_cast<double>(n))
                 .cwiseSqrt()
                 .transpose();
  j.after = ((s.mean - j.fitted).colwise().squaredNorm() / static_cast<double>(n)).cwiseSqrt().transpose();
  const Eigen::MatrixXd dy = increments(s.mean), dx = increments(columns);
  const Eigen::MatrixXd step = dx.colPivHouseholderQr().solve(dy);
  const Eigen::MatrixXd inverse = (dx.transpose() * dx).completeOrthogonalDecomposition().pseudoInverse();
  j.sd = Eigen::MatrixXd::Zero(p, 3);
  for (int k = 0; k < 3; ++k) {
    const double sse0 = dy.col(k).squaredNorm(), sse1 = (dy.col(k) - dx * step.col(k)).squaredNorm();
    j.gain += 0.5 * static_cast<double>(n - 1) * std::log(std::max(sse0, 1e-300) / std::max(sse1, 1e-300));
    // The two estimates differ by what a walk can do to the levels; the interval must hold both.
    for (long i = 0; i < p; ++i)
      j.sd(i, k) = std::hypot(std::sqrt(std::max(inverse(i, i), 0.0) * sse1 / static_cast<double>(n - 1 - p)),
                              0.5 * (step(i, k) - j.value(i, k)));
    // Held out: coefficients from the increments of one half of the recording, scored on the other, both ways round.
    for (int half = 0; half < 2; ++half) {
      const long m = dy.rows() / 2, from = half ? m : 0, to = half ? 0 : m;
      const Eigen::VectorXd fit = dx.middleRows(from, m).colPivHouseholderQr().solve(dy.col(k).segment(from, m));
      const double e0 = dy.col(k).segment(to, m).squaredNorm(),
                   e1 = (dy.col(k).segment(to, m) - dx.middleRows(to, m) * fit).squaredNorm();
      j.held_out += 0.5 * static_cast<double>(m) * std::log(std::max(e0, 1e-300) / std::max(e1, 1e-300));
    }
  }
  return j;
}

/// T - T_L: how far the temperature that lags by tau is behind.
Eigen::VectorXd behind(const Still& s, double tau_s) {
  Eigen::VectorXd out(s.temp.size());
  double slow = s.temp[0];
  for (long i = 0; i < out.size(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (i > 0) slow += (1.0 - std::exp(-(s.t_s[at] - s.t_s[at - 1]) / tau_s)) * (s.temp[i] - slow);
    out[i] = s.temp[i] - slow;
  }
  return out;
}

std::vector<StillLaw> laws_of(const Still& s, const std::string& sensor, const std::string& unit) {
  std::vector<StillLaw> laws;
  if (s.temp.size() == 0) return laws;
  const Eigen::VectorXd tau = s.temp.array() - sim::kReferenceTemp_degC;
  Eigen::MatrixXd quad(tau.size(), 2);
  quad << tau, tau.cwiseAbs2();
  laws.push_back({sensor + "_temp_lin", "D = k (T - T0)", unit, {"k"}, tau, 0.0});
  laws.push_back({sensor + "_temp_quad", "D = k1 tau + k2 tau^2, tau = T - T0", unit, {"k1", "k2"}, quad, 0.0});
  const double span_s = s.t_s.back() - s.t_s.front();
  for (const double share : kLagShares) {
    Eigen::MatrixXd lag(tau.size(), 2);
    lag << tau, behind(s, share * span_s);
    laws.push_back({sensor + "_temp_lag",
                    "D = k0 (T - T0) + k (T - T_L), tau dT_L/dt = T - T_L",
                    unit,
                    {"k0", "k"},
                    lag,
                    share * span_s});
  }
  std::erase_if(laws, [](const StillLaw& law) { return sim::find_effect(law.id) == nullptr; });
  return laws;
}

Finding describe(const Still& s, Sensor sensor, const StillLaw& law, const Judged& j, double score) {
  Finding f;
  f.effect = law.id;
  f.equation = law.equation;
  f.driver = "temperature";
  f.interval_s = {s.t_s.front(), s.t_s.back()};
  f.regime = fmt::format("at rest in one attitude, {:.1f} to {:.1f} degC", s.temp.minCoeff(), s.temp.maxCoeff());
  int k = 0;
  j.before.maxCoeff(&k);
  for (int axis = 0; axis < 3; ++axis) {
    if (j.after[axis] < 0.7 * j.before[axis])
      f.channels.push_back(fmt::format("{}_{}", kSensorName[sensor], "xyz"[axis]));
    for (std::size_t i = 0; i < law.symbols.size(); ++i) {
      const auto row = static_cast<long>(i);
      const double half = 1.96 * j.sd(row, axis), v = j.value(row, axis);
      f.parameters.push_back({fmt::format("{}_{}", law.symbols[i], "xyz"[axis]),
                              v,
                              {v - half, v + half},
                              law.unit + (law.symbols[i] == "k2" ? "/K^2" : "/K")});
    }
  }
  if (f.channels.empty()) f.channels.push_back(fmt::format("{}_{}", kSensorName[sensor], "xyz"[k]));
  if (law.tau_s > 0) f.parameters.push_back({"tau", law.tau_s, {0.5 * law.tau_s, 2.0 * law.tau_s}, "s"});
  f.held_out.rms_before = j.before[k], f.held_out.rms_after = j.after[k];
  f.held_out.noise_floor = std::min(s.cell_sd, j.after[k]);
  f.held_out.unit = kSensorUnit[sensor];
  f.held_out.gain_nats = j.held_out;
  f.held_out.blocks = 2, f.held_out.blocks_better = j.held_out > 0 ? 2 : 0;
  const double removable = j.before[k] * j.before[k] - f.held_out.noise_floor * f.held_out.noise_floor;
  f.held_out.removable_share_removed =
      removable > 0 ? (j.before[k] * j.before[k] - j.after[k] * j.after[k]) / removable : 0.0;
  f.p_value = chance_of(score);
  f.decided_by =
      "several attitudes at each temperature: one attitude cannot tell an offset from a scale that follows temperature";
  if (sensor == kAcc) f.equivalent = {"acc_temp_scale"};
  auto& g = f.figures;
  g.channel = fmt::format("{}_{}", kSensorName[sensor], "xyz"[k]), g.unit = kSensorUnit[sensor],
  g.driver_label = "temperature, degC";
  const double mean = s.mean.col(k).mean();
  for (long i = 0; i < s.mean.rows(); ++i) {
    g.t_s.push_back(s.t_s[static_cast<std::size_t>(i)]);
    g.residual_before.push_back(s.mean(i, k) - mean), g.residual_after.push_back(s.mean(i, k) - j.fitted(i, k));
    g.held_out.push_back(i >= s.mean.rows() / 2);
    g.driver.push_back(s.temp[i]), g.residual_at_driver.push_back(s.mean(i, k) - mean),
        g.law_at_driver.push_back(j.fitted(i, k) - mean);
  }
  return f;
}

/// Two branches, heating and cooling, beside a law of temperature: the lag that explains most of what the law leaves.
/// The law's own numbers are then those of the joint fit.
std::optional<Finding> hysteresis(const Still& s, Sensor sensor, const StillLaw& law, const Judged& alone,
                                  Finding& named) {
  const long n = s.mean.rows(), p = law.columns.cols();
  const double span_s = s.t_s.back() - s.t_s.front();
  std::optional<Judged> best;
  StillLaw both = law;
  for (const double share : kLagShares) {
    Eigen::MatrixXd columns(n, p + 1);
    columns << law.columns, behind(s, share * span_s);
    Judged j = judge(s, columns);
    if (best && j.gain <= best->gain) continue;
    best = std::move(j);
    both.columns = std::move(columns), both.tau_s = share * span_s;
  }
  const double score = best->gain - alone.gain - 1.5 * std::log(static_cast<double>(n)) - 2.0;
  if (score < kAbstainAtRest_nats || best->held_out < alone.held_out + 1.0) return std::nullopt;
  both.id = fmt::format("{}_temp_lag", kSensorName[sensor]);
  both.equation = "D = k (T - T_L), tau dT_L/dt = T - T_L";
  both.symbols.emplace_back("k");
  Finding f = describe(s, sensor, both, *best, score);
  int strongest = 0;
  best->before.maxCoeff(&strongest);
  f.driver = "temperature, lagging: heating and cooling take two branches";
  f.held_out.rms_before = alone.after[strongest];
  f.held_out.gain_nats = best->held_out - alone.held_out;
  f.equivalent.clear();
  for (auto& q : named.parameters)
    for (const auto& joint : f.parameters)
      if (joint.name == q.name) q = joint;
  std::erase_if(f.parameters, [](const Parameter& q) { return q.name != "tau" && !q.name.starts_with("k_"); });
  f.decided_by =
      "a slow cycle with its true clock: the loop between heating and cooling closes when the change is slow";
  return f;
}

Finding describe_drift(const Still& s, Sensor sensor) {
  Finding f;
  f.effect = fmt::format("{}_drift", kSensorName[sensor]);
  for (const char axis : {'x', 'y', 'z'}) f.channels.push_back(fmt::format("{}_{}", kSensorName[sensor], axis));
  f.interval_s = {s.t_s.front(), s.t_s.back()};
  f.equation = "slow offset, no recorded driver";
  f.driver = "time";
  f.regime = s.temp.size() ? "slow; temperature does not explain it"
                           : "slow; could be thermal: temperature is not in the recording";
  f.decided_by = s.temp.size() ? "record supply_V and current_A" : "record temp_degC";
  f.held_out.unit = kSensorUnit[sensor];
  return f;
}

}  // namespace

Diagnosis diagnose_still(const io::Recording& r, const sim::SimulationConfig& simulation,
                         const std::vector<std::string>& without) {
  Diagnosis d;
  d.abstention_nats = kAbstainAtRest_nats;
  for (const Sensor sensor : {kGyr, kAcc}) {
    if (triad(simulation, sensor) == nullptr || triad(r, sensor).size() < 400) continue;
    const Still s = cells_of(r, sensor);
    std::optional<Finding> best, loop;
    StillLaw best_law;
    Judged best_judged;
    double best_score = kAbstainAtRest_nats;
    for (const auto& law : laws_of(s, kSensorName[sensor], kSensorUnit[sensor])) {
      if (contains(without, law.id)) continue;
      const Judged j = judge(s, law.columns);
      const double score =
          j.gain - 0.5 * 3.0 * static_cast<double>(law.columns.cols()) * std::log(static_cast<double>(s.mean.rows())) -
          (law.tau_s > 0 ? 2.0 : 0.0);
      d.ranking.push_back({law.id, score});
      if (score <= best_score || j.held_out < 1.0) continue;
      best_score = score;
      best = describe(s, sensor, law, j, score);
      best_law = law, best_judged = j;
    }
    const double spread =
        std::sqrt((s.mean.rowwise() - s.mean.colwise().mean()).squaredNorm() / static_cast<double>(3 * s.mean.rows()));
    if (!best && spread > kWalkOverWhite * s.cell_sd) best = describe_drift(s, sensor);
    if (best && best_law.columns.size() > 0 && best_law.tau_s == 0)
      loop = hysteresis(s, sensor, best_law, best_judged, *best);
    if (best) d.findings.push_back(std::move(*best));
    if (loop) d.findings.push_back(std::move(*loop));
  }
  d.verdict = d.findings.empty() ? Verdict::kNoMismatch : Verdict::kExplained;
  std::string named;
  for (const auto& f : d.findings) named += (named.empty() ? "" : ", ") + f.effect;
  d.summary = d.findings.empty() ? "No mismatch in what a recording at rest in one attitude can show."
                                 : "Missing physics, seen at rest in one attitude: " + named + ".";
  d.notices.push_back(
      "no motion and one attitude: scale, cross terms, delays and everything that needs rotation or acceleration stay "
      "untested");
  return d;
}

}  // namespace stillpoint::diag::detail
