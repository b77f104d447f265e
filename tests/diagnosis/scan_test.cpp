/// What the scan makes of drivers that are zero for a while.
#include "diagnosis/reference/scan.h"

#include <gtest/gtest.h>

#include "diagnosis/reference/scan_noise.h"
#include "diagnosis/reference/selection.h"
#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

/// Squared it is less than the rounding of the sums over the rows before, and would explain anything: such drivers
/// stood first on the short list.
TEST(Scan, ADriverThatIsNearlyZeroInAWindowExplainsNothingThere) {
  const auto config = test::baseline("exact", 60.0);
  const Result<Signals> s = make_signals(test::record(config, "", {}, 3), config, {});
  ASSERT_TRUE(s);
  const SensorSearch search = start_search(*s, kGyr);
  Law law = search.laws.front();
  law.shapes = {0.0};
  law.extent = Extent::kAny;
  law.columns = [&](double) {
    Series3 x = s->vector[kAcc];
    x.bottomRows(s->n / 2) *= 1e-11;
    return Columns{{-1, x}};
  };
  const NoiseModel noise = scan_noise(search.target, {}, *search.walk);
  for (const Candidate& c : Scan(search.target, {}, noise).look(law, 0)) EXPECT_LT(c.gain_nats, 50.0);
}

}  // namespace
}  // namespace stillpoint::diag
