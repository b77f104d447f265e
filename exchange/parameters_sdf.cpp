/// <imu> of SDF: per axis a Gaussian with a mean, and a bias that walks. Gazebo adds the noise sample by sample, and
/// draws the sign of bias_mean anew at each start; an offset that is known stands in mean.
#include <fmt/format.h>
#include <tinyxml2.h>

#include <cmath>

#include "exchange/parameters_of.h"

namespace stillpoint::exchange::parameters {
namespace {

using tinyxml2::XMLElement;

constexpr double kForever_s = 1e6;  // a walk is a Markov process that forgets nothing: its rate is the same
constexpr double kForgets_s = 3600.0;

double number_in(const XMLElement& e, const char* key) {
  const XMLElement* child = e.FirstChildElement(key);
  return child == nullptr ? 0.0 : child->DoubleText(0.0);
}

const XMLElement* imu_in(const tinyxml2::XMLNode& node) {
  for (const XMLElement* e = node.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    if (std::string(e->Name()) == "imu") return e;
    if (const XMLElement* inner = imu_in(*e)) return inner;
  }
  return nullptr;
}

void read_axis(const XMLElement& noise, int axis, const std::string& where, sim::TriadConfig& t, Vec3& sd, Vec3& steps,
               std::vector<std::string>& lost) {
  t.bias[axis] = number_in(noise, "mean") + number_in(noise, "bias_mean");
  if (number_in(noise, "bias_mean") != 0.0) lost.push_back(where + ": the sign of bias_mean, drawn anew at each start");
  if (number_in(noise, "bias_stddev") != 0.0) lost.push_back(where + ": bias_stddev, a bias drawn anew at each start");
  sd[axis] = number_in(noise, "stddev");
  steps[axis] = number_in(noise, "precision");
  const double walk = number_in(noise, "dynamic_bias_stddev"), tau = number_in(noise, "dynamic_bias_correlation_time");
  t.random_walk_per_sqrts = std::max(t.random_walk_per_sqrts, walk);
  if (walk != 0.0 && tau < kForgets_s) lost.push_back(where + ": dynamic_bias_correlation_time, the walk is free");
}

std::optional<sim::TriadConfig> read_triad(const XMLElement& imu, const char* element, const std::string& id,
                                           const std::string& key, ReadParameters& out) {
  const XMLElement* triad = imu.FirstChildElement(element);
  if (triad == nullptr) return std::nullopt;
  sim::TriadConfig t;
  Vec3 sd = Vec3::Zero(), steps = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const XMLElement* e = triad->FirstChildElement(std::array{"x", "y", "z"}[static_cast<std::size_t>(axis)]);
    const XMLElement* noise = e == nullptr ? nullptr : e->FirstChildElement("noise");
    if (noise != nullptr) read_axis(*noise, axis, fmt::format("{} {}", element, "xyz"[axis]), t, sd, steps, out.lost);
  }
  t.noise_sd = sd.mean();
  if (t.noise_sd > 0) t.noise_axes = sd / t.noise_sd;
  add_effect(out.simulation, id, key, steps);
  return t;
}

std::string axis_text(const sim::TriadConfig& t, int axis, double precision) {
  std::string walk;
  if (t.random_walk_per_sqrts > 0)
    walk = fmt::format(
        "\n          <dynamic_bias_stddev>{}</dynamic_bias_stddev>\n"
        "          <dynamic_bias_correlation_time>{}</dynamic_bias_correlation_time>",
        t.random_walk_per_sqrts, kForever_s);
  if (precision > 0) walk += fmt::format("\n          <precision>{}</precision>", precision);
  return fmt::format(
      "      <{0}>\n        <noise type=\"gaussian\">\n          <mean>{1}</mean>\n          <stddev>{2}</stddev>{3}\n"
      "        </noise>\n      </{0}>\n",
      "xyz"[axis], t.bias[axis], t.noise_sd * t.noise_axes[axis], walk);
}

}  // namespace

Result<ReadParameters> read_sdf(const std::string& text, const std::string& name) {
  tinyxml2::XMLDocument document;
  if (document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS)
    return fail(ErrorKind::kBadData,
                fmt::format("{}:{}: no XML: {}", name, document.ErrorLineNum(), document.ErrorName()));
  const XMLElement* imu = imu_in(document);
  if (imu == nullptr) return fail(ErrorKind::kBadData, name + ": there is no <imu> in it");
  ReadParameters out;
  const XMLElement* sensor = imu->Parent() == nullptr ? nullptr : imu->Parent()->ToElement();
  if (sensor != nullptr)
    if (const double rate = number_in(*sensor, "update_rate"); rate > 0) out.simulation.rate_hz = rate;
  out.simulation.gyroscope = read_triad(*imu, "angular_velocity", "gyr_quant", "q_radps", out);
  out.simulation.accelerometer = read_triad(*imu, "linear_acceleration", "acc_quant", "q_mps2", out);
  if (imu->FirstChildElement("orientation_reference_frame") != nullptr)
    out.lost.emplace_back("orientation_reference_frame");
  return out;
}

WrittenParameters write_sdf(const sim::SimulationConfig& s) {
  WrittenParameters out;
  out.text = fmt::format("<sensor name=\"imu\" type=\"imu\">\n  <update_rate>{}</update_rate>\n  <imu>\n", s.rate_hz);
  std::vector<std::string> held{"acc_quant", "gyr_quant"};
  for (const Part& p : {parts_of(s)[1], parts_of(s)[0]}) {
    if (!*p.triad) continue;
    const sim::TriadConfig& t = **p.triad;
    const bool gyr = p.sensor == sim::Sensor::kGyr;
    const Vec3 step = gyr ? three(entry_of(s, "gyr_quant"), "q_radps") : three(entry_of(s, "acc_quant"), "q_mps2");
    const char* element = gyr ? "angular_velocity" : "linear_acceleration";
    out.text += fmt::format("    <{}>\n", element);
    for (int axis = 0; axis < 3; ++axis) out.text += axis_text(t, axis, step[axis]);
    out.text += fmt::format("    </{}>\n", element);
    if (!t.matrix.isIdentity(1e-9)) out.lost.push_back(std::string(p.name) + ": matrix (scale and misalignment)");
    if (t.bias_instability > 0) out.lost.push_back(std::string(p.name) + ": bias_instability");
    if (t.noise_band_hz > 0) out.lost.push_back(std::string(p.name) + ": noise_band_hz, the noise is white");
  }
  out.text += "  </imu>\n</sensor>\n";
  if (s.magnetometer) out.lost.emplace_back("magnetometer: a sensor of its own in SDF");
  lose_effects(s, held, out.lost);
  return out;
}

}  // namespace stillpoint::exchange::parameters
