/// `stillpoint calibrate --points`: runs one method on a table, prints its result or why there is none.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/stillpoint/calibrate.h"
#include "apps/stillpoint/json_text.h"
#include "apps/stillpoint/outcome.h"
#include "apps/stillpoint/points_table.h"
#include "io/text_file.h"

namespace stillpoint::app {
namespace {

using Json = nlohmann::ordered_json;

Json rows(const Mat3& m) {
  Json out = Json::array();
  for (int r = 0; r < 3; ++r) out.push_back({m(r, 0), m(r, 1), m(r, 2)});
  return out;
}

/// |matrix (reading - offset)| - 1 of every reading, in the order of the table; none without a result.
std::vector<double> norm_residuals(const calib::PointsFit& fit, const std::vector<calib::Point>& points) {
  std::vector<double> out;
  if (fit.status != calib::FitStatus::kOk) return out;
  for (const auto& p : points) out.push_back((fit.matrix * (p.y - fit.offset)).norm() - 1.0);
  return out;
}

Json to_json(const std::string& method, const calib::PointsFit& fit, std::size_t count,
             const std::vector<double>& residuals) {
  const bool ok = fit.status == calib::FitStatus::kOk;
  Json j;
  j["method"] = method;
  j["status"] = calib::name(fit.status);
  j["points"] = count;
  j["offset"] = ok ? Json(array(fit.offset)) : Json();
  j["radii"] = ok && fit.radii ? Json(array(*fit.radii)) : Json();
  j["matrix"] = ok ? rows(fit.matrix) : Json();
  j["covariance"] = nullptr;
  if (ok && fit.covariance.size() > 0) {
    j["covariance"] = Json::array();
    for (Eigen::Index r = 0; r < fit.covariance.rows(); ++r) {
      Json row = Json::array();
      for (Eigen::Index c = 0; c < fit.covariance.cols(); ++c) row.push_back(fit.covariance(r, c));
      j["covariance"].push_back(row);
    }
    j["covariance_of"] = fit.radii ? Json{"offset_x", "offset_y", "offset_z", "radius_x", "radius_y", "radius_z"}
                                   : Json{"offset_x", "offset_y", "offset_z", "m00", "m01", "m02", "m11", "m12", "m22"};
  }
  j["residual_rms"] = ok ? Json(fit.residual_rms) : Json();
  j["residuals"] = Json::array();
  for (const double r : residuals) j["residuals"].push_back(r);
  j["iterations"] = fit.iterations;
  j["reason"] = fit.reason;
  j["conditions_violated"] = fit.conditions;
  j["set_aside"] = Json::array();
  for (const std::size_t i : fit.set_aside) j["set_aside"].push_back(i + 1);
  return j;
}

void print(const std::string& method, const calib::PointsFit& fit, const std::vector<double>& residuals) {
  fmt::print("{}: {}, {} points\n", method, calib::name(fit.status), residuals.size());
  fmt::print("  matrix * (reading - offset) has length 1; offset and radii are in the unit of the readings\n");
  const auto sd = [&fit](int k) {
    return fit.covariance.size() > 0 ? fmt::format(" +- {:.3g}", std::sqrt(fit.covariance(k, k))) : std::string();
  };
  for (int k = 0; k < 3; ++k) fmt::print("  offset {}  {:.6g}{}\n", "xyz"[k], fit.offset[k], sd(k));
  if (fit.radii)
    for (int k = 0; k < 3; ++k) fmt::print("  radius {}  {:.6g}{}\n", "xyz"[k], (*fit.radii)[k], sd(3 + k));
  for (int k = 0; k < 3; ++k)
    fmt::print("  matrix    {:14.7g} {:14.7g} {:14.7g}\n", fit.matrix(k, 0), fit.matrix(k, 1), fit.matrix(k, 2));
  const auto worst = std::max_element(residuals.begin(), residuals.end(),
                                      [](double a, double b) { return std::abs(a) < std::abs(b); });
  fmt::print("  length off by {:.3g} rms, at most by {:+.3g} (point {}); {} iterations\n", fit.residual_rms, *worst,
             worst - residuals.begin() + 1, fit.iterations);
  for (const std::size_t i : fit.set_aside) fmt::print("  point {} is set aside: too far from all others\n", i + 1);
  for (const auto& condition : fit.conditions) fmt::print("  violates condition {}\n", condition);
}

}  // namespace

int calibrate_points(const std::string& path, const std::string& method_name, const calib::PointsOptions& options,
                     const std::string& json) {
  const auto method = calib::method_named(method_name);
  if (!method) {
    std::string known;
    for (const auto& m : calib::methods()) known += " " + std::string(m.name);
    const std::string what =
        method_name.empty() ? "--points needs a --method" : fmt::format("--method '{}' is not known", method_name);
    return report({ErrorKind::kUsage, fmt::format("{}; known are:{}", what, known)});
  }
  const auto table = read_points(path);
  calib::PointsFit fit;
  std::size_t count = 0;
  if (!table) {
    if (table.error().kind == ErrorKind::kNoInput) return report(table.error());
    fit.status = calib::FitStatus::kBadInput;
    fit.reason = table.error().message;
  } else if (!table->faults.empty()) {
    fit.status = calib::FitStatus::kBadInput;
    const auto shown = std::min<std::size_t>(table->faults.size(), 10);
    for (std::size_t k = 0; k < shown; ++k) fit.reason += (k ? "\n" : "") + table->faults[k];
    count = table->points.size() + table->faults.size();
  } else {
    fit = calib::fit_points(*method, table->points, options);
    count = table->points.size();
  }
  const std::vector<double> residuals = table ? norm_residuals(fit, table->points) : std::vector<double>{};
  if (!json.empty()) {
    const std::string text = json_text(to_json(method_name, fit, count, residuals));
    if (const auto written = io::write_text_file(json, text); !written) return report(written.error());
  }
  if (fit.status != calib::FitStatus::kOk)
    return report({ErrorKind::kBadData, fmt::format("{}: {}", calib::name(fit.status), fit.reason)});
  if (json.empty()) print(method_name, fit, residuals);
  return 0;
}

}  // namespace stillpoint::app
