#include "diagnosis/discovery/table_term.h"

#include <algorithm>

namespace stillpoint::diag {
namespace {

constexpr int kMostKnots = 12, kLeastKnots = 4;
constexpr double kClosest = 0.04;  // of the range
constexpr double kTail = 0.01;     // of the rows, at either end: too few to hold a point of their own
constexpr std::string_view kBefore = "table(", kBehind = ")";

/// 1 at point `at`, 0 at its neighbours; the end points keep their value beyond the range.
double hat(double x, const std::vector<double>& points, std::size_t at) {
  x = std::clamp(x, points.front(), points.back());
  if (at > 0 && x < points[at]) return std::max(0.0, (x - points[at - 1]) / (points[at] - points[at - 1]));
  if (at + 1 < points.size() && x > points[at])
    return std::max(0.0, (points[at + 1] - x) / (points[at + 1] - points[at]));
  return x == points[at] ? 1.0 : 0.0;
}

}  // namespace

std::vector<double> table_points(const Eigen::MatrixXd& driver) {
  const Eigen::VectorXd all = driver.reshaped();
  const double low = all.minCoeff(), range = all.maxCoeff() - low;
  std::vector<double> out;
  for (int i = 0; i < kMostKnots; ++i) {
    const double x = quantile(all, kTail + (1.0 - 2.0 * kTail) * i / (kMostKnots - 1));
    if (out.empty() || x > out.back() + kClosest * range) out.push_back(x);
  }
  if (std::ssize(out) < kLeastKnots) out.clear();
  return out;
}

std::vector<std::size_t> free_points(std::size_t points) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < points; ++i)
    if (i != points / 2) out.push_back(i);
  return out;
}

Columns table_columns(const Series& driver, const std::vector<double>& points) {
  Columns out;
  for (int axis = 0; axis < 3; ++axis)
    for (const std::size_t at : free_points(points.size()))
      out.push_back({axis, driver.unaryExpr([&](double x) { return hat(x, points, at); })});
  return out;
}

std::string table_text(const std::string& driver) { return std::string(kBefore) + driver + std::string(kBehind); }

std::optional<std::string> driver_of_table(const std::string& text) {
  if (!text.starts_with(kBefore) || !text.ends_with(kBehind)) return std::nullopt;
  return text.substr(kBefore.size(), text.size() - kBefore.size() - kBehind.size());
}

}  // namespace stillpoint::diag
