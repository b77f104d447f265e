#include "diagnosis/laws.h"

#include <fmt/format.h>

#include <cmath>

#include "diagnosis/response.h"

namespace stillpoint::diag {
namespace {

const std::vector<std::string> kPerAxis{"k_x", "k_y", "k_z"};

std::vector<std::string> entries(const std::string& letter) {
  std::vector<std::string> names;
  for (const char* row : kAxisName)
    for (const char* column : kAxisName) names.push_back(fmt::format("{}_{}{}", letter, row, column));
  return names;
}

/// T - T_L with tau dT_L/dt = T - T_L, started in equilibrium.
Series lagged_difference(const Series& T, double dt_s, double tau_s) {
  Series out(T.size());
  double lagged = T.size() ? T[0] : 0.0;
  const double share = 1.0 - std::exp(-dt_s / tau_s);
  for (Eigen::Index i = 0; i < T.size(); ++i) {
    lagged += share * (T[i] - lagged);
    out[i] = T[i] - lagged;
  }
  return out;
}

/// What is left of x when an adaptive bias estimate, started at zero, follows it at rest with time constant tau and
/// holds in motion.
Series after_tracker(const Series& x, const Mask& rest, double dt_s, double tau_s) {
  Series out(x.size());
  double tracked = 0.0;
  const double share = 1.0 - std::exp(-dt_s / tau_s);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (rest[static_cast<std::size_t>(i)]) tracked += share * (x[i] - tracked);
    out[i] = x[i] - tracked;
  }
  return out;
}

Series3 world_vector(const Signals& s, const Vec3& v) {
  return v.x() * s.world_axis[0] + v.y() * s.world_axis[1] + v.z() * s.world_axis[2];
}

Columns coupled(std::initializer_list<Series3> parts) {
  Columns out;
  for (const auto& part : parts) out.push_back({-1, part});
  return out;
}

Columns world_fixed(const Signals& s) { return coupled({s.world_axis[0], s.world_axis[1], s.world_axis[2]}); }

/// omega' x e_j + omega x (omega x e_j)
Series3 lever_column(const Signals& s, int j) {
  Series3 out(s.n, 3);
  for (Eigen::Index i = 0; i < s.n; ++i) {
    const Vec3 w = s.rate.row(i), a = s.rate_dot.row(i), e = Vec3::Unit(j);
    out.row(i) = a.cross(e) + w.cross(w.cross(e));
  }
  return out;
}

Columns size_columns(const Signals& s) {
  Columns out;
  std::array<Series3, 3> lever{lever_column(s, 0), lever_column(s, 1), lever_column(s, 2)};
  for (int axis = 0; axis < 3; ++axis)
    for (const auto& column : lever) out.push_back({axis, column.col(axis)});
  return out;
}

/// R' G p with the nine entries of G free: a measured map need not be free of curl to be a gradient in the catalogue's
/// sense.
Columns gradient_columns(const Signals& s) {
  Columns out;
  for (int row = 0; row < 3; ++row)
    for (int c = 0; c < 3; ++c)
      out.push_back({-1, s.position_m.col(c).asDiagonal() * s.world_axis[static_cast<std::size_t>(row)]});
  return out;
}

Series3 at_rest_zero(const Signals& s, Series3 x) {
  for (Eigen::Index i = 0; i < s.n; ++i)
    if (s.rest[static_cast<std::size_t>(i)]) x.row(i).setZero();
  return x;
}

class LawList {
 public:
  LawList(const Signals& s, Sensor sensor) : s_(s), sensor_(sensor), prefix_(std::string(kSensorName[sensor]) + "_") {}

  Law& add(const std::string& id, std::function<Columns(double)> columns, std::vector<std::string> names,
           std::string unit, std::string equation, std::string driver) {
    Law law;
    law.id = id;
    law.columns = std::move(columns);
    law.coefficients = std::move(names);
    law.unit = std::move(unit);
    law.equation = std::move(equation);
    law.driver = std::move(driver);
    laws_.push_back(std::move(law));
    return laws_.back();
  }

  void thermal() {
    if (!s_.temperature_K.size()) return;
    const Signals& s = s_;
    const Sensor k = sensor_;
    const std::string u = kSensorUnit[k];
    add(
        prefix_ + "temp_lin", [&s](double) { return on_each_axis(s.temperature_K); }, kPerAxis, u + "/K",
        "delta = k (T - 25 degC)", "temperature");
    add(
        prefix_ + "temp_scale", [&s, k](double) { return diagonal(s.temperature_K.asDiagonal() * s.vector[k]); },
        {"S_x", "S_y", "S_z"}, "1/K", "delta = S (T - 25 degC) o true", "temperature times the measured vector");
    if (k == kMag) return;
    add(
        prefix_ + "temp_quad", [&s](double) { return on_each_axis(s.temperature_K.cwiseAbs2()); },
        {"k2_x", "k2_y", "k2_z"}, u + "/K^2", "delta = k2 (T - 25 degC)^2", "temperature squared");
    add(
        prefix_ + "temp_quad",
        [&s](double) {
          Columns c = on_each_axis(s.temperature_K), square = on_each_axis(s.temperature_K.cwiseAbs2());
          c.insert(c.end(), square.begin(), square.end());
          return c;
        },
        {"k1_x", "k1_y", "k1_z", "k2_x", "k2_y", "k2_z"}, u + "/K and " + u + "/K^2",
        "delta = k1 (T - 25 degC) + k2 (T - 25 degC)^2", "temperature and its square");
    Law& lag = add(
        prefix_ + "temp_lag",
        [&s](double tau) { return on_each_axis(lagged_difference(s.temperature_K, s.dt_s, tau)); }, kPerAxis, u + "/K",
        "delta = k (T - T_L), tau dT_L/dt = T - T_L", "rate of change of temperature");
    lag.shapes = {5.0, 10.0, 20.0, 40.0, 60.0};
    lag.shape_name = "tau";
    lag.shape_unit = "s";
  }

  /// The same physics behind an estimator that has already taken the slow part of it away.
  void thermal_behind_tracker() {
    if (!s_.temperature_K.size() || !s_.has_rest) return;
    const Signals& s = s_;
    const auto behind = [&](const std::string& id, const Series& x, const std::string& name, const std::string& unit) {
      Law& law = add(
          id, [&s, x](double tau) { return on_each_axis(after_tracker(x, s.rest, s.dt_s, tau)); },
          {name + "_x", name + "_y", name + "_z"}, unit,
          "delta = x - b, db/dt = (x - b) / tau at rest, x as without the estimator",
          "temperature, partly absorbed by an adaptive bias estimate");
      law.extent = Extent::kWhole;
      law.shapes = {3.0, 6.0, 10.0, 15.0, 22.0, 32.0, 50.0};
      law.shape_name = kTrackerShape;
      law.shape_unit = "s";
    };
    behind(prefix_ + "temp_lin", s.temperature_K, "k", std::string(kSensorUnit[sensor_]) + "/K");
    behind(prefix_ + "temp_quad", s.temperature_K.cwiseAbs2(), "k2", std::string(kSensorUnit[sensor_]) + "/K^2");
  }

  void nonlinear() {
    const Signals& s = s_;
    const Sensor k = sensor_;
    const std::string u = kSensorUnit[k];
    if (k == kAcc)
      add(
          "acc_quad", [&s](double) { return diagonal(s.vector[kAcc].cwiseAbs2()); }, kPerAxis, "1/(m/s^2)",
          "delta = k f o f", "specific force squared");
    add(
        k == kMag ? "mag_sat" : prefix_ + "cubic", [&s, k](double) { return diagonal(s.vector[k].array().cube()); },
        kPerAxis, "1/(" + u + ")^2", "delta = k true^3", "the measured vector cubed");
    if (k != kMag)
      add(
          prefix_ + "asym", [&s, k](double) { return diagonal(s.vector[k].cwiseAbs()); }, kPerAxis, "1",
          "delta = k |true|", "magnitude of each component");
  }

  void vibration() {
    const Signals& s = s_;
    if (s.vibration.rows() == 0) return;
    add(
        prefix_ + "vre", [&s](double) { return diagonal(s.vibration); }, kPerAxis,
        std::string(kSensorUnit[sensor_]) + " per (m/s^2)^2", "delta = k <f_hf^2> over 0.5 s", "vibration power");
  }

  void timing() {
    const Signals& s = s_;
    const Sensor k = sensor_;
    const auto slope = [&s, k](double) { return coupled({at_rest_zero(s, -derivative(s.vector[k], s.dt_s))}); };
    add(prefix_ + "delay", slope, {"tau"}, "s", "delta = true(t - tau) - true(t)",
        "first derivative of the measured vector")
        .kind = Kind::kTiming;
    Law& filter = add(
        prefix_ + (k == kMag ? "delay" : "resonance"),
        [&s, k](double) {
          return coupled({at_rest_zero(s, -derivative(s.vector[k], s.dt_s)),
                          at_rest_zero(s, second_derivative(s.vector[k], s.dt_s))});
        },
        {"c1", "c2"}, "s", "delta = -c1 d/dt + c2 d2/dt2", "first and second derivative of the measured vector");
    filter.kind = Kind::kTiming;
    Law& gap = add("sys_gap", slope, {"shift"}, "s", "delta = true(t - n/fs) - true(t) from t0 on",
                   "first derivative of the measured vector, from one moment on");
    gap.kind = Kind::kTiming;
    gap.extent = Extent::kStep;
    Law& skew = add(
        "sys_skew",
        [&s, k](double) {
          const Series3 d = at_rest_zero(s, derivative(s.vector[k], s.dt_s));
          return coupled({s.t_s.asDiagonal() * d});
        },
        {"epsilon"}, "1", "delta = true(t (1 + epsilon)) - true(t)", "time times the first derivative");
    skew.kind = Kind::kTiming;
    skew.extent = Extent::kWhole;
  }

  void supply() {
    const Signals& s = s_;
    if (!s.voltage_V.size() || sensor_ == kMag) return;
    add(
        prefix_ + "volt", [&s](double) { return on_each_axis(s.voltage_V.array() - s.voltage_V.mean()); }, kPerAxis,
        std::string(kSensorUnit[sensor_]) + "/V", "delta = k (V - V0)", "supply voltage");
  }

  void accelerometer() {
    const Signals& s = s_;
    if (s.has_position) {
      add(
          "acc_lever",
          [&s](double) {
            return coupled({lever_column(s, 0), lever_column(s, 1), lever_column(s, 2)});
          },
          {"r_x", "r_y", "r_z"}, "m", "delta = omega' x r + omega x (omega x r)",
          "angular acceleration and squared rate");
      add(
          "acc_size", [&s](double) { return size_columns(s); }, entries("r"), "m",
          "delta_i = [omega' x r_i + omega x (omega x r_i)]_i", "angular acceleration and squared rate, per axis");
      add(
          "acc_gravity", [&s](double) { return coupled({world_vector(s, Vec3::UnitZ())}); }, {"dg"}, "m/s^2",
          "delta = dg R' e_z", "attitude")
          .extent = Extent::kWhole;
    }
    Law& sat = add(
        "acc_sat",
        [&s](double level) { return coupled({s.vector[kAcc].cwiseMin(level).cwiseMax(-level) - s.vector[kAcc]}); },
        {"share"}, "1", "y = clip(y, +-L) before filtering", "specific force above a level");
    const double top = s.vector[kAcc].cwiseAbs().maxCoeff();
    sat.shapes = {0.6 * top, 0.7 * top, 0.8 * top, 0.9 * top};
    sat.shape_name = "L";
    sat.shape_unit = "m/s^2";
  }

  void gyroscope() {
    const Signals& s = s_;
    add(
        "gyr_gsens", [&s](double) { return matrix_of(s.vector[kAcc]); }, entries("G"), "rad/s per m/s^2", "delta = G f",
        "specific force");
    add(
        "gyr_earth", [&s](double) { return world_fixed(s); }, {"w_x", "w_y", "w_z"}, "rad/s", "delta = R' omega_earth",
        "attitude");
  }

  void magnetometer() {
    const Signals& s = s_;
    add(
        "mag_hard_step", [&s](double) { return on_each_axis(Series::Ones(s.n)); }, {"b_x", "b_y", "b_z"}, "uT",
        "delta = b from t0 on", "time, fixed in the body")
        .extent = Extent::kStep;
    add(
        "mag_field_step", [&s](double) { return world_fixed(s); }, {"b_x", "b_y", "b_z"}, "uT",
        "delta = R' b from t0 on", "time, fixed in the world")
        .extent = Extent::kStep;
    add(
        "mag_soft_step", [&s](double) { return matrix_of(s.vector[kMag]); }, entries("M"), "1",
        "delta = M m from t0 on", "time and the field")
        .extent = Extent::kStep;
    if (s.has_position)
      add(
          "mag_gradient", [&s](double) { return gradient_columns(s); }, entries("G"), "uT/m", "delta = R' G p",
          "position");
    if (s.current_A.size())
      add(
          "mag_current", [&s](double) { return on_each_axis(s.current_A); }, kPerAxis, "uT/A", "delta = k I",
          "current");
    Law& field = add(
        "field_world", [&s](double) { return world_fixed(s); }, {"d_x", "d_y", "d_z"}, "uT", "delta = R' d",
        "attitude, fixed in the world");
    field.kind = Kind::kConfiguration;
    field.extent = Extent::kWhole;
  }

  std::vector<Law> take() { return std::move(laws_); }

 private:
  const Signals& s_;
  Sensor sensor_;
  std::string prefix_;
  std::vector<Law> laws_;
};

}  // namespace

Columns on_each_axis(const Series& x) { return {{0, x}, {1, x}, {2, x}}; }

Columns diagonal(const Series3& x) { return {{0, x.col(0)}, {1, x.col(1)}, {2, x.col(2)}}; }

Columns matrix_of(const Series3& x) {
  Columns out;
  for (int row = 0; row < 3; ++row)
    for (int c = 0; c < 3; ++c) out.push_back({row, x.col(c)});
  return out;
}

std::vector<Law> make_laws(const Signals& s, Sensor sensor) {
  LawList list(s, sensor);
  list.thermal();
  list.nonlinear();
  if (sensor != kMag) list.vibration();
  list.timing();
  list.supply();
  if (sensor == kAcc) list.accelerometer();
  if (sensor == kGyr) list.gyroscope();
  if (sensor == kGyr) list.thermal_behind_tracker();
  if (sensor == kMag) list.magnetometer();
  return list.take();
}

std::vector<Law> make_unknown_laws(const Signals& s, Sensor sensor) {
  struct Scalar {
    std::string name;
    Series x;
  };
  struct Vector {
    std::string name;
    Series3 x;
  };
  std::vector<Scalar> scalars;
  if (s.temperature_K.size()) scalars.push_back({"(T-T0)", s.temperature_K});
  if (s.current_A.size()) scalars.push_back({"I", s.current_A});
  if (s.voltage_V.size()) scalars.push_back({"(V-V0)", s.voltage_V.array() - s.voltage_V.mean()});
  scalars.push_back({"|w|", s.rate.rowwise().norm()});
  std::vector<Vector> vectors{{"f", s.vector[kAcc]}, {"w", s.rate}, {"m", s.vector[kMag]}, {"dw/dt", s.rate_dot}};
  const int own = sensor;
  std::vector<Law> laws;
  const auto add = [&](const std::string& name, Columns columns) {
    Law law;
    law.id = "unknown:" + name;
    law.kind = Kind::kUnknown;
    law.columns = [columns = std::move(columns)](double) { return columns; };
    law.coefficients = kPerAxis;
    law.unit = "see driver";
    law.equation = "delta = k " + name;
    law.driver = name;
    laws.push_back(std::move(law));
  };
  for (std::size_t v = 0; v < vectors.size(); ++v) {
    const Vector& w = vectors[v];
    if (v == 2 && !s.present[kMag] && !s.has_orientation) continue;
    for (std::size_t d = 0; d < scalars.size(); ++d) {
      const bool catalogued = static_cast<int>(v) == own && scalars[d].name == "(T-T0)";
      if (!catalogued) add(w.name + "*" + scalars[d].name, diagonal(scalars[d].x.asDiagonal() * w.x));
      for (int j = 0; j < 3; ++j)
        add(fmt::format("{}_{}*{}", w.name, kAxisName[static_cast<std::size_t>(j)], scalars[d].name),
            on_each_axis(scalars[d].x.cwiseProduct(w.x.col(j))));
    }
    if (static_cast<int>(v) == own || (sensor == kGyr && v == 0)) continue;
    add(w.name, diagonal(w.x));
    for (int j = 0; j < 3; ++j)
      add(fmt::format("{}_{}", w.name, kAxisName[static_cast<std::size_t>(j)]), on_each_axis(w.x.col(j)));
  }
  for (std::size_t v = 0; v < 3; ++v)
    for (std::size_t u = v; u < 3; ++u)
      for (int i = 0; i < 3; ++i)
        for (int j = (u == v ? i : 0); j < 3; ++j)
          add(fmt::format("{}_{}*{}_{}", vectors[v].name, kAxisName[static_cast<std::size_t>(i)], vectors[u].name,
                          kAxisName[static_cast<std::size_t>(j)]),
              on_each_axis(vectors[v].x.col(i).cwiseProduct(vectors[u].x.col(j))));
  for (const auto& d : scalars) {
    const bool catalogued =
        d.name == "(T-T0)" || (d.name == "(V-V0)" && sensor != kMag) || (d.name == "I" && sensor == kMag);
    if (!catalogued) add(d.name, on_each_axis(d.x));
  }
  return laws;
}

}  // namespace stillpoint::diag
