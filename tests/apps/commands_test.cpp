/// What every command does at its edges: outputs that cannot be written, standard output, files that are not there.
#include <gmock/gmock.h>

#include "tests/apps/apps_testing.h"

namespace stillpoint::test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class Commands : public ::testing::Test {
 protected:
  /// Exit code of the command line in this folder; what it said stands in told_ afterwards.
  int tool(const std::string& arguments, const std::string& program = STILLPOINT) {
    const int code = run("cd " + (folder_ / ".") + " && " + program + " " + arguments, folder_ / "err");
    told_ = read_file(folder_ / "err");
    return code;
  }
  void write_simulation() {
    write_file(folder_ / "sim.yaml",
               "accelerometer: {noise_mps2: 0.02}\ngyroscope: {noise_radps: 0.001}\n"
               "motion: {kind: hand, duration_s: 5}\n");
  }
  ScratchFolder folder_;
  std::string told_;
};

TEST_F(Commands, AnOutputThatCannotBeWrittenIsNamedWithItsReason) {
  write_simulation();
  ASSERT_EQ(tool("simulate --simulation sim.yaml --output rec.csv"), 0) << told_;
  write_file(folder_ / "config.yaml", "sensor: {id: a}\n");
  for (const std::string command :
       {"simulate --simulation sim.yaml --output ", "estimate --config config.yaml --recording rec.csv --output ",
        "record --output "}) {
    const auto to = [&](const std::string& path) { return tool(command + path + ""); };
    EXPECT_EQ(to("/dev/full"), 73) << command;
    EXPECT_THAT(told_, StartsWith("stillpoint: /dev/full: cannot be written: No space left on device; ")) << command;
    EXPECT_EQ(to("no/folder.csv"), 73) << command;
    EXPECT_THAT(told_, HasSubstr("no/folder.csv: cannot be written: No such file or directory; ")) << command;
    EXPECT_EQ(to("."), 73) << command;
    EXPECT_THAT(told_, HasSubstr(".: cannot be written: Is a directory; ")) << command;
  }
}

TEST_F(Commands, AMinusIsStandardOutputForEveryFileWritten) {
  write_simulation();
  ASSERT_EQ(tool("simulate --simulation sim.yaml --output rec.csv"), 0) << told_;
  ASSERT_EQ(tool("simulate --simulation sim.yaml --output - > piped.csv"), 0) << told_;
  EXPECT_EQ(read_file(folder_ / "piped.csv"), read_file(folder_ / "rec.csv"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "-"));
}

}  // namespace
}  // namespace stillpoint::test
