/// A reference that turns slowly against the sensors is no physics of theirs.
#include "diagnosis/reference/wandering_reference.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/so3.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

TEST(WanderingReference, ItsTurnsAreNoLaw) {
  auto config = test::baseline("mocap", 60.0);
  io::Recording r = test::record(config, "", {}, 11);
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double t = r.t_s(i) - r.t_s(0);
    const Quat turn = exp_quat(Vec3(4e-3 * std::sin(0.11 * t), 4e-3 * std::cos(0.17 * t), 0.0));
    const auto& q = r.ref_q_world_body[i];
    const Quat turned = Quat(q[0], q[1], q[2], q[3]) * turn;
    r.ref_q_world_body[i] = Eigen::Vector4d(turned.w(), turned.x(), turned.y(), turned.z());
  }
  Result<Signals> s = make_signals(r, config, {});
  ASSERT_TRUE(s);
  SensorSearch search = start_search(*s, kMag);
  Found product;
  product.id = "unknown:m*t";
  product.names = {"k"};
  Series3 x(s->n, 3);
  for (Eigen::Index i = 0; i < s->n; ++i)
    x.row(i) = std::sin(0.11 * s->t_s[i]) * Vec3::UnitX().cross(Vec3(s->vector[kMag].row(i).transpose()));
  product.columns = {{-1, x}};
  const double alone = fit_profile(search.beside_walk(), product.columns).log_likelihood -
                       fit_profile(search.beside_walk(), {}).log_likelihood;
  EXPECT_GT(alone, 20.0) << "it fits";
  EXPECT_FALSE(stands_beside_wandering(*s, search, product));
  s->exact_reference = true;
  EXPECT_TRUE(stands_beside_wandering(*s, search, product)) << "an exact reference does not turn";
}

TEST(WanderingReference, MayBeWhatASmallLawOfTheAccelerometerIsTakenFor) {
  auto config = test::baseline("mocap", 60.0);
  config.environment.temperature = {.kind = "warm_up", .start_degC = 22.0, .rise_K = 12.0, .tau_s = 40.0};
  for (const auto& [k, small] : {std::pair{3e-4, true}, std::pair{1e-2, false}}) {
    const io::Recording r = test::record(config, "acc_temp_lin", {{"k_mps2_per_K", {k, -k, k}}}, 11);
    Result<Signals> s = make_signals(r, config, {});
    ASSERT_TRUE(s);
    Found law;
    law.id = "acc_temp_lin";
    for (int axis = 0; axis < 3; ++axis) law.columns.push_back({axis, s->temperature_K});
    EXPECT_EQ(as_small_as_wandering(*s, start_search(*s, kAcc), law), small) << k;
    s->exact_reference = true;
    EXPECT_FALSE(as_small_as_wandering(*s, start_search(*s, kAcc), law));
  }
}

}  // namespace
}  // namespace stillpoint::diag
