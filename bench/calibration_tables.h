/// The parts of bench/calibration_tables: each prints one comparison, paper beside ours, with its seeds.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "calib_online/directions.h"
#include "core/so3.h"
#include "core/types.h"
#include "core/units.h"

namespace stillpoint::bench {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double normal(double sd = 1.0) { return sd * normal_(engine_); }
  double uniform(double low, double high) { return low + (high - low) * uniform_(engine_); }
  Vec3 normal3(double sd = 1.0) { return {normal(sd), normal(sd), normal(sd)}; }
  Vec3 direction() { return normal3().normalized(); }
  /// One draw a statement: in which order the arguments of a call are evaluated is the compiler's choice.
  Quat rotation() {
    const double z = normal(), y = normal(), x = normal(), w = normal();
    return Quat(w, x, y, z).normalized();
  }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_{0.0, 1.0};
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
};

inline double mean(const std::vector<double>& v) {
  double s = 0.0;
  for (double x : v) s += x;
  return v.empty() ? 0.0 : s / static_cast<double>(v.size());
}
inline double sd(const std::vector<double>& v) {
  double s = 0.0;
  for (double x : v) s += (x - mean(v)) * (x - mean(v));
  return v.size() < 2 ? 0.0 : std::sqrt(s / static_cast<double>(v.size() - 1));
}
inline double quantile(std::vector<double> v, double q) {
  if (v.empty()) return 0.0;
  std::sort(v.begin(), v.end());
  return v[std::min(v.size() - 1, static_cast<std::size_t>(q * static_cast<double>(v.size())))];
}
inline double rms(const std::vector<double>& v) {
  double s = 0.0;
  for (double x : v) s += x * x;
  return v.empty() ? 0.0 : std::sqrt(s / static_cast<double>(v.size()));
}
/// Even directions, for judging a calibration over the whole sphere.
inline std::vector<Vec3> even_directions(int n) {
  std::vector<Vec3> out;
  for (int k = 0; k < n; ++k) out.push_back(calib::even_direction(k, n));
  return out;
}

/// Rest windows of a day of wear: most lie near a few postures. `n` directions.
inline std::vector<Vec3> worn_directions(Random& random, int n) {
  const Vec3 postures[4] = {Vec3(0.1, 0.05, 1).normalized(), Vec3(0.95, 0.2, 0.25).normalized(),
                            Vec3(0.2, 0.9, 0.35).normalized(), Vec3(-0.3, -0.8, 0.4).normalized()};
  const double share[4] = {0.55, 0.8, 0.9, 0.97};
  std::vector<Vec3> out;
  for (int k = 0; k < n; ++k) {
    const double p = random.uniform(0.0, 1.0);
    int posture = 0;
    while (posture < 4 && p > share[posture]) ++posture;
    out.push_back(posture == 4 ? random.direction() : (postures[posture] + random.normal3(0.15)).normalized());
  }
  return out;
}

/// Each part prints its table and returns the figures that are held against a goal.
using Figures = std::map<std::string, double>;
Figures gietzelt_tables();
Figures zhang_tables();
void zhang_gyro_tables(Figures& figures);  ///< a part of zhang_tables
Figures worn_and_adjusted();
Figures simulated_day();
Figures alignment_and_gyro();
Figures rest_detection();
Figures real_recordings(const std::string& folder);
void ordinary_use(unsigned first_seed, unsigned seeds);
void thermal_chamber(const std::string& folder, Figures& figures);  ///< a part of real_recordings

}  // namespace stillpoint::bench
