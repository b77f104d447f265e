/// Times that jump, wrap or go back: what is left of them before anything is told from the values.
#include <gmock/gmock.h>

#include <algorithm>

#include "tests/exchange/foreign_files.h"
#include "tests/exchange/importing.h"

namespace stillpoint::exchange {
namespace {

using test::all;
using test::file;
using test::read;
using testing::HasSubstr;

constexpr const char* kUnnamed = "t,ax,ay,az,gx,gy,gz";

std::string table_in_order(const std::vector<RawSample>& samples, const std::string& header = kUnnamed,
                           double factor = 1.0) {
  return test::table(samples, {header, ",", factor, 0, {{&RawSample::acc_mps2, 1.0}, {&RawSample::gyr_radps, 1.0}}});
}

TEST(Order, RowsWhoseTimeGoesBackTellNoUnit) {
  auto samples = test::hand();
  constexpr std::size_t kAgain = 800;
  std::rotate(samples.begin(), samples.begin() + kAgain, samples.end());
  const auto imported = read(file("restart.csv", table_in_order(samples)));
  EXPECT_THAT(all(imported.reasons), HasSubstr("gx, gy, gz looks like rad/s"));
  EXPECT_THAT(all(imported.reasons), HasSubstr("800 rows dropped, whose time does not advance"));
  ASSERT_EQ(imported.recording.size(), samples.size() - kAgain);
  EXPECT_NEAR(imported.recording.gyr_radps[1000].norm(), vec(samples[1000].gyr_radps).norm(), 1e-6);
}

TEST(Order, OneWildStampCostsItsOwnRowAlone) {
  const std::size_t rows = test::hand().size();
  for (const std::size_t wild : {std::size_t{0}, std::size_t{100}, rows - 1}) {
    auto samples = test::hand();
    samples[wild].t_ns = 1'000'000'000'000'000;
    const auto imported = read(file("wild.csv", table_in_order(samples)));
    EXPECT_EQ(imported.recording.size(), rows - 1) << "row " << wild;
    EXPECT_THAT(all(imported.reasons), HasSubstr("1 row dropped, far ahead of all others in time"));
    EXPECT_THAT(all(imported.reasons), HasSubstr("gx, gy, gz looks like rad/s"));
  }
}

TEST(Order, ACounterOf32BitsGoesOnWhereItWraps) {
  struct Counter {
    const char* name;
    std::int64_t tick_ns;
  };
  for (const auto& [name, tick_ns] : {Counter{"time_ms", 1'000'000}, {"time_us", 1000}, {"time_ns", 1}}) {
    const std::int64_t period_ns = (std::int64_t{1} << 32) * tick_ns;
    auto samples = test::hand();
    const auto truth = samples;
    for (auto& s : samples) s.t_ns = (s.t_ns + period_ns - 2'000'000'000) % period_ns;
    const std::string header = std::string(name) + ",ax,ay,az,gx,gy,gz";
    const auto imported = read(file("wrap.csv", table_in_order(samples, header, 1e9 / static_cast<double>(tick_ns))));
    ASSERT_EQ(imported.recording.size(), truth.size()) << name;
    EXPECT_NEAR(static_cast<double>(imported.recording.t_ns.back()),
                static_cast<double>(truth.back().t_ns - truth.front().t_ns), 2000.0);
    EXPECT_THAT(all(imported.reasons), HasSubstr("its 32-bit counter wraps"));
  }
}

TEST(Order, ARestartIsNoWrap) {
  auto samples = test::hand();
  for (std::size_t i = 0; i < samples.size(); ++i)
    samples[i].t_ns = static_cast<std::int64_t>(i < 1500 ? i : i - 1500) * 10'000'000;
  const auto imported =
      read(file("again.csv", table_in_order(samples, "t,ax,ay,az,gyr_x_radps,gyr_y_radps,gyr_z_radps")));
  EXPECT_EQ(imported.recording.size(), 1500U);
  EXPECT_THAT(all(imported.reasons), testing::Not(HasSubstr("wraps")));
}

}  // namespace
}  // namespace stillpoint::exchange
