#include "diagnosis/discovery/law_entry.h"

#include <fmt/format.h>

#include <cmath>

#include "diagnosis/discovery/law_words.h"
#include "diagnosis/discovery/table_term.h"
#include "simulation/law_effect.h"

namespace stillpoint::diag {
namespace {

constexpr double kSeen = 3.0;  // standard deviations

std::optional<sim::EffectConfig> formula_entry(sim::EffectConfig e, const Eigen::VectorXd& values,
                                               const Eigen::VectorXd& sd) {
  const auto tree = sim::tree_of(e);
  if (!tree || (values.size() != 3 && values.size() != 9) || (values.size() == 9 && !tree->vector)) return std::nullopt;
  auto& numbers = e.parameters[values.size() == 9 ? "matrix" : "k"];
  for (Eigen::Index i = 0; i < values.size(); ++i)
    numbers.push_back(std::abs(values[i]) > kSeen * sd[i] ? values[i] : 0.0);
  return e;
}

/// Beyond its range a table that was found keeps its end values: another recording goes a little further.
sim::EffectConfig table_entry(sim::EffectConfig e, const Found& found, const Eigen::VectorXd& values,
                              const Eigen::VectorXd& sd) {
  auto &x = e.parameters["x"], &y = e.parameters["y"];
  for (std::size_t i = 0; i < found.fixed.size(); ++i) x.push_back(found.fixed.at(fmt::format("x{}", i)));
  const auto free = free_points(x.size());
  const auto count = static_cast<Eigen::Index>(free.size());
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::vector<double> row(x.size(), 0.0);
    const auto v = values.segment(axis * count, count).array(), s = sd.segment(axis * count, count).array();
    if ((v.abs() > kSeen * s).any())
      for (Eigen::Index i = 0; i < count; ++i) row[free[static_cast<std::size_t>(i)]] = v[i];
    y.insert(y.end(), row.begin(), row.end());
  }
  e.parameters["clamp"] = {1.0};
  return e;
}

}  // namespace

std::optional<sim::EffectConfig> law_entry(const Found& found, Sensor sensor, const Eigen::VectorXd& values,
                                           const Eigen::VectorXd& sd) {
  if (!is_unknown(found.id) || found.window.local || found.shape_name == kTrackerShape) return std::nullopt;
  const std::string text = law_text(found.id);
  const auto driver = driver_of_table(text);
  sim::EffectConfig e;
  e.id = std::string(driver ? sim::kTablePrefix : sim::kLawPrefix) + driver.value_or(text);
  e.sensors = {static_cast<sim::Sensor>(sensor)};
  return driver ? table_entry(std::move(e), found, values, sd) : formula_entry(std::move(e), values, sd);
}

}  // namespace stillpoint::diag
