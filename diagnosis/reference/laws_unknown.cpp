#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <sstream>

#include "diagnosis/reference/columns.h"
#include "diagnosis/reference/driver_unit.h"
#include "diagnosis/reference/laws.h"
#include "diagnosis/reference/separable.h"
#include "simulation/effect_catalogue.h"

namespace stillpoint::diag {
namespace {

struct Scalar {
  std::string name;
  Series x;
};
struct Vector {
  std::string name;
  Series3 x;
};

/// The drivers, shared by all products of one sensor: each product is made when it is looked at.
struct Drivers {
  std::vector<Scalar> scalars;
  std::vector<Vector> vectors;
};

class Products {
 public:
  Products(const Signals& s, Sensor sensor) : sensor_(sensor), drivers_(std::make_shared<Drivers>()) {
    auto& scalars = drivers_->scalars;
    if (s.temperature_K.size()) scalars.push_back({"(T-T0)", s.temperature_K});
    if (s.current_A.size()) scalars.push_back({"I", s.current_A});
    if (s.voltage_V.size()) scalars.push_back({"(V-V0)", s.voltage_V.array() - s.voltage_V.mean()});
    scalars.push_back({"|w|", s.rate.rowwise().norm()});
    drivers_->vectors = {{"f", s.vector[kAcc]}, {"w", s.rate}, {"m", s.vector[kMag]}, {"dw/dt", s.rate_dot}};
    Series force = s.vector[kAcc].rowwise().norm().array() - s.gravity_mps2;
    for (Eigen::Index i = 0; i < s.n; ++i)
      if (s.rest[static_cast<std::size_t>(i)]) force[i] = 0.0;  // by definition; a reading shows its own noise there
    scalars.push_back({"|f|", force});
  }

  void scalars_and_their_products() {
    const auto& scalars = drivers_->scalars;
    for (std::size_t a = 0; a < scalars.size(); ++a) {
      add(scalars[a].name, [a](const Drivers& d) { return d.scalars[a].x; });
      for (std::size_t b = a; b < scalars.size(); ++b)
        add(scalars[a].name + "*" + scalars[b].name,
            [a, b](const Drivers& d) -> Series { return d.scalars[a].x.cwiseProduct(d.scalars[b].x); });
    }
  }

  void vectors_and_scalars() {
    const auto& [scalars, vectors] = *drivers_;
    for (std::size_t v = 0; v < vectors.size(); ++v) {
      for (std::size_t a = 0; a < scalars.size(); ++a) {
        add_vector(vectors[v].name + "*" + scalars[a].name,
                   [v, a](const Drivers& d) -> Series3 { return d.scalars[a].x.asDiagonal() * d.vectors[v].x; });
        for (int j = 0; j < 3; ++j)
          add(fmt::format("{}*{}", component(v, j), scalars[a].name),
              [v, a, j](const Drivers& d) -> Series { return d.scalars[a].x.cwiseProduct(d.vectors[v].x.col(j)); });
      }
      // A linear map of its own vector is a wrong matrix; one of the force goes into the gyroscope as a whole, below.
      if (v == static_cast<std::size_t>(sensor_) || (sensor_ == kGyr && v == kAcc)) continue;
      add_vector(vectors[v].name, [v](const Drivers& d) { return d.vectors[v].x; });
      for (int j = 0; j < 3; ++j)
        add(component(v, j), [v, j](const Drivers& d) -> Series { return d.vectors[v].x.col(j); });
    }
  }

  void vectors_and_vectors() {
    for (std::size_t v = 0; v < 3; ++v)
      for (std::size_t u = v; u < 3; ++u)
        for (int i = 0; i < 3; ++i)
          for (int j = (u == v ? i : 0); j < 3; ++j)
            add(component(v, i) + "*" + component(u, j), [v, u, i, j](const Drivers& d) -> Series {
              return d.vectors[v].x.col(i).cwiseProduct(d.vectors[u].x.col(j));
            });
  }

  /// Powers of the sensor's own vector, each axis by itself.
  void own_vector() {
    const auto v = static_cast<std::size_t>(sensor_);
    const std::string& name = drivers_->vectors[v].name;
    add_vector(name + "^2", [v](const Drivers& d) -> Series3 { return d.vectors[v].x.cwiseAbs2(); });
    add_vector(name + "^3", [v](const Drivers& d) -> Series3 { return d.vectors[v].x.array().cube(); });
    add_vector("|" + name + "_i|", [v](const Drivers& d) -> Series3 { return d.vectors[v].x.cwiseAbs(); });
  }

  /// What a vector does through a full matrix, and what lags behind the temperature.
  void matrices_and_lags(const Signals& s) {
    if (sensor_ == kGyr) {
      add_columns("f", [d = drivers_](double) { return matrix_of(d->vectors[kAcc].x); });
      laws_.back().coefficients = entries("k");
    }
    if (!s.temperature_K.size()) return;
    add_columns("dT/dt", [&s](double tau) { return on_each_axis(lagged_difference(s.temperature_K, s.dt_s, tau)); });
    laws_.back().shapes = {5.0, 15.0, 40.0};
    laws_.back().shape_name = "tau";
    laws_.back().shape_unit = "s";
  }

  /// What depends on where the body is, or on its turning as a whole: products that go together or not at all.
  void arm_and_place(const Signals& s) {
    if (!s.has_position) return;
    if (sensor_ == kAcc)
      add_columns("dw/dt x r + w x (w x r)", [&s](double) {
        return coupled({lever_column(s, 0), lever_column(s, 1), lever_column(s, 2)});
      });
    if (sensor_ != kMag) return;
    add_columns("field(p)", [&s](double) { return linear_in_place(s); });
    laws_.back().coefficients = entries("k");
  }

  /// What relaxes after it was bolted down or switched on.
  void relaxation(const Signals& s) {
    if (sensor_ == kMag) return;
    add_columns("log(t)", [&s](double tau) { return on_each_axis((1.0 + s.t_s.array() / tau).log().matrix()); });
    laws_.back().text = "log(1 + t / {})";
    laws_.back().shapes = {1.0, 4.0, 15.0};
    laws_.back().shape_name = "tau";
    laws_.back().shape_unit = "s";
    laws_.back().extent = Extent::kWhole;
    laws_.back().equation = "delta = k log(1 + t / tau)";
    laws_.back().driver = "time: stress that relaxes";
  }

  /// An offset, one fixed in the world, a linear map, each there for a while and by no driver at all: the plain rivals
  /// of whatever is local in time.
  void for_a_while(const Signals& s) {
    const auto add_step = [this](const std::string& name, const std::string& what, auto columns) {
      add_columns(name, columns);
      laws_.back().extent = Extent::kStep;
      laws_.back().equation = what + ", for a while";
      laws_.back().driver = "something that is not in the recording";
    };
    add_step("offset(t)", "an offset fixed in the body", [n = s.n](double) { return on_each_axis(Series::Ones(n)); });
    if (sensor_ != kMag) return;
    add_step("field(t)", "an offset fixed in the world", [&s](double) { return world_fixed(s); });
    add_step("m(t)", "a linear map of the field", [&s](double) { return matrix_of(s.vector[kMag]); });
    laws_.back().coefficients = entries("k");
  }

  /// Temperature and supply do not stop acting in the middle of a recording; in a short window they would only stand
  /// for an offset.
  std::vector<Law> take() {
    for (Law& law : laws_) law.form_of = known_form(law.id.substr(std::string("unknown:").size()));
    for (Law& law : laws_)
      for (const char* lasting : {"T", "V"})
        if (law.id.find(lasting) != std::string::npos) law.extent = Extent::kWhole;
    return std::move(laws_);
  }

 private:
  /// The law of the catalogue with this form. Nature is as likely to use the form whether the library has its name or
  /// not.
  [[nodiscard]] std::string known_form(const std::string& form) const {
    static constexpr std::array<const char*, kSensors> kOwn{"f", "w", "m"};
    const std::string own = kOwn[sensor_];
    const std::map<std::string, std::string> any{{"(T-T0)", "temp_lin"},
                                                 {"(T-T0)*(T-T0)", "temp_quad"},
                                                 {"dT/dt", "temp_lag"},
                                                 {own + "*(T-T0)", "temp_scale"},
                                                 {"(V-V0)", "volt"},
                                                 {own + "^2", "quad"},
                                                 {own + "^3", "cubic"},
                                                 {"|" + own + "_i|", "asym"},
                                                 {"I", "current"},
                                                 {"f", "gsens"},
                                                 {"offset(t)", "hard_step"},
                                                 {"field(t)", "field_step"},
                                                 {"m(t)", "soft_step"},
                                                 {"field(p)", "gradient"},
                                                 {"dw/dt x r + w x (w x r)", "lever"}};
    const auto at = any.find(form);
    if (at == any.end()) return {};
    const std::string id = std::string(kSensorName[sensor_]) + "_" + at->second;
    return id == "mag_cubic" ? "mag_sat" : sim::find_effect(id) != nullptr ? id : "";
  }

  [[nodiscard]] std::string component(std::size_t v, int axis) const {
    return fmt::format("{}_{}", drivers_->vectors[v].name, kAxisName[static_cast<std::size_t>(axis)]);
  }

  template <class Make>
  void add(const std::string& name, Make make) {
    add_columns(name, [d = drivers_, make](double) { return on_each_axis(make(*d)); });
  }
  template <class Make>
  void add_vector(const std::string& name, Make make) {
    add_columns(name, [d = drivers_, make](double) { return diagonal(make(*d)); });
  }
  void add_columns(const std::string& name, std::function<Columns(double)> columns) {
    Law law;
    law.id = "unknown:" + name;
    law.kind = Kind::kUnknown;
    law.columns = std::move(columns);
    law.coefficients = {"k_x", "k_y", "k_z"};
    law.unit = coefficient_unit(kSensorUnit[sensor_], name);
    law.equation = "delta = k " + name;
    law.driver = name;
    laws_.push_back(std::move(law));
  }

  Sensor sensor_;
  std::shared_ptr<Drivers> drivers_;
  std::vector<Law> laws_;
};

}  // namespace

std::vector<Law> make_unknown_laws(const Signals& s, Sensor sensor) {
  Products products(s, sensor);
  products.scalars_and_their_products();
  products.vectors_and_scalars();
  products.vectors_and_vectors();
  products.own_vector();
  products.matrices_and_lags(s);
  products.arm_and_place(s);
  products.relaxation(s);
  products.for_a_while(s);
  std::vector<Law> laws = products.take();
  drop_inseparable(s, sensor, laws);
  return laws;
}

bool is_part_of(const std::string& part, const std::string& whole) {
  constexpr std::string_view kPrefix = "unknown:";
  if (!part.starts_with(kPrefix) || !whole.starts_with(kPrefix)) return false;
  const auto factors = [&](const std::string& id) {
    std::multiset<std::string> out;
    std::istringstream names(id.substr(kPrefix.size()));
    for (std::string name; std::getline(names, name, '*');) out.insert(name);
    return out;
  };
  const auto some = factors(part), all = factors(whole);
  return some.size() < all.size() && std::includes(all.begin(), all.end(), some.begin(), some.end());
}

}  // namespace stillpoint::diag
