/// Readers meet damaged files: whatever the damage, they answer with data or a located error. The sanitizer builds run
/// this too, which is what finds a read past the end.
#include <gtest/gtest.h>

#include <random>

#include "io/recording.h"
#include "io/yaml.h"

namespace stillpoint::io {
namespace {

constexpr int kMutants = 4000;

/// Some bytes flipped, a stretch removed, a stretch repeated, or the tail cut off.
std::string damaged(std::string text, std::mt19937& random) {
  static constexpr std::string_view kBytes = "0123456789.,-+eE#:\n\r\t []{}'\"&*!|>%@\0\xFF";
  const auto below = [&random](std::size_t n) { return n == 0 ? 0 : random() % n; };
  for (std::size_t edits = 1 + below(4); edits > 0 && !text.empty(); --edits) {
    const std::size_t at = below(text.size());
    const std::size_t length = 1 + below(std::min<std::size_t>(20, text.size() - at));
    switch (below(4)) {
      case 0:
        text[at] = kBytes[below(kBytes.size())];
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, text.substr(at, length));
        break;
      default:
        text.resize(at);
    }
  }
  return text;
}

TEST(Mutation, TheRecordingReaderAlwaysAnswers) {
  const std::string good =
      "# sensor: a\ntime_s,acc_x_mps2,acc_y_mps2,acc_z_mps2,temp_degC\n"
      "0.00,0.1,0.2,9.8,25\n0.01,0.1,,9.8,25\n0.02,0.1,0.2,9.8,nan\n0.03,0.1,0.2,9.8,25\n";
  std::mt19937 random(1);
  int read = 0, refused = 0;
  for (int i = 0; i < kMutants; ++i) {
    const auto r = parse_recording(damaged(good, random), "m.csv");
    if (!r) {
      ++refused;
      EXPECT_EQ(r.error().message.rfind("m.csv:", 0), 0U) << r.error().message;
      continue;
    }
    ++read;
    for (std::size_t row = 1; row < r->size(); ++row) ASSERT_GT(r->t_ns[row], r->t_ns[row - 1]);
    if (!r->acc_mps2.empty()) {
      ASSERT_EQ(r->acc_mps2.size(), r->size());
    }
  }
  EXPECT_GT(read, kMutants / 20) << "the damage is so great that nothing is tested";
  EXPECT_GT(refused, kMutants / 20);
}

TEST(Mutation, TheYamlReaderAlwaysAnswers) {
  const std::string good = "rate_hz: 50\nfield: [1.0, 2.0, -3]\ngroup: {a: 1, b: [[1,2],[3,4]]}\nname: 'x'\n";
  std::mt19937 random(2);
  for (int i = 0; i < kMutants; ++i) {
    const auto node = parse_yaml(damaged(good, random), "m.yaml");
    if (node) {
      YamlFaults faults("m.yaml");
      refuse_unknown_keys(*node, {"rate_hz", "field"}, faults);
    } else {
      EXPECT_EQ(node.error().message.rfind("m.yaml:", 0), 0U) << node.error().message;
    }
  }
}

}  // namespace
}  // namespace stillpoint::io
