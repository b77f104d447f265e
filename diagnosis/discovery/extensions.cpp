#include "diagnosis/discovery/extensions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/discovery/open_numbers.h"

namespace stillpoint::diag {
namespace {

constexpr std::size_t kMostFactors = 4;
constexpr double kLongestOfAFactor = 0.15;  // time constant, of the recording
constexpr double kMomentsInRegime = 25.0;
constexpr std::array<double, 7> kEarlier_s{0.0, 1.0, 2.0, 3.0, 4.5, 6.0, 8.0};
constexpr std::array<double, 5> kAround{0.6, 0.8, 1.0, 1.25, 1.6};  // times a number that is looked for anew
constexpr double kMomentReach_s = 2.0, kMomentStep_s = 0.25;

struct Factor {
  std::string text;
  bool vector = false;
  bool plain = false;  ///< a driver, an axis, a size or a difference from a constant: it may still be bent
  std::string inside;  ///< of a lag: what is lagged, where that is plain
  std::string tau;     ///< of a lag
};

bool is_plain(const laws::Node& n) {
  using enum laws::Op;
  const bool shifted = n.op == kSubtract && n.args[1].op == kNumber;
  return n.op == kDriver || n.op == kComponent || n.op == kNorm || n.op == kRate || shifted;
}

/// A sum in brackets, so that it may stand beside a factor.
std::string in_brackets(const laws::Node& n) {
  using enum laws::Op;
  const bool sum = n.op == kAdd || n.op == kSubtract || n.op == kDivide || n.op == kNegate;
  return sum ? "(" + laws::text(n) + ")" : laws::text(n);
}

void collect_factors(const laws::Node& n, std::vector<Factor>& out) {
  using enum laws::Op;
  if (n.op == kMultiply) {
    for (const laws::Node& a : n.args) collect_factors(a, out);
    return;
  }
  Factor f{in_brackets(n), n.vector, is_plain(n), {}, {}};
  if (n.op == kLag && is_plain(n.args[0]) && !n.vector)
    f.inside = in_brackets(n.args[0]), f.tau = laws::text(n.args[1]);
  out.push_back(std::move(f));
}

class Neighbours {
 public:
  Neighbours(const Idea& best, double shape, const laws::Columns& drivers)
      : best_(best), shape_(shape), drivers_(drivers), signature_(signature_of(drivers)) {
    length_s_ = drivers.t_s[drivers.t_s.size() - 1] - drivers.t_s[0];
    leaves_ = scalar_leaves(drivers);
    const auto tree = laws::parse(best.text(0, shape), signature_);
    if (!tree) return;
    collect_factors(*tree, factors_);
    may_grow_ = factors_.size() < kMostFactors;
    if (best.texts.size() != 1) {
      factors_.clear();
      return;
    }
    text_ = best.text(0, shape);
    vector_ = tree->vector;
  }

  std::vector<Idea> all() {
    further_factor();
    if (factors_.empty()) return std::move(out_);
    settling();
    coupling();
    for (std::size_t i = 0; i < factors_.size(); ++i) {
      if (factors_[i].vector) other_vector(i);
      if (!factors_[i].vector) other_scalar(i), memory_of(i);
      if (factors_[i].plain && !factors_[i].vector) bends_of(i);
      if (!factors_[i].inside.empty()) bends_in_lag(i);
      if (factors_.size() > 1) add(with(i, ""), best_.matrix && vector_, -1);
    }
    open("lag(" + text_ + ", {})", "tau", "s", geometric(0.2, 0.3 * length_s_, 1.8));
    regimes();
    return std::move(out_);
  }

 private:
  void add(std::string text, bool matrix, int step = 1) { push({{std::move(text)}, {}, {}, {0.0}, matrix}, step); }
  void open(std::string text, const char* name, const char* unit, std::vector<double> shapes) {
    push({{std::move(text)}, name, unit, std::move(shapes), best_.matrix}, 1);
  }
  void push(Idea idea, int step) {
    idea.steps = static_cast<std::size_t>(std::max(0, static_cast<int>(best_.steps) + step));
    if (!idea.shapes.empty() && !idea.texts.front().empty()) out_.push_back(std::move(idea));
  }
  /// The product with factor `at` replaced; with nothing: without it.
  [[nodiscard]] std::string with(std::size_t at, const std::string& instead) const {
    std::string out;
    for (std::size_t i = 0; i < factors_.size(); ++i) {
      const std::string& f = i == at ? instead : factors_[i].text;
      if (!f.empty()) out += (out.empty() ? "" : " * ") + f;
    }
    return out;
  }

  void further_factor() {
    if (!may_grow_) return;
    for (const std::string& leaf : leaves_) {
      Idea idea{{}, {}, {}, {0.0}, best_.matrix};
      for (std::size_t part = 0; part < best_.texts.size(); ++part)
        idea.texts.push_back(best_.text(part, shape_) + " * " + leaf);
      push(std::move(idea), 1);
    }
  }

  void coupling() {
    if (vector_) return add(text_, !best_.matrix, best_.matrix ? -1 : 1);
    for (const char* v : {"w", "f", "m"})
      for (const bool matrix : {false, true})
        if (drivers_.values.contains(v)) add(text_ + " * " + v, matrix);
  }

  void bends_of(std::size_t at) {
    const std::string& x = factors_[at].text;
    for (const char* form : {"{0}^2", "{0}^3", "abs({0})", "abs({0})^0.5"})
      add(with(at, fmt::format(fmt::runtime(form), x)), best_.matrix);
    const auto tree = laws::parse(x, signature_);
    if (!tree) return;
    const Eigen::MatrixXd value = laws::evaluate(*tree, drivers_);
    const std::vector<double> levels = levels_in(value);
    const double size = value.norm() / std::sqrt(static_cast<double>(value.size()));
    const std::vector<double> widths = geometric(0.2 * size, 3.0 * size, 1.7);
    open(with(at, "tanh(" + x + " / {})"), "level", "", widths);
    open(with(at, "(1 / (1 + (" + x + " / {})^2))"), "width", "", widths);
    open(with(at, "step(" + x + ", {}) * (" + x + " - {})"), "threshold", "", levels);
    open(with(at, "step(" + x + ", {})"), "threshold", "", levels);
  }

  /// Of what is bent already, and a second lag, too. Within a product a longer memory is a trend: on another motion it
  /// predicts nothing.
  void memory_of(std::size_t at) {
    if (factors_[at].text.find("step(t") != std::string::npos) return;
    open(with(at, lag_of(factors_[at].text)), "tau", "s", geometric(0.2, kLongestOfAFactor * length_s_, 1.8));
  }

  void bends_in_lag(std::size_t at) {
    for (const char* form : {"lag({0}^2, {1})", "lag({0}^3, {1})", "lag(abs({0}), {1})"})
      add(with(at, fmt::format(fmt::runtime(form), factors_[at].inside, factors_[at].tau)), best_.matrix);
  }

  /// A factor is as often one of its relatives: what goes along with it in this motion, or another axis of it.
  void other_scalar(std::size_t at) {
    for (const std::string& leaf : leaves_) {
      if (leaf == factors_[at].text) continue;
      add(with(at, leaf), best_.matrix, 0);
      if (!factors_[at].inside.empty() && leaf != "t") add(with(at, lag_of(leaf, factors_[at].tau)), best_.matrix, 0);
    }
    if (!vector_ || !factors_[at].text.starts_with("norm(")) return;
    for (const char* v : {"w", "f", "m"})  // what each axis does by its own size
      if (drivers_.values.contains(v)) add(with(at, fmt::format("abs({})", v)), best_.matrix, 0);
  }

  void other_vector(std::size_t at) {
    for (const char* v : {"w", "f", "m"})
      if (factors_[at].plain && drivers_.values.contains(v) && factors_[at].text != v)
        add(with(at, v), best_.matrix, 0);
  }

  void regimes() {
    if (factors_.size() > kMostFactors) return;
    std::vector<double> moments;
    for (double t = 0.1 * length_s_; t < 0.9 * length_s_; t += length_s_ / kMomentsInRegime) moments.push_back(t);
    open(text_ + " * step(t, {})", "at", "s", std::move(moments));
    for (const std::string& leaf : leaves_)
      if (const auto tree = laws::parse(leaf, signature_); tree && leaf != "t")
        open(text_ + " * step(" + leaf + ", {})", "threshold", "", levels_in(laws::evaluate(*tree, drivers_)));
  }

  /// What settles slowly after an event begins before its step seems to be.
  void settling() {
    if (text_.find("step(t, ") == std::string::npos || best_.shape_name != "at") return;
    const std::vector<double> tau = geometric(0.5, 40.0, 1.6);
    const std::string own = text_.substr(0, text_.find("step(t, "));
    for (const double earlier : kEarlier_s) {
      const std::string at = fmt::format("{:.5g}", std::max(0.5, shape_ - earlier));
      const std::string on = fmt::format("{}step(t, {})", own, at), settles = fmt::format("exp(-(t - {}) / {{}})", at);
      open(fmt::format("{} * {}", on, settles), "tau", "s", tau);
      open(fmt::format("{} * (1 - {})", on, settles), "tau", "s", tau);
    }
    add(text_ + fmt::format(" * (t - {:.5g})", shape_), best_.matrix);
  }

  const Idea& best_;
  double shape_;
  const laws::Columns& drivers_;
  laws::Signature signature_;
  double length_s_ = 0.0;
  std::vector<std::string> leaves_;
  std::vector<Factor> factors_;
  std::string text_;
  bool vector_ = false, may_grow_ = false;
  std::vector<Idea> out_;
};

}  // namespace

std::vector<Idea> extensions(const Idea& best, double shape, const laws::Columns& drivers) {
  return Neighbours(best, shape, drivers).all();
}

std::vector<Idea> reopened(const Idea& best, double shape) {
  std::vector<Idea> out;
  if (best.texts.size() != 1) return out;
  const std::string text = best.text(0, shape);
  for (const OpenNumber& n : open_numbers(text)) {
    const double now = std::stod(n.digits);
    std::vector<double> around;
    if (n.name == "at")
      for (double step = -kMomentReach_s; step <= kMomentReach_s; step += kMomentStep_s) around.push_back(now + step);
    else
      for (const double factor : kAround) around.push_back(factor * now);
    std::sort(around.begin(), around.end());
    if (n.name == "at") std::erase_if(around, [](double t) { return t <= 0.0; });
    if (now == 0.0 || around.empty()) continue;
    out.push_back(
        {{with_number(text, n.digits, "{}")}, n.name, n.unit, std::move(around), best.matrix, {}, best.steps});
  }
  return out;
}

}  // namespace stillpoint::diag
