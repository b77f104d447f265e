/// Traces in tests/golden that a replay has to meet to the last digit but rounding.
#pragma once
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/source_folder.h"

namespace stillpoint::test {

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
  }
  EXPECT_FALSE(std::getline(now, now_line)) << path << ": the replay is longer";
  EXPECT_GT(number, 10);
}

}  // namespace stillpoint::test
