/// Every number that the fits to a table and the mounting give, on sound and on spoilt input. That they are right is
/// asked elsewhere; here a figure that is another one shows.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <iomanip>

#include "calib_online/offline/points_fit.h"
#include "calib_online/offline/two_step.h"
#include "tests/calib_online/mount_scene.h"
#include "tests/golden.h"

namespace stillpoint::calib {
namespace {

using namespace test;

/// A line of numbers, six decimals.
class Line {
 public:
  Line() { text_ << std::fixed << std::setprecision(6); }
  template <class T>
  Line& put(const T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>)
      text_ << static_cast<std::conditional_t<std::is_floating_point_v<T>, double, int>>(value) << ' ';
    else
      for (const double x : value.reshaped()) put(x);
    return *this;
  }
  /// Standard deviations, times a thousand.
  Line& put_sd(const Eigen::MatrixXd& covariance) {
    for (const double variance : covariance.diagonal()) put(1e3 * std::sqrt(variance));
    return *this;
  }
  std::string end() {
    text_ << '\n';
    return text_.str();
  }

 private:
  std::ostringstream text_;
};

std::string line(const PointsFit& fit) {
  Line out;
  out.put(fit.status).put(fit.offset).put(fit.matrix).put(fit.residual_rms);
  if (fit.radii) out.put(*fit.radii);
  out.put_sd(fit.covariance);
  for (Eigen::Index k = 0; k + 1 < fit.covariance.rows(); ++k) out.put(1e6 * fit.covariance(k, k + 1));
  for (const std::size_t k : fit.set_aside) out.put(k);
  for (const std::string& condition : fit.conditions) out.put(condition.size());
  return out.put(fit.reason.size()).end();
}

/// Readings of a sensor of radius about 10 whose axes differ, are skewed and have an offset.
std::vector<Point> table(std::size_t n, double noise, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto vector = [&](double sd) {
    const double x = normal(random), y = normal(random);
    return Vec3(sd * Vec3(x, y, normal(random)));
  };
  Mat3 shape;
  shape << 9.5, 0.1, -0.2, 0.0, 10.0, 0.15, 0.0, 0.0, 10.6;
  std::vector<Point> out;
  while (out.size() < n) {
    const Vec3 error = vector(noise);
    out.push_back({Vec3(20, 21, 19.5) + shape * vector(1.0).normalized() + error, std::nullopt});
  }
  return out;
}

/// What each of the methods says of one table.
std::string of_all_methods(std::span<const Point> points, const PointsOptions& options = {}) {
  std::string text;
  for (const auto& m : methods()) text += line(fit_points(m.method, points, options));
  return text;
}

TEST(GoldenOffline, TablesByEveryMethod) {
  std::string text;
  for (const std::size_t n : {12U, 30U, 90U})
    for (const double noise : {0.01, 0.1}) text += of_all_methods(table(n, noise, static_cast<unsigned>(n)));
  PointsOptions known;
  known.initial_centre = Vec3(20.5, 20.5, 20);
  known.initial_radius = 10.2;
  known.converter_bits = 5;
  known.full_scale_g = 2.0;
  known.prior_relative_sd = 0.05;
  known.min_vol_tolerance = 0.05;
  auto weighed = table(24, 0.05, 7);
  for (std::size_t k = 0; k < weighed.size(); ++k) weighed[k].variance = 1e-4 * static_cast<double>(1 + k % 5);
  text += of_all_methods(weighed, known);
  known.converter_bits = 4;  // readings beyond 16, a radius too small for 3 g, a start far off
  known.full_scale_g = 3.0;
  known.initial_centre = Vec3(25, 18, 20);
  text += of_all_methods(weighed, known);
  std::erase_if(weighed, [](const Point& p) { return p.y.z() < 22.0; });
  text += of_all_methods(weighed, known);
  auto spoilt = table(60, 0.05, 9);
  for (const std::size_t k : {3U, 4U, 20U}) spoilt[k].y += Vec3(2.0, -1.0, 7.0);
  spoilt[30].y = Vec3(300, 0, 0);
  text += of_all_methods(spoilt);
  std::vector<Point> six;
  for (int k = 0; k < 3; ++k)
    for (const double sign : {1.0, -1.0})
      for (const double push : {0.0, 0.02})
        six.push_back({Vec3(20, 21, 19) + sign * (9.5 + 0.3 * k + push) * Vec3::Unit(k), std::nullopt});
  text += of_all_methods(six);
  check_golden("offline_tables", text);
}

TEST(GoldenOffline, TwoStepOfFewOrientations) {
  std::string text;
  std::mt19937_64 random(3);
  Mat3 H;
  H << 0.021, -0.0024, 0.0034, 0, 0.0238, 0.0022, 0.0021, 0.0024, -0.0224;
  const Vec3 u(2.6, 5.2, 7.9);
  for (const int n : {3, 4, 6, 12}) {
    TwoStepSums sums;
    std::vector<Vec3> y;
    std::vector<Mat3> R;
    for (int k = 0; k < n; ++k) {
      R.push_back(any_rotation(random));
      y.push_back(H.inverse() * (R.back() * u) + Vec3(0.3, -0.2, 0.1) * (k % 3));
      sums.add(y.back(), R.back());
    }
    for (const TwoStepFit& fit :
         {two_step_closed(sums, u.norm(), H), two_step_iterated(y, R, Vec3(5, 5, 5), u.norm(), 7)})
      text += Line().put(fit.status).put(Mat3(100.0 * fit.H)).put(fit.u).put(fit.contraction).end() + "\n";
  }
  check_golden("offline_two_step", text);
}

std::string line(const SensorMount& m) {
  Line out;
  out.put(m.lack).put(m.mirror_excluded).put(m.R).put_sd(m.covariance).put(m.misfit_rad);
  const NamedMount n = named(m.R, m.covariance);
  return out.put(n.map).put(n.rest_rad).put(n.rest_sd_rad).put(n.angle_sd_rad).put(n.significant).end();
}

std::string lines(const MountFit& fit) {
  Line more;
  more.put(fit.acc.bias_mps2).put(fit.acc.bias_sd_mps2).put(fit.mag.dip_sine);
  for (const RestPose& pose : fit.acc.poses)
    more.put(pose.face.value_or(Vec3::Zero())).put(pose.stated).put(pose.direction_only).put(pose.off_rad);
  return line(fit.acc) + line(fit.gyr) + line(fit.mag) + more.end();
}

TEST(GoldenOffline, MountsAsTheySit) {
  std::string text;
  const Sitting sitting{exp_so3(Vec3(0.02, -0.05, 0.03)), exp_so3(Vec3(0.01, 1.55, 0.02)), exp_so3(Vec3(3.1, 0.05, 0))};
  const Quat tipped = exp_quat(Vec3(0, -1.2, 0)), askew = exp_quat(Vec3(0.4, 0.3, 0));
  const std::vector<std::vector<Quat>> ways{{kLevel, kFrontUp, kLeftUp, kLevel},
                                            kManySides,
                                            {kLevel, tipped, kLeftUp, askew, kLevel},
                                            {kLevel, kFrontUp, kLevel},
                                            {kLevel, askew, kBottomUp},
                                            {kLevel}};
  MountParams stated;
  stated.faces = {Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY()};
  stated.north = false;
  for (std::size_t k = 0; k < ways.size(); ++k) {
    const auto seed = static_cast<unsigned>(20 + k);
    text += lines(fit(ways[k], sitting, seed, kUsual));
    text += lines(fit(ways[k], {}, seed, {}, stated));
  }
  Mat3 mirrored = Mat3::Identity();
  mirrored(1, 1) = -1.0;
  text += lines(fit(kManySides, {mirrored, sitting.gyr, mirrored}, 40, kUsual, stated));
  text += lines(fit(kManySides, {sitting.acc, mirrored, sitting.mag}, 41, kUsual));
  check_golden("offline_mounts", text);
}

}  // namespace
}  // namespace stillpoint::calib
