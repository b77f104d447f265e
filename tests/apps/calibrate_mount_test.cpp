/// `stillpoint calibrate --mount`: simulated sensors that sit in known ways, and that what is printed sets them right.
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/so3.h"
#include "core/units.h"
#include "tests/apps/tool_in_folder.h"

namespace stillpoint::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kRest_s = 4.0, kTurn_s = 2.0;
const Quat kLevel = Quat::Identity(), kFrontUp = exp_quat(Vec3(0, -std::numbers::pi / 2, 0)),
           kLeftUp = exp_quat(Vec3(std::numbers::pi / 2, 0, 0));

class CalibrateMount : public ToolInFolder {
 protected:
  /// A recording of these poses, by sensors of which these matrices lead to the body.
  void simulate(const std::vector<Quat>& poses, const Mat3& acc, const Mat3& gyr, const Mat3& mag) {
    std::ostringstream motion;
    motion << "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2,ref_qw,ref_qx,ref_qy,ref_qz,ref_moving\n";
    const double end_s = (kRest_s + kTurn_s) * static_cast<double>(poses.size()) - kTurn_s;
    for (int k = 0; 0.02 * k < end_s; ++k) {
      const double t_s = 0.02 * k, within_s = std::fmod(t_s, kRest_s + kTurn_s);
      const auto i = static_cast<std::size_t>(t_s / (kRest_s + kTurn_s));
      const double share = std::max(0.0, within_s - kRest_s) / kTurn_s;
      const double eased = share - std::sin(2.0 * std::numbers::pi * share) / (2.0 * std::numbers::pi);
      const Quat q = poses[i].slerp(eased, poses[std::min(i + 1, poses.size() - 1)]);
      motion << t_s << ",0,0,0," << q.w() << ',' << q.x() << ',' << q.y() << ',' << q.z() << ',' << (share > 0.0)
             << '\n';
    }
    write_file(folder_ / "motion.csv", motion.str());
    const auto text = [](const Mat3& M) {
      std::ostringstream out;
      for (int r = 0; r < 3; ++r) out << (r > 0 ? ", [" : "[[") << M(r, 0) << ", " << M(r, 1) << ", " << M(r, 2) << "]";
      return out.str() + "]";
    };
    write_file(folder_ / "sim.yaml",
               "rate_hz: 100\naccelerometer: {noise_mps2: 0.02, matrix: " + text(acc) +
                   "}\ngyroscope: {noise_radps: 0.001, bias: [0.01, -0.02, 0.015], matrix: " + text(gyr) +
                   "}\nmagnetometer: {noise_uT: 0.3, bias: [12, -8, 5], matrix: " + text(mag) + "}\n");
    ASSERT_EQ(tool("simulate --simulation sim.yaml --motion motion.csv --output rec.csv"), 0) << told_;
  }
  /// How far the estimate's vertical is off in the middle of the second half of each rest, at most.
  /// Leaves the estimates in att.csv.
  double worst_tilt_deg(const std::vector<Quat>& poses, const std::string& recording, const std::string& config) {
    EXPECT_EQ(tool("estimate --config " + config + " --recording " + recording + " --output att.csv > said"), 0)
        << told_;
    std::ifstream file(folder_ / "att.csv");
    std::string line;
    std::getline(file, line);
    double worst_rad = 0.0;
    for (std::size_t i = 0; i < poses.size();) {
      if (!std::getline(file, line)) return 180.0;
      double t_s = 0.0, w = 0.0, x = 0.0, y = 0.0, z = 0.0;
      EXPECT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf", &t_s, &w, &x, &y, &z), 5) << line;
      if (t_s < (kRest_s + kTurn_s) * static_cast<double>(i) + 0.9 * kRest_s) continue;
      const Vec3 up = Quat(w, x, y, z).conjugate() * Vec3::UnitZ(), truth = poses[i].conjugate() * Vec3::UnitZ();
      worst_rad = std::max(worst_rad, std::atan2(up.cross(truth).norm(), up.dot(truth)));
      ++i;
    }
    return worst_rad * kDegPerRad;
  }
};

const std::vector<Quat> kPoses{kLevel, kFrontUp, kLeftUp, kLevel};

Mat3 axes(std::initializer_list<int> numbers) {  // 1 +x, -3 -z
  Mat3 M = Mat3::Zero();
  int row = 0;
  for (const int n : numbers) M(row++, std::abs(n) - 1) = n > 0 ? 1.0 : -1.0;
  return M;
}

TEST_F(CalibrateMount, OneChipInOtherAxesIsNamedAndThePrintedMountGivesTheTilt) {
  const Mat3 on_body = axes({2, -1, 3});
  simulate(kPoses, on_body, on_body, on_body);
  ASSERT_EQ(tool("calibrate --mount rec.csv --latitude 50 --output mount.yaml > out"), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "out"), AllOf(HasSubstr("accelerometer in the body: \"+y -x +z\""),
                                                HasSubstr("gyroscope in the accelerometer's axes: \"+x +y +z\""),
                                                HasSubstr("still missing:\n  nothing\n")));
  EXPECT_THAT(read_file(folder_ / "mount.yaml"), AllOf(HasSubstr("mount: \"+y -x +z\""), Not(HasSubstr("source:"))));
  write_file(folder_ / "none.yaml", "sensor: {id: a}\n");
  EXPECT_GT(worst_tilt_deg(kPoses, "rec.csv", "none.yaml"), 80.0);
  EXPECT_LT(worst_tilt_deg(kPoses, "rec.csv", "mount.yaml"), 2.0);
}

TEST_F(CalibrateMount, ASlantThatNoNamesSayIsWrittenAsAQuaternion) {
  const Mat3 on_body = exp_so3(Vec3(0.0, 20.0, 5.0) * kRadPerDeg) * axes({-1, -2, 3});
  simulate(kPoses, on_body, on_body, on_body);
  ASSERT_EQ(tool("calibrate --mount rec.csv --output mount.yaml --json mount.json > out"), 0) << told_;
  const auto answer = nlohmann::json::parse(read_file(folder_ / "mount.json"));
  EXPECT_EQ(answer["body_from_accelerometer"]["names"], "-x -y +z");
  EXPECT_TRUE(answer["body_from_accelerometer"]["remainder_rad"]["significant"]);
  EXPECT_NEAR(answer["body_from_accelerometer"]["remainder_rad"]["angle"].get<double>() * kDegPerRad, 20.6, 0.5);
  EXPECT_EQ(answer["yaml"], read_file(folder_ / "mount.yaml"));
  EXPECT_LT(worst_tilt_deg(kPoses, "rec.csv", "mount.yaml"), 2.0);
}

TEST_F(CalibrateMount, SensorsThatSitEachInItsOwnWayAreBroughtTogetherByThePrintedSource) {
  const Mat3 acc = axes({3, 1, 2}), gyr = axes({-2, 1, 3}), mag = axes({1, -3, 2});
  simulate(kPoses, acc, acc * gyr, acc * mag);
  ASSERT_EQ(tool("calibrate --mount rec.csv --output mount.yaml > out"), 0) << told_;
  const std::string yaml = read_file(folder_ / "mount.yaml");
  EXPECT_THAT(yaml, AllOf(HasSubstr("gyroscope: \"-y +x +z\""), HasSubstr("magnetometer: \"+x -z +y\""),
                          HasSubstr("mount: \"+z +x +y\"")));
  const auto at = yaml.find("  mount:");
  write_file(folder_ / "daemon.yaml", yaml.substr(0, at) + "  kind: recording\n  file: rec.csv\n" + yaml.substr(at));
  EXPECT_EQ(run(STILLPOINTD " --check-config --config " + (folder_ / "daemon.yaml"), folder_ / "err"), 0);
  // Each as it sits, gyroscope and field contradict gravity; at rest gravity alone holds the tilt.
  write_file(folder_ / "as_it_sits.yaml", yaml.substr(yaml.find("output:")));
  worst_tilt_deg(kPoses, "rec.csv", "as_it_sits.yaml");
  EXPECT_THAT(read_file(folder_ / "att.csv"), HasSubstr("inconsistent"));
  for (const std::string config : {"mount.yaml", "daemon.yaml"}) {
    EXPECT_LT(worst_tilt_deg(kPoses, "rec.csv", config), 2.0) << config;
    EXPECT_THAT(read_file(folder_ / "att.csv"), Not(HasSubstr("inconsistent"))) << config;
  }
  ASSERT_EQ(tool("calibrate --recording rec.csv --config mount.yaml > out"), 0) << told_;
}

TEST_F(CalibrateMount, AMirroredGyroscopeIsRefusedWithItsAxisAndTheNearestThatIsRight) {
  simulate(kPoses, Mat3::Identity(), axes({1, 2, -3}), Mat3::Identity());
  EXPECT_EQ(tool("calibrate --mount rec.csv --output mount.yaml > out"), 65);
  EXPECT_THAT(told_, AllOf(HasSubstr("gyroscope: mirrored against the accelerometer: nearest is \"+x +y -z\""),
                           HasSubstr("its z reads with the wrong sign"), HasSubstr("then mount \"+x +y +z\"")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "mount.yaml"));
}

TEST_F(CalibrateMount, WhatIsMissingIsSaidWithWhatToDo) {
  simulate({kLevel}, Mat3::Identity(), Mat3::Identity(), Mat3::Identity());
  EXPECT_EQ(tool("calibrate --mount rec.csv > out"), 65);
  EXPECT_THAT(told_, HasSubstr("only one rest; level is seen, forward is not: tip the body so that its +x is up"));
  EXPECT_EQ(tool("calibrate --mount rec.csv --faces=-z,+y > out"), 65);
  EXPECT_THAT(told_, HasSubstr("so that its +y is up"));
  simulate({kLevel, kFrontUp}, Mat3::Identity(), Mat3::Identity(), Mat3::Identity());
  EXPECT_EQ(tool("calibrate --mount rec.csv > out"), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "out"), AllOf(HasSubstr("gyroscope: all turns are about one axis"),
                                                HasSubstr("magnetometer: needs the gyroscope's axes")));
}

TEST_F(CalibrateMount, RestsMayLieInSeveralRecordingsAndTurnsThenDoNot) {
  simulate({kLevel}, Mat3::Identity(), Mat3::Identity(), Mat3::Identity());
  std::filesystem::rename(folder_ / "rec.csv", folder_ / "level.csv");
  simulate({kFrontUp}, Mat3::Identity(), Mat3::Identity(), Mat3::Identity());
  EXPECT_EQ(tool("calibrate --mount level.csv rec.csv > out"), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "out"), AllOf(HasSubstr("accelerometer in the body: \"+x +y +z\""),
                                                HasSubstr("keep all poses in one recording")));
}

TEST_F(CalibrateMount, OptionsThatDoNotGoTogetherAreWrongUsage) {
  for (const std::string wrong : {"--mount a.csv --recording b.csv", "--faces +z,+x", "--mount a.csv --faces +z,-z",
                                  "--mount a.csv --faces +w,+x", "--mount a.csv --pose-sd 0",
                                  "--mount a.csv --gravity 9.81", "--points a.csv --method map --output b.yaml"})
    EXPECT_EQ(tool("calibrate " + wrong), 64) << wrong << told_;
  EXPECT_EQ(tool("calibrate --mount gone.csv"), 66);
}

}  // namespace
}  // namespace stillpoint::test
