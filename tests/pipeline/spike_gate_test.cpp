#include "pipeline/spike_gate.h"

#include <gtest/gtest.h>

namespace stillpoint::pipeline {
namespace {

TEST(SpikeGate, RefusesASingleReadingThatNoMotionGives) {
  SpikeGate gate(30.0);
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(gate.refuses({0.01 * k, 0.0, 0.0}));
  EXPECT_TRUE(gate.refuses({300.0, 0.0, 0.0}));
  EXPECT_FALSE(gate.refuses({1.0, 0.0, 0.0}));
}

TEST(SpikeGate, BelievesWhatLasts) {
  SpikeGate gate(30.0);
  EXPECT_FALSE(gate.refuses({0.0, 0.0, 0.0}));
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(gate.refuses({0.0, -40.0, 0.0}));
  for (int k = 0; k < 3; ++k) EXPECT_FALSE(gate.refuses({0.0, -40.0, 0.0}));
}

TEST(SpikeGate, AllowsASensorItsUsualSteps) {
  SpikeGate gate(30.0);
  for (int k = 0; k < 1000; ++k) EXPECT_FALSE(gate.refuses({k % 2 == 0 ? 10.0 : -10.0, 0.0, 0.0}));
  EXPECT_FALSE(gate.refuses({60.0, 0.0, 0.0})) << "three of its steps";
  EXPECT_FALSE(gate.refuses({-10.0, 0.0, 0.0}));
  EXPECT_TRUE(gate.refuses({600.0, 0.0, 0.0}));
}

TEST(SpikeGate, KnowsNothingAfterAGap) {
  SpikeGate gate(30.0);
  EXPECT_FALSE(gate.refuses({0.0, 0.0, 0.0}));
  gate.forget();
  EXPECT_FALSE(gate.refuses({0.0, 50.0, 0.0}));
}

}  // namespace
}  // namespace stillpoint::pipeline
