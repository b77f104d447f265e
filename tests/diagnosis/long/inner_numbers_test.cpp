/// What a law's text has in its brackets is known as well as its coefficients, and no better.
#include <gtest/gtest.h>

#include "diagnosis/diagnose.h"
#include "io/simulated_recording.h"
#include "simulation/simulator.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

struct Inner {
  const char *law, *name, *unit;
  double value;
};

void PrintTo(const Inner& inner, std::ostream* out) { *out << inner.law; }

class InnerNumbers : public testing::TestWithParam<Inner> {};

INSTANTIATE_TEST_SUITE_P(
    Laws, InnerNumbers,
    testing::Values(Inner{"sensor: gyr, law: \"step(w_z, 0.5) * (w_z - 0.5)\", k: [0.003, 0, -0.002]}", "threshold",
                          "rad/s", 0.5},
                    Inner{"sensor: acc, law: \"lag(I, 4)\", k: [0.03, 0, -0.02]}", "tau", "s", 4.0},
                    Inner{"sensor: mag, law: \"play(m_x, 6)\", k: [0.03, 0.05, 0]}", "width", "uT", 6.0},
                    Inner{"sensor: gyr, law: \"w_y * step(t, 30)\", k: [0.01, 0, -0.02]}", "at", "s", 30.0}));

TEST_P(InnerNumbers, AreStatedWithAnIntervalThatHoldsThem) {
  const sim::SimulationConfig truth = test::with_law(std::string("  - {effect: law, ") + GetParam().law);
  sim::SimulationConfig plain = truth;
  plain.effects.clear();
  int stated = 0, held = 0;
  double width = 0.0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Answer answer = diagnose(io::to_recording(sim::simulate(truth, seed)), plain);
    for (const Finding& f : answer.diagnosis.findings)
      for (const Parameter& p : f.parameters) {
        if (p.name != GetParam().name || p.unit != GetParam().unit) continue;
        ++stated;
        held += p.ci95[0] < GetParam().value && GetParam().value < p.ci95[1];
        width += p.ci95[1] - p.ci95[0];
      }
  }
  EXPECT_GE(stated, 7);
  EXPECT_GE(held, stated - 1);
  EXPECT_LT(width, 0.3 * GetParam().value * stated);
}

}  // namespace
}  // namespace stillpoint::diag
