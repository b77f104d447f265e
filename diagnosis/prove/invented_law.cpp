#include "diagnosis/prove/invented_law.h"
#include "simulation/effect_catalogue.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace stillpoint::diag::invented {
namespace {

/// A number as a function of the scene, of order one.
struct Number {
  std::function<Eigen::VectorXd(const Scene&)> value;
  std::string text;
  std::set<std::string> drivers;
};

const Eigen::MatrixXd& vector_of(const Scene& s, const std::string& name) {
  return name == "w" ? s.w : name == "f" ? s.f : s.m;
}

double size_of(const std::string& vector) { return vector == "w" ? 2.0 : vector == "f" ? 9.8 : 48.0; }

Number draw_leaf(Draw& draw, const Scene& scene) {
  const std::size_t which = draw.bits() % 10;
  if (which < 5) {
    static const std::vector<std::string> names{"T", "I", "V", "motor_rpm", "pressure_kPa"};
    const std::string& name = names[which];
    const Eigen::VectorXd& x = scene.scalars.at(name);
    // A driver counts from where the part was calibrated, not from its mean in this recording.
    const double middle = name == "T" ? sim::kReferenceTemp_degC : name == "V" ? sim::kReferenceSupply_V : 0.0;
    const double size = std::max(1e-9, (x.array() - middle).matrix().norm() / std::sqrt(static_cast<double>(x.size())));
    return {[name, middle, size](const Scene& s) -> Eigen::VectorXd {
              return (s.scalars.at(name).array() - middle) / size;
            },
            middle == 0.0 ? name : fmt::format("({} - {})", name, middle),
            {name}};
  }
  static const std::vector<std::string> vectors{"w", "f", "m"};
  const std::string& v = vectors[which == 5 ? 0 : draw.bits() % 3];
  const double size = size_of(v);
  if (which == 5 || which == 6) {
    const double rest = v == "f" ? 9.81 : v == "m" ? 48.0 : 0.0;
    return {[v, size, rest](const Scene& s) -> Eigen::VectorXd {
              return (vector_of(s, v).rowwise().norm().array() - rest) / size;
            },
            "|" + v + "|",
            {v}};
  }
  const auto axis = static_cast<Eigen::Index>(draw.bits() % 3);
  return {[v, axis, size](const Scene& s) -> Eigen::VectorXd { return vector_of(s, v).col(axis) / size; },
          fmt::format("{}_{}", v, "xyz"[axis]),
          {v}};
}

Number bent(Draw& draw, Number x) {
  const auto apply = [&x](const std::string& words, std::function<double(double)> g) {
    return Number{[value = x.value, g](const Scene& s) -> Eigen::VectorXd { return value(s).unaryExpr(g); },
                  fmt::format(fmt::runtime(words), x.text), x.drivers};
  };
  const double c = draw.uniform(0.3, 1.2);
  switch (draw.bits() % 6) {
    case 0:
      return apply("{}^2", [](double v) { return v * v; });
    case 1:
      return apply("|{}|", [](double v) { return std::abs(v); });
    case 2:
      return apply("tanh(" + fmt::format("{:.2f}", 1.0 / c) + " {})", [c](double v) { return std::tanh(v / c); });
    case 3:
      return apply("{}^3", [](double v) { return v * v * v; });
    case 4:
      return apply("max({} - " + fmt::format("{:.2f}", 0.5 * c) + ", 0)",
                   [c](double v) { return std::max(v - 0.5 * c, 0.0); });
    default:
      return apply("1 / (1 + {}^2)", [](double v) { return 1.0 / (1.0 + v * v); });
  }
}

Eigen::VectorXd lagged(const Eigen::VectorXd& x, const Eigen::VectorXd& t, double tau) {
  Eigen::VectorXd y = x;
  for (Eigen::Index i = 1; i < x.size(); ++i) {
    const double keep = std::exp(-(t[i] - t[i - 1]) / tau);
    y[i] = keep * y[i - 1] + (1.0 - keep) * 0.5 * (x[i] + x[i - 1]);
  }
  return y;
}

Number remembered(Draw& draw, Number x) {
  const double tau = draw.log_uniform(0.3, 8.0);
  const bool twice = draw.bits() % 4 == 0;
  return {[value = x.value, tau, twice](const Scene& s) {
            const Eigen::VectorXd once = lagged(value(s), s.t, tau);
            return twice ? lagged(once, s.t, tau) : once;
          },
          fmt::format("lag{}({}, {:.2f} s)", twice ? "2" : "", x.text, tau), x.drivers};
}

Number times(const Number& a, const Number& b) {
  std::set<std::string> drivers = a.drivers;
  drivers.insert(b.drivers.begin(), b.drivers.end());
  return {[x = a.value, y = b.value](const Scene& s) -> Eigen::VectorXd { return x(s).cwiseProduct(y(s)); },
          a.text + " * " + b.text, drivers};
}

Number draw_number(Draw& draw, const Scene& scene) {
  Number x = draw_leaf(draw, scene);
  if (draw.bits() % 3 == 0) x = bent(draw, std::move(x));
  if (draw.bits() % 5 == 0) x = remembered(draw, std::move(x));
  if (draw.bits() % 2 == 0) x = times(x, draw_leaf(draw, scene));
  return x;
}

/// Only from a time on, or while a driver is high.
Number in_regime(Draw& draw, const Scene& scene, const Number& x) {
  if (draw.bits() % 2 == 0) {
    const double from = draw.uniform(0.25, 0.6) * scene.t[scene.t.size() - 1];
    Number out = x;
    out.value = [value = x.value, from](const Scene& s) -> Eigen::VectorXd {
      return (s.t.array() > from).select(value(s), 0.0);
    };
    out.text += fmt::format(" from {:.1f} s", from);
    out.drivers.insert("t");
    return out;
  }
  const Number gate = draw_leaf(draw, scene);
  Eigen::VectorXd sorted = gate.value(scene);
  std::sort(sorted.begin(), sorted.end());
  const double level = sorted[sorted.size() / 2];
  Number out = times(
      x, {[g = gate.value, level](const Scene& s) -> Eigen::VectorXd { return (g(s).array() > level).cast<double>(); },
          fmt::format("[{} high]", gate.text), gate.drivers});
  return out;
}

}  // namespace

Eigen::VectorXd smooth(const Eigen::VectorXd& x, Eigen::Index half) {
  Eigen::VectorXd out(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const Eigen::Index reach = std::min({half, i, x.size() - 1 - i});
    out[i] = x.segment(i - reach, 2 * reach + 1).mean();
  }
  return out;
}

Law draw_law(Draw& draw, const Scene& scene, const std::string& own) {
  Number x = draw_number(draw, scene);
  if (draw.bits() % 6 == 0) x = in_regime(draw, scene, x);
  const std::size_t coupling = draw.bits() % 4;
  Eigen::Matrix3d K = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double k = draw.normal();
      if (i == j || coupling == 3) K(i, j) = k;
    }
  Law out;
  out.drivers = x.drivers;
  if (coupling < 2) {
    out.text = "k * " + x.text;
    out.value = [x = x.value, k = Eigen::RowVector3d(K.diagonal())](const Scene& s) -> Eigen::MatrixXd {
      return x(s) * k;
    };
    return out;
  }
  static const std::vector<std::string> vectors{"w", "f", "m"};
  const std::string v = coupling == 2 ? own : draw.one_of(vectors);
  out.drivers.insert(v);
  out.text = fmt::format("{} {} * {}", coupling == 3 ? "K" : "k o", v, x.text);
  out.value = [x = x.value, K, v](const Scene& s) -> Eigen::MatrixXd {
    return x(s).asDiagonal() * vector_of(s, v) * K.transpose();
  };
  return out;
}

}  // namespace stillpoint::diag::invented
