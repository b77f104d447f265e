/// A simulation's configuration as YAML that reads back to the same.
#include <algorithm>

#include "io/simulation_yaml.h"
#include "io/text_file.h"
#include "simulation/law_effect.h"

namespace stillpoint::io {
namespace {

using sim::EffectConfig;
using sim::SimulationConfig;
using sim::TriadConfig;

std::string number(double x) { return fmt::format("{}", x); }  // the shortest that reads back to the same

template <class Values>
std::string list(const Values& values) {
  std::string out = "[";
  for (const double x : values) out += (out.size() > 1 ? ", " : "") + number(x);
  return out + "]";
}

std::string list(const Vec3& v) { return list(array(v)); }
std::string matrix(const Mat3& m) {
  std::string out = "[";
  for (int row = 0; row < 3; ++row) out += (row > 0 ? ", " : "") + list(Vec3(m.row(row)));
  return out + "]";
}

std::string emit(double x) { return number(x); }
std::string emit(int x) { return fmt::format("{}", x); }
std::string emit(const std::string& x) { return x; }
std::string emit(const Vec3& x) { return list(x); }
template <HasFields P>
std::string emit(const P& value);
template <HasFields P>
std::string emit(const std::vector<P>& values) {
  std::string out;
  for (const P& v : values) out += (out.empty() ? "" : ", ") + emit(v);
  return "[" + out + "]";
}
/// Flow map of the fields that differ from their defaults.
template <HasFields P>
std::string emit(const P& value) {
  const P plain;
  std::string out;
  const auto one = [&](const auto& f) {
    const std::string text = emit(value.*(f.member));
    if (f.name == "kind" || text != emit(plain.*(f.member)))
      out += fmt::format("{}{}: {}", out.empty() ? "" : ", ", f.name, text);
  };
  std::apply([&](const auto&... f) { (one(f), ...); }, P::fields());
  return "{" + out + "}";
}

std::string format_triad(const TriadConfig& t, const std::string& unit) {
  std::string out = fmt::format("{{{}, noise_{}: {}", format_numbers(t), unit, number(t.noise_sd));
  if (t.noise_axes != Vec3::Ones()) out += ", noise_axes: " + list(t.noise_axes);
  const auto add = [&out](const std::string& key, double value) {
    if (value != 0.0) out += fmt::format(", {}: {}", key, number(value));
  };
  add("noise_band_hz", t.noise_band_hz);
  add("bias_instability_" + unit, t.bias_instability);
  add("random_walk_" + unit + "_per_sqrts", t.random_walk_per_sqrts);
  add("rate_hz", t.rate_hz);
  return out + "}";
}

}  // namespace

std::string format_numbers(const TriadConfig& t) {
  return fmt::format("bias: {}, matrix: {}", list(t.bias), matrix(t.matrix));
}

std::string format_effect(const EffectConfig& e) {
  if (sim::is_law(e) || sim::is_table(e)) return format_written_effect(e);
  std::string out = "{effect: " + e.id;
  for (const auto& [key, values] : e.parameters) {
    if (values.size() == 1) {
      out += fmt::format(", {}: {}", key, number(values[0]));
    } else if (values.size() == 9) {
      Array9 m{};
      std::copy(values.begin(), values.end(), m.begin());
      out += fmt::format(", {}: {}", key, matrix(mat(m)));
    } else {
      out += fmt::format(", {}: {}", key, list(values));
    }
  }
  std::vector<std::string> axes, sensors;
  for (const int axis : e.axes) axes.emplace_back(1, "xyz"[axis]);
  for (const sim::Sensor s : e.sensors) sensors.emplace_back(sim::prefix(s));
  if (!axes.empty()) out += fmt::format(", axes: [{}]", fmt::join(axes, ", "));
  if (!sensors.empty()) out += fmt::format(", sensors: [{}]", fmt::join(sensors, ", "));
  if (e.window_s) out += fmt::format(", window_s: [{}, {}]", number(e.window_s->first), number(e.window_s->second));
  return out + "}";
}

std::string format_simulation(const SimulationConfig& c) {
  std::string out = fmt::format("rate_hz: {}\ngravity_mps2: {}\nfield_world_uT: {}\n", number(c.rate_hz),
                                number(c.gravity_mps2), list(c.field_world_uT));
  const auto add_triad = [&out](const char* key, const std::optional<TriadConfig>& triad, const char* unit) {
    if (triad) out += fmt::format("{}: {}\n", key, format_triad(*triad, unit));
  };
  add_triad("accelerometer", c.accelerometer, "mps2");
  add_triad("gyroscope", c.gyroscope, "radps");
  add_triad("magnetometer", c.magnetometer, "uT");
  out += c.effects.empty() ? "effects: []\n" : "effects:\n";
  for (const auto& e : c.effects) out += "  - " + format_effect(e) + "\n";
  if (c.motion) out += "motion: " + emit(*c.motion) + "\n";
  const auto block = [&out](const char* key, const std::string& text, const std::string& plain) {
    if (text != plain) out += fmt::format("{}: {}\n", key, text);
  };
  block("environment", emit(c.environment), emit(sim::EnvironmentConfig{}));
  block("timing", emit(c.timing), emit(sim::TimingConfig{}));
  // Said at all, it is said again: a diagnosis holds the reference to it. A latency alone says nothing of its errors.
  sim::ReferenceConfig on_time = c.reference;
  on_time.latency_s = 0.0;
  if (c.reference.stated || emit(on_time) != emit(sim::ReferenceConfig{}))
    block("reference", emit(c.reference), {});
  else if (c.reference.latency_s != 0.0)
    out += fmt::format("reference: {{latency_s: {}}}\n", number(c.reference.latency_s));
  return out;
}

Result<void> write_simulation(const SimulationConfig& config, const std::string& path) {
  return write_text_file(path, format_simulation(config));
}

}  // namespace stillpoint::io
