#include "simulation/law_effect.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

namespace stillpoint::sim {
namespace {

const std::vector<double>* numbers(const EffectConfig& e, const char* key) {
  const auto it = e.parameters.find(key);
  return it == e.parameters.end() || it->second.empty() ? nullptr : &it->second;
}

laws::Table table_of(const EffectConfig& e) {
  laws::Table out{*numbers(e, "x"), {}, {}};
  const auto curves = curves_of(e);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.y[axis] = curves[axis].values();
    out.slope[axis] = curves[axis].slopes();
  }
  return out;
}

laws::Node checked_tree(const EffectConfig& e) {
  auto tree = tree_of(e);
  SP_EXPECTS(tree.has_value());
  return std::move(*tree);
}

}  // namespace

bool is_law(const EffectConfig& e) { return e.id.starts_with(kLawPrefix); }
bool is_table(const EffectConfig& e) { return e.id.starts_with(kTablePrefix); }

std::string expression_of(const EffectConfig& e) {
  return e.id.substr(is_law(e) ? kLawPrefix.size() : is_table(e) ? kTablePrefix.size() : 0);
}

laws::Signature signature_for(std::string_view expression) {
  std::vector<std::string> columns;
  const auto part = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  for (std::size_t at = 0; at < expression.size();) {
    std::size_t end = at;
    while (end < expression.size() && part(expression[end])) ++end;
    const std::string name(expression.substr(at, end - at));
    const std::size_t bar = name.rfind('_');
    const bool axis = bar != std::string::npos && laws::standard_drivers().contains(name.substr(0, bar));
    if (bar != std::string::npos && bar > 0 && bar + 1 < name.size() && !axis &&
        std::isalpha(static_cast<unsigned char>(name.front())) != 0)
      columns.push_back(name);
    at = std::max(end, at + 1);
  }
  return laws::drivers_with(columns);
}

tl::expected<laws::Node, laws::Fault> tree_of(const EffectConfig& e) {
  const std::string text = expression_of(e);
  const laws::Signature drivers = signature_for(text);
  auto tree = laws::parse(text, drivers);
  const auto* tau = numbers(e, "tau_s");
  if (!tree || tau == nullptr) return tree;
  return laws::checked(laws::apply(laws::Op::kLag, {std::move(*tree), laws::number(tau->front())}), drivers);
}

laws::Coupled coupled(const EffectConfig& e) {
  laws::Coupled out;
  out.tree = checked_tree(e);
  if (is_table(e)) out.table = table_of(e);
  const auto *k = numbers(e, "k"), *matrix = numbers(e, "matrix");
  out.has_matrix = matrix != nullptr;
  if (matrix != nullptr) std::copy(matrix->begin(), matrix->end(), out.matrix.begin());
  if (k != nullptr) std::copy(k->begin(), k->end(), out.matrix.begin());
  if (e.window_s) std::tie(out.from_s, out.to_s) = *e.window_s;
  const Sensor sensor = e.sensors.empty() ? Sensor::kAcc : e.sensors.front();
  out.sensor = sensor == Sensor::kAcc ? "accelerometer" : sensor == Sensor::kGyr ? "gyroscope" : "magnetometer";
  out.unit = sensor == Sensor::kAcc ? "m/s^2" : sensor == Sensor::kGyr ? "rad/s" : "uT";
  return out;
}

Curve::Curve(std::vector<double> x, std::vector<double> y) : x_(std::move(x)), y_(std::move(y)) {
  const std::size_t n = x_.size();
  SP_EXPECTS(n >= 2 && y_.size() == n);
  slope_.assign(n, 0.0);
  const auto secant = [this](std::size_t i) { return (y_[i + 1] - y_[i]) / (x_[i + 1] - x_[i]); };
  slope_.front() = secant(0);
  slope_.back() = secant(n - 2);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double a = secant(i - 1), b = secant(i);
    if (a * b <= 0.0) continue;
    const double ha = x_[i] - x_[i - 1], hb = x_[i + 1] - x_[i];
    const double wa = 2.0 * hb + ha, wb = hb + 2.0 * ha;
    slope_[i] = (wa + wb) / (wa / a + wb / b);
  }
}

double Curve::at(double x) const noexcept {
  if (x <= x_.front()) return y_.front();
  if (x >= x_.back()) return y_.back();
  const auto k = static_cast<std::size_t>(std::upper_bound(x_.begin(), x_.end(), x) - x_.begin()) - 1;
  const double h = x_[k + 1] - x_[k], s = (x - x_[k]) / h;
  const double value = y_[k] * (1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s) + y_[k + 1] * s * s * (3.0 - 2.0 * s);
  return value + h * (slope_[k] * s * (1.0 - s) * (1.0 - s) - slope_[k + 1] * s * s * (1.0 - s));
}

std::array<Curve, 3> curves_of(const EffectConfig& table) {
  const auto &x = *numbers(table, "x"), &y = *numbers(table, "y");
  const auto row = [&](std::size_t axis) {
    const auto begin = y.begin() + static_cast<std::ptrdiff_t>(axis * x.size());
    return Curve(x, {begin, begin + static_cast<std::ptrdiff_t>(x.size())});
  };
  return {row(0), row(1), row(2)};
}

LawEffect::LawEffect(const EffectConfig& e) : stream_(checked_tree(e)) {
  constexpr double kEver = std::numeric_limits<double>::max();
  std::tie(from_s_, to_s_) = e.window_s.value_or(std::pair{-kEver, kEver});
  if (!e.axes.empty()) axes_.setZero();
  for (const int axis : e.axes) axes_[axis] = 1.0;
  if (is_table(e)) {
    for (auto& c : curves_of(e)) curves_.push_back(std::move(c));
    clamp_ = numbers(e, "clamp") != nullptr && numbers(e, "clamp")->front() != 0.0;
  } else {
    const laws::Coupled law = coupled(e);
    matrix_ = law.has_matrix ? Mat3(mat(law.matrix)) : Mat3(Vec3(law.matrix.data()).asDiagonal());
  }
}

Vec3 LawEffect::next(const laws::DriverAt& drivers, double t_s) {
  const Vec3 x = stream_.next(drivers, t_s);  // also outside the window: its memory goes on
  outside_ = false;
  if (t_s < from_s_ || t_s > to_s_) return Vec3::Zero();
  if (curves_.empty()) return axes_.cwiseProduct(matrix_ * x);
  Vec3 out;
  for (int i = 0; i < 3; ++i) {
    const Curve& curve = curves_[static_cast<std::size_t>(i)];
    out[i] = axes_[i] * curve.at(x[i]);
    outside_ = outside_ || (!clamp_ && axes_[i] != 0.0 && !curve.covers(x[i]));
  }
  return out;
}

std::vector<LawEffect> law_effects(const std::vector<EffectConfig>& effects, Sensor sensor) {
  std::vector<LawEffect> out;
  for (const EffectConfig& e : effects)
    if ((is_law(e) || is_table(e)) && !e.sensors.empty() && e.sensors.front() == sensor) out.emplace_back(e);
  return out;
}

std::vector<std::string> user_columns_of(const std::vector<EffectConfig>& effects) {
  std::vector<std::string> out;
  for (const EffectConfig& e : effects) {
    if (!is_law(e) && !is_table(e)) continue;
    for (const std::string& name : laws::drivers_of(checked_tree(e)))
      if (!laws::standard_drivers().contains(name) && std::find(out.begin(), out.end(), name) == out.end())
        out.push_back(name);
  }
  return out;
}

}  // namespace stillpoint::sim
