#include "calib_online/offline/outliers.h"
#include "core/median.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

namespace stillpoint::calib {
namespace {

constexpr int kSpheres = 300;  // with one outlier in four, 0.32 of the quadruples hold none: a miss is 1e-50
constexpr int kHalves = 100;   // three outliers: one half in eight holds none, a miss is 2e-6
constexpr std::size_t kLeastLeft = 8;
constexpr std::size_t kLeastToJudge = 18;
constexpr double kBorne = 3.0;  // sd; beyond, a reading counts less
constexpr int kFalls = 3;       // power: the pull of what is far off ends, where Huber's would stay

/// The same table gives the same answer.
class Picks {
 public:
  explicit Picks(std::size_t size) : size_(size) {}
  std::size_t next() {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<std::size_t>((state_ >> 33) % size_);
  }

 private:
  std::size_t size_;
  std::uint64_t state_ = 1;
};

struct Sphere {
  Vec3 centre = Vec3::Zero();
  double radius = 0.0;
};

std::optional<Sphere> through(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  Mat3 A;
  A << (b - a).transpose(), (c - a).transpose(), (d - a).transpose();
  const Eigen::FullPivLU<Mat3> lu(A);
  if (!lu.isInvertible()) return std::nullopt;
  const Vec3 z = lu.solve(0.5 * Vec3((b - a).squaredNorm(), (c - a).squaredNorm(), (d - a).squaredNorm()));
  if (!z.allFinite()) return std::nullopt;
  return Sphere{a + z, z.norm()};
}

/// In units of the readings: relative to its own radius a huge sphere would leave the least.
std::vector<double> distances(const Sphere& s, std::span<const Vec3> readings) {
  std::vector<double> out;
  for (const Vec3& y : readings) out.push_back(std::abs((y - s.centre).norm() - s.radius));
  return out;
}

}  // namespace

std::vector<std::size_t> gross_outliers(std::span<const Vec3> readings, double tolerance) {
  if (readings.size() <= kLeastLeft) return {};
  Picks picks(readings.size());
  Sphere best;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kSpheres; ++k) {
    const Vec3 &a = readings[picks.next()], &b = readings[picks.next()], &c = readings[picks.next()];
    const auto sphere = through(a, b, c, readings[picks.next()]);
    if (!sphere) continue;
    const double left = median(distances(*sphere, readings));
    if (left < least) least = left, best = *sphere;
  }
  std::vector<std::size_t> out;
  if (!(least < tolerance * best.radius)) return out;
  const std::vector<double> off = distances(best, readings);
  for (std::size_t i = 0; i < off.size(); ++i)
    if (off[i] > tolerance * best.radius) out.push_back(i);
  const std::size_t left = readings.size() - out.size();
  if (left < kLeastLeft || 4 * left < 3 * readings.size()) out.clear();
  return out;
}

std::vector<double> norm_errors(std::span<const Vec3> readings, const Ellipsoid& e) {
  std::vector<double> out;
  for (const Vec3& x : readings) out.push_back(std::abs((e.K * (x - e.centre)).norm() - 1.0));
  return out;
}

std::vector<double> robust_weights(const std::vector<double>& errors) {
  std::vector<double> weights(errors.size(), 1.0);
  if (errors.size() < kLeastToJudge) return weights;
  const double n = static_cast<double>(errors.size());
  const double sd = std::max(1e-6, 1.4826 * median(errors) * std::sqrt(n / (n - 9.0)));
  for (std::size_t i = 0; i < errors.size(); ++i)
    weights[i] = std::pow(std::min(1.0, kBorne * sd / std::max(1e-12, errors[i])), kFalls);
  return weights;
}

std::vector<double> first_weights(std::span<const Vec3> readings, double norm_sd, const MapPrior& prior) {
  std::vector<double> errors(readings.size(), 0.0);
  if (readings.size() < kLeastToJudge) return robust_weights(errors);
  const Mat3 C = norm_sd * norm_sd * Mat3::Identity();
  Picks picks(readings.size());
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kHalves; ++k) {
    Moments half;
    for (std::size_t i = 0; i < (readings.size() + 1) / 2; ++i) half.add(readings[picks.next()]);
    const MapFit fit = map_fit(half.adjusted(C), norm_sd, prior);
    if (fit.status != FitStatus::kOk) continue;
    const std::vector<double> off = norm_errors(readings, fit.ellipsoid);
    const double left = median(off);
    if (left < least) least = left, errors = off;
  }
  return robust_weights(errors);
}

}  // namespace stillpoint::calib
