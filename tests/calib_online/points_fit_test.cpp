#include <gmock/gmock.h>

#include <array>
#include <ranges>

#include "calib_online/offline/points_fit.h"
#include "tests/calib_online/dice.h"

namespace stillpoint::calib {
namespace {

const Vec3 kCentre(2300, 2250, 2340);

std::vector<Point> cloud(int n, double noise, unsigned seed) {
  Dice dice(seed);
  std::vector<Point> out;
  for (int k = 0; k < n; ++k) {
    const Vec3 error = dice.normal3(noise);
    const Vec3 direction = dice.normal3().normalized();
    out.push_back({Vec3(kCentre + Vec3(480, 500, 520).cwiseProduct(direction) + error), std::nullopt});
  }
  return out;
}

TEST(PointsFit, EveryMethodFindsTheCentre) {
  const auto points = cloud(400, 1.0, 5);
  for (const auto& m : methods()) {
    if (m.method == Method::kManual) continue;  // needs the six positions
    const PointsFit f = fit_points(m.method, points);
    ASSERT_EQ(f.status, FitStatus::kOk) << m.name << ": " << f.reason;
    // 1 count over 400 points: 0.1 a coordinate. LinAuto as printed assumes equal radii; MinVol follows the outermost
    // points.
    const double tolerance = m.method == Method::kLinAuto ? 8.0 : m.method == Method::kMinVolEllipsoid ? 5.0 : 0.6;
    EXPECT_LT((f.offset - kCentre).norm(), tolerance) << m.name;
    EXPECT_LT(f.residual_rms, m.method == Method::kLinAuto ? 0.02 : 0.01) << m.name;
  }
}

TEST(PointsFit, ManualReadsTheSixPositions) {
  std::vector<Point> six;
  for (int k = 0; k < 3; ++k)
    for (const double sign : {1.0, -1.0})
      six.push_back({Vec3(Vec3(10, 20, 30) + sign * (5.0 + k) * Vec3::Unit(k)), std::nullopt});
  const PointsFit f = fit_points(Method::kManual, six);
  ASSERT_EQ(f.status, FitStatus::kOk);
  EXPECT_LT((f.offset - Vec3(10, 20, 30)).norm(), 1e-12);
  EXPECT_LT((*f.radii - Vec3(5, 6, 7)).norm(), 1e-12);
}

TEST(PointsFit, ManualRefusesWhatIsNotSixPositions) {
  const PointsFit scattered = fit_points(Method::kManual, cloud(24, 1.0, 3));
  EXPECT_EQ(scattered.status, FitStatus::kNotObservable);
  EXPECT_NE(scattered.reason.find("not six positions"), std::string::npos) << scattered.reason;
  auto five = cloud(5, 1.0, 3);
  for (const Method m : {Method::kManual, Method::kNonLinear, Method::kLsqNonLinear})
    EXPECT_EQ(fit_points(m, five).status, FitStatus::kTooFewPoints);
}

/// Readings of a sensor with the given offset, within `cap_rad` of one direction; radius 10.
std::vector<Point> cap_about(const Vec3& offset, double cap_rad, int n, double noise, unsigned seed) {
  Dice dice(seed);
  const Vec3 axis = dice.normal3().normalized();
  std::vector<Point> out;
  while (out.size() < static_cast<std::size_t>(n)) {
    const Vec3 u = dice.normal3().normalized();
    if (u.dot(axis) > std::cos(cap_rad)) out.push_back({Vec3(offset + 10.0 * u + dice.normal3(noise)), std::nullopt});
  }
  return out;
}

TEST(PointsFit, MapOverOneCapKeepsItsPriorOrSaysThatItHasNone) {
  PointsOptions known;
  known.initial_centre = Vec3::Zero();
  known.initial_radius = 10.0;
  constexpr int kSeeds = 40;
  double nees = 0.0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const Vec3 offset = Dice(1000 + seed).normal3(1.0);  // the prior's own 10 %
    const auto points = cap_about(offset, 0.3, 50, 0.1, seed);
    EXPECT_EQ(fit_points(Method::kMap, points).status, FitStatus::kNotObservable)
        << seed;  // noise bends so small a cap
    const PointsFit f = fit_points(Method::kMap, points, known);
    ASSERT_EQ(f.status, FitStatus::kOk) << seed << f.reason;
    const Vec3 e = f.offset - offset;
    const Mat3 P = f.covariance.topLeftCorner<3, 3>();
    nees += e.dot(P.inverse() * e) / kSeeds;
  }
  // Chi-square(3), 40 seeds: sd 0.39. Below 3, for scale and shear, of which the prior allows 10 %, have no error here.
  EXPECT_GT(nees, 1.0);
  EXPECT_LT(nees, 4.2);
}

TEST(PointsFit, WhatIsNoEllipsoidIsNotCalledOne) {
  Dice dice(4);
  std::vector<Point> ball;
  for (int k = 0; k < 50; ++k) ball.push_back({dice.normal3(), std::nullopt});
  for (const auto& m : methods()) {
    const PointsFit f = fit_points(m.method, ball);
    EXPECT_NE(f.status, FitStatus::kOk) << m.name << " off by " << f.residual_rms;
    EXPECT_FALSE(f.reason.empty()) << m.name;
  }
}

TEST(PointsFit, BadTablesGetAStatusAndAReason) {
  auto points = cloud(50, 1.0, 6);
  const auto status = [](const std::vector<Point>& p) { return fit_points(Method::kMap, p).status; };
  auto bad = points;
  bad[7].y.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(status(bad), FitStatus::kBadInput);
  EXPECT_EQ(status({points.begin(), points.begin() + 3}), FitStatus::kTooFewPoints);
  EXPECT_EQ(status(std::vector<Point>(40, points[0])), FitStatus::kTooFewPoints);
  EXPECT_EQ(status({}), FitStatus::kTooFewPoints);
  auto flat = points;
  for (auto& p : flat) p.y.z() = 7.0;
  for (const auto& m : methods()) {
    const PointsFit f = fit_points(m.method, flat);
    EXPECT_EQ(f.status, FitStatus::kNotObservable) << m.name;
    EXPECT_FALSE(f.reason.empty()) << m.name;
  }
}

TEST(PointsFit, WhatDeterminesNoEllipsoidIsRefused) {
  const auto refused = [](const std::vector<Point>& points, Method method, FitStatus status) {
    const PointsFit f = fit_points(method, points);
    EXPECT_EQ(f.status, status) << static_cast<int>(method) << f.reason;
    EXPECT_FALSE(f.reason.empty());
  };
  auto flat = cloud(50, 1.0, 6), huge = flat, doubtful = flat, cap = cloud(4000, 3.0, 8);
  for (std::size_t k = 0; k < flat.size(); ++k) {
    flat[k].y.z() = 7.0 + 0.3 * std::sin(static_cast<double>(k));  // a plane but for noise
    huge[k].y *= 1e80;
    doubtful[k].variance = 1e6;
  }
  for (const auto& m : methods()) {
    refused(flat, m.method, FitStatus::kNotObservable);
    refused(huge, m.method, FitStatus::kBadInput);
    refused(doubtful, m.method, FitStatus::kNotObservable);
  }
  std::erase_if(cap, [](const Point& p) { return p.y.z() < 2340 + 0.95 * 520; });
  refused(cap, Method::kLinAutoRepeated, FitStatus::kNotConverged);
}

constexpr int kClouds = 40;
constexpr std::array<std::size_t, 3> kOutliers{5, 17, 30};  // of 40 points

/// Three readings are as many times further from the centre.
std::vector<Point> with_outliers(double times, unsigned seed) {
  auto points = cloud(40, 1.0, seed);
  for (const std::size_t k : kOutliers) points[k].y = kCentre + times * (points[k].y - kCentre);
  return points;
}

double error(const PointsFit& f) { return f.status == FitStatus::kOk ? (f.offset - kCentre).norm() : 1e9; }

TEST(PointsFit, MapFitsAsIfFarOutliersWereNotInTheTable) {
  for (const double times : {3.0, 60.0})
    for (unsigned seed = 0; seed < kClouds; ++seed) {
      auto points = with_outliers(times, seed);
      const PointsFit f = fit_points(Method::kMap, points);
      EXPECT_THAT(f.set_aside, testing::ElementsAreArray(kOutliers)) << times << " " << seed;
      EXPECT_GT(error(fit_points(Method::kMgn, points)), 100.0) << times << " " << seed;
      for (const std::size_t k : std::views::reverse(kOutliers))
        points.erase(points.begin() + static_cast<std::ptrdiff_t>(k));
      const PointsFit without = fit_points(Method::kMap, points);
      ASSERT_EQ(without.status, FitStatus::kOk);
      EXPECT_LT((f.offset - without.offset).norm(), 1e-9) << times << " " << seed;
    }
}

/// Chi-square of the offset's error over what is stated of it, three numbers.
double surprise(const PointsFit& f) {
  const Vec3 e = f.offset - kCentre;
  return e.dot(Mat3(f.covariance.topLeftCorner<3, 3>()).inverse() * e);
}

/// 30 % of the radius may be the shape of the ellipsoid: such readings are not taken out, they get less weight and
/// widen the error that is stated. Nobody can say of one table how much they bend it; of many one can.
TEST(PointsFit, MapBearsNearOutliersAndStatesTheErrorTheyLeave) {
  int twice_as_good = 0;
  double nees = 0.0;
  for (unsigned seed = 0; seed < kClouds; ++seed) {
    const auto points = with_outliers(1.3, seed);
    const PointsFit f = fit_points(Method::kMap, points);
    ASSERT_EQ(f.status, FitStatus::kOk) << seed << f.reason;
    twice_as_good += error(fit_points(Method::kMgn, points)) > 2.0 * error(f);
    nees += surprise(f) / kClouds;
  }
  // So with 182 of the seeds 1 to 200; fewer than 32 of 40 would come out of such odds once in a hundred.
  EXPECT_GE(twice_as_good, 32);
  EXPECT_LT(nees, 4.2);  // chi-square(3), 40 seeds: sd 0.39
}

/// With the noise stated nothing widens the covariance: what lies a hundred of its deviations off must not pull.
TEST(PointsFit, MapIsNotBentByReadingsFarBeyondTheStatedNoise) {
  double nees = 0.0;
  for (unsigned seed = 0; seed < kClouds; ++seed) {
    auto points = with_outliers(1.25, seed);
    for (Point& p : points) p.variance = 1.0;
    const PointsFit f = fit_points(Method::kMap, points);
    ASSERT_EQ(f.status, FitStatus::kOk) << seed << f.reason;
    nees += surprise(f) / kClouds;
  }
  EXPECT_LT(nees, 4.2);
}

}  // namespace
}  // namespace stillpoint::calib
