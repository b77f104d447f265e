#include "diagnosis/discovery/law_curves.h"

#include <algorithm>

#include "diagnosis/discovery/drivers.h"
#include "diagnosis/discovery/law_words.h"

namespace stillpoint::diag {
namespace {

constexpr Eigen::Index kMostPoints = 1000;
constexpr std::size_t kMostQuantities = 6;

/// What is drawn as one quantity: a driver or an axis of it, its size, and whatever remembers, which is no function of
/// what it remembers.
bool is_quantity(const laws::Node& n) {
  using enum laws::Op;
  switch (n.op) {
    case kDriver:
    case kComponent:
    case kNorm:
    case kRate:
    case kIntegral:
    case kLag:
    case kDelay:
    case kPlay:
      return true;
    default:
      return false;
  }
}

void quantities_of(const laws::Node& n, std::vector<laws::Node>& out) {
  if (!is_quantity(n)) {
    for (const laws::Node& arg : n.args) quantities_of(arg, out);
    return;
  }
  const auto same = [&n](const laws::Node& known) { return laws::text(known) == laws::text(n); };
  if (std::none_of(out.begin(), out.end(), same)) out.push_back(n);
}

AgainstQuantity drawn(std::string label, const Series& x, const Series& before, const Series& after,
                      const Layout& layout) {
  AgainstQuantity out{std::move(label), {}, {}, {}};
  const Eigen::Index step = std::max<Eigen::Index>(1, x.size() / kMostPoints);
  for (Eigen::Index i = 0; i < x.size(); i += step) {
    if (layout.present[i] == 0.0) continue;
    out.x.push_back(x[i]);
    out.before.push_back(before[i]);
    out.after.push_back(after[i]);
  }
  return out;
}

std::string label_of(const laws::Node& quantity, int axis) {
  const std::string name = laws::text(quantity) + (quantity.vector ? std::string(", axis ") + "xyz"[axis] : "");
  const bool is_temperature = quantity.op == laws::Op::kDriver && laws::text(quantity) == "T";
  const std::string unit = is_temperature ? "degC" : laws::text(quantity.unit);  // differences are in K
  return unit == "1" ? name : name + ", " + unit;
}

/// A recorded column that is no part of the law; one of another name says its unit itself.
std::string label_of_column(const std::string& name) {
  const auto driver = law_tree("unknown:" + name);
  return driver ? label_of(*driver, 0) : name;
}

}  // namespace

std::vector<AgainstQuantity> against_each(const Signals& s, const std::string& effect, int axis, const Series& before,
                                          const Series& after, const Layout& layout) {
  const auto law = law_tree(effect);
  if (!law) return {};
  const laws::Columns rows = drivers_of_rows(s);
  const auto recorded = [&rows](const std::string& name) { return name == "t" || rows.values.contains(name); };
  const std::vector<std::string> used = laws::drivers_of(*law);
  if (!std::all_of(used.begin(), used.end(), recorded)) return {};
  std::vector<AgainstQuantity> out;
  std::vector<laws::Node> quantities;
  quantities_of(*law, quantities);
  for (const laws::Node& q : quantities) {
    const Eigen::MatrixXd x = laws::evaluate(q, rows);
    out.push_back(drawn(label_of(q, axis), x.col(x.cols() == 3 ? axis : 0), before, after, layout));
  }
  for (const auto& [name, x] : rows.values)
    if (x.cols() == 1 && name.find('(') == std::string::npos && std::find(used.begin(), used.end(), name) == used.end())
      out.push_back(drawn(label_of_column(name), x.col(0), before, after, layout));
  if (out.size() > kMostQuantities) out.resize(kMostQuantities);
  return out;
}

}  // namespace stillpoint::diag
