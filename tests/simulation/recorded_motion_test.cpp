/// A hand's motion goes out as reference columns and comes back through the splines.
#include "simulation/recorded_motion.h"

#include <gmock/gmock.h>

#include "core/so3.h"
#include "io/simulated_recording.h"
#include "io/simulation_yaml.h"
#include "simulation/reference_noise.h"

namespace stillpoint::sim {
namespace {

struct Recorded {
  std::shared_ptr<const Motion> truth;
  ReferenceTrack track;
};

/// 120 s of a hand's motion as a motion capture with this reference would have recorded it.
Recorded recorded(const std::string& reference, std::uint64_t seed = 9) {
  const auto c = *io::parse_simulation(
      "accelerometer: {noise_mps2: 0.02}\nmotion: {kind: hand, duration_s: 120}\n" + reference, "test");
  Recorded out{make_motion(*c.motion, seed), {}};
  out.track = io::reference_track(io::to_recording(simulate(c, out.truth, seed)));
  out.track.moving.clear();  // rest must be recognised from the reference itself
  return out;
}

/// What the motion taken from the track gets wrong, rms over the time in motion and over all axes.
struct Errors {
  double acceleration_mps2, rate_radps;
  double rest_found, rest_wrong;  ///< share of the true rest that was found, of what was found that was none
};

Errors errors_of(const Motion& taken, const Motion& truth) {
  double a2 = 0.0, w2 = 0.0, moving = 0.0, rest = 0.0, found = 0.0, wrong = 0.0;
  for (double t = 1.0; t < 118.0; t += 0.0137) {
    const MotionState is = truth.at(t), ours = taken.at(t);
    if (!ours.moving) {
      EXPECT_EQ(ours.rate_radps.norm() + ours.acceleration_mps2.norm(), 0.0);  // still is still, not nearly so
    }
    const bool truly_still = is.rate_radps.norm() < 0.02 && is.acceleration_mps2.norm() < 0.05;
    rest += is.moving ? 0.0 : 1.0;
    found += !is.moving && !ours.moving ? 1.0 : 0.0;
    wrong += !ours.moving && !truly_still ? 1.0 : 0.0;
    if (!is.moving) continue;
    moving += 3.0;
    a2 += (is.acceleration_mps2 - ours.acceleration_mps2).squaredNorm();
    w2 += (is.rate_radps - ours.rate_radps).squaredNorm();
  }
  return {std::sqrt(a2 / moving), std::sqrt(w2 / moving), found / rest, wrong / rest};
}

TEST(RecordedMotion, FollowsAnExactReferenceAndRests) {
  const auto [truth, track] = recorded("");
  const auto motion = RecordedMotion::from(track);
  ASSERT_TRUE(motion);
  const Errors e = errors_of(**motion, *truth);
  EXPECT_LT(e.acceleration_mps2, 0.002);
  EXPECT_LT(e.rate_radps, 2e-4);
  EXPECT_GT(e.rest_found, 0.8);  // a quarter of a second at either end of 2.5 to 5 s is not judged
  EXPECT_LT(e.rest_wrong, 0.01);
}

/// A person stands, then walks: held to the mean of his sway he would be thrown to where he sets out from.
TEST(RecordedMotion, WhoSwaysIsNotHeldStill) {
  ReferenceTrack track;
  const auto place = [](double t) {
    const double walks = t > 20.0 ? 0.05 * (1.0 - std::cos(2.0 * (t - 20.0))) : 0.0;
    return Vec3(0.002 * std::sin(1.3 * t) + walks, 0.001 * std::cos(2.1 * t), walks);
  };
  for (int i = 0; i < 4000; ++i) {
    const double t = 0.01 * i;
    track.t_s.push_back(t);
    track.position_m.push_back(place(t));
    track.q_world_body.push_back(stillpoint::exp_quat(Vec3(0.003 * std::sin(1.1 * t), 0.0, 0.002 * std::cos(0.8 * t))));
  }
  const auto motion = RecordedMotion::from(track);
  ASSERT_TRUE(motion);
  double most = 0.0;
  for (double t = 1.0; t < 19.5; t += 0.0137) most = std::max(most, (*motion)->at(t).acceleration_mps2.norm());
  EXPECT_LT(most, 0.02);
}

constexpr const char* kColoured =
    "reference: {kind: mocap, orientation_sd_rad: 1e-3, position_sd_m: 2e-4, band_hz: 10}\n";
constexpr const char* kWhiteReference =
    "reference: {kind: mocap, orientation_sd_rad: 1e-3, position_sd_m: 2e-4, band_hz: 500}\n";

CurveSamples<3> places_of(const ReferenceTrack& track) {
  CurveSamples<3> out;
  out.t_s = track.t_s;
  out.value = track.position_m;
  out.weight.assign(track.t_s.size(), 1.0);
  return out;
}

std::vector<Span> true_rests(const Recorded& r) {
  std::vector<Span> out;
  for (std::size_t i = 0; i < r.track.t_s.size(); ++i) {
    if (r.truth->at(r.track.t_s[i]).moving) continue;
    if (out.empty() || out.back().second + 1 != i) out.emplace_back(i, i);
    out.back().second = i;
  }
  return out;
}

/// The penalty that follows from the noise at rest against every penalty tried with the truth at hand: within a tenth
/// of the least error in the acceleration that any of them leaves.
TEST(RecordedMotion, SmoothsAsItsNoiseDemands) {
  for (const char* reference : {kColoured, kWhiteReference}) {
    const Recorded r = recorded(reference);
    const auto places = places_of(r.track);
    const auto error = [&](double penalty) {
      const SmoothingSpline<3> spline(places, 0.01, penalty);
      double sum = 0.0, count = 0.0;
      for (double t = 1.0; t < 118.0; t += 0.0137) {
        const MotionState is = r.truth->at(t);
        if (!is.moving) continue;
        const auto p = spline.at(t);
        sum += (Vec3(p[0].dd, p[1].dd, p[2].dd) - is.acceleration_mps2).squaredNorm();
        count += 3.0;
      }
      return std::sqrt(sum / count);
    };
    double least = 1e9;
    for (const double penalty : spline_penalties()) least = std::min(least, error(penalty));
    const double chosen = error(penalty_against_noise(places, true_rests(r), 0.01, 2));
    EXPECT_LT(chosen, 1.35 * least) << reference;
    EXPECT_GT(error(1e-10), 3.0 * chosen) << reference << "without smoothing the noise is taken for motion";
  }
}

/// What is left of a noise of known size: noise inside the band of the motion, which no smoothing takes.
TEST(RecordedMotion, DoesNotTakeTheNoiseOfItsReferenceForMotion) {
  const auto [truth, track] = recorded(kColoured);
  const auto motion = RecordedMotion::from(track);
  ASSERT_TRUE(motion);
  const Errors e = errors_of(**motion, *truth);
  EXPECT_LT(e.acceleration_mps2, 0.1);  // 2.1 m/s^2 without smoothing
  EXPECT_LT(e.rate_radps, 0.02);
  EXPECT_GT(e.rest_found, 0.75);
  EXPECT_LT(e.rest_wrong, 0.02);
}

TEST(RecordedMotion, BridgesAGapWithoutSwinging) {
  for (const char* reference : {"", kColoured}) {
    auto track = recorded(reference).track;
    track.t_s.erase(track.t_s.begin() + 2000, track.t_s.begin() + 2300);
    track.q_world_body.erase(track.q_world_body.begin() + 2000, track.q_world_body.begin() + 2300);
    track.position_m.erase(track.position_m.begin() + 2000, track.position_m.begin() + 2300);
    const auto motion = RecordedMotion::from(track);
    for (double t = 19.0; t < 24.0; t += 0.01) {
      ASSERT_LT((*motion)->at(t).position_m.norm(), 1.0) << t;
      ASSERT_LT((*motion)->at(t).rate_radps.norm(), 15.0) << t;
      ASSERT_LT((*motion)->at(t).acceleration_mps2.norm(), 60.0) << t;
    }
  }
}

TEST(RecordedMotion, RefusesARecordingWithoutReference) { EXPECT_FALSE(RecordedMotion::from({})); }

}  // namespace
}  // namespace stillpoint::sim
