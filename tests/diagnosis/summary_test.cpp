/// The text for people: it fits a terminal, and loses no word for it.
#include "diagnosis/summary.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <sstream>

#include "tests/diagnosis/simulated.h"

namespace stillpoint::diag {
namespace {

TEST(Summary, FitsEightyColumnsAndLosesNoWord) {
  Diagnosis d;
  d.summary = "No mismatch.";
  const std::string word(120, 'x');
  d.notices = {"one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen",
               word + " after a word longer than any line"};
  const std::string text = to_text(d);
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    EXPECT_TRUE(line.size() <= 80 || line.find(word) != std::string::npos) << line;
  std::string joined = text;
  std::replace(joined.begin(), joined.end(), '\n', ' ');
  joined.erase(std::unique(joined.begin(), joined.end(), [](char a, char b) { return a == ' ' && b == ' '; }),
               joined.end());
  for (const std::string& n : d.notices) EXPECT_THAT(joined, testing::HasSubstr(n));
}

TEST(Summary, SaysThatTheNoiseIsNotAsConfigured) {
  const auto config = test::baseline("mocap", 60.0);
  auto noisy = config;
  noisy.gyroscope->noise_sd *= 3.0;
  const Diagnosis d = diagnose(test::record(noisy, "", {}, 5), config).diagnosis;
  EXPECT_TRUE(d.findings.empty());
  EXPECT_EQ(d.verdict, Verdict::kWrongNumbers);
  EXPECT_THAT(d.summary,
              testing::MatchesRegex("No missing physics. The noise is not as configured: gyr_x (2.9|3.0|3.1) times, "
                                    "gyr_y (2.9|3.0|3.1) times, gyr_z (2.9|3.0|3.1) times."));
  EXPECT_THAT(diagnose(test::record(config, "", {}, 5), config).diagnosis.summary, testing::StartsWith("No mismatch."));
}

}  // namespace
}  // namespace stillpoint::diag
