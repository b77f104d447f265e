/// Replays of recordings and of a simulated hand through the filter (tests/golden.h).
#include <gtest/gtest.h>

#include <filesystem>

#include "core/units.h"
#include "fusion/attitude_filter.h"
#include "io/recording.h"
#include "tests/fusion/random_motion.h"
#include "tests/golden.h"
#include "tests/source_folder.h"

namespace stillpoint::fusion {
namespace {

std::string line(const AttitudeEstimate& e) {
  char text[160];
  std::snprintf(text, sizeof text, "%.3f %.6f %.6f %.6f %.6f %.6f %.6f %d %d\n", in_seconds(e.t_ns), e.q_world_body[0],
                e.q_world_body[1], e.q_world_body[2], e.q_world_body[3], e.sigma_roll_rad, e.sigma_yaw_rad,
                static_cast<int>(e.heading), static_cast<int>(e.status));
  return text;
}

template <class Next>
std::string trace_of(std::size_t n, Next&& next) {
  AttitudeFilter filter;
  test::GoldenTrace trace{1'000'000'000};
  for (std::size_t i = 0; i < n; ++i) {
    const auto [sample, rest] = next(i);
    const AttitudeEstimate e = filter.step(sample, rest);
    trace.add(e.t_ns, [&e] { return line(e); });
  }
  return trace.text;
}

/// A rest rule of its own (the rate stays small for two seconds), so that a change of the rest detector is not a change
/// here.
void check_recording(const std::string& name, const std::string& file) {
  const std::string path = in_source("../shared/recordings/") + file;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "LOUD: SKIPPED, recording absent: " << path;
  const auto recording = io::read_recording(path);
  ASSERT_TRUE(recording.has_value()) << recording.error().message;
  double still_s = 0.0;
  test::check_golden(name, trace_of(recording->size(), [&](std::size_t i) {
                       const RawSample raw = recording->sample(i);
                       CalibratedSample s;
                       s.t_ns = raw.t_ns;
                       s.acc_mps2 = raw.acc_mps2;
                       s.gyr_radps = raw.gyr_radps;
                       s.mag_uT = raw.mag_uT;
                       s.has = raw.has;
                       const double dt_s = i == 0 ? 0.0 : recording->t_s(i) - recording->t_s(i - 1);
                       still_s = vec(raw.gyr_radps).norm() < 0.05 ? still_s + dt_s : 0.0;
                       return std::pair{s, still_s > 2.0};
                     }));
}

TEST(Golden, HandheldNineAxis) {
  const std::string folder = in_source("../shared/recordings/handheld_9axis");
  std::error_code absent;
  for (const auto& entry : std::filesystem::directory_iterator(folder, absent)) {
    if (entry.path().extension() == ".csv") {
      return check_recording("handheld_9axis", "handheld_9axis/" + entry.path().filename().string());
    }
  }
  GTEST_SKIP() << "LOUD: SKIPPED, recording absent: " << folder;
}

TEST(Golden, BroadPhoneVibration) { check_recording("broad_26", "broad/26_disturbed_phone_vibration_A.csv"); }

TEST(Golden, SimulatedHandMotionWithAMagnetAndAGap) {
  test::RandomMotion motion({}, 1);
  test::check_golden("simulated", trace_of(9000, [&](std::size_t i) {
                       const bool still = i % 2000 < 500;
                       CalibratedSample s = motion.next(still);
                       if (i > 4000 && i < 5000) vec(s.mag_uT) += Vec3(20.0, 10.0, 0.0);
                       if (i > 6000 && i < 6100) s.has = kAcc;
                       return std::pair{s, still && i % 2000 > 200};
                     }));
}

}  // namespace
}  // namespace stillpoint::fusion
