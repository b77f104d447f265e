/// Which rows of a reference a camera measured, and which were drawn as a line between two of its frames.
#include "diagnosis/sanity/frames_between.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

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

TEST(FramesBetween, AreNotSeenWhereEveryRowWasMeasured) {
  EXPECT_EQ(rows_drawn_between_frames(followed(4001, 1e-4)).rows_a_frame, 1u) << "a camera";
  EXPECT_EQ(rows_drawn_between_frames(followed(4001, 0.0)).rows_a_frame, 1u) << "arithmetic";
}

}  // namespace
}  // namespace stillpoint::diag
