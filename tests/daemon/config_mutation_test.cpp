/// Damaged configurations of the daemon: whatever the damage, the answer is a located fault or a configuration with
/// which the stages publish. The sanitizer builds run this too.
#include <random>

#include "io/config.h"
#include "tests/apps/apps_testing.h"

namespace stillpoint::io {
namespace {

constexpr int kMutants = 1500;

/// A number or a word replaced by one that a careless or hostile hand would write, or a stretch cut out.
std::string damaged(std::string text, std::mt19937& random) {
  static const std::vector<std::string> kWords{
      "nan", ".nan", "-.inf", "1e999", "-1", "0",  "1e308", "-1e308", "1e-308", "9223372036854775807",
      "''",  "~",    "[]",    "{}",    "x",  "\t", "*a",    "? ",     "true",   std::string(300, '[')};
  static constexpr std::string_view kNumber = "0123456789.eE+-", kEnds = " :,[]{}\n";
  const auto below = [&random](std::size_t n) { return n == 0 ? 0 : random() % n; };
  for (std::size_t edits = 1 + below(3); edits > 0; --edits) {
    const std::size_t at = below(text.size());
    const bool number = below(2) == 0;
    if (below(6) == 0) {
      text.erase(at, 1 + below(40));
      continue;
    }
    const std::size_t begin = number ? text.find_first_of("0123456789", at) : text.find_first_not_of(kEnds, at);
    if (begin == std::string::npos) continue;
    const std::size_t end = number ? text.find_first_not_of(kNumber, begin) : text.find_first_of(kEnds, begin);
    text.replace(begin, (end == std::string::npos ? text.size() : end) - begin, kWords[below(kWords.size())]);
  }
  return text;
}

/// Attitudes published of 400 samples of a body at rest.
std::size_t published(const DaemonConfig& config) {
  calib::OnlineCalibrator calibrator(config.calibration.online, factory_calibration(config.sensor));
  pipeline::DirectLink link(calibrator);
  pipeline::Stages stages(stages_params(config), calibrator.snapshot());
  pipeline::Processed out;
  std::size_t count = 0;
  for (std::uint64_t k = 0; k < 400; ++k) {
    const double jitter = 1e-3 * static_cast<double>(k % 7);
    const RawSample sample{.t_ns = static_cast<std::int64_t>(k) * 10'000'000,
                           .sequence = k,
                           .acc_mps2 = {jitter, -jitter, 9.8},
                           .gyr_radps = {1e-3 * jitter, 0, 1e-3 * jitter},
                           .mag_uT = {20, jitter, -43},
                           .temp_degC = 25,
                           .has = kAcc | kGyr | kMag | kTemp};
    count += stages.process(sample, out, link) == pipeline::StageStatus::kDrop ? 0U : 1U;
  }
  return count;
}

TEST(ConfigMutation, ADamagedConfigurationIsAFaultAtItsPlaceOrOneThatPublishes) {
  const auto good = parse_config("source: {kind: simulation, file: /a.yaml}\n", "g.yaml");
  ASSERT_TRUE(good) << good.error().message;
  const std::string text = print_config(*good);
  std::mt19937 random(7);
  int read = 0, refused = 0;
  for (int i = 0; i < kMutants; ++i) {
    const std::string mutant = damaged(text, random);
    const auto config = parse_config(mutant, "m.yaml");
    if (!config) {
      ++refused;
      ASSERT_EQ(config.error().message.rfind("m.yaml:", 0), 0U) << config.error().message;
      continue;
    }
    ++read;
    // Beyond a thousand times full scale a reading is a broken transfer: a mutant may set full scale so low.
    const auto& limits = config->sensor.limits;
    if (std::min({limits.acc_limit_mps2, limits.gyr_limit_radps, limits.mag_limit_uT}) < 1.0) continue;
    ASSERT_EQ(published(*config), 400U) << "mutant " << i << "\n" << mutant;
  }
  EXPECT_GT(read, kMutants / 10) << "the damage is so great that nothing is tested";
  EXPECT_GT(refused, kMutants / 5);
}

}  // namespace
}  // namespace stillpoint::io
