#include "diagnosis/reference/slow_look.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "diagnosis/discovery/law_words.h"
#include "diagnosis/reference/evidence.h"

namespace stillpoint::diag {
namespace {

constexpr double kSlow_s = 0.1;  // from row to row, of long recordings more
constexpr Eigen::Index kMostSlowRows = 2000;
constexpr double kLeastMeasured = 0.9;  // of the weight
constexpr double kClearly_nats = 30.0;  // laws that were not there gained 17 to 40 more than in all rows

/// Means over `factor` rows of means over `factor` rows: a triangle around each row; fewer at the ends.
template <class Matrix>
Matrix in_triangles(const Matrix& x, Eigen::Index factor) {
  const auto means = [&](const Matrix& of, Eigen::Index before, Eigen::Index after) {
    Matrix out(of.rows(), of.cols());
    for (Eigen::Index i = 0; i < of.rows(); ++i) {
      const Eigen::Index begin = std::max<Eigen::Index>(0, i - before);
      out.row(i) = of.middleRows(begin, std::min(of.rows(), i + after + 1) - begin).colwise().mean();
    }
    return out;
  };
  return means(means(x, 0, factor - 1), factor - 1, 0);
}

/// What drives it but the motion. What moves with the body shows in all rows, and is not linear in means.
std::set<std::string> slow_drivers(const Found& f) {
  if (f.id.find("_temp_") != std::string::npos) return {"T"};
  if (f.id.ends_with("_volt")) return {"V"};
  const auto tree = f.kind == Kind::kUnknown ? law_tree(f.id) : std::nullopt;
  if (!tree) return {};
  const std::vector<std::string> drivers = laws::drivers_of(*tree);
  std::set<std::string> out(drivers.begin(), drivers.end());
  for (const char* motion : {"w", "f", "m", "p", "east", "north", "up"}) out.erase(motion);
  return out;
}

/// Whether all rows show the same drivers: then the form of the law is theirs to tell.
bool is_the_same_cause(const SensorSearch& slow, const SensorSearch& fast) {
  std::set<std::string> here, there;
  for (const Found& f : slow.found) here.merge(slow_drivers(f));
  for (const Found& f : fast.found) there.merge(slow_drivers(f));
  return !there.empty() && std::includes(here.begin(), here.end(), there.begin(), there.end());
}

double gain_of(const SensorSearch& search) {
  double out = 0.0;
  for (const Found& f : search.found) out += f.gain_nats;
  return out;
}

}  // namespace

std::optional<Signals> slow_rows(const Signals& s) {
  const auto factor = std::max(static_cast<Eigen::Index>(std::lround(kSlow_s / s.dt_s)), s.n / kMostSlowRows);
  if (s.exact_reference || s.from_log || factor < 2) return std::nullopt;
  Signals out = s;
  out.present[kMag] = false;  // its residual holds the camera's errors themselves
  for (std::size_t k = 0; k < kSensors; ++k) {
    if (s.muted[k].empty()) continue;
    Series measured(s.n);
    for (Eigen::Index i = 0; i < s.n; ++i) measured[i] = s.muted[k][static_cast<std::size_t>(i)] ? 0.0 : 1.0;
    if (s.edges_of_rests[k].rows() > 0) {
      out.predicted[k] += s.edges_of_rests[k];
      out.residual[k] -= s.edges_of_rests[k];
    }
    const Series weight = in_triangles(measured, factor);
    for (auto* group : {&out.reading, &out.predicted, &out.residual}) {
      Series3& x = (*group)[k];
      if (x.rows() == 0) continue;
      x = in_triangles<Series3>(x.array().colwise() * measured.array(), factor).array().colwise() /
          weight.array().max(1e-9);
    }
    for (Eigen::Index i = 0; i < s.n; ++i) out.muted[k][static_cast<std::size_t>(i)] = weight[i] < kLeastMeasured;
  }
  out.rest.assign(s.rest.size(), 0);
  for (auto* group : {&out.vector, &out.world_axis})
    for (Series3& x : *group) x = in_triangles(x, factor);
  for (Series3* x : {&out.rate, &out.rate_dot, &out.position_m, &out.vibration, &out.given_rate})
    *x = in_triangles(*x, factor);
  for (Series* x : {&out.temperature_K, &out.current_A, &out.voltage_V}) *x = in_triangles(*x, factor);
  for (auto& [name, x] : out.user) x = in_triangles(x, factor);
  return thinned(out, factor);
}

void keep_what_is_slow(EngineResult& in_slow_rows) {
  for (auto& search : in_slow_rows.sensor) {
    if (!search) continue;
    for (std::size_t i = search->found.size(); i-- > 0;) {
      if (slow_drivers(search->found[i]).empty() || is_unsure(held_out_by_regime(*search, {i}))) take_out(*search, i);
    }
  }
}

bool is_seen_better(const EngineResult& in_slow_rows, const EngineResult& in_all_rows, Sensor sensor) {
  const auto& slow = in_slow_rows.sensor[sensor];
  const auto& fast = in_all_rows.sensor[sensor];
  if (!slow || !fast || !in_slow_rows.system.empty()) return false;
  const auto speaks = [sensor](const SystemEffect& e) { return e.lead == sensor; };
  if (std::any_of(in_all_rows.system.begin(), in_all_rows.system.end(), speaks)) return false;
  return gain_of(*slow) > gain_of(*fast) + kClearly_nats && !is_the_same_cause(*slow, *fast);
}

}  // namespace stillpoint::diag
