/// PX4's thermal parameters: for each axis a polynomial of third order in T - TREF that is taken off the raw reading.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <sstream>

#include "exchange/parameters_of.h"
#include "simulation/effect_catalogue.h"
#include "simulation/law_effect.h"

namespace stillpoint::exchange::parameters {
namespace {

struct Words {
  char letter;
  const char *sensor, *unit;
};
constexpr std::array<Words, 2> kWords{{{'A', "acc", "mps2"}, {'G', "gyr", "radps"}}};

/// Lines of "1 1 NAME VALUE TYPE" (QGroundControl), "NAME VALUE" or "NAME,VALUE".
std::map<std::string, double> values_in(const std::string& text) {
  std::map<std::string, double> out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    for (char& c : line)
      if (c == ',' || c == '=') c = ' ';
    std::istringstream words(line);
    std::string name, word;
    while (words >> word && !word.starts_with("TC_")) continue;
    name = word;
    double value = 0.0;
    if (name.starts_with("TC_") && words >> value) out[name] = value;
  }
  return out;
}

/// The polynomial about another reference temperature: p(T - a) = q(T - b).
std::array<Vec3, 4> moved(const std::array<Vec3, 4>& p, double shift) {
  return {p[0] + shift * (p[1] + shift * (p[2] + shift * p[3])), p[1] + shift * (2.0 * p[2] + 3.0 * shift * p[3]),
          p[2] + 3.0 * shift * p[3], p[3]};
}

sim::TriadConfig read_triad(const std::map<std::string, double>& values, const Words& w, ReadParameters& out) {
  const auto value = [&](const std::string& key, double otherwise) {
    const auto at = values.find(fmt::format("TC_{}0_{}", w.letter, key));
    return at == values.end() ? otherwise : at->second;
  };
  std::array<Vec3, 4> p;
  Vec3 scale;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t order = 0; order < 4; ++order) p[order][axis] = value(fmt::format("X{}_{}", order, axis), 0.0);
    scale[axis] = value(fmt::format("SCL_{}", axis), 1.0);
  }
  p = moved(p, sim::kReferenceTemp_degC - value("TREF", sim::kReferenceTemp_degC));
  const std::string id = w.sensor, unit = w.unit;
  sim::TriadConfig t;
  t.bias = p[0];
  t.matrix = scale.asDiagonal();
  for (Vec3& c : p) c = c.cwiseProduct(scale);  // an effect acts on the true value, before the matrix
  if (p[2].isZero(0.0)) {
    add_effect(out.simulation, id + "_temp_lin", "k_" + unit + "_per_K", p[1]);
  } else {
    add_effect(out.simulation, id + "_temp_quad", "k2_" + unit + "_per_K2", p[2]);
    out.simulation.effects.back().parameters["k1_" + unit + "_per_K"] = {p[1][0], p[1][1], p[1][2]};
  }
  if (!p[3].isZero(0.0)) {
    sim::EffectConfig law;
    law.id = std::string(sim::kLawPrefix) + "(T - 25)^3";
    law.parameters["k"] = {p[3][0], p[3][1], p[3][2]};
    law.sensors = {w.letter == 'A' ? sim::Sensor::kAcc : sim::Sensor::kGyr};
    out.simulation.effects.push_back(std::move(law));
  }
  if (values.contains(fmt::format("TC_{}0_TMIN", w.letter)))
    out.lost.push_back(fmt::format("TC_{0}0_TMIN and TC_{0}0_TMAX: the range of the polynomial", w.letter));
  return t;
}

}  // namespace

Result<ReadParameters> read_px4(const std::string& text, const std::string& name) {
  const auto values = values_in(text);
  ReadParameters out;
  for (const Words& w : kWords) {
    const std::string prefix = fmt::format("TC_{}0_", w.letter);
    const auto at = values.lower_bound(prefix);
    if (at == values.end() || !at->first.starts_with(prefix)) continue;
    (w.letter == 'A' ? out.simulation.accelerometer : out.simulation.gyroscope) = read_triad(values, w, out);
  }
  if (!out.simulation.accelerometer && !out.simulation.gyroscope)
    return fail(ErrorKind::kBadData, name + ": there is no TC_A0_ or TC_G0_ parameter in it");
  for (const auto& [key, value] : values)
    if (key.size() > 5 && key[3] != 'B' && std::isdigit(static_cast<unsigned char>(key[4])) != 0 && key[4] != '0') {
      out.lost.emplace_back("the parameters of further sensors (TC_A1_, ...)");
      break;
    }
  out.lost.emplace_back("noise, which PX4 does not hold");
  return out;
}

WrittenParameters write_px4(const sim::SimulationConfig& s) {
  WrittenParameters out;
  std::vector<std::string> held;
  const auto line = [&](const std::string& name, double value, int type) {
    out.text += fmt::format("1\t1\t{}\t{}\t{}\n", name, value, type);
  };
  for (const Words& w : kWords) {
    const auto& triad = w.letter == 'A' ? s.accelerometer : s.gyroscope;
    if (!triad) continue;
    const std::string id = w.sensor, unit = w.unit, prefix = fmt::format("TC_{}0_", w.letter);
    const sim::EffectConfig *linear = entry_of(s, id + "_temp_lin"), *square = entry_of(s, id + "_temp_quad");
    held.insert(held.end(), {id + "_temp_lin", id + "_temp_quad"});
    const Mat3 M = of_readings(*triad);
    const Vec3 k1 = three(linear, "k_" + unit + "_per_K") + three(square, "k1_" + unit + "_per_K");
    const std::array<Vec3, 4> p{triad->bias, M * k1, M * three(square, "k2_" + unit + "_per_K2"), Vec3::Zero()};
    line(fmt::format("TC_{}_ENABLE", w.letter), 1, 6);
    line(prefix + "TREF", sim::kReferenceTemp_degC, 9);
    for (int axis = 0; axis < 3; ++axis) {
      line(fmt::format("{}SCL_{}", prefix, axis), triad->matrix(axis, axis), 9);
      for (std::size_t order = 0; order < 4; ++order)
        line(fmt::format("{}X{}_{}", prefix, order, axis), p[order][axis], 9);
    }
    const std::string name = w.letter == 'A' ? "accelerometer" : "gyroscope";
    if (!triad->matrix.isDiagonal(1e-9)) out.lost.push_back(name + ": misalignment");
    if (triad->noise_sd > 0 || triad->random_walk_per_sqrts > 0 || triad->bias_instability > 0)
      out.lost.push_back(name + ": noise");
    out.lost.push_back(name + ": TMIN and TMAX, set them to the range that you have measured");
  }
  if (s.magnetometer) out.lost.emplace_back("magnetometer");
  lose_effects(s, held, out.lost);
  return out;
}

}  // namespace stillpoint::exchange::parameters
