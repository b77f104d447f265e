/// The YAML of the ROS package imu_calib: of the accelerometer, force = SM reading - bias, SM by rows.
#include <fmt/format.h>

#include "exchange/parameters_of.h"
#include "io/yaml.h"

namespace stillpoint::exchange::parameters {

Result<ReadParameters> read_imu_calib(const std::string& text, const std::string& name) {
  const auto all = io::parse_yaml(text, name);
  if (!all) return tl::unexpected(all.error());
  io::YamlFaults faults(name);
  std::vector<double> matrix, bias;
  for (const auto& [key, values, count] :
       {std::tuple("SM", &matrix, std::size_t{9}), std::tuple("bias", &bias, std::size_t{3})}) {
    if (const YAML::Node node = (*all)[key]) io::read_value(node, *values, {}, key, faults);
    if (faults.empty() && values->size() != count)
      faults.add(*all, fmt::format("{}: {} numbers are needed", key, count));
  }
  if (!faults.empty()) return faults.error();
  sim::TriadConfig t;
  for (Eigen::Index i = 0; i < 9; ++i) t.matrix(i / 3, i % 3) = matrix[static_cast<std::size_t>(i)];
  if (!(std::abs(t.matrix.determinant()) > 0.0)) return fail(ErrorKind::kBadData, name + ": SM has no inverse");
  t.bias = t.matrix.inverse() * Vec3(bias[0], bias[1], bias[2]);
  ReadParameters out;
  out.simulation.accelerometer = t;
  return out;
}

WrittenParameters write_imu_calib(const sim::SimulationConfig& s) {
  WrittenParameters out;
  for (const Part& p : parts_of(s))
    if (*p.triad && p.sensor != sim::Sensor::kAcc) out.lost.emplace_back(p.name);
  lose_effects(s, {}, out.lost);
  if (!s.accelerometer) return out;
  const Mat3& H = s.accelerometer->matrix;
  const Vec3 bias = H * s.accelerometer->bias;
  out.text = "SM:\n";
  for (Eigen::Index i = 0; i < 9; ++i) out.text += fmt::format("  - {}\n", H(i / 3, i % 3));
  out.text += "bias:\n";
  for (const double b : bias) out.text += fmt::format("  - {}\n", b);
  if (s.accelerometer->noise_sd > 0) out.lost.emplace_back("accelerometer: noise");
  return out;
}

}  // namespace stillpoint::exchange::parameters
