#include "diagnosis/discovery/grammar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diagnosis/discovery/drivers.h"
#include "diagnosis/discovery/table_term.h"
#include "laws/expression.h"

namespace stillpoint::diag {
namespace {

constexpr double kFirstEvent_s = 3.0;
constexpr double kLongestOfMotion = 0.15;  // time constant, of the recording: a longer memory of what swings is a trend
constexpr std::array<double, 3> kWiderLags_s{0.5, 1.6, 5.0};  // refined where they are of use
constexpr double kOfALine_s = 0.1;                            // period / 2 pi below it: more than a cycle a second
constexpr int kMostCycles = 40;                               // of a periodic function over the range of its driver

class Ideas {
 public:
  Ideas(Sensor sensor, const laws::Columns& drivers) : own_(own_vector(sensor)), drivers_(drivers) {
    length_s_ = drivers.t_s[drivers.t_s.size() - 1] - drivers.t_s[0];
    for (const char* v : {"w", "f", "m"})
      if (drivers.values.contains(v)) vectors_.emplace_back(v);
    scalars_ = scalar_factors(drivers);
    for (const auto& v : vectors_)
      for (const char* axis : {"_x", "_y", "_z"}) components_.push_back(v + axis);
  }

  void of_scalars() {
    for (const auto& x : scalars_) {
      add(x), add(x + "^2"), add(x + "^3"), add("abs(" + x + ")^0.5");
      if (x != "t" && x != "norm(w)") add("abs(" + x + ")"), add("sign(" + x + ")");
      thresholds(x);
      for (const auto& y : scalars_)
        if (x < y) add(fmt::format("{} * {}", x, y));
      for (const auto& c : components_) add(fmt::format("{} * {}", x, c));
    }
    for (const auto& [name, values] : drivers_.values) {
      if (values.cols() != 1 || name.find('(') != std::string::npos) continue;
      memory(name);
      if (name == "T")
        hysteresis(name, values);  // of a noisy driver a small width would smooth its noise
      else
        add("d(" + name + ")");
    }
    for (const auto& c : components_) open(remembered(c), "tau", lags(kLongestOfMotion), "s");
    for (const char* heat : {"norm(w)", "norm(w)^2", "norm(f)", "I^2", "d(T)"})
      if (known(heat)) memory(heat);
  }

  void of_components() {
    for (std::size_t a = 0; a < components_.size(); ++a) {
      const std::string& x = components_[a];
      const bool own = x.substr(0, 1) == own_;
      if (!own) add(x), add("d(" + x + ")");
      add("abs(" + x + ")"), add(x + "^3"), add("sign(" + x + ")"), add("abs(" + x + ")^0.5"), add("d(" + x + ")^2");
      add(fmt::format("{0} * abs({0})", x));
      thresholds(x);
      for (std::size_t b = a; b < components_.size(); ++b) add(fmt::format("{} * {}", x, components_[b]));
      for (const auto& y : components_)
        if (y[0] != x[0] || y == x) add(fmt::format("d({}) * {}", y, x));
    }
  }

  void of_vectors() {
    for (const auto& v : vectors_) {
      if (v != own_) both(v), add("d(" + v + ")");
      add_matrix("d(" + v + ")");  // axis by axis of the reading itself it is a delay
      both(remembered(v), lags(kLongestOfMotion), "tau");
      add_powers(v);
      for (const auto& c : components_) add_matrix(fmt::format("{} * {}", v, c));
      for (const auto& x : scalars_) {
        both(fmt::format("{} * {}", v, x));
        add(fmt::format("d({}) * {}", v, x));
      }
      for (const auto& u : vectors_) {
        if (u <= v) continue;
        add(fmt::format("cross({}, {})", v, u)), add(fmt::format("{} * {}", v, u));
        both(fmt::format("cross(d({}), {})", v, u)), both(fmt::format("cross(d({}), {})", u, v));
      }
    }
    for (const char* triple : {"cross(w, cross(w, f))", "cross(w, cross(w, m))", "cross(d(w), w)"})
      if (known(triple)) add(triple);
    for (const char* world : {"east", "north", "up"})
      if (known(world)) both(world), both(std::string(world) + " * step(t, {})", events());
    if (known("p")) both("p");
  }

  /// What an axis does to its own reading.
  void of_the_reading() {
    const Eigen::MatrixXd& x = drivers_.values.find(own_)->second;
    const double span = x.maxCoeff() - x.minCoeff();
    if (!(span > 0)) return;
    std::vector<double> periods;
    for (int half = 2 * kMostCycles; half >= 2; --half) periods.push_back(span / (std::numbers::pi * half));
    pair("sin(" + own_ + " / {})", "cos(" + own_ + " / {})", "period / 2 pi", "", std::move(periods));
    hysteresis(own_, x);
    open("step(abs(" + own_ + "), {}) * sign(" + own_ + ") * (abs(" + own_ + ") - {})", "threshold", levels_of_own());
    open("step(" + own_ + ", {})", "threshold", levels_of_own());
  }

  void of_time() {
    open("step(t, {})", "at", events());
    both(own_ + " * step(t, {})", events());
    open("exp(-t / {})", "tau", settling());
    open("log(1 + t / {})", "tau", settling());
    both(own_ + " * t");
    both(own_ + " * exp(-t / {})", settling(), "tau");
    std::vector<double> turns;
    for (double cycles = std::min(0.5 * length_s_, 40.0); cycles >= 1.0; cycles -= 0.5)
      turns.push_back(length_s_ / (2.0 * std::numbers::pi * cycles));
    pair("d(" + own_ + ") * sin(t / {})", "d(" + own_ + ") * cos(t / {})", "period / 2 pi", "s", turns);
    pair("sin(t / {})", "cos(t / {})", "period / 2 pi", "s", std::move(turns));
  }

  std::vector<Idea> take() { return std::move(out_); }

 private:
  [[nodiscard]] bool known(const std::string& text) const {
    const auto tree = laws::parse(text, laws::standard_drivers());
    if (!tree) return false;
    for (const auto& name : laws::drivers_of(*tree))
      if (name != "t" && !drivers_.values.contains(name)) return false;
    return true;
  }
  void add(const std::string& text) { out_.push_back({{text}, {}, {}, {0.0}, false}); }
  void both(const std::string& vector) {
    add(vector);
    add_matrix(vector);
  }
  void add_matrix(const std::string& vector) { out_.push_back({{vector}, {}, {}, {0.0}, true}); }
  void both(const std::string& vector, std::vector<double> shapes, const char* name = "at") {
    out_.push_back({{vector}, name, "s", std::move(shapes), true});
  }
  void open(const std::string& text, const char* name, std::vector<double> shapes, const char* unit = "") {
    if (!shapes.empty()) out_.push_back({{text}, name, unit, std::move(shapes), false});
  }
  void pair(std::string a, std::string b, const char* name, const char* unit, std::vector<double> shapes) {
    out_.push_back({{std::move(a), std::move(b)}, name, unit, std::move(shapes), false});
  }
  void add_powers(const std::string& v) {
    for (const char* form : {"{0}^2", "{0}^3", "abs({0})", "sign({0})", "{0} * abs({0})", "abs({0})^0.5",
                             "norm(d({0}))", "norm(d({0}))^2"})
      add(fmt::format(fmt::runtime(form), v));
    if (v != own_) add("cross(" + v + ", d(" + v + "))");
  }
  /// Of what the sensor itself reads, what its memory lacks: the memory alone would change the matrix by as much.
  [[nodiscard]] std::string remembered(const std::string& x) const {
    return x.substr(0, 1) == own_ ? fmt::format("({0} - lag({0}, {{}}))", x) : "lag(" + x + ", {})";
  }
  void memory(const std::string& x) {
    open("lag(" + x + ", {})", "tau", lags(0.5), "s");
    open("delay(" + x + ", {})", "delay", geometric(0.05, 5.0, 2.0), "s");
  }
  void hysteresis(const std::string& x, const Eigen::MatrixXd& values) {
    const double span = values.maxCoeff() - values.minCoeff();
    open("play(" + x + ", {})", "width", geometric(0.01 * span, 0.6 * span, 1.6));
  }
  void thresholds(const std::string& x) {
    const auto tree = laws::parse(x, signature_of(drivers_));
    if (!tree) return;
    const std::vector<double> levels = levels_in(laws::evaluate(*tree, drivers_));
    open("step(" + x + ", {})", "threshold", levels);
    open("step(" + x + ", {}) * (" + x + " - {})", "threshold", levels);
  }
  [[nodiscard]] std::vector<double> levels_of_own() const {
    std::vector<double> out = levels_in(drivers_.values.find(own_)->second.cwiseAbs());
    std::erase_if(out, [](double x) { return !(x > 0); });
    return out;
  }
  [[nodiscard]] std::vector<double> events() const {
    std::vector<double> out;
    const double step = std::max(1.0, length_s_ / 80.0);
    for (double t = kFirstEvent_s; t < length_s_ - kFirstEvent_s; t += step) out.push_back(t);
    if (out.empty()) out.push_back(0.5 * length_s_);
    return out;
  }
  [[nodiscard]] std::vector<double> lags(double longest) const { return geometric(0.2, longest * length_s_, 1.8); }
  [[nodiscard]] std::vector<double> settling() const { return geometric(0.5, 2.0 * length_s_, 1.8); }

  std::string own_;
  const laws::Columns& drivers_;
  double length_s_ = 0.0;
  std::vector<std::string> vectors_, scalars_, components_;
  std::vector<Idea> out_;
};

}  // namespace

std::string Idea::text(std::size_t part, double shape) const {
  std::string out = texts[part];
  // A small error of a line's period adds up over its many cycles.
  const bool of_a_line = shape_unit == "s" && shape < kOfALine_s;
  const std::string number = of_a_line ? fmt::format("{:.8g}", shape) : fmt::format("{:.5g}", shape);
  for (std::size_t at = out.find("{}"); at != std::string::npos; at = out.find("{}", at + number.size()))
    out.replace(at, 2, number);
  return out;
}

std::string lag_of(const std::string& x, const std::string& tau) {
  const bool bracketed = x.starts_with('(') && x.ends_with(')');
  return "lag(" + (bracketed ? x.substr(1, x.size() - 2) : x) + ", " + tau + ")";
}

laws::Signature signature_of(const laws::Columns& drivers) {
  std::vector<std::string> users;
  for (const auto& [name, x] : drivers.values)
    if (name.find('_') != std::string::npos && name.find('(') == std::string::npos) users.push_back(name);
  return laws::drivers_with(users);
}

/// Where the force is gravity alone, what is left of its size is the reading's own noise and wrong numbers: times the
/// force it would explain that noise by itself.
bool is_felt(const Eigen::MatrixXd& force) {
  constexpr double kFelt_mps2 = 0.1;
  const Eigen::ArrayXd size = force.rowwise().norm();
  return (size - size.mean()).matrix().norm() > kFelt_mps2 * std::sqrt(static_cast<double>(size.size()));
}

std::vector<std::string> scalar_factors(const laws::Columns& drivers) {
  std::vector<std::string> out{"norm(w)"};
  const auto has = [&](const char* name) { return drivers.values.contains(name); };
  if (has("T")) out.insert(out.end(), {"(T - 25)", "d(T)"});
  if (has("V")) out.emplace_back("(V - 3.7)");
  if (has("I")) out.emplace_back("I");
  if (has("f") && is_felt(drivers.values.at("f"))) out.emplace_back("(norm(f) - 9.81)");
  for (const auto& [name, x] : drivers.values)
    if (name.find('_') != std::string::npos && name.find('(') == std::string::npos) out.push_back(name);
  out.emplace_back("t");
  return out;
}

std::vector<std::string> scalar_leaves(const laws::Columns& drivers) {
  std::vector<std::string> out = scalar_factors(drivers);
  for (const char* v : {"w", "f", "m"})
    for (const char* axis : {"_x", "_y", "_z"})
      if (drivers.values.contains(v)) out.push_back(std::string(v) + axis);
  return out;
}

std::vector<Idea> wider_ideas(const laws::Columns& drivers) {
  const std::vector<double> tau(kWiderLags_s.begin(), kWiderLags_s.end());
  const double length = drivers.t_s[drivers.t_s.size() - 1] - drivers.t_s[0];
  std::vector<double> moments;
  for (double share = 0.1; share < 0.9; share += 0.04) moments.push_back(share * length);
  const std::vector<std::string> leaves = scalar_leaves(drivers);
  std::vector<Idea> out;
  for (const std::string& x : leaves) {
    for (const char* v : {"w", "f", "m"}) {
      if (!drivers.values.contains(v)) continue;
      for (const std::string& y : leaves)
        if (x <= y) out.push_back({{fmt::format("{} * {} * {}", v, x, y)}, {}, {}, {0.0}, true, {}, 1});
      if (x != "t") out.push_back({{v + (" * " + lag_of(x))}, "tau", "s", tau, true, {}, 1});
    }
    if (x == "t") continue;
    for (const std::string& y : leaves) out.push_back({{lag_of(x) + " * " + y}, "tau", "s", tau, false, {}, 1});
    out.push_back({{x + " * step(t, {})"}, "at", "s", moments, false, {}, 1});
  }
  return out;
}

std::vector<Idea> line_ideas(const laws::Columns& drivers, std::span<const double> lines_hz) {
  std::vector<Idea> out;
  const auto add = [&out](std::vector<std::string> texts, double f_hz) {
    out.push_back({std::move(texts), "period / 2 pi", "s", {1.0 / (2.0 * std::numbers::pi * f_hz)}, false});
  };
  for (const double f_hz : lines_hz) {
    for (const std::string& x : scalar_factors(drivers))
      if (x != "t") add({x + " * sin(t / {})", x + " * cos(t / {})"}, f_hz);
    std::vector<std::string> in_world;
    for (const char* axis : {"east", "north", "up"})
      if (drivers.values.contains(axis))
        for (const char* wave : {" * sin(t / {})", " * cos(t / {})"}) in_world.push_back(axis + std::string(wave));
    if (!in_world.empty()) add(std::move(in_world), f_hz);
  }
  return out;
}

std::vector<Idea> event_ideas(Sensor sensor, std::span<const double> moments_s) {
  std::vector<Idea> out;
  const std::string own = own_vector(sensor);
  const std::vector<double> tau = geometric(0.5, 40.0, 1.6);
  for (const double moment_s : moments_s) {
    const std::string at = fmt::format("{:.6g}", moment_s), settles = "exp(-(t - " + at + ") / {})";
    for (const bool matrix : {false, true}) {
      const std::string on = fmt::format("{}step(t, {})", matrix ? own + " * " : "", at);
      out.push_back({{on}, {}, {}, {0.0}, matrix});
      out.push_back({{fmt::format("{} * {}", on, settles)}, "tau", "s", tau, matrix, {}, 1});
      out.push_back({{fmt::format("{} * (1 - {})", on, settles)}, "tau", "s", tau, matrix, {}, 1});
    }
  }
  return out;
}

std::vector<Idea> table_ideas(const laws::Columns& drivers) {
  std::vector<Idea> out;
  for (const std::string& text : scalar_leaves(drivers)) {
    const auto tree = laws::parse(text, signature_of(drivers));
    if (!tree || text == "t") continue;  // a free function of time predicts nothing
    std::vector<double> points = table_points(laws::evaluate(*tree, drivers));
    if (!points.empty()) out.push_back({{text}, {}, {}, {0.0}, false, std::move(points)});
  }
  return out;
}

std::vector<Idea> first_ideas(Sensor sensor, const laws::Columns& drivers) {
  Ideas ideas(sensor, drivers);
  ideas.of_scalars();
  ideas.of_components();
  ideas.of_vectors();
  ideas.of_the_reading();
  ideas.of_time();
  return ideas.take();
}

}  // namespace stillpoint::diag
