/// Replays whose rounded figures lie in tests/golden: a change of behaviour shows as a diff and must be committed. To
/// write them anew: STILLPOINT_WRITE_GOLDEN=1 build/release/tests/test_fusion --gtest_filter='Golden*', and
/// test_pipeline.
#pragma once
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/source_folder.h"

namespace stillpoint::test {

/// Of a replay: a line at most every so often.
struct GoldenTrace {
  std::int64_t every_ns;
  std::string text{};
  std::int64_t due_ns = 0;

  template <class Line>
  void add(std::int64_t t_ns, const Line& line) {
    if (t_ns < due_ns) return;
    text += line();
    due_ns = t_ns + every_ns;
  }
};

/// A fault's time.
inline bool within(double t_s, double from_s, double to_s) { return t_s >= from_s && t_s < to_s; }

inline void check_golden(const std::string& name, const std::string& trace) {
  const std::string path = in_source("tests/golden/") + name + ".txt";
  if (std::getenv("STILLPOINT_WRITE_GOLDEN") != nullptr) {
    std::ofstream(path) << trace;
    GTEST_SKIP() << "LOUD: SKIPPED, wrote " << path;
  }
  std::ifstream file(path);
  ASSERT_TRUE(file) << path << " is absent";
  std::istringstream now(trace);
  constexpr double kRounding = 2e-6;  // one unit of the last digit, and the rounding of another compiler
  std::string stored_line, now_line;
  int number = 0;
  while (std::getline(file, stored_line)) {
    ++number;
    ASSERT_TRUE(std::getline(now, now_line)) << path << ":" << number << ": the replay is shorter";
    std::istringstream a(stored_line), b(now_line);
    double x = 0.0, y = 0.0;
    while (a >> x) {
      ASSERT_TRUE(b >> y);
      ASSERT_NEAR(x, y, kRounding) << path << ":" << number << "\nstored " << stored_line << "\nnow    " << now_line;
    }
    ASSERT_TRUE(a.eof() && !(b >> y) && b.eof())
        << path << ":" << number << ": what is no number, or more of them\nstored " << stored_line << "\nnow    "
        << now_line;
  }
  EXPECT_FALSE(std::getline(now, now_line)) << path << ": the replay is longer";
  EXPECT_GT(number, 10);
}

}  // namespace stillpoint::test
