#include "diagnosis/no_reference/laws.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag::detail {
namespace {

constexpr double kTemperatureSmoothing_s = 1.0;
constexpr double kVibrationWindow_s = 0.5;
constexpr std::size_t kMostOffsets = 60;    // more follow a drift no better
constexpr std::size_t kLeastAttitudes = 3;  // rests, to tell laws of the accelerometer from each other
constexpr double kStepGrid_s = 1.0, kStepMargin_s = 3.0;

std::vector<double> smoothed(const std::vector<double>& v, std::size_t half) {
  std::vector<double> sum(v.size() + 1, 0.0), count(v.size() + 1, 0.0), out(v.size());
  for (std::size_t i = 0; i < v.size(); ++i) {
    const bool there = std::isfinite(v[i]);
    sum[i + 1] = sum[i] + (there ? v[i] : 0.0), count[i + 1] = count[i] + there;
  }
  for (std::size_t i = 0; i < v.size(); ++i) {
    const std::size_t a = i > half ? i - half : 0, b = std::min(i + half + 1, v.size());
    out[i] = count[b] > count[a] ? (sum[b] - sum[a]) / (count[b] - count[a]) : (i ? out[i - 1] : 0.0);
  }
  return out;
}

class Laws {
 public:
  Laws(const SelfConsistency& model, const sim::SimulationConfig& simulation) : m_(model), simulation_(simulation) {
    const auto& r = model.recording();
    const auto half = [&](double seconds) {
      return static_cast<std::size_t>(std::max(1.0, 0.5 * seconds / std::max(r.median_step_s(), 1e-6)));
    };
    if (!r.temp_degC.empty()) {
      tau_ = smoothed(r.temp_degC, half(kTemperatureSmoothing_s));
      for (auto& t : tau_) t -= sim::kReferenceTemp_degC;
    }
    if (!r.current_A.empty()) current_ = smoothed(r.current_A, 1);
    if (!r.supply_V.empty()) {
      supply_ = smoothed(r.supply_V, 1);
      const double mean = supply_.empty() ? 0.0 : supply_.front();
      for (auto& v : supply_) v -= mean;
    }
    vibration_window_ = half(kVibrationWindow_s);
  }

  std::vector<WitnessedLaw> all() {
    gyro_laws();
    if (m_.rest().size() >= kLeastAttitudes) force_laws();
    if (simulation_.magnetometer && !m_.recording().mag_uT.empty()) mag_laws();
    return std::move(laws_);
  }

 private:
  using Signal = std::function<double(std::size_t, int)>;  // row, axis

  /// One coefficient an axis: D_i = k_i s_i.
  [[nodiscard]] std::vector<LawColumn> diagonal(Sensor sensor, const Signal& s) const {
    std::vector<LawColumn> c(3);
    for (int k = 0; k < 3; ++k) {
      auto& column = c[static_cast<std::size_t>(k)];
      column.sensor = sensor;
      column.unit.resize(m_.recording().size());
      for (std::size_t i = 0; i < column.unit.size(); ++i) column.unit[i] = Vec3::Unit(k) * s(i, k);
    }
    return c;
  }
  static void append(std::vector<LawColumn>& to, std::vector<LawColumn> more) {
    for (auto& c : more) to.push_back(std::move(c));
  }
  void add(const std::string& id, Sensor sensor, const std::string& equation, const std::string& driver,
           std::vector<std::string> names, const std::string& unit,
           const std::function<std::vector<LawColumn>()>& columns) {
    laws_.push_back(
        {id, equation, driver, sensor, std::move(names), unit, "", "", {}, [columns](double) { return columns(); }});
  }
  void add_diagonal(const std::string& id, Sensor sensor, const std::string& equation, const std::string& driver,
                    const std::string& unit, const Signal& s) {
    const sim::EffectInfo* known = sim::find_effect(id);
    const std::string symbol = known ? known->parameters.front().symbol : "k";  // so that effect_of() finds its own
    add(id, sensor, equation, driver, {symbol + "_x", symbol + "_y", symbol + "_z"}, unit,
        [this, sensor, s] { return diagonal(sensor, s); });
  }

  void thermal_laws(Sensor sensor, const std::string& name, const std::string& unit) {
    if (tau_.empty()) return;
    add_diagonal(name + "_temp_lin", sensor, "D = k (T - T0)", "temperature", unit + "/K",
                 [this](std::size_t i, int) { return tau_[i]; });
    add(name + "_temp_quad", sensor, "D = k1 tau + k2 tau^2, tau = T - T0", "temperature",
        {"k1_x", "k1_y", "k1_z", "k2_x", "k2_y", "k2_z"}, unit + "/K", [this, sensor] {
          auto c = diagonal(sensor, [this](std::size_t i, int) { return tau_[i]; });
          append(c, diagonal(sensor, [this](std::size_t i, int) { return tau_[i] * tau_[i]; }));
          return c;
        });
    laws_.push_back({name + "_temp_lag",
                     "D = k (T - T_L), tau dT_L/dt = T - T_L",
                     "temperature, lagging",
                     sensor,
                     {"k_x", "k_y", "k_z"},
                     unit + "/K",
                     "tau",
                     "s",
                     {5, 8, 13, 20, 35, 60},
                     [this, sensor](double tau_s) {
                       const auto lag = lagged(tau_s);
                       return diagonal(sensor, [this, lag](std::size_t i, int) { return tau_[i] - lag[i]; });
                     }});
  }
  [[nodiscard]] std::vector<double> lagged(double tau_s) const {
    std::vector<double> lag(tau_.size());
    lag[0] = tau_[0];
    for (std::size_t i = 1; i < lag.size(); ++i)
      lag[i] = lag[i - 1] + (1.0 - std::exp(-(m_.recording().t_s(i) - m_.recording().t_s(i - 1)) / tau_s)) *
                                (tau_[i - 1] - lag[i - 1]);
    return lag;
  }

  void gyro_laws() {
    thermal_laws(kGyr, "gyr", "rad/s");
    if (!tau_.empty())
      add_diagonal("gyr_temp_scale", kGyr, "D = S (T - T0) o omega", "temperature times rate", "1/K",
                   [this](std::size_t i, int k) { return tau_[i] * m_.rate_radps()[i][k]; });
    if (!supply_.empty())
      add_diagonal("gyr_volt", kGyr, "D = k (V - V0)", "supply voltage", "rad/s per V",
                   [this](std::size_t i, int) { return supply_[i]; });
    add("gyr_gsens", kGyr, "D = G f", "specific force",
        {"G_xx", "G_xy", "G_xz", "G_yx", "G_yy", "G_yz", "G_zx", "G_zy", "G_zz"}, "rad/s per m/s^2", [this] {
          std::vector<LawColumn> c;
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
              c.push_back({kGyr, std::vector<Vec3>(m_.recording().size())});
              for (std::size_t r = 0; r < c.back().unit.size(); ++r)
                c.back().unit[r] = Vec3::Unit(i) * m_.force_mps2()[r][j];
            }
          return c;
        });
    add_diagonal("gyr_vre", kGyr, "D = k o <f_hf^2>", "vibration power", "rad/s per (m/s^2)^2", vibration());
    add_diagonal("gyr_cubic", kGyr, "D = k3 o omega^3", "rate cubed", "1/(rad/s)^2",
                 [this](std::size_t i, int k) { return std::pow(m_.rate_radps()[i][k], 3); });
    add_diagonal("gyr_asym", kGyr, "D = k o |omega|", "size of the rate", "1",
                 [this](std::size_t i, int k) { return std::abs(m_.rate_radps()[i][k]); });
    add("gyr_delay", kGyr, "D = omega(t - tau) - omega(t)", "angular acceleration", {"tau"}, "s", [this] {
      const auto& w = m_.rate_radps();
      std::vector<LawColumn> c{{kGyr, std::vector<Vec3>(w.size(), Vec3::Zero())}};
      for (std::size_t i = 1; i + 1 < w.size(); ++i)
        c[0].unit[i] = -(w[i + 1] - w[i - 1]) / (m_.recording().t_s(i + 1) - m_.recording().t_s(i - 1));
      return c;
    });
    if (simulation_.magnetometer && !m_.rest().empty()) {  // up is known
      add("gyr_earth", kGyr, "D = R^T omega_e", "attitude", {"scale"}, "1", [this] {
        // North is where the field points; the latitude follows from its dip as for a dipole.
        const Vec3 m = simulation_.field_world_uT;
        const double horizontal = std::hypot(m.x(), m.y());
        const double latitude = std::atan2(-m.z(), 2.0 * horizontal);
        const Vec3 north = Vec3(m.x(), m.y(), 0) / std::max(horizontal, 1e-9);
        const Vec3 earth = kEarthRate_radps * (std::cos(latitude) * north + std::sin(latitude) * Vec3::UnitZ());
        std::vector<LawColumn> c{{kGyr, std::vector<Vec3>(m_.recording().size())}};
        for (std::size_t i = 0; i < c[0].unit.size(); ++i) c[0].unit[i] = m_.R_world_body()[i].transpose() * earth;
        return c;
      });
    }
  }

  /// At rest alone: there the gyroscope says which way gravity points.
  void force_laws() {
    thermal_laws(kAcc, "acc", "m/s^2");
    const auto force = [this](std::size_t i, int k) { return m_.force_mps2()[i][k]; };
    if (!tau_.empty())
      add_diagonal("acc_temp_scale", kAcc, "D = S (T - T0) o f", "temperature times force", "1/K",
                   [this, force](std::size_t i, int k) { return tau_[i] * force(i, k); });
    if (!supply_.empty())
      add_diagonal("acc_volt", kAcc, "D = k (V - V0)", "supply voltage", "m/s^2 per V",
                   [this](std::size_t i, int) { return supply_[i]; });
    add_diagonal("acc_asym", kAcc, "D = k o |f|", "size of the force", "1",
                 [force](std::size_t i, int k) { return std::abs(force(i, k)); });
    add_diagonal("acc_quad", kAcc, "D = k2 o f^2", "force squared", "1/(m/s^2)",
                 [force](std::size_t i, int k) { return std::pow(force(i, k), 2); });
    add_diagonal("acc_cubic", kAcc, "D = k3 o f^3", "force cubed", "1/(m/s^2)^2",
                 [force](std::size_t i, int k) { return std::pow(force(i, k), 3); });
  }

  [[nodiscard]] Signal vibration() const {
    const std::size_t n = m_.recording().size();
    std::array<std::vector<double>, 3> power;
    for (int k = 0; k < 3; ++k) {
      std::vector<double> f(n), square(n);
      for (std::size_t i = 0; i < n; ++i) f[i] = m_.force_mps2()[i][k];
      const auto slow = smoothed(f, vibration_window_ / 2);
      for (std::size_t i = 0; i < n; ++i) square[i] = (f[i] - slow[i]) * (f[i] - slow[i]);
      power[static_cast<std::size_t>(k)] = smoothed(square, vibration_window_);
    }
    return [power](std::size_t i, int k) { return power[static_cast<std::size_t>(k)][i]; };
  }

  [[nodiscard]] std::vector<double> step_times() const {
    std::vector<double> t;
    const auto& r = m_.recording();
    const double last = r.t_s(r.size() - 1) - kStepMargin_s;
    const double step = std::max(kStepGrid_s, (last - r.t_s(0)) / 150.0);
    for (double s = r.t_s(0) + kStepMargin_s; s < last; s += step) t.push_back(s);
    return t;
  }

  void mag_laws() {
    thermal_laws(kMag, "mag", "uT");
    if (!tau_.empty())
      add_diagonal("mag_temp_scale", kMag, "D = S (T - T0) o m", "temperature times field", "1/K",
                   [this](std::size_t i, int k) { return tau_[i] * m_.field_uT()[i][k]; });
    if (!current_.empty())
      add_diagonal("mag_current", kMag, "D = k I", "current", "uT/A",
                   [this](std::size_t i, int) { return current_[i]; });
    add("mag_delay", kMag, "D = m(t - tau) - m(t) = tau omega x m", "rate x field", {"tau"}, "s", [this] {
      std::vector<LawColumn> c{{kMag, std::vector<Vec3>(m_.recording().size())}};
      for (std::size_t i = 0; i < c[0].unit.size(); ++i) c[0].unit[i] = m_.rate_radps()[i].cross(m_.field_uT()[i]);
      return c;
    });
    mag_steps();
  }

  /// What begins at a time t0 that the search must find.
  void mag_steps() {
    add_mag_step("mag_hard_step", "D = b 1(t > t0)", "time", {"b_x", "b_y", "b_z"}, "uT",
                 [this](double t0) { return diagonal(kMag, [this, t0](std::size_t i, int) { return after(i, t0); }); });
    add_mag_step("mag_field_step", "D = R^T b_w 1(t > t0)", "time and attitude", {"b_wx", "b_wy", "b_wz"}, "uT",
                 [this](double t0) {
                   std::vector<LawColumn> c;
                   for (int j = 0; j < 3; ++j) {
                     c.push_back({kMag, std::vector<Vec3>(m_.recording().size())});
                     for (std::size_t i = 0; i < c.back().unit.size(); ++i)
                       c.back().unit[i] = after(i, t0) * m_.R_world_body()[i].row(j).transpose();
                   }
                   return c;
                 });
    add_mag_step("mag_soft_step", "D = M m 1(t > t0)", "time and field",
                 {"M_xx", "M_xy", "M_xz", "M_yx", "M_yy", "M_yz", "M_zx", "M_zy", "M_zz"}, "1", [this](double t0) {
                   std::vector<LawColumn> c;
                   for (int i = 0; i < 3; ++i)
                     for (int j = 0; j < 3; ++j) {
                       c.push_back({kMag, std::vector<Vec3>(m_.recording().size())});
                       for (std::size_t r = 0; r < c.back().unit.size(); ++r)
                         c.back().unit[r] = Vec3::Unit(i) * (after(r, t0) * m_.field_uT()[r][j]);
                     }
                   return c;
                 });
  }
  void add_mag_step(const std::string& id, const std::string& equation, const std::string& driver,
                    std::vector<std::string> names, const std::string& unit,
                    std::function<std::vector<LawColumn>(double t0_s)> columns) {
    laws_.push_back({id, equation, driver, kMag, std::move(names), unit, "t0", "s", step_times(), std::move(columns)});
  }
  [[nodiscard]] double after(std::size_t row, double t0_s) const { return m_.recording().t_s(row) > t0_s ? 1.0 : 0.0; }

  const SelfConsistency& m_;
  const sim::SimulationConfig& simulation_;
  std::vector<double> tau_, current_, supply_;
  std::size_t vibration_window_ = 1;
  std::vector<WitnessedLaw> laws_;
};

}  // namespace

std::vector<WitnessedLaw> witnessed_laws(const SelfConsistency& model, const sim::SimulationConfig& simulation) {
  // The columns refer to the signals, so the maker of the laws lives as long as they do.
  const auto maker = std::make_shared<Laws>(model, simulation);
  auto laws = maker->all();
  // Each sensor is asked about all that temperature does; what no simulation can hold is no name.
  std::erase_if(laws, [](const WitnessedLaw& law) { return sim::find_effect(law.id) == nullptr; });
  for (auto& law : laws) law.columns = [maker, inner = std::move(law.columns)](double g) { return inner(g); };
  return laws;
}

std::vector<LawColumn> free_offsets(const SelfConsistency& model, Sensor sensor) {
  std::vector<LawColumn> c;
  const auto& rest = model.rest();
  const std::size_t together = (rest.size() + kMostOffsets - 1) / kMostOffsets;
  for (std::size_t w = together; w < rest.size(); w += together) {
    const std::size_t next = w + together, from = (rest[w - 1].last + rest[w].first) / 2;
    const std::size_t to = next < rest.size() ? (rest[next - 1].last + rest[next].first) / 2 : model.recording().size();
    for (int k = 0; k < 3; ++k) c.push_back({sensor, std::vector<Vec3>(to - from, Vec3::Unit(k)), from});
  }
  return c;
}

}  // namespace stillpoint::diag::detail
