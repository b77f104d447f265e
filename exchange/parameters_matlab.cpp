/// JSON of MATLAB's imuSensor (loadparams): SI units and uT, misalignment and scale factors in percent. Its noise is
/// drawn with NoiseDensity sqrt(rate) a sample ("double-sided", the default), its random walk with RandomWalk /
/// sqrt(rate).
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "exchange/parameters_of.h"

namespace stillpoint::exchange::parameters {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kPercent = 0.01;

struct MatlabWords {
  const char *element, *sensor, *unit;
};
constexpr std::array<MatlabWords, 3> kMatlabWords{
    {{"Accelerometer", "acc", "mps2"}, {"Gyroscope", "gyr", "radps"}, {"Magnetometer", "mag", "uT"}}};

Json list(const Vec3& v) { return {v[0], v[1], v[2]}; }

Vec3 vector_in(const Json& j, const char* key) {
  if (!j.contains(key)) return Vec3::Zero();
  const Json& v = j[key];
  if (v.is_number()) return Vec3::Constant(v.get<double>());
  return v.is_array() && v.size() == 3 && v[0].is_number() ? Vec3(v[0], v[1], v[2]) : Vec3(Vec3::Zero());
}

/// The matrix of readings; a vector is what each axis leans into the two others.
Mat3 misalignment_in(const Json& j) {
  Mat3 m = Mat3::Identity();
  if (!j.contains("AxesMisalignment")) return m;
  const Json& v = j["AxesMisalignment"];
  if (v.is_array() && v.size() == 3 && v[0].is_array()) {
    for (Eigen::Index i = 0; i < 3; ++i)
      for (Eigen::Index k = 0; k < 3; ++k)
        m(i, k) = kPercent * v[static_cast<std::size_t>(i)].at(static_cast<std::size_t>(k)).get<double>();
    return m;
  }
  const Vec3 lean = vector_in(j, "AxesMisalignment");
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index k = 0; k < 3; ++k)
      if (i != k) m(i, k) = kPercent * lean[k];
  return m;
}

sim::TriadConfig read_triad(const Json& j, const MatlabWords& w, ReadParameters& out) {
  sim::TriadConfig t;
  t.bias = vector_in(j, "ConstantBias");
  t.matrix = misalignment_in(j).inverse();
  double rate = out.simulation.rate_hz;
  if (j.value("NoiseType", std::string("double-sided")) == "single-sided") rate /= 2.0;
  const Vec3 density = vector_in(j, "NoiseDensity");
  t.noise_sd = density.mean() * std::sqrt(rate);
  if (density.mean() > 0) t.noise_axes = density / density.mean();
  t.bias_instability = vector_in(j, "BiasInstability").mean();
  t.random_walk_per_sqrts = vector_in(j, "RandomWalk").mean();
  sim::SimulationConfig& s = out.simulation;
  const std::string id = w.sensor, unit = w.unit;
  add_effect(s, id + "_temp_lin", "k_" + unit + "_per_K", vector_in(j, "TemperatureBias"));
  add_effect(s, id + "_temp_scale", "S_per_K", kPercent * vector_in(j, "TemperatureScaleFactor"));
  add_effect(s, id + "_quant", "q_" + unit, vector_in(j, "Resolution"));
  if (j.contains("MeasurementRange") && j["MeasurementRange"].is_number())
    add_effect(s, id + "_sat", "L_" + unit, vector_in(j, "MeasurementRange"));
  if (const Vec3 g = vector_in(j, "AccelerationBias"); !g.isZero(0.0)) {
    sim::EffectConfig e;
    e.id = "gyr_gsens";
    e.parameters["G_radps_per_mps2"] = {g[0], 0, 0, 0, g[1], 0, 0, 0, g[2]};
    s.effects.push_back(std::move(e));
  }
  return t;
}

/// The element that holds the sensors: at the top, or under the name of a part.
const Json* part_in(const Json& all) {
  for (const MatlabWords& w : kMatlabWords)
    if (all.contains(w.element)) return &all;
  for (const auto& [name, part] : all.items())
    if (part.is_object())
      for (const MatlabWords& w : kMatlabWords)
        if (part.contains(w.element)) return &part;
  return nullptr;
}

Result<ReadParameters> read_all(const Json& all, const std::string& name) {
  const Json* part = all.is_object() ? part_in(all) : nullptr;
  if (part == nullptr)
    return fail(ErrorKind::kBadData, name + ": neither Accelerometer nor Gyroscope nor Magnetometer is in it");
  ReadParameters out;
  if (part->contains("SampleRate")) out.simulation.rate_hz = (*part)["SampleRate"].get<double>();
  std::array<std::optional<sim::TriadConfig>*, 3> triads{&out.simulation.accelerometer, &out.simulation.gyroscope,
                                                         &out.simulation.magnetometer};
  for (std::size_t k = 0; k < kMatlabWords.size(); ++k)
    if (part->contains(kMatlabWords[k].element))
      *triads[k] = read_triad((*part)[kMatlabWords[k].element], kMatlabWords[k], out);
  if (!part->contains("SampleRate")) out.lost.emplace_back("the rate: MATLAB keeps it outside; 100 Hz is taken");
  return out;
}

}  // namespace

Result<ReadParameters> read_matlab(const std::string& text, const std::string& name) {
  const Json all = Json::parse(text, nullptr, false);
  if (all.is_discarded()) return fail(ErrorKind::kBadData, name + ": no JSON");
  try {
    return read_all(all, name);
  } catch (const Json::exception& e) {  // a text where a number is wanted, a row that is too short
    return fail(ErrorKind::kBadData, fmt::format("{}: not as loadparams writes it: {}", name, e.what()));
  }
}

WrittenParameters write_matlab(const sim::SimulationConfig& s) {
  WrittenParameters out;
  Json part;
  std::vector<std::string> held;
  for (const Part& p : parts_of(s)) {
    if (!*p.triad) continue;
    const sim::TriadConfig& t = **p.triad;
    const MatlabWords& w = kMatlabWords[static_cast<std::size_t>(p.sensor)];
    const std::string id = w.sensor, unit = w.unit;
    const auto value = [&](const std::string& effect, const std::string& key) {
      held.push_back(id + effect);
      return three(entry_of(s, id + effect), key);
    };
    Json& j = part[w.element];
    if (const Vec3 limit = value("_sat", "L_" + unit); !limit.isZero(0.0)) j["MeasurementRange"] = limit.minCoeff();
    if (const sim::EffectConfig* e = entry_of(s, id + "_sat"); e != nullptr && e->parameters.contains("side"))
      out.lost.push_back(id + "_sat: side; MeasurementRange is of both signs");
    j["Resolution"] = value("_quant", "q_" + unit).maxCoeff();
    j["ConstantBias"] = list(t.bias);
    Mat3 m = of_readings(t);
    const Vec3 size = m.colwise().norm();
    m = m * size.cwiseInverse().asDiagonal();
    j["AxesMisalignment"] = {list(100.0 * m.row(0)), list(100.0 * m.row(1)), list(100.0 * m.row(2))};
    if ((size - Vec3::Ones()).cwiseAbs().maxCoeff() > 1e-6)
      out.lost.push_back(std::string(p.name) + ": scale factors; columns of AxesMisalignment have size 100");
    j["NoiseDensity"] = list(t.noise_sd / std::sqrt(s.rate_hz) * t.noise_axes);
    j["NoiseType"] = "double-sided";
    j["BiasInstability"] = list(Vec3::Constant(t.bias_instability));
    j["RandomWalk"] = list(Vec3::Constant(t.random_walk_per_sqrts));
    j["TemperatureBias"] = list(value("_temp_lin", "k_" + unit + "_per_K"));
    j["TemperatureScaleFactor"] = list(100.0 * value("_temp_scale", "S_per_K"));
    if (t.noise_band_hz > 0) out.lost.push_back(std::string(p.name) + ": noise_band_hz, the noise is white");
    const sim::EffectConfig* g = p.sensor == sim::Sensor::kGyr ? entry_of(s, "gyr_gsens") : nullptr;
    if (g == nullptr) continue;
    const Mat3 G =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(g->parameters.at("G_radps_per_mps2").data());
    j["AccelerationBias"] = list(G.diagonal());
    held.emplace_back("gyr_gsens");
    if (!G.isDiagonal(1e-12)) out.lost.emplace_back("gyr_gsens: its entries off the diagonal");
  }
  lose_effects(s, held, out.lost);
  out.text = Json{{"stillpoint", part}}.dump(2) + "\n";
  return out;
}

}  // namespace stillpoint::exchange::parameters
