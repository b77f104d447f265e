/// The calibration of a real sensor, as `stillpoint calibrate --output` writes it and the daemon takes it: the
/// `sensor:` of a configuration. Behind its bias and matrix stand the same numbers as in a simulation; the temperature
/// terms are kept as effects, which act on the true value, before the matrix.
#include <fmt/format.h>

#include "exchange/parameters_of.h"
#include "io/triad_factory.h"
#include "io/yaml.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::exchange::parameters {
namespace {

const char* unit_of(sim::Sensor sensor) {
  return sensor == sim::Sensor::kAcc ? "mps2" : sensor == sim::Sensor::kGyr ? "radps" : "uT";
}

sim::TriadConfig triad_of(const io::TriadFactory& f, sim::Sensor sensor, ReadParameters& out) {
  const double shift = sim::kReferenceTemp_degC - f.temp_ref_degC;
  sim::TriadConfig t;
  t.bias = f.bias + shift * (f.bias_per_K + shift * f.bias_per_K2);
  t.matrix = f.matrix;
  const std::string id = sim::prefix(sensor), unit = unit_of(sensor);
  const Vec3 k1 = f.matrix * (f.bias_per_K + 2.0 * shift * f.bias_per_K2), k2 = f.matrix * f.bias_per_K2;
  if (k2.isZero(0.0)) {
    add_effect(out.simulation, id + "_temp_lin", "k_" + unit + "_per_K", k1);
  } else if (sensor == sim::Sensor::kMag) {
    add_effect(out.simulation, id + "_temp_lin", "k_" + unit + "_per_K", k1);
    out.lost.emplace_back("magnetometer: bias_per_K2");
  } else {
    add_effect(out.simulation, id + "_temp_quad", "k2_" + unit + "_per_K2", k2);
    out.simulation.effects.back().parameters["k1_" + unit + "_per_K"] = {k1[0], k1[1], k1[2]};
  }
  return t;
}

}  // namespace

Result<ReadParameters> read_sensor(const std::string& text, const std::string& name) {
  const auto all = io::parse_yaml(text, name);
  if (!all) return tl::unexpected(all.error());
  const YAML::Node sensor = (*all)["sensor"];
  if (!sensor || !sensor.IsMap()) return fail(ErrorKind::kBadData, name + ": there is no sensor: in it");
  ReadParameters out;
  io::YamlFaults faults(name);
  const auto read = [&](const char* key, sim::Sensor which, std::optional<sim::TriadConfig>& triad) {
    if (!sensor[key]) return;
    io::TriadFactory factory;
    io::read_fields(sensor[key], factory, faults);
    if (!(std::abs(factory.matrix.determinant()) > 0.0))
      faults.add(sensor[key], std::string(key) + ": its matrix has no inverse");
    else
      triad = triad_of(factory, which, out);
    if (factory.temp_min_degC < factory.temp_max_degC)
      out.lost.push_back(fmt::format("{}: the range of its temperature, {} to {} degC", key, factory.temp_min_degC,
                                     factory.temp_max_degC));
  };
  read("accelerometer", sim::Sensor::kAcc, out.simulation.accelerometer);
  read("gyroscope", sim::Sensor::kGyr, out.simulation.gyroscope);
  read("magnetometer", sim::Sensor::kMag, out.simulation.magnetometer);
  if (!faults.empty()) return faults.error();
  for (const char* key : {"id", "limits"})
    if (sensor[key]) out.lost.emplace_back(key);
  out.lost.emplace_back("deviations, which stand in the state");
  return out;
}

WrittenParameters write_sensor(const sim::SimulationConfig& s) {
  WrittenParameters out;
  out.text = "sensor:\n";
  std::vector<std::string> held;
  for (const Part& p : parts_of(s)) {
    if (!*p.triad) continue;
    const sim::TriadConfig& t = **p.triad;
    const std::string id = sim::prefix(p.sensor), unit = unit_of(p.sensor), name = p.name;
    const sim::EffectConfig *linear = entry_of(s, id + "_temp_lin"), *square = entry_of(s, id + "_temp_quad");
    held.insert(held.end(), {id + "_temp_lin", id + "_temp_quad"});
    const Mat3 M = of_readings(t);
    const Vec3 k1 = three(linear, "k_" + unit + "_per_K") + three(square, "k1_" + unit + "_per_K");
    const Vec3 k2 = three(square, "k2_" + unit + "_per_K2");
    const io::TriadFactory factory{.bias = t.bias, .bias_per_K = M * k1, .bias_per_K2 = M * k2, .matrix = t.matrix};
    out.text += "  " + name + ":\n" + io::format_fields(factory);
    if (linear != nullptr || square != nullptr)
      out.lost.push_back(name + ": temp_min_degC and temp_max_degC, set them to the range that was measured");
    if (t.noise_sd > 0 || t.random_walk_per_sqrts > 0 || t.bias_instability > 0) out.lost.push_back(name + ": noise");
  }
  lose_effects(s, held, out.lost);
  return out;
}

}  // namespace stillpoint::exchange::parameters
