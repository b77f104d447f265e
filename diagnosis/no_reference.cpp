#include "diagnosis/no_reference.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/forensics.h"
#include "diagnosis/no_reference_laws.h"
#include "diagnosis/no_reference_model.h"
#include "diagnosis/no_reference_still.h"

namespace stillpoint::diag {
namespace {

using detail::LawColumn;
using detail::LawFit;
using detail::SelfConsistency;
using detail::WitnessedLaw;

constexpr std::size_t kLeastRests = 3;
constexpr int kMostFindings = 3;
constexpr double kAbstain_nats = 7.0;     // after the charges below; e^-7 is one false name in a thousand
constexpr double kEquivalent_nats = 2.5;  // names within this of the best are given together
constexpr double kLeastOfFirst = 0.02;    // smaller gains are the second order of the first finding
constexpr double kDriftOverLaw = 1.15;    // a free offset per rest must beat a law by this to take its place
constexpr double kLargestTau_s = 0.1;
constexpr double kLeastShare = 0.5;   // a law that removes less of what is not noise is not the cause
constexpr double kDispersion = 1.5;   // mean square of whitened residuals above which something is left unexplained
constexpr double kForceMisfit = 1.6;  // whitened rms of the accelerometer's rests above this is more than noise

struct Candidate {
  const WitnessedLaw* law = nullptr;
  double grid_value = 0.0;
  std::array<double, 2> grid_ci95{};
  LawFit fit;
  Eigen::VectorXd applied;   ///< what of it has been taken out of the rates; empty: nothing
  double score = -HUGE_VAL;  ///< gain less the charges for parameters and for having searched
};

/// BIC charge for the coefficients, and the logarithm of the number of places and names searched.
double charge(std::size_t coefficients, std::size_t grid, std::size_t names, std::size_t observations) {
  return 0.5 * static_cast<double>(coefficients) * std::log(static_cast<double>(observations) / 30.0) +
         std::log(static_cast<double>(std::max<std::size_t>(grid, 1))) + std::log(static_cast<double>(names));
}

bool plausible(const Candidate& c) {
  const auto& id = c.law->id;
  const double first = c.fit.value[0];
  if (id == "gyr_delay" || id == "mag_delay") return first > 0 && first < kLargestTau_s;
  if (id == "gyr_earth") return first > 0.2 && first < 5.0;
  if (id == "mag_soft_step") return c.fit.value.cwiseAbs().maxCoeff() < 0.5;  // iron does not turn the field about
  return true;
}

class Search {
 public:
  Search(SelfConsistency& model, const sim::SimulationConfig& simulation)
      : model_(model), laws_(detail::witnessed_laws(model, simulation)) {
    std::erase_if(laws_, [&simulation](const WitnessedLaw& law) {
      return std::any_of(simulation.effects.begin(), simulation.effects.end(),
                         [&law](const auto& e) { return e.id == law.id; });
    });
  }

  [[nodiscard]] std::vector<Candidate> rank() const {
    std::vector<Candidate> all;
    for (const auto& law : laws_) {
      Candidate best = law.grid.empty() ? at(law, 0.0) : over_grid(law);
      best.score = best.fit.gain_nats - charge(law.names.size(), law.grid.size(), laws_.size(), model_.observations());
      if (plausible(best)) all.push_back(std::move(best));
    }
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
    return all;
  }

 private:
  [[nodiscard]] Candidate at(const WitnessedLaw& law, double g) const {
    Candidate c;
    c.law = &law;
    c.grid_value = g;
    c.fit = model_.fit(law.columns(g));
    return c;
  }

  /// Best of the grid, then halvings around it; the interval is where the gain has fallen by 1.92 nats.
  [[nodiscard]] Candidate over_grid(const WitnessedLaw& law) const {
    Candidate best;
    std::size_t best_at = 0;
    for (std::size_t i = 0; i < law.grid.size(); ++i) {
      Candidate c = at(law, law.grid[i]);
      if (best.law == nullptr || c.fit.gain_nats > best.fit.gain_nats) best = std::move(c), best_at = i;
    }
    if (best.law == nullptr) return at(law, 0.0);
    double left = law.grid[best_at > 0 ? best_at - 1 : 0], right = law.grid[std::min(best_at + 1, law.grid.size() - 1)];
    if (best.fit.gain_nats < kAbstain_nats) {
      best.grid_ci95 = {left, right};
      return best;
    }
    const double least = 1e-3 * std::max(1.0, std::abs(best.grid_value));
    double low = left, high = right;
    for (int halving = 0; halving < 7 && right - left > least; ++halving) {
      for (const double g : {0.5 * (left + best.grid_value), 0.5 * (best.grid_value + right)}) {
        Candidate c = at(law, g);
        if (c.fit.gain_nats < best.fit.gain_nats - 1.92)
          (g < best.grid_value ? low : high) = g;
        else if (c.fit.gain_nats > best.fit.gain_nats)
          best = std::move(c);
      }
      left = std::max(left, best.grid_value - 0.5 * (right - left) * 0.5 - least);
      right = std::min(right, best.grid_value + 0.5 * (right - left) * 0.5 + least);
    }
    best.grid_ci95 = {std::min(low, best.grid_value), std::max(high, best.grid_value)};
    return best;
  }

  SelfConsistency& model_;
  std::vector<WitnessedLaw> laws_;
};

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

Finding describe(const SelfConsistency& model, const Candidate& c, const std::vector<Candidate>& ranking) {
  Finding f;
  f.effect = c.law->id;
  f.equation = c.law->equation;
  f.driver = c.law->driver;
  const auto columns = c.law->columns(c.grid_value);
  const auto& r = model.recording();
  f.interval_s = {r.t_s(0), r.t_s(r.size() - 1)};
  Vec3 significance = Vec3::Zero();
  for (std::size_t i = 0; i < c.law->names.size(); ++i) {
    const auto k = static_cast<long>(i);
    const double half = 1.96 * c.fit.sd[k];
    f.parameters.push_back(
        {c.law->names[i], c.fit.value[k], {c.fit.value[k] - half, c.fit.value[k] + half}, c.law->unit});
    const int axis = c.law->names.size() == 9 ? static_cast<int>(i / 3) : static_cast<int>(i % 3);
    significance[axis] = std::max(significance[axis], std::abs(c.fit.value[k]) / c.fit.sd[k]);
  }
  const bool per_axis = c.law->names.size() % 3 == 0 && c.law->id != "mag_field_step";
  for (int k = 0; k < 3; ++k)
    if (!per_axis || significance[k] > 2.6)
      f.channels.push_back(fmt::format("{}_{}", kSensorName[c.law->sensor], "xyz"[k]));
  if (!c.law->grid_name.empty()) {
    f.parameters.push_back({c.law->grid_name, c.grid_value, c.grid_ci95, c.law->grid_unit});
    if (c.law->grid_name == "t0") f.interval_s[0] = c.grid_value;
  }
  f.regime = c.law->sensor == kGyr
                 ? "seen in the rate at rest and in how the integrated attitude turns field and gravity"
                 : "seen in the field against the attitude integrated from the gyro";
  for (const auto& other : ranking) {
    if (other.law == c.law || other.score <= 0) continue;
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
  const auto held_out = model.held_out(columns, c.applied);
  f.held_out.gain_nats = held_out.nats, f.held_out.blocks_better = held_out.blocks_better,
  f.held_out.blocks = held_out.blocks;
  f.p_value = std::exp(-std::max(c.score, 0.0));
  f.confidence = 1.0 / (1.0 + std::exp(-(c.score - kAbstain_nats) - 3.0));
  fill_figures(model, c, columns, f);
  return f;
}

/// A large effect bends the attitude that was settled around it, and the calibrations with it: it is taken out of the
/// readings and fitted again around what follows, until nothing changes. Each time all of it is taken out anew, for the
/// driver (the corrected force or rate) moves with the calibration.
void relinearise(SelfConsistency& model, Candidate& c) {
  constexpr int kMostPasses = 8;
  std::vector<LawColumn> taken;
  c.applied = Eigen::VectorXd::Zero(c.fit.value.size());
  for (int pass = 0; pass < kMostPasses; ++pass) {
    std::vector<LawColumn> columns = c.law->columns(c.grid_value);
    model.replace(taken, c.applied, columns, c.fit.value);
    taken = std::move(columns);
    c.applied = c.fit.value;
    c.fit = model.fit(c.law->columns(c.grid_value), c.applied);
    if ((c.fit.value - c.applied).cwiseAbs().cwiseQuotient(c.fit.sd).maxCoeff() < 0.1) break;
  }
}

/// Whether the offsets of the rests wander (successive ones differ little against their spread, and most of them
/// differ) or jump about, as an effect of attitude or of a short time does. After von Neumann's ratio: 2 for
/// independent values.
bool wanders(const SelfConsistency& model, Sensor sensor) {
  const LawFit fit = model.fit(detail::free_offsets(model, sensor));
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

/// A slow offset that no law of the recording's drivers describes.
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
  f.p_value = std::exp(-std::max(score, 0.0));
  f.confidence = 0.9;
  return f;
}

/// Something is there, and no law of the list is it.
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
  f.p_value = std::exp(-std::max(closest.score, 0.0));
  f.confidence = 0.9;
  return f;
}

/// Score of a free offset per rest. Its many coefficients are drawn from one law (a walk), so it is charged for the
/// information in them, a third of the usual.
double drift_score(const SelfConsistency& model, Sensor sensor) {
  const auto columns = detail::free_offsets(model, sensor);
  if (columns.empty()) return -HUGE_VAL;
  const double gain = model.fit(columns).gain_nats;
  return gain - 1.5 * static_cast<double>(columns.size()) - 4.0;
}

/// Heat map and table of the channels that have a witness.
void fill_channels(const SelfConsistency& model, const std::vector<SelfConsistency::Series>& before, Diagnosis& d) {
  constexpr double kHeatBlock_s = 2.0;
  const auto& r = model.recording();
  const double start_s = r.t_s(0);
  const auto blocks = static_cast<std::size_t>((r.t_s(r.size() - 1) - start_s) / kHeatBlock_s) + 1;
  for (std::size_t b = 0; b < blocks; ++b)
    d.heat_t_s.push_back(start_s + kHeatBlock_s * (static_cast<double>(b) + 0.5));
  for (const Sensor s : {kGyr, kMag}) {
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
        heat[static_cast<std::size_t>((first.t_s[i] - start_s) / kHeatBlock_s)] +=
            std::max(0.0, 0.5 * (first.residual[i][k] * first.residual[i][k] / noise - 1.0));
      d.heat_channels.push_back(fmt::format("{}_{}", kSensorName[s], "xyz"[k]));
      d.heat_nats.push_back(std::move(heat));
    }
  }
}

void conclude(const SelfConsistency& model, const Forensics& raw, Diagnosis& d) {
  const bool force_off = model.force_misfit() > kForceMisfit;
  d.notices.push_back(
      "accelerometer: without a reference only its norm at rest is witnessed; its dynamics, delay and cross terms stay "
      "untested. "
      "Record rests of 3 s in at least twelve attitudes, or a reference orientation and position");
  const bool unknown = std::any_of(d.findings.begin(), d.findings.end(),
                                   [](const Finding& f) { return f.effect.starts_with("unknown"); });
  if (!d.findings.empty()) {
    d.verdict = unknown ? Verdict::kUnexplained : Verdict::kExplained;
    d.summary = fmt::format(
        "Missing physics: {} ({}); found from rests and from gyroscope against magnetometer, without a reference.",
        d.findings.front().effect, fmt::join(d.findings.front().channels, ", "));
  } else if (model.dispersion() > kDispersion) {
    d.verdict = Verdict::kUnexplained;
    d.summary = fmt::format(
        "Something is there that no law of the library explains: gyroscope, magnetometer and rests disagree by {:.1f} "
        "times their noise. Record a reference orientation to decide.",
        std::sqrt(model.dispersion()));
  } else if (force_off) {
    d.verdict = Verdict::kInsufficientData;
    d.summary = fmt::format(
        "Insufficient data for the accelerometer: its rests depart from gravity by {:.1f} times their noise, and "
        "without "
        "a reference the cause cannot be told. Gyroscope and magnetometer agree with the simulation.",
        model.force_misfit());
  } else {
    d.verdict = Verdict::kNoMismatch;
    d.summary =
        "No mismatch in what can be seen without a reference: rests, norms, and gyroscope against magnetometer agree "
        "with the simulation.";
  }
  for (const auto& n : raw.notices) d.notices.push_back(n);
}

}  // namespace

Diagnosis diagnose_without_reference(const io::Recording& recording, const sim::SimulationConfig& simulation) {
  Diagnosis d;
  const Forensics raw = examine_raw_values(recording, simulation);
  if (detail::lies_still(recording)) {
    d = detail::diagnose_still(recording, simulation);
    d.findings.insert(d.findings.end(), raw.findings.begin(), raw.findings.end());
    d.notices.insert(d.notices.end(), raw.notices.begin(), raw.notices.end());
    return d;
  }
  d.findings = raw.findings;
  d.abstention_nats = kAbstain_nats;
  const auto insufficient = [&](const std::string& why) {
    d.verdict = d.findings.empty() ? Verdict::kInsufficientData : Verdict::kPartlyExplained;
    d.summary = d.findings.empty()
                    ? "Insufficient data: " + why
                    : fmt::format("Found {} in the raw values; for the rest: {}", d.findings.front().effect, why);
    d.notices.push_back(why);
    for (const auto& n : raw.notices) d.notices.push_back(n);
    return d;
  };
  const auto coarse = [&](Sensor s) {
    const auto* config = triad(simulation, s);
    return config && raw.sensor[s].quantised && raw.sensor[s].lattice_step.maxCoeff() > config->noise_sd;
  };
  if (raw.sensor[kGyr].saturated || coarse(kGyr))
    return insufficient(
        "the gyroscope's raw values are spoiled, and without a reference everything else is judged by it; repair that "
        "first");
  if (!simulation.gyroscope || recording.gyr_radps.empty() || !simulation.accelerometer || recording.acc_mps2.empty())
    return insufficient(
        "without a reference, gyroscope and accelerometer are both needed: record them or add a reference orientation");
  const auto rest = detail::find_rest(recording, simulation);
  if (rest.size() < kLeastRests)
    return insufficient(fmt::format(
        "{} windows of rest where {} are needed: put the sensor down for 3 s between movements, in different "
        "attitudes, or record a reference orientation",
        rest.size(), kLeastRests));
  SelfConsistency model(recording, simulation, raw, rest);
  model.settle();
  const std::vector<SelfConsistency::Series> before{model.series(kGyr, {}, {}), model.series(kMag, {}, {})};
  double first_gain = 0.0;
  for (int i = 0; i < kMostFindings; ++i) {
    const Search search(model, simulation);
    const auto ranking = search.rank();
    if (i == 0)
      for (const auto& c : ranking) d.ranking.push_back({c.law->id, c.score});
    for (const Sensor s : {kGyr, kMag}) {
      if (i > 0) continue;
      const double drift = drift_score(model, s);
      d.ranking.push_back({fmt::format("{}_drift", kSensorName[s]), drift});
      double best = 0.0;  // among all laws: the field's offset also moves when the gyro turns it wrongly
      for (const auto& c : ranking) best = std::max(best, c.score);
      if (drift > kAbstain_nats && drift > kDriftOverLaw * best + kAbstain_nats) {
        d.findings.push_back(describe_drift(model, s, drift));
        i = kMostFindings;
      }
    }
    if (i >= kMostFindings || ranking.empty()) break;
    Candidate best = ranking.front();
    if (best.score < kAbstain_nats || best.fit.gain_nats < kLeastOfFirst * first_gain) break;
    relinearise(model, best);
    if (!plausible(best)) break;
    Finding f = describe(model, best, ranking);
    if (!(f.held_out.gain_nats > 1.0)) break;
    if (f.held_out.removable_share_removed < kLeastShare && model.dispersion() > kDispersion) {
      d.findings.push_back(describe_unknown(model, best.law->sensor, best));
      break;
    }
    first_gain = std::max(first_gain, best.fit.gain_nats);
    d.findings.push_back(std::move(f));
    model.accept(best.law->columns(best.grid_value));
  }
  std::sort(d.ranking.begin(), d.ranking.end(), [](const auto& a, const auto& b) { return a.gain_nats > b.gain_nats; });
  fill_channels(model, before, d);
  conclude(model, raw, d);
  return d;
}

}  // namespace stillpoint::diag
