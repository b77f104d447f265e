#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "diagnosis/prove/draw.h"
#include "diagnosis/prove/kinds.h"
#include "diagnosis/prove/prove.h"
#include "diagnosis/prove/strength.h"
#include "io/simulated_recording.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {
namespace {

constexpr double kBadPart = 5.0;  // times the upper end of the usual sizes
constexpr int kMostDraws = 30;

sim::TriadConfig triad_of(Draw& draw, double bias, double matrix, double noise) {
  sim::TriadConfig t;
  for (int i = 0; i < 3; ++i) {
    t.bias[i] = bias * draw.normal();
    for (int j = 0; j < 3; ++j) t.matrix(i, j) += matrix * draw.normal();
  }
  t.noise_sd = noise;
  return t;
}

void perturb(Draw& draw, sim::TriadConfig& t, double bias, double matrix) {
  for (int i = 0; i < 3; ++i) {
    t.bias[i] += bias * draw.normal();
    for (int j = 0; j < 3; ++j) t.matrix(i, j) += matrix * draw.normal();
  }
}

/// The first parameter, all its numbers alike.
void set_all(sim::EffectConfig& e, double value) {
  auto& values = e.parameters.begin()->second;
  std::fill(values.begin(), values.end(), value);
}

/// Parameters of the usual size, with signs; times in the middle of the recording.
sim::EffectConfig draw_effect(Draw& draw, const std::string& id, double duration_s) {
  sim::EffectConfig e;
  e.id = id;
  for (const auto& p : sim::find_effect(id)->parameters) {
    if (!p.required) continue;
    auto& values = e.parameters[p.key];
    for (int i = 0; i < p.count; ++i) {
      double v = p.typical_high > p.typical_low && p.typical_low > 0 ? draw.log_uniform(p.typical_low, p.typical_high)
                                                                     : p.typical_low;
      if (p.count > 1 && draw.bits() % 2 == 0) v = -v;
      values.push_back(v);
    }
    if (p.key == "t0_s") values = {draw.uniform(0.3, 0.7) * duration_s};
    if (p.symbol == "n") values = {id == "mag_hold" ? std::floor(draw.uniform(2, 6)) : std::floor(draw.uniform(2, 12))};
  }
  if (id == "mag_gradient") {  // curl- and divergence-free
    auto& g = e.parameters.begin()->second;
    g[3] = g[1], g[6] = g[2], g[7] = g[5], g[8] = -g[0] - g[4];
  }
  if (id == "sys_dup") set_all(e, draw.log_uniform(0.002, 0.02));
  if (id == "gyr_quant") set_all(e, draw.log_uniform(5e-4, 0.01));
  if (id == "acc_sat") set_all(e, draw.uniform(10.5, 14.0));
  if (id == "gyr_sat") set_all(e, draw.uniform(2.0, 3.0));
  return e;
}

/// d' of one effect alone, as seen with the reference that is given, or with none.
double d_prime_of(sim::SimulationConfig config, std::size_t which, const std::shared_ptr<const sim::Motion>& motion,
                  std::uint64_t seed) {
  config.effects = {config.effects[which]};
  return whitened_d_prime(config, motion, seed);
}

bool scales(const std::string& key) { return key != "t0_s" && key != "tau_s"; }

/// Scales the coefficients to a drawn d', or as far as parts on the bad side go. Times and time constants are left as
/// they are.
void scale_to_d_prime(Draw& draw, sim::SimulationConfig& config, std::size_t which,
                      const std::shared_ptr<const sim::Motion>& motion, std::uint64_t seed, const Range& range) {
  const double wanted = draw.log_uniform(range[0], range[1]);
  sim::EffectConfig& effect = config.effects[which];
  for (int pass = 0; pass < 2; ++pass) {
    const double now = d_prime_of(config, which, motion, seed);
    if (!(now > 0)) return;
    double factor = wanted / now;
    for (const auto& p : sim::find_effect(effect.id)->parameters)
      if (const auto at = effect.parameters.find(p.key); at != effect.parameters.end() && scales(p.key))
        for (const double v : at->second) factor = std::min(factor, kBadPart * p.typical_high / std::abs(v));
    for (auto& [key, values] : effect.parameters)
      if (scales(key))
        for (double& v : values) v *= factor;
  }
}

/// A law that the catalogue does not have, put on the readings themselves.
void add_novel(Draw& draw, io::Recording& r, const sim::SimulationConfig& config, CaseTruth& truth) {
  const std::size_t which = draw.bits() % 3;
  const double z = draw.normal(), y = draw.normal(), x = draw.normal();  // one after the other, by any compiler
  const Vec3 k(x, y, z);
  std::vector<Vec3> delta(r.size());
  double square = 0.0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double tau = r.temp_degC[i] - sim::kReferenceTemp_degC;
    const Vec3 f = r.acc_mps2[i], w = r.gyr_radps[i];
    delta[i] = which == 0   ? Vec3(tau * k.cwiseProduct(f))
               : which == 1 ? Vec3(k * w.squaredNorm())
                            : Vec3(tau * w.norm() * k);
    square += delta[i].squaredNorm() / 3.0 / static_cast<double>(r.size());
  }
  const double noise = which == 0   ? config.gyroscope->noise_sd
                       : which == 1 ? config.magnetometer->noise_sd
                                    : config.accelerometer->noise_sd;
  const double rms_over_noise = draw.log_uniform(0.5, 3.0);
  auto& column = which == 0 ? r.gyr_radps : which == 1 ? r.mag_uT : r.acc_mps2;
  for (std::size_t i = 0; i < r.size(); ++i) column[i] += rms_over_noise * noise / std::sqrt(square) * delta[i];
  static const std::array<const char*, 3> names{"novel_gyr_Tf", "novel_mag_w2", "novel_acc_Tw"};
  truth.effects[names[which]] = {{"rms_over_noise", {rms_over_noise}}};
  truth.d_prime = rms_over_noise * std::sqrt(3.0 * static_cast<double>(r.size()));
}

void conceal(Draw& draw, const std::string& kind, double duration_s, sim::SimulationConfig& config, CaseTruth& truth) {
  if (kind == "window") {
    const double length_s = draw.uniform(0.12, 0.2) * duration_s, start_s = draw.uniform(0.1, 0.7) * duration_s;
    truth.window_s = {start_s, start_s + length_s};
    config.effects[0].window_s = {start_s, start_s + length_s};
    if (const auto t0 = config.effects[0].parameters.find("t0_s"); t0 != config.effects[0].parameters.end())
      t0->second = {start_s};  // a step begins with its window
  }
  if (kind == "oneaxis") config.effects[0].axes = {static_cast<int>(draw.bits() % 3)};
}

void draw_effects(Draw& draw, const std::string& kind, double duration_s,
                  const std::shared_ptr<const sim::Motion>& motion, std::uint64_t seed, sim::SimulationConfig& config,
                  CaseTruth& truth) {
  config.effects.clear();
  for (const auto& id : effects_of(draw, kind)) config.effects.push_back(draw_effect(draw, id, duration_s));
  conceal(draw, kind, duration_s, config, truth);
  for (std::size_t i = 0; i < config.effects.size(); ++i)
    if (is_scaled(config.effects[i].id)) scale_to_d_prime(draw, config, i, motion, seed, range_of(kind));
}

/// Some effects of a usual size drown in the noise of a camera; those are drawn anew before anything is sealed.
bool all_can_be_seen(const sim::SimulationConfig& config, const std::shared_ptr<const sim::Motion>& motion,
                     std::uint64_t seed, double least) {
  for (std::size_t i = 0; i < config.effects.size(); ++i)
    if (config.effects[i].id != "sys_tracker" && d_prime_of(config, i, motion, seed) < 0.95 * least) return false;
  return true;
}

/// A simulation without effects, as the one to be diagnosed is given; `kind` decides how the temperature runs.
sim::SimulationConfig draw_baseline(Draw& draw, const std::string& kind, const std::string& reference,
                                    double duration_s) {
  sim::SimulationConfig config;
  config.rate_hz = 50.0;
  config.gravity_mps2 = 9.81;
  const double dip = draw.uniform(0.9, 1.25), strength = draw.uniform(42, 54);
  config.field_world_uT = strength * Vec3(0, std::cos(dip), -std::sin(dip));
  config.accelerometer = triad_of(draw, 0.2, 0.01, 0.02);
  config.gyroscope = triad_of(draw, 0.01, 0.01, 0.001);
  config.magnetometer = triad_of(draw, 5.0, 0.03, 0.3);
  config.motion = sim::MotionConfig{};
  config.motion->duration_s = duration_s;
  config.motion->rate_radps = draw.uniform(1.0, 2.0);
  config.environment.temperature.kind = kind == "confound" ? "activity" : "warm_up";
  config.environment.temperature.start_degC = draw.uniform(18, 26);
  config.environment.temperature.rise_K = draw.uniform(5, 14);
  config.environment.temperature.tau_s = draw.uniform(25, 80);
  config.environment.current.kind = "steps";
  config.reference.kind = reference;
  return config;
}

/// What differs from the baseline and is no effect: the noise's colour or axes, and wrong offsets and scales.
void draw_nuisance(Draw& draw, const std::string& kind, std::size_t slot, sim::SimulationConfig& config,
                   CaseTruth& truth) {
  truth.noise = slot == 7 ? "coloured" : slot == 16 ? "uneven" : "white";
  if (truth.noise == "coloured")
    for (auto* t : {&config.accelerometer, &config.gyroscope, &config.magnetometer}) (*t)->noise_band_hz = 8.0;
  if (truth.noise == "uneven")
    for (auto* t : {&config.accelerometer, &config.gyroscope, &config.magnetometer})
      (*t)->noise_axes = Vec3(1.0, 1.6, 0.8);
  if (kind == "cfgerr" || (kind == "clean" && slot == 20)) {
    perturb(draw, *config.accelerometer, 0.05, 0.003);
    perturb(draw, *config.gyroscope, 0.002, 0.004);
    perturb(draw, *config.magnetometer, 0.8, 0.01);
  }
}

/// Noise of parts as they are sold; the simulation does not know of it.
void make_real(Draw& draw, sim::SimulationConfig& baseline, sim::SimulationConfig& config, CaseTruth& truth) {
  baseline.rate_hz = config.rate_hz = draw.one_of(std::vector<double>{50.0, 100.0, 200.0});
  const double flicker = draw.one_of(std::vector<double>{0.0, 0.1, 0.25});  // over the deviation of one sample
  truth.noise = fmt::format("flicker {:g}", flicker);
  for (auto* triad : {&config.accelerometer, &config.gyroscope, &config.magnetometer})
    (*triad)->bias_instability = flicker * (*triad)->noise_sd;
  for (const char* sensor : {"acc", "gyr", "mag"}) truth.allowed.push_back(fmt::format("{}_instability", sensor));
}

/// The effects as they will be scored, and the least d' among them.
void write_truth(const sim::SimulationConfig& config, const std::shared_ptr<const sim::Motion>& motion,
                 std::uint64_t seed, CaseTruth& truth) {
  for (std::size_t i = 0; i < config.effects.size(); ++i) {
    const sim::EffectConfig& effect = config.effects[i];
    for (const auto& p : sim::find_effect(effect.id)->parameters)
      if (const auto at = effect.parameters.find(p.key); at != effect.parameters.end())
        truth.effects[effect.id][p.symbol] = at->second;
    act_on_axes(truth.effects[effect.id], effect.axes);
    if (effect.id == "sys_tracker") continue;
    const double d = d_prime_of(config, i, motion, seed);
    truth.d_prime = i == 0 ? d : std::min(truth.d_prime, d);
  }
}

SealedCase draw_as(const std::string& kind, const std::string& salt, std::size_t index, bool quick, Parts parts) {
  Draw draw(salt, index);
  SealedCase c;
  c.id = fmt::format("{:04}", index);
  const double duration_s = quick ? 60.0 : 120.0;
  c.truth.kind = kind;
  c.truth.reference = kind == "noref" ? "none" : draw.bits() % 2 == 0 ? "exact" : "mocap";
  sim::SimulationConfig config = c.baseline = draw_baseline(draw, kind, c.truth.reference, duration_s);
  const std::uint64_t seed = draw.bits();
  if (parts == Parts::kReal) make_real(draw, c.baseline, config, c.truth);
  const std::shared_ptr<const sim::Motion> motion = sim::make_motion(*config.motion, seed);
  for (int drawn = 0; drawn < kMostDraws; ++drawn) {
    draw_effects(draw, kind, duration_s, motion, seed, config, c.truth);
    if (all_can_be_seen(config, motion, seed, range_of(kind)[0])) break;
  }
  if (kind == "deleted") c.without = {config.effects[0].id};
  if (parts == Parts::kIdeal) draw_nuisance(draw, kind, index % kSlots, config, c.truth);
  write_truth(config, motion, seed, c.truth);
  c.recording = io::to_recording(sim::simulate(config, motion, seed));
  if (kind == "novel") add_novel(draw, c.recording, config, c.truth);
  if (kind == "notemp") c.recording.temp_degC.clear();
  if (kind == "noaux") c.recording.current_A.clear(), c.recording.supply_V.clear();
  std::random_device device;  // the nonce keeps the hash from being guessed; it does not enter the recording
  for (int i = 0; i < 4; ++i) c.nonce += fmt::format("{:08x}", device());
  return c;
}

}  // namespace

SealedCase draw_case(const std::string& salt, std::size_t index, bool quick, Parts parts) {
  return draw_as(kind_of(index), salt, index, quick, parts);
}

SealedCase draw_case_of(const std::string& kind, const std::string& salt, std::size_t index, bool quick, Parts parts) {
  return draw_as(kind, salt + "/" + kind, index, quick, parts);
}

SealedCase draw_limit_case(const std::string& salt, std::size_t index, bool quick, Parts parts) {
  return draw_as("limit", salt + "/limits", index, quick, parts);
}

}  // namespace stillpoint::diag
