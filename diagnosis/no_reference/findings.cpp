#include "diagnosis/no_reference/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/certainty.h"

namespace stillpoint::diag::detail {
namespace {

void fill_figures(const SelfConsistency& model, const Candidate& c, const std::vector<LawColumn>& columns, Finding& f) {
  const auto series = model.series(c.law->sensor, columns, c.applied);
  Vec3 before = Vec3::Zero(), after = Vec3::Zero();
  for (std::size_t i = 0; i < series.t_s.size(); ++i) {
    before += series.residual[i].cwiseAbs2();
    after += (series.residual[i] - series.explained[i]).cwiseAbs2();
  }
  const auto n = static_cast<double>(std::max<std::size_t>(series.t_s.size(), 1));
  int k = 0;
  (before - after).maxCoeff(&k);
  f.held_out.rms_before = std::sqrt(before[k] / n), f.held_out.rms_after = std::sqrt(after[k] / n);
  double difference = 0;  // neighbours share law and misfit: what differs between them is noise
  for (std::size_t i = 1; i < series.t_s.size(); ++i)
    difference += std::pow(series.residual[i][k] - series.residual[i - 1][k], 2);
  f.held_out.noise_floor = std::min(std::sqrt(0.5 * difference / n), f.held_out.rms_after);
  f.held_out.unit = kSensorUnit[c.law->sensor];
  const double removable = before[k] / n - f.held_out.noise_floor * f.held_out.noise_floor;
  f.held_out.removable_share_removed = removable > 0 ? std::min(1.0, (before[k] - after[k]) / n / removable) : 0.0;
  auto& g = f.figures;
  g.channel = fmt::format("{}_{}", kSensorName[c.law->sensor], "xyz"[k]);
  g.unit = kSensorUnit[c.law->sensor];
  g.driver_label = c.law->driver;
  const std::size_t stride = std::max<std::size_t>(1, series.t_s.size() / 1500);
  for (std::size_t i = 0; i < series.t_s.size(); i += stride) {
    g.t_s.push_back(series.t_s[i]);
    g.residual_before.push_back(series.residual[i][k]);
    g.residual_after.push_back(series.residual[i][k] - series.explained[i][k]);
    g.held_out.push_back(static_cast<int>((series.t_s[i] - series.t_s[0]) / 10.0) % 2 == 1);
  }
}

/// Whether the offsets of the rests wander (successive ones differ little against their spread, and most of them
/// differ) or jump about, as an effect of attitude or of a short time does. After von Neumann's ratio: 2 for
/// independent values.
bool wanders(const SelfConsistency& model, Sensor sensor) {
  const LawFit fit = model.fit(free_offsets(model, sensor));
  const long rests = fit.value.size() / 3;
  double successive = 0, spread = 0, differing = 0;
  for (int k = 0; k < 3; ++k) {
    Eigen::VectorXd offset = Eigen::VectorXd::Zero(rests + 1), sd = Eigen::VectorXd::Zero(rests + 1);
    for (long w = 0; w < rests; ++w) offset[w + 1] = fit.value[3 * w + k], sd[w + 1] = fit.sd[3 * w + k];
    const double mean = offset.mean(), weight = 1.0 / (sd.squaredNorm() + 1e-300);
    for (long w = 0; w <= rests; ++w) spread += weight * (offset[w] - mean) * (offset[w] - mean);
    for (long w = 0; w < rests; ++w) {
      const double step = offset[w + 1] - offset[w];
      successive += weight * step * step;
      differing += std::abs(step) > 2.0 * std::hypot(sd[w], sd[w + 1]);
    }
  }
  return successive < 1.0 * spread && differing > 0.3 * 3.0 * static_cast<double>(rests);
}

/// The coefficients with their intervals, and the channels in which they matter.
void fill_parameters(const Candidate& c, const Eigen::VectorXd& sd, double start_s, Finding& f) {
  Vec3 significance = Vec3::Zero();
  for (std::size_t i = 0; i < c.law->names.size(); ++i) {
    const auto k = static_cast<long>(i);
    const double half = 1.96 * sd[k];
    f.parameters.push_back({c.law->names[i],
                            c.fit.value[k],
                            {c.fit.value[k] - half, c.fit.value[k] + half},
                            c.law->unit + (c.law->names[i].starts_with("k2") ? "^2" : "")});
    const int axis = c.law->names.size() == 9 ? static_cast<int>(i / 3) : static_cast<int>(i % 3);
    significance[axis] = std::max(significance[axis], std::abs(c.fit.value[k]) / sd[k]);
  }
  const bool per_axis = c.law->names.size() % 3 == 0 && c.law->id != "mag_field_step";
  for (int k = 0; k < 3; ++k)
    if (!per_axis || significance[k] > 2.6)
      f.channels.push_back(fmt::format("{}_{}", kSensorName[c.law->sensor], "xyz"[k]));
  if (!c.law->grid_name.empty()) {
    const bool step = c.law->grid_name == "t0";  // from the start of the recording, as a simulation has it
    const double zero = step ? start_s : 0.0;
    f.parameters.push_back(
        {c.law->grid_name, c.grid_value - zero, {c.grid_ci95[0] - zero, c.grid_ci95[1] - zero}, c.law->grid_unit});
    if (step) f.interval_s[0] = c.grid_value;
  }
}

/// Which other names would do as well, and why the next one was not taken.
void fill_rivals(const Candidate& c, const std::vector<Candidate>& ranking, Finding& f) {
  for (const auto& other : ranking) {
    if (other.law->id == c.law->id || other.score <= 0) continue;
    if (c.score - other.score < kEquivalent_nats && f.equivalent.size() < 2) f.equivalent.push_back(other.law->id);
    if (f.runner_up_effect.empty()) {
      f.runner_up_effect = other.law->id;
      f.runner_up_why_rejected =
          fmt::format("explains {:.1f} nats less after the charge for its parameters", c.score - other.score);
    }
  }
  if (c.law->id == "gyr_delay") f.equivalent = {"gyr_lpf"};
  if (c.law->id == "mag_delay") f.equivalent = {"mag_lpf"};
  f.decided_by = f.equivalent.empty() ? "a recording with a reference orientation would test it against motion as well"
                                      : "a recording with a reference orientation and more attitudes at rest";
}

}  // namespace

Finding describe(const SelfConsistency& model, const Candidate& c, const Eigen::VectorXd& sd,
                 const std::vector<Candidate>& ranking) {
  Finding f;
  f.effect = c.law->id;
  f.equation = c.law->equation;
  f.driver = c.law->driver;
  const auto& r = model.recording();
  f.interval_s = {r.t_s(0), r.t_s(r.size() - 1)};
  const auto columns = c.law->columns(c.grid_value);
  fill_parameters(c, sd, r.t_s(0), f);
  f.regime = c.law->sensor == kGyr
                 ? "seen in the rate at rest and in how the integrated attitude turns field and gravity"
                 : "seen in the field against the attitude integrated from the gyro";
  fill_rivals(c, ranking, f);
  const auto held_out = model.held_out(columns, c.applied);
  f.held_out.gain_nats = held_out.nats, f.held_out.blocks_better = held_out.blocks_better,
  f.held_out.blocks = held_out.blocks;
  f.p_value = chance_of(c.score);
  f.confidence = confidence_of(c.score);
  fill_figures(model, c, columns, f);
  return f;
}

Finding describe_drift(const SelfConsistency& model, Sensor sensor, double score) {
  const auto& r = model.recording();
  Finding f;
  const bool walk = wanders(model, sensor);
  f.effect = fmt::format(
      "{}{}", walk ? "" : "unknown:", walk ? fmt::format("{}_drift", kSensorName[sensor]) : "offset(attitude or time)");
  for (const char axis : {'x', 'y', 'z'}) f.channels.push_back(fmt::format("{}_{}", kSensorName[sensor], axis));
  f.interval_s = {r.t_s(0), r.t_s(r.size() - 1)};
  f.equation = "offset differs from rest to rest, following no recorded driver";
  f.driver = "time";
  f.regime = !walk                 ? "the offset jumps from rest to rest"
             : r.temp_degC.empty() ? "slow; could be thermal, but temperature is not in the recording"
                                   : "slow";
  f.decided_by = walk && r.temp_degC.empty()
                     ? "record temp_degC"
                     : "a reference orientation, and rests in the same attitude at different times";
  f.held_out.unit = kSensorUnit[sensor];
  f.p_value = chance_of(score);
  return f;
}

Finding describe_unknown(const SelfConsistency& model, Sensor sensor, const Candidate& closest) {
  const auto& r = model.recording();
  Finding f;
  f.effect = sensor == kMag ? "unknown:m(place or time)" : "unknown:omega";
  for (const char axis : {'x', 'y', 'z'}) f.channels.push_back(fmt::format("{}_{}", kSensorName[sensor], axis));
  f.interval_s = {r.t_s(0), r.t_s(r.size() - 1)};
  f.equation = "none of the library";
  f.driver = closest.law->driver;
  f.regime = fmt::format("whitened misfit {:.1f} times the noise; the closest law, {}, removes too little of it",
                         std::sqrt(model.dispersion()), closest.law->id);
  f.runner_up_effect = closest.law->id;
  f.runner_up_why_rejected = "removes less than half of what is not noise";
  f.decided_by = "a reference orientation and position: the field may differ from place to place";
  f.held_out.unit = kSensorUnit[sensor];
  f.p_value = chance_of(closest.score);
  return f;
}

void fill_channels(const SelfConsistency& model, const std::array<SelfConsistency::Series, 2>& before, Diagnosis& d) {
  constexpr double kHeatBlock_s = 2.0, kMostBlocks = 2000.0;  // a clock may jump by years
  const auto& r = model.recording();
  const double start_s = r.t_s(0), span_s = r.t_s(r.size() - 1) - start_s;
  const double block_s = std::max(kHeatBlock_s, span_s / kMostBlocks);
  const auto blocks = static_cast<std::size_t>(span_s / block_s) + 1;
  for (std::size_t b = 0; b < blocks; ++b) d.heat_t_s.push_back(start_s + block_s * (static_cast<double>(b) + 0.5));
  for (const Sensor s : {kGyr, kMag}) {
    if (s == kGyr && model.rest().empty()) continue;
    const auto& first = before[s == kGyr ? 0 : 1];
    const auto last = model.series(s, {}, {});
    const auto n = static_cast<double>(first.t_s.size());
    if (first.t_s.empty() || last.t_s.size() != first.t_s.size()) continue;
    for (int k = 0; k < 3; ++k) {
      double square0 = 0, square1 = 0, noise = 0;
      for (std::size_t i = 0; i < first.t_s.size(); ++i) {
        square0 += first.residual[i][k] * first.residual[i][k], square1 += last.residual[i][k] * last.residual[i][k];
        if (i > 0) noise += 0.5 * std::pow(last.residual[i][k] - last.residual[i - 1][k], 2) / n;
      }
      d.residual.push_back({fmt::format("{}_{}{}", kSensorName[s], "xyz"[k], s == kGyr ? " at rest" : ""),
                            std::sqrt(square0 / n), std::sqrt(square1 / n), square1 / n < 1.3 * noise,
                            4.0 * std::sqrt(square1) / n, kSensorUnit[s]});
      std::vector<double> heat(blocks, 0.0);
      for (std::size_t i = 0; i < first.t_s.size(); ++i)
        heat[static_cast<std::size_t>((first.t_s[i] - start_s) / block_s)] +=
            0.5 * (first.residual[i][k] * first.residual[i][k] / noise - 1.0);
      d.heat_channels.push_back(fmt::format("{}_{}", kSensorName[s], "xyz"[k]));
      d.heat_nats.push_back(std::move(heat));
    }
  }
}

}  // namespace stillpoint::diag::detail
