/// Rounded figures and texts that lie in tests/golden: a change of behaviour shows as a diff and must be committed. To
/// write them anew: STILLPOINT_WRITE_GOLDEN=1 build/release/tests/test_fusion --gtest_filter='Golden*', and the same
/// with test_calib_online, test_diagnosis, test_io, test_pipeline, test_simulation and test_sources.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
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

inline std::string golden_path(const std::string& name) { return in_source("tests/golden/") + name + ".txt"; }

inline bool write_golden(const std::string& name, const std::string& text) {
  if (std::getenv("STILLPOINT_WRITE_GOLDEN") == nullptr) return false;
  std::ofstream(golden_path(name)) << text;
  return true;
}

/// Words: every letter counts.
inline void check_golden_text(const std::string& name, const std::string& text) {
  if (write_golden(name, text)) GTEST_SKIP() << "LOUD: SKIPPED, wrote " << golden_path(name);
  std::ifstream file(golden_path(name));
  const std::string stored{std::istreambuf_iterator<char>(file), {}};
  EXPECT_GT(stored.size(), 100U) << golden_path(name);
  EXPECT_EQ(stored, text);
}

/// How far two numbers may differ: by one unit of the last digit, and by the rounding of another compiler.
struct GoldenTolerance {
  double absolute = 2e-6, relative = 0.0;
};

/// Words and the numbers among them: every letter counts, a number but to one part in a hundred and one unit of what is
/// small beside it.
inline void check_golden_words(const std::string& name, const std::string& text) {
  if (write_golden(name, text)) GTEST_SKIP() << "LOUD: SKIPPED, wrote " << golden_path(name);
  std::ifstream file(golden_path(name));
  std::istringstream now(text);
  std::string stored_word, word;
  int count = 0;
  while (file >> stored_word) {
    ++count;
    ASSERT_TRUE(now >> word) << golden_path(name) << ": the answer ends before \"" << stored_word << '"';
    if (word == stored_word) continue;
    const auto number = [](const std::string& w, double& x) {
      char* end = nullptr;
      x = std::strtod(w.c_str() + std::min(w.find_first_not_of("([{"), w.size()), &end);
      return std::string(end);
    };
    double stored = 0.0, here = 0.0;
    ASSERT_EQ(number(stored_word, stored), number(word, here)) << golden_path(name) << ": word " << count;
    ASSERT_NEAR(stored, here, 0.01 * std::abs(stored) + 1e-7) << golden_path(name) << ": word " << count;
  }
  EXPECT_FALSE(now >> word) << golden_path(name) << ": the answer goes on with \"" << word << '"';
  EXPECT_GT(count, 30) << golden_path(name);
}

inline void check_golden(const std::string& name, const std::string& trace, const GoldenTolerance& tolerance = {}) {
  const std::string path = golden_path(name);
  if (write_golden(name, trace)) GTEST_SKIP() << "LOUD: SKIPPED, wrote " << path;
  std::ifstream file(path);
  ASSERT_TRUE(file) << path << " is absent";
  std::istringstream now(trace);
  std::string stored_line, now_line;
  int number = 0;
  while (std::getline(file, stored_line)) {
    ++number;
    ASSERT_TRUE(std::getline(now, now_line)) << path << ":" << number << ": the replay is shorter";
    std::istringstream a(stored_line), b(now_line);
    double x = 0.0, y = 0.0;
    while (a >> x) {
      ASSERT_TRUE(b >> y);
      ASSERT_NEAR(x, y, tolerance.absolute + tolerance.relative * std::abs(x))
          << path << ":" << number << "\nstored " << stored_line << "\nnow    " << now_line;
    }
    ASSERT_TRUE(a.eof() && !(b >> y) && b.eof())
        << path << ":" << number << ": what is no number, or more of them\nstored " << stored_line << "\nnow    "
        << now_line;
  }
  EXPECT_FALSE(std::getline(now, now_line)) << path << ": the replay is longer";
  EXPECT_GT(number, 10);
}

}  // namespace stillpoint::test
