/// The frames of a camera that was drawn as lines onto rows with another clock, read back from the lines.
#include "diagnosis/sanity/frames_off_rows.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <random>

#include "tests/source_folder.h"

namespace stillpoint::diag {
namespace {

constexpr double kRow_s = 0.01, kPhase_s = 0.0037;

Vec3 place(double t) { return {0.1 * std::sin(6.0 * t), 0.1 * std::cos(4.0 * t), 0.05 * std::sin(9.0 * t)}; }

/// A hand: up to 6 rad/s.
Quat attitude(double t) {
  return Quat(Eigen::AngleAxisd(1.5 * std::sin(4.0 * t), Vec3::UnitX()) *
              Eigen::AngleAxisd(0.8 * std::sin(2.3 * t), Vec3(0.6, 0.0, 0.8)));
}

/// What a frame adds to the truth, and how values between two frames are made of them.
struct Camera {
  double frame_s = 0.0;
  double noise = 0.0;
  std::function<Quat(double, const Quat&, const Quat&)> between;
  double phase_s = kPhase_s;

  [[nodiscard]] Vec3 jitter(long frame) const {
    std::mt19937_64 engine(static_cast<std::uint64_t>(frame + 1000));
    std::normal_distribution<double> normal(0.0, noise);
    return {normal(engine), normal(engine), normal(engine)};
  }
  [[nodiscard]] double time(long frame) const { return phase_s + frame_s * static_cast<double>(frame); }
  [[nodiscard]] Vec3 places(long frame) const { return place(time(frame)) + jitter(frame); }
  [[nodiscard]] Quat turns(long frame) const {
    const Vec3 off = 0.5 * jitter(frame);
    return (attitude(time(frame)) * Quat(1.0, off[0], off[1], off[2])).normalized();
  }
};

Quat line_of_length_one(double share, const Quat& a, const Quat& b) {
  const double sign = a.dot(b) < 0 ? -1.0 : 1.0;
  return Quat((1.0 - share) * a.coeffs() + sign * share * b.coeffs()).normalized();
}
Quat great_circle(double share, const Quat& a, const Quat& b) { return a.slerp(share, b); }

io::Recording drawn(const Camera& camera, std::size_t rows = 3001) {
  const auto printed = [](double x) { return 1e-7 * std::round(1e7 * x); };
  io::Recording r;
  for (std::size_t i = 0; i < rows; ++i) {
    const double t = kRow_s * static_cast<double>(i);
    r.t_ns.push_back(std::llround(1e9 * t));
    const long frame = std::lround(std::floor((t - camera.phase_s) / camera.frame_s));
    const double share = (t - camera.time(frame)) / camera.frame_s;
    const Vec3 p = (1.0 - share) * camera.places(frame) + share * camera.places(frame + 1);
    r.ref_position_m.push_back(p.unaryExpr(printed));
    const Quat q = camera.between(share, camera.turns(frame), camera.turns(frame + 1));
    r.ref_q_world_body.push_back(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()).unaryExpr(printed));
  }
  return r;
}

void expect_its_frames(const FramesOffRows& found, const Camera& camera) {
  EXPECT_NEAR(found.step_s, camera.frame_s, 1e-6 * camera.frame_s);
  ASSERT_GT(found.turns_t_s.size(), 0.9 * 30.0 / camera.frame_s);
  ASSERT_EQ(found.turns_t_s.size(), found.turns_world_body.size());
  for (std::size_t k = 0; k < found.turns_t_s.size(); ++k) {
    const long frame = std::lround((found.turns_t_s[k] - camera.phase_s) / camera.frame_s);
    EXPECT_NEAR(found.turns_t_s[k], camera.time(frame), 1e-5) << k;
    const Quat q = camera.turns(frame);
    const Eigen::Vector4d its(q.w(), q.x(), q.y(), q.z()), read = found.turns_world_body[k];
    // Rounding, and the clock's own error at 6 rad/s; a line that was not undone would be off by a milliradian.
    EXPECT_LT(std::min((read - its).norm(), (read + its).norm()), 2e-5) << k;
  }
  for (std::size_t k = 0; k < found.places_t_s.size(); ++k) {
    const long frame = std::lround((found.places_t_s[k] - camera.phase_s) / camera.frame_s);
    EXPECT_LT((found.places_m[k] - camera.places(frame)).norm(), 1e-5) << k;
  }
}

TEST(FramesOffRows, AreReadBackFromTheLinesBetweenThem) {
  for (const double rows_a_frame : {5.0 / 3.0, 2.0, 2.5, 3.3})
    for (const double noise : {0.0, 3e-4}) {
      const Camera camera{rows_a_frame * kRow_s, noise, line_of_length_one};
      const auto found = frames_off_rows(drawn(camera));
      ASSERT_TRUE(found) << rows_a_frame << " " << noise;
      expect_its_frames(*found, camera);
    }
}

/// Two rows on each line bend nearly alike where they are nearly as far from its ends.
TEST(FramesOffRows, AreReadBackWhereverTheyFallBetweenTheRows) {
  for (const double phase_s : {0.002, 0.0045, 0.005, 0.0055, 0.008}) {
    const Camera camera{2.0 * kRow_s, 0.0, line_of_length_one, phase_s};
    const auto found = frames_off_rows(drawn(camera));
    ASSERT_TRUE(found) << phase_s;
    expect_its_frames(*found, camera);
  }
}

TEST(FramesOffRows, MayBeJoinedByGreatCircles) {
  const Camera camera{0.025, 3e-4, great_circle};
  const auto found = frames_off_rows(drawn(camera));
  ASSERT_TRUE(found);
  expect_its_frames(*found, camera);
}

TEST(FramesOffRows, KeepTheirClockOverLostRows) {
  const Camera camera{0.025, 3e-4, line_of_length_one};
  io::Recording r = drawn(camera);
  for (std::size_t i = 1000; i < 1200; ++i)
    r.ref_q_world_body[i].setConstant(io::kMissing), r.ref_position_m[i].setConstant(io::kMissing);
  const auto found = frames_off_rows(r);
  ASSERT_TRUE(found);
  expect_its_frames(*found, camera);
  for (const double t : found->turns_t_s) EXPECT_FALSE(t > 10.03 && t < 11.96) << "no row tells of this frame";
}

TEST(FramesOffRows, OfAttitudesAloneAreFoundToo) {
  const Camera camera{0.025, 3e-4, line_of_length_one};
  io::Recording r = drawn(camera);
  r.ref_position_m.clear();
  const auto found = frames_off_rows(r);
  ASSERT_TRUE(found);
  expect_its_frames(*found, camera);
}

TEST(FramesOffRows, AreNotSeenInWhatWasMeasuredInEveryRow) {
  // A camera of as many frames as rows, of more, and arithmetic.
  for (const Camera& camera : {Camera{kRow_s, 3e-4, great_circle}, Camera{0.4 * kRow_s, 3e-4, great_circle},
                               Camera{0.001 * kRow_s, 0.0, great_circle}})
    EXPECT_FALSE(frames_off_rows(drawn(camera))) << camera.frame_s;
}

/// BROAD's cameras took 120 frames a second (Laidig et al. 2021); its files hold 286 rows.
TEST(FramesOffRows, OfARealTrackerAreThoseThatItTook) {
  for (const char* trial : {"03_undisturbed_slow_rotation_C", "15_undisturbed_fast_translation_A"}) {
    const std::string path = in_source(fmt::format("../shared/recordings/broad/{}.csv", trial));
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "LOUD: SKIPPED, recording absent: " << path;
    const auto recording = io::read_recording(path);
    ASSERT_TRUE(recording);
    const auto found = frames_off_rows(*recording);
    ASSERT_TRUE(found) << trial;
    EXPECT_NEAR(1.0 / found->step_s, 120.0, 0.02) << trial;
    EXPECT_GT(found->turns_t_s.size(), recording->size() / 3) << trial;
  }
}

}  // namespace
}  // namespace stillpoint::diag
