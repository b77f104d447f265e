#include "diagnosis/reference/laws.h"

#include <fmt/format.h>

#include "diagnosis/reference/columns.h"
#include "diagnosis/reference/hidden_rail.h"
#include "diagnosis/reference/separable.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {
namespace {

const std::vector<std::string> kPerAxis{"k_x", "k_y", "k_z"};

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

  /// Of the reference or of the simulation's surroundings, and there all the time: no physics of the sensor.
  static Law& set_up(Law& law) {
    law.kind = Kind::kConfiguration;
    law.extent = Extent::kWhole;
    return law;
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
    Law& quad = add(
        prefix_ + "temp_quad",
        [&s](double) {
          Columns c = on_each_axis(s.temperature_K), square = on_each_axis(s.temperature_K.cwiseAbs2());
          c.insert(c.end(), square.begin(), square.end());
          return c;
        },
        {"k1_x", "k1_y", "k1_z", "k2_x", "k2_y", "k2_z"}, u + "/K^2", "delta = k1 (T - 25 degC) + k2 (T - 25 degC)^2",
        "temperature and its square");
    quad.units = {u + "/K", u + "/K", u + "/K", u + "/K^2", u + "/K^2", u + "/K^2"};
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
      law.shapes = {3.0, 6.0, 10.0, 15.0, 22.0, 32.0, 50.0};
      law.shape_name = kTrackerShape;
      law.shape_unit = "s";
      law.extent = Extent::kWhole;  // a stretch of it is whatever begins and decays
    };
    behind(prefix_ + "temp_lin", s.temperature_K, "k", std::string(kSensorUnit[sensor_]) + "/K");
    behind(prefix_ + "temp_quad", s.temperature_K.cwiseAbs2(), "k2", std::string(kSensorUnit[sensor_]) + "/K^2");
  }

  /// An estimator on board takes away what the simulation knows of: seen by what is missing of it.
  void tracker() {
    if (s_.given_rate.rows() == 0 || !s_.has_rest) return;
    const Signals& s = s_;
    Law& law = add(
        "sys_tracker",
        [&s](double tau) {
          Series3 lost = s.given_rate;
          for (int axis = 0; axis < 3; ++axis)
            lost.col(axis) = after_tracker(s.given_rate.col(axis), s.rest, s.dt_s, tau) - s.given_rate.col(axis);
          return coupled({lost});
        },
        kWholeOrNothing, "1", "u = y - b, db/dt = (y - b) / tau at rest",
        "pattern of rests, and what drifts between them");
    law.shapes = {3.0, 6.0, 10.0, 15.0, 22.0, 32.0, 50.0};
    law.shape_name = "tau";
    law.shape_unit = "s";
    law.extent = Extent::kWhole;
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
    const auto slope = [&s, k](double) { return coupled({at_rest_zero(s, -derivative(s.vector[k], s.rows))}); };
    add(prefix_ + "delay", slope, {"tau"}, "s", "delta = true(t - tau) - true(t)",
        "first derivative of the measured vector")
        .kind = Kind::kTiming;
    Law& filter = add(
        prefix_ + (k == kMag ? "delay" : "resonance"),
        [&s, k](double) {
          return coupled({at_rest_zero(s, -derivative(s.vector[k], s.rows)),
                          at_rest_zero(s, second_derivative(s.vector[k], s.rows))});
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
          const Series3 d = at_rest_zero(s, derivative(s.vector[k], s.rows));
          return coupled({s.t_s.asDiagonal() * d});
        },
        {"epsilon"}, "1", "delta = true(t (1 + epsilon)) - true(t)", "time times the first derivative");
    skew.kind = Kind::kTiming;
    skew.extent = Extent::kWhole;
  }

  void supply() {
    const Signals& s = s_;
    if (!s.voltage_V.size() || sensor_ == kMag) return;
    // About which supply is the bias' affair, but in a window.
    add(
        prefix_ + "volt", [&s](double V0) { return on_each_axis(s.voltage_V.array() - V0); }, kPerAxis,
        std::string(kSensorUnit[sensor_]) + "/V", "delta = k (V - V0)", "supply voltage")
        .shapes = {sim::kReferenceSupply_V, s.voltage_V.mean()};
  }

  void accelerometer() {
    const Signals& s = s_;
    if (!s.exact_reference && !s.from_log) {  // a camera's world is levelled by hand
      set_up(add(
          "vertical_world",
          [&s](double) {
            return coupled({s.world_axis[0], s.world_axis[1]});
          },
          {"d_x", "d_y"}, "m/s^2", "delta = R' d", "attitude, fixed in the world"));
      if (s.has_position)  // of two systems, or one that levels its attitudes by itself
        set_up(add(
            kTurnedAttitudes, [&s](double) { return turned_columns(s); }, {"d_x", "d_y", "d_z"}, "rad",
            "delta = R' (d x R f)", "specific force"));
    }
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
          "acc_gravity", [&s](double) { return coupled({s.world_axis[2]}); }, {"dg"}, "m/s^2", "delta = dg R' e_z",
          "attitude");
    }
  }

  void hidden_saturation() {
    const Signals& s = s_;
    const Sensor k = sensor_;
    HiddenRail rail = hidden_rail(s, k);
    Law& sat = add(
        prefix_ + "sat",
        [&s, k, y = std::move(rail.clipped)](double level) {
          return coupled({(y.cwiseMin(level).cwiseMax(-level) - y) * s.triad[k].matrix.transpose()});
        },
        kWholeOrNothing, "1", "y = clip(y, +-L) before filtering", "the reading above a level");
    sat.shapes = std::move(rail.levels);
    sat.shape_name = "L";
    sat.shape_unit = kSensorUnit[k];
    sat.fixed["hidden"] = 1.0;
    sat.extent = Extent::kWhole;
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
          "mag_gradient", [&s](double) { return gradient_columns(s); },
          {"G_xx", "G_xy", "G_xz", "G_yy", "G_yz", "b_x", "b_y", "b_z"}, "uT/m",
          "delta = R' (G p + b), G symmetric, its trace 0", "position");
    if (s.current_A.size())
      add(
          "mag_current", [&s](double) { return on_each_axis(s.current_A); }, kPerAxis, "uT/A", "delta = k I",
          "current");
    // What a log's own noise does to its field is another field of the world and a scale that undoes it.
    if (s.from_log && !s.exact_reference) return;
    set_up(add(
        "field_world", [&s](double) { return world_fixed(s); }, {"d_x", "d_y", "d_z"}, "uT", "delta = R' d",
        "attitude, fixed in the world"));
  }

  void smoothed_reference() {
    const Signals& s = s_;
    if (s.exact_reference || s.from_log) return;
    Law& smoothed = set_up(add(
        kSmoothedReference, [&s, k = sensor_](double places) { return smoothing_columns(s, k, places > 0.0); },
        {"half_square"}, "s^2", "delta = s^2/2 omega' x true", "angular acceleration"));
    if (sensor_ == kAcc && s.has_position) smoothed.shapes = {0.0, 1.0};
  }

  /// What has a memory, bends or scales with a slow driver, or acts everywhere: a short stretch of it is another law.
  /// So is a line over temperature where the supply, which may have done it, was not recorded.
  void never_local(std::initializer_list<const char*> parts) {
    for (Law& law : laws_)
      for (const char* part : parts)
        if (law.id.find(part) != std::string::npos) law.extent = Extent::kWhole;
  }

  std::vector<Law> take() { return std::move(laws_); }

 private:
  const Signals& s_;
  Sensor sensor_;
  std::string prefix_;
  std::vector<Law> laws_;
};

}  // namespace

std::vector<Law> make_laws(const Signals& s, Sensor sensor) {
  LawList list(s, sensor);
  list.thermal();
  list.nonlinear();
  if (sensor != kMag) list.vibration();
  list.timing();
  list.supply();
  if (sensor != kMag) list.hidden_saturation();
  if (sensor == kAcc) list.accelerometer();
  if (sensor == kGyr) list.gyroscope();
  if (sensor == kGyr) list.thermal_behind_tracker(), list.tracker();
  if (sensor == kMag) list.magnetometer();
  list.smoothed_reference();
  list.never_local({"_earth", "_gravity", "_vre"});
  if (!s.voltage_V.size()) list.never_local({"_temp_"});
  std::vector<Law> laws = list.take();
  drop_inseparable(s, sensor, laws);
  return laws;
}

}  // namespace stillpoint::diag
