/// Kalibr's imu.yaml: densities per square root of hertz, of which a sample has density times the root of the rate; in
/// the scale-misalignment model the readings are M_acc f + B, and M_gyr C w + A f + B.
#include <fmt/format.h>

#include <Eigen/QR>
#include <cmath>

#include "exchange/parameters_of.h"
#include "io/yaml.h"

namespace stillpoint::exchange::parameters {
namespace {

std::string rows(const Mat3& m, const std::string& indent) {
  std::string out;
  for (Eigen::Index i = 0; i < 3; ++i) out += fmt::format("\n{}- [{}, {}, {}]", indent, m(i, 0), m(i, 1), m(i, 2));
  return out;
}

/// Three rows of three; nothing where it is not there.
std::optional<Mat3> matrix_in(const YAML::Node& map, const char* key) {
  const YAML::Node m = map[key];
  if (!m || !m.IsSequence() || m.size() != 3) return std::nullopt;
  Mat3 out;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!m[i].IsSequence() || m[i].size() != 3) return std::nullopt;
    for (std::size_t k = 0; k < 3; ++k)
      out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = m[i][k].as<double>();
  }
  return out;
}

/// A lower triangle with a positive diagonal, and a rotation: M = L C.
std::pair<Mat3, Mat3> lower_and_rotation(const Mat3& M) {
  const Eigen::HouseholderQR<Mat3> qr(M.transpose());
  Mat3 Q = qr.householderQ(), R = qr.matrixQR().triangularView<Eigen::Upper>();
  for (Eigen::Index i = 0; i < 3; ++i)
    if (R(i, i) < 0) R.row(i) *= -1.0, Q.col(i) *= -1.0;
  return {R.transpose(), Q.transpose()};
}

Result<ReadParameters> read_map(const YAML::Node& all, const std::string& name) {
  const YAML::Node map = all["imu0"] ? all["imu0"] : all;
  if (!map["update_rate"]) return fail(ErrorKind::kBadData, name + ": there is no update_rate in it");
  ReadParameters out;
  out.simulation.rate_hz = map["update_rate"].as<double>();
  const double root = std::sqrt(out.simulation.rate_hz);
  const auto triad = [&](const std::string& key) {
    sim::TriadConfig t;
    if (const YAML::Node d = map[key + "_noise_density"]) t.noise_sd = d.as<double>() * root;
    if (const YAML::Node k = map[key + "_random_walk"]) t.random_walk_per_sqrts = k.as<double>();
    return t;
  };
  sim::TriadConfig acc = triad("accelerometer"), gyr = triad("gyroscope");
  if (const YAML::Node a = map["accelerometers"])
    if (const auto M = matrix_in(a, "M")) acc.matrix = M->inverse();
  if (const YAML::Node g = map["gyroscopes"]) {
    const Mat3 M = matrix_in(g, "M").value_or(Mat3::Identity());
    gyr.matrix = (M * matrix_in(g, "C_gyro_i").value_or(Mat3::Identity())).inverse();
    const Mat3 A = gyr.matrix * matrix_in(g, "A").value_or(Mat3::Zero());  // ours stands before the matrix
    if (!A.isZero(0.0)) {
      sim::EffectConfig e;
      e.id = "gyr_gsens";
      for (Eigen::Index i = 0; i < 9; ++i) e.parameters["G_radps_per_mps2"].push_back(A(i / 3, i % 3));
      out.simulation.effects.push_back(std::move(e));
    }
  }
  for (const char* key : {"T_i_b", "time_offset"})
    if (map[key]) out.lost.emplace_back(key);
  out.simulation.accelerometer = acc, out.simulation.gyroscope = gyr;
  return out;
}

}  // namespace

Result<ReadParameters> read_kalibr(const std::string& text, const std::string& name) {
  const auto all = io::parse_yaml(text, name);
  if (!all) return tl::unexpected(all.error());
  try {
    return read_map(*all, name);
  } catch (const YAML::Exception& e) {
    return fail(ErrorKind::kBadData, fmt::format("{}:{}:{}: {}", name, e.mark.line + 1, e.mark.column + 1, e.msg));
  }
}

WrittenParameters write_kalibr(const sim::SimulationConfig& s) {
  WrittenParameters out;
  out.text = fmt::format("rostopic: /imu0\nupdate_rate: {}\nmodel: scale-misalignment\n", s.rate_hz);
  std::vector<std::string> held;
  for (const Part& p : parts_of(s)) {
    if (!*p.triad || p.sensor == sim::Sensor::kMag) continue;
    const sim::TriadConfig& t = **p.triad;
    const std::string name = p.name;
    out.text += fmt::format("{0}_noise_density: {1}\n{0}_random_walk: {2}\n", name,
                            t.noise_sd * t.noise_axes.mean() / std::sqrt(s.rate_hz), t.random_walk_per_sqrts);
    const auto [M, C] = lower_and_rotation(of_readings(t));
    out.text += fmt::format("{}s:\n  M:{}\n", name, rows(M, "    "));
    if (p.sensor == sim::Sensor::kGyr) {
      Mat3 G = Mat3::Zero();
      if (const sim::EffectConfig* e = entry_of(s, "gyr_gsens")) {
        const std::vector<double>& g = e->parameters.at("G_radps_per_mps2");
        for (Eigen::Index i = 0; i < 9; ++i) G(i / 3, i % 3) = g[static_cast<std::size_t>(i)];
        held.emplace_back("gyr_gsens");
      }
      out.text += fmt::format("  A:{}\n  C_gyro_i:{}\n", rows(of_readings(t) * G, "    "), rows(C, "    "));
    } else if (!C.isIdentity(1e-9)) {
      out.lost.push_back(name + ": the rotation in its matrix; Kalibr's body is its accelerometer's");
    }
    if (!t.bias.isZero(0.0)) out.lost.push_back(name + ": bias, which Kalibr estimates anew");
    if (!t.noise_axes.isApproxToConstant(t.noise_axes[0], 1e-9))
      out.lost.push_back(name + ": noise_axes, their mean stands");
    if (t.bias_instability > 0) out.lost.push_back(name + ": bias_instability");
    if (t.noise_band_hz > 0) out.lost.push_back(name + ": noise_band_hz, the noise is white");
  }
  if (s.magnetometer) out.lost.emplace_back("magnetometer");
  lose_effects(s, held, out.lost);
  return out;
}

}  // namespace stillpoint::exchange::parameters
