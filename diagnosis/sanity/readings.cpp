#include "diagnosis/sanity/readings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "diagnosis/forensics/forensics.h"
#include "diagnosis/sanity/rows.h"

namespace stillpoint::diag {
namespace {

constexpr double kMostFalse = 0.2;
constexpr double kLost = 1.75;           // of the median step; jitter of the clock stays below
constexpr std::size_t kLeastFilled = 3;  // rows with one number in all axes; fewer may be chance
constexpr std::array<double, 3> kBeyondAnySensor{1e6, 1e6, 1e8};  // m/s^2, rad/s, uT; counts and small units lie below
constexpr std::array<double, 3> kLeastFilling{30.0, 10.0, 200.0};
constexpr double kColdest_degC = -150.0, kHottest_degC = 500.0, kFarthest_m = 1e8, kLargestDriver = 1e6;

using Rows = std::vector<std::size_t>;

std::vector<Vec3>& column(io::Recording& r, Sensor s) {
  return s == kAcc ? r.acc_mps2 : s == kGyr ? r.gyr_radps : r.mag_uT;
}

bool counts(const io::Recording& r, Sensor s) {
  return s == kAcc ? r.acc_in_counts : s == kGyr ? r.gyr_in_counts : r.mag_in_counts;
}

/// One number in all axes, far from anything small: 65535, -999; and nought where a field or gravity is always there.
bool filled_in(const Vec3& y, Sensor s) {
  if (y.x() != y.y() || y.y() != y.z()) return false;
  return std::abs(y.x()) >= kLeastFilling[s] || (y.x() == 0.0 && s != kGyr);
}

template <class Column, class Test>
Rows rows_where(const Column& values, Test&& test) {
  Rows rows;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (test(values[i])) rows.push_back(i);
  return rows;
}

class Cleaner {
 public:
  Cleaner(const io::Recording& r, std::vector<std::string>& notices) : r_(r), notices_(notices) {}

  std::optional<io::Recording> run() {
    for (const Sensor s : {kAcc, kGyr, kMag}) clean_triad(s);
    clean(r_.temp_degC, &io::Recording::temp_degC, "temp_degC",
          [](double x) { return x < kColdest_degC || x > kHottest_degC; });
    clean(r_.current_A, &io::Recording::current_A, "current_A", [](double x) { return std::abs(x) > kLargestDriver; });
    clean(r_.supply_V, &io::Recording::supply_V, "supply_V", [](double x) { return std::abs(x) > kLargestDriver; });
    clean(r_.ref_q_world_body, &io::Recording::ref_q_world_body, "reference: quaternions without unit length",
          [](const Eigen::Vector4d& q) { return q.allFinite() && std::abs(q.norm() - 1.0) > 0.01; });
    clean(r_.ref_position_m, &io::Recording::ref_position_m, "reference: positions",
          [](const Vec3& p) { return p.allFinite() && p.cwiseAbs().maxCoeff() > kFarthest_m; });
    return std::move(out_);
  }

 private:
  void clean_triad(Sensor s) {
    if (counts(r_, s)) return;
    const auto& values = triad(r_, s);
    take_out(
        rows_where(values,
                   [s](const Vec3& y) { return y.allFinite() && y.cwiseAbs().maxCoeff() > kBeyondAnySensor[s]; }),
        values, [s](io::Recording & out) -> auto& { return column(out, s); },
        fmt::format("{}: readings beyond anything a sensor can measure", kSensorName[s]));
    const Rows filled = rows_where(values, [s](const Vec3& y) { return filled_in(y, s); });
    if (filled.size() < kLeastFilled) return;
    take_out(
        filled, values, [s](io::Recording & out) -> auto& { return column(out, s); },
        fmt::format("{}: rows with {:.6g} in all three axes, filled in where a reading was lost", kSensorName[s],
                    values[filled.front()].x()));
  }

  template <class Column, class Member, class Test>
  void clean(const Column& values, Member member, const char* name, Test&& test) {
    take_out(
        rows_where(values, test), values, [member](io::Recording & out) -> auto& { return out.*member; },
        fmt::format("{}: values that cannot be", name));
  }

  template <class Column, class Access>
  void take_out(const Rows& rows, const Column& values, Access&& access, const std::string& what) {
    if (rows.empty() || static_cast<double>(rows.size()) > kMostFalse * static_cast<double>(values.size())) return;
    if (!out_) out_ = r_;
    auto& to = access(*out_);
    for (const std::size_t i : rows) set_missing(to[i]);
    notices_.push_back(fmt::format("{}: {} of {} (first at {:.3f} s), taken as not measured", what, rows.size(),
                                   values.size(), r_.t_s(rows.front())));
  }

  static void set_missing(double& x) { x = io::kMissing; }
  template <class Vector>
  static void set_missing(Vector& x) {
    x.setConstant(io::kMissing);
  }

  const io::Recording& r_;
  std::vector<std::string>& notices_;
  std::optional<io::Recording> out_;
};

}  // namespace

std::optional<io::Recording> without_false_values(const io::Recording& recording, std::vector<std::string>& notices) {
  return Cleaner(recording, notices).run();
}

std::optional<io::Recording> with_lost_rows(const io::Recording& r) {
  constexpr double kMost_s = 1.0;
  const double step_s = r.median_step_s();
  if (!(step_s > 0)) return std::nullopt;
  const auto lost_before = [&](std::size_t i) -> std::int64_t {
    const double steps = (r.t_s(i) - r.t_s(i - 1)) / step_s;
    return steps < kLost ? 0 : std::llround(std::min(steps, kMost_s / step_s)) - 1;
  };
  std::int64_t lost = 0;
  for (std::size_t i = 1; i < r.size(); ++i) lost += lost_before(i);
  if (lost == 0 || lost > static_cast<std::int64_t>(r.size())) return std::nullopt;  // no even clock at all
  io::Recording out = detail::without_rows(r);
  const auto step_ns = static_cast<std::int64_t>(1e9 * step_s);
  for (std::size_t i = 0; i < r.size(); ++i) {
    for (std::int64_t k = i == 0 ? 0 : lost_before(i); k > 0; --k) {
      detail::append_empty_row(r, r.t_ns[i] - k * step_ns, out);
    }
    detail::append_row(r, i, out);
  }
  return out;
}

double even_step_s(const io::Recording& r) {
  const double longest_s = kLost * r.median_step_s();
  std::int64_t sum_ns = 0, count = 0;
  for (std::size_t i = 1; i < r.size(); ++i)
    if (r.t_s(i) - r.t_s(i - 1) <= longest_s) sum_ns += r.t_ns[i] - r.t_ns[i - 1], ++count;
  return count == 0 ? 0.0 : 1e-9 * (static_cast<double>(sum_ns) / static_cast<double>(count));
}

}  // namespace stillpoint::diag
