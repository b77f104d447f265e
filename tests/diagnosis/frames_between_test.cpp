/// Which rows of a reference a camera measured, and which were drawn as a line between two of its frames.
#include "diagnosis/sanity/frames_between.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnosis/sanity/rows_with_reference.h"

namespace stillpoint::diag {
namespace {

constexpr double kStep_s = 0.005;

/// A hand with the noise of a camera, to the decimals of a file.
io::Recording followed(std::size_t rows, double noise_m) {
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal;
  const auto printed = [](double x) { return 1e-7 * std::round(1e7 * x); };
  io::Recording r;
  for (std::size_t i = 0; i < rows; ++i) {
    const double t = kStep_s * static_cast<double>(i);
    r.t_ns.push_back(std::llround(1e9 * t));
    const Vec3 p(0.1 * std::sin(6.0 * t), 0.1 * std::cos(4.0 * t), 0.05 * std::sin(9.0 * t));
    r.ref_position_m.push_back((p + noise_m * Vec3(normal(engine), normal(engine), normal(engine))).unaryExpr(printed));
    const double half = 0.3 * std::sin(5.0 * t) + noise_m * normal(engine);
    r.ref_q_world_body.emplace_back(printed(std::cos(half)), printed(std::sin(half)), 0.0, 0.0);
  }
  return r;
}

io::Recording drawn_between(io::Recording r, std::size_t step) {
  for (std::size_t i = 0; i + step < r.size(); i += step)
    for (std::size_t k = 1; k < step; ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(step);
      const auto between = [share](const auto& a, const auto& b) { return ((1.0 - share) * a + share * b).eval(); };
      r.ref_position_m[i + k] = between(r.ref_position_m[i], r.ref_position_m[i + step]);
      r.ref_q_world_body[i + k] = between(r.ref_q_world_body[i], r.ref_q_world_body[i + step]).normalized();
    }
  return r;
}

TEST(FramesBetween, AreFoundByTheirBends) {
  for (const std::size_t step : {2u, 4u}) {
    const DrawnRows found = rows_drawn_between_frames(drawn_between(followed(4001, 1e-4), step));
    ASSERT_EQ(found.rows_a_frame, step);
    for (std::size_t i = 0; i < found.drawn.size(); ++i) EXPECT_EQ(found.drawn[i], i % step != 0) << i;
  }
}

TEST(FramesBetween, AreFoundByThePositionWhereTheBodyTurnsFast) {
  io::Recording r = followed(4001, 1e-4);
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double half = 6.0 * std::sin(0.005 * static_cast<double>(i));
    r.ref_q_world_body[i] = Eigen::Vector4d(std::cos(half), std::sin(half), 0.0, 0.0);
  }
  EXPECT_EQ(rows_drawn_between_frames(drawn_between(r, 3)).rows_a_frame, 3u);
}

TEST(FramesBetween, KeepTheirStepAfterALostRow) {
  io::Recording r = drawn_between(followed(4001, 1e-4), 2);
  const auto drop = [](auto& column) { column.erase(column.begin() + 1001); };
  drop(r.t_ns), drop(r.ref_position_m), drop(r.ref_q_world_body);
  const DrawnRows found = rows_drawn_between_frames(r);
  ASSERT_EQ(found.rows_a_frame, 2u);
  EXPECT_TRUE(found.drawn[901]);
  EXPECT_FALSE(found.drawn[1101]) << "the frames lie on odd rows from there on";
}

/// Rows [begin, end) lost, and a line drawn over them: turns at a constant rate, places alike.
io::Recording drawn_over(io::Recording r, std::size_t begin, std::size_t end) {
  const auto at = [&r](std::size_t i) {
    const Eigen::Vector4d& q = r.ref_q_world_body[i];
    return Quat(q[0], q[1], q[2], q[3]);
  };
  const Quat from = at(begin - 1), to = at(end);
  const Vec3 a = r.ref_position_m[begin - 1], b = r.ref_position_m[end];
  for (std::size_t i = begin; i < end; ++i) {
    const double share = static_cast<double>(i - begin + 1) / static_cast<double>(end - begin + 1);
    const Quat q = from.slerp(share, to);
    r.ref_q_world_body[i] = Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
    r.ref_position_m[i] = (1.0 - share) * a + share * b;
  }
  return r;
}

TEST(FramesBetween, AreNoneUnderALineOverLostFrames) {
  const DrawnRows found = rows_drawn_between_frames(drawn_over(followed(4001, 1e-4), 1001, 1021));
  EXPECT_EQ(found.rows_a_frame, 1u);
  EXPECT_EQ(found.lost_rows, 20u);
  for (std::size_t i = 0; i < found.drawn.size(); ++i) EXPECT_EQ(found.drawn[i], i >= 1001 && i < 1021) << i;
  const DrawnRows of_frames = rows_drawn_between_frames(drawn_over(drawn_between(followed(4001, 1e-4), 4), 1001, 1021));
  EXPECT_EQ(of_frames.rows_a_frame, 4u);
  for (std::size_t i = 1001; i < 1020; ++i) EXPECT_TRUE(of_frames.drawn[i]) << i;
  EXPECT_FALSE(of_frames.drawn[1000]);
}

TEST(FramesBetween, AreNotLostWhereNothingMovesOrNothingIsNoisy) {
  io::Recording still = followed(4001, 1e-4);
  for (std::size_t i = 1001; i < 1021; ++i)
    still.ref_q_world_body[i] = still.ref_q_world_body[1000], still.ref_position_m[i] = still.ref_position_m[1000];
  const DrawnRows held = rows_drawn_between_frames(still);
  EXPECT_EQ(held.lost_rows, 0u) << "a value that repeats is another matter";
  EXPECT_EQ(rows_drawn_between_frames(drawn_over(followed(4001, 0.0), 1001, 1021)).lost_rows, 0u)
      << "steady motion is as straight";
}

/// 100 frames a second on 104 rows: one in 26 has none. Beside it no bend is seen, which is no line.
TEST(FramesBetween, AreNotLostBesideARowWithoutOne) {
  io::Recording r = followed(4001, 1e-4);
  for (std::size_t i = 14; i < r.size(); i += 26)
    r.ref_q_world_body[i].setConstant(io::kMissing), r.ref_position_m[i].setConstant(io::kMissing);
  EXPECT_EQ(rows_drawn_between_frames(r).lost_rows, 0u);
  r.gyr_radps.assign(r.size(), Vec3(0.1, 0.2, 0.3));
  std::vector<std::string> notices;
  const RowsWithReference filled = rows_with_reference(r, notices);
  ASSERT_TRUE(filled.changed);
  const io::Recording truth = followed(4001, 0.0);
  for (std::size_t i = 14; i + 26 < r.size(); i += 26)
    EXPECT_LT((filled.changed->ref_position_m[i] - truth.ref_position_m[i]).norm(), 1e-3) << i;
}

TEST(FramesBetween, AreNotLostWhereTheyFallOnNoRows) {
  const io::Recording frames = followed(4001, 1e-4);
  io::Recording r;
  for (std::size_t i = 0; i < 8000; ++i) {  // 4.6 rows a frame
    const double at = static_cast<double>(i) / 4.6;
    const auto k = static_cast<std::size_t>(at);
    const double share = at - static_cast<double>(k);
    const auto between = [share](const auto& a, const auto& b) { return ((1.0 - share) * a + share * b).eval(); };
    r.t_ns.push_back(std::llround(1e9 * kStep_s * at));
    r.ref_position_m.push_back(between(frames.ref_position_m[k], frames.ref_position_m[k + 1]));
    r.ref_q_world_body.push_back(between(frames.ref_q_world_body[k], frames.ref_q_world_body[k + 1]).normalized());
  }
  EXPECT_EQ(rows_drawn_between_frames(r).lost_rows, 0u);
}

TEST(FramesBetween, AreNotSeenWhereEveryRowWasMeasured) {
  EXPECT_EQ(rows_drawn_between_frames(followed(4001, 1e-4)).rows_a_frame, 1u) << "a camera";
  EXPECT_EQ(rows_drawn_between_frames(followed(4001, 0.0)).rows_a_frame, 1u) << "arithmetic";
}

}  // namespace
}  // namespace stillpoint::diag
