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

TEST_F(Commands, AnythingButOneCommandIsWrongUsage) {
  for (const std::string arguments : {"", "--", "simulat", "effects check rec.csv", "effects --nothing"}) {
    EXPECT_EQ(tool(arguments + " > out"), 64) << arguments;
    EXPECT_NE(told_, "") << arguments;
    EXPECT_EQ(read_file(folder_ / "out"), "") << arguments;
  }
  EXPECT_EQ(tool("--help > out"), 0);
  EXPECT_THAT(read_file(folder_ / "out"), HasSubstr("Usage: stillpoint"));
}

TEST_F(Commands, AnOutputThatCannotBeWrittenIsNamedWithItsReason) {
  write_simulation();
  ASSERT_EQ(tool("simulate --simulation sim.yaml --output rec.csv"), 0) << told_;
  write_file(folder_ / "config.yaml", "sensor: {id: a}\n");
  for (const std::string command :
       {"simulate --simulation sim.yaml --output ", "estimate --config config.yaml --recording rec.csv --output "}) {
    const auto to = [&](const std::string& path) { return tool(command + path); };
    EXPECT_EQ(to("/dev/full"), 73) << command;
    EXPECT_THAT(told_, StartsWith("stillpoint: /dev/full: cannot be written: No space left on device; ")) << command;
    EXPECT_EQ(to("no/folder.csv"), 73) << command;
    EXPECT_THAT(told_, HasSubstr("no/folder.csv: cannot be written: No such file or directory; ")) << command;
    EXPECT_EQ(to("."), 73) << command;
    EXPECT_THAT(told_, HasSubstr(".: cannot be written: Is a directory; ")) << command;
  }
}

TEST_F(Commands, ANameInAFileDoesNotSteerTheTerminalThatShowsIt) {
  const std::string topic = "/\x1b[2J";
  const std::string channel = std::string("\1\0\0\0", 4) + std::string("\5\0\0\0", 4) + topic + std::string(8, '\0');
  write_file(folder_ / "bag.mcap",
             "\x89MCAP0\r\n\4" + std::string(1, static_cast<char>(channel.size())) + std::string(7, '\0') + channel);
  EXPECT_EQ(tool("import bag.mcap --output out.csv"), 65);
  EXPECT_THAT(told_, HasSubstr("topics: /?[2J ("));
}

TEST_F(Commands, AMinusIsStandardOutputForEveryFileWritten) {
  write_simulation();
  ASSERT_EQ(tool("simulate --simulation sim.yaml --output rec.csv"), 0) << told_;
  ASSERT_EQ(tool("simulate --simulation sim.yaml --output - > piped.csv"), 0) << told_;
  EXPECT_EQ(read_file(folder_ / "piped.csv"), read_file(folder_ / "rec.csv"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "-"));
}

TEST_F(Commands, StandardOutputTakesOneFileAndNothingElse) {
  write_simulation();
  ASSERT_EQ(tool("simulate --simulation sim.yaml --output rec.csv"), 0) << told_;
  write_file(folder_ / "config.yaml", "sensor: {id: a}\n");
  for (const std::string command :
       {"noise --recording rec.csv --json --kalibr -", "simulate --simulation sim.yaml --output - --truth -",
        "estimate --config config.yaml --recording rec.csv --output - --json -",
        "diagnose --simulation sim.yaml --recording rec.csv --json - --report -"}) {
    EXPECT_EQ(tool(command + " > out"), 64) << command;
    EXPECT_THAT(told_, HasSubstr("only one output can be '-'")) << command;
    EXPECT_EQ(read_file(folder_ / "out"), "") << command;
  }
  ASSERT_EQ(tool("diagnose --simulation sim.yaml --recording rec.csv --json > out"), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "out"), StartsWith("{"));
}

TEST_F(Commands, WhatIsReadOrWrittenIsNotOverwritten) {
  write_simulation();
  ASSERT_EQ(tool("simulate --simulation sim.yaml --output rec.csv"), 0) << told_;
  write_file(folder_ / "config.yaml", "sensor: {id: a}\n");
  std::filesystem::create_symlink("rec.csv", folder_ / "link.csv");
  const std::string before = read_file(folder_ / "rec.csv");
  for (const std::string command :
       {"simulate --simulation sim.yaml --motion rec.csv --output ./rec.csv",
        "estimate --config config.yaml --recording rec.csv --output link.csv",
        "simulate --simulation sim.yaml --output new --truth ./new", "noise --recording rec.csv --json rec.csv"}) {
    EXPECT_EQ(tool(command), 64) << command;
    EXPECT_THAT(told_, HasSubstr("name the same file")) << command;
  }
  EXPECT_EQ(read_file(folder_ / "rec.csv"), before);
}

TEST_F(Commands, AnImprovedSimulationIsJudgedOnAnotherRecording) {
  const std::string sensors =
      "accelerometer: {noise_mps2: 0.02}\ngyroscope: {noise_radps: 0.001}\nmotion: {kind: hand, duration_s: 60}\n";
  write_file(folder_ / "plain.yaml", sensors);
  write_file(folder_ / "real.yaml", sensors + "effects: [{effect: acc_lever, r_m: [0.1, 0.0, 0.05]}]\n");
  for (const std::string seed : {"1", "2"})
    ASSERT_EQ(tool("simulate --simulation real.yaml --seed " + seed + " --output " + seed + ".csv"), 0) << told_;
  const std::string diagnose = "diagnose --simulation plain.yaml --recording 1.csv --improved better.yaml --validate ";
  EXPECT_EQ(tool(diagnose + "nothing.csv > out"), 66);
  EXPECT_EQ(read_file(folder_ / "out"), "");  // before the first search, not after it
  ASSERT_EQ(tool(diagnose + "2.csv > out"), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "out"),
              ::testing::ContainsRegex("VALIDATE 2.csv acc: (1|0.9[0-9]*) of the removable residual is"));
  EXPECT_THAT(read_file(folder_ / "better.yaml"), HasSubstr("acc_lever"));
}

TEST_F(Commands, AnImprovedSimulationIsOneWithoutFault) {
  const std::string sensors =
      "accelerometer: {noise_mps2: 0.02}\ngyroscope: {noise_radps: 0.001}\nmagnetometer: {noise_uT: 0.3}\n"
      "motion: {kind: hand, duration_s: 60}\n";
  write_file(folder_ / "plain.yaml", sensors);
  write_file(folder_ / "real.yaml", sensors + "effects: [{effect: mag_hold, n: 2.8}]\n");  // of a resampled file
  ASSERT_EQ(tool("simulate --simulation real.yaml --output rec.csv"), 0) << told_;
  ASSERT_EQ(tool("diagnose --simulation plain.yaml --recording rec.csv --improved better.yaml > out"), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "better.yaml"), ::testing::ContainsRegex("effect: mag_hold, n: 2\\.(8|79)"));
  EXPECT_EQ(tool("check better.yaml > out"), 0) << told_ << read_file(folder_ / "better.yaml");
  EXPECT_EQ(tool("diagnose --simulation better.yaml --recording rec.csv --fail-on-mismatch > out"), 0)
      << told_ << read_file(folder_ / "out");
}

TEST_F(Commands, AFullStandardOutputIsToldAndAFullStandardErrorEndsNothing) {
  write_simulation();
  ASSERT_EQ(tool("simulate --simulation sim.yaml --output rec.csv"), 0) << told_;
  write_file(folder_ / "config.yaml", "source: {kind: stream, from: stdin}\nsensor: {id: a}\n");
  for (const std::string command : {"--help", "effects", "simulate --help", "calibrate --recording rec.csv",
                                    "check config.yaml", "simulate --simulation sim.yaml --output -"}) {
    EXPECT_EQ(tool(command + " > /dev/full"), 73) << command;
    EXPECT_THAT(told_, HasSubstr("standard output: cannot be written")) << command;
  }
  for (const std::string flag : {"--check-config", "--print-config"})
    EXPECT_EQ(tool("--config config.yaml " + flag + " > /dev/full", STILLPOINTD), 73) << flag;
  const auto with_full_error = [&](const std::string& arguments, const std::string& program) {
    return tool("'" + program + " " + arguments + " 2> /dev/full'", "sh -c");
  };
  EXPECT_EQ(with_full_error("nonsense", STILLPOINT), 64);
  EXPECT_EQ(with_full_error("--config nothing.yaml", STILLPOINTD), 66);
  EXPECT_EQ(with_full_error("estimate --config config.yaml --recording rec.csv --output - > /dev/null", STILLPOINT), 0);
}

TEST_F(Commands, ARecordingThatGetsNoReadingLeavesTheFileOfItsName) {
  write_file(folder_ / "kept.csv", "precious");
  const std::string domain = std::to_string(io::own_domain());
  EXPECT_EQ(tool("record --timeout 0 --domain " + domain + " --output kept.csv"), 69) << told_;
  EXPECT_EQ(read_file(folder_ / "kept.csv"), "precious");
  EXPECT_EQ(tool("record --timeout 0 --domain " + domain + " --output no/folder.csv"), 73) << told_;
}

TEST_F(Commands, ADaemonWithoutASourceNamesTheFileThatLacksIt) {
  EXPECT_EQ(tool("--config " + configs("estimate.yaml"), STILLPOINTD), 78);
  EXPECT_THAT(told_, HasSubstr("estimate.yaml: no 'source:'"));
}

TEST_F(Commands, AProofThatCannotBeginSaysSoAndLeavesNothing) {
  std::filesystem::create_directories(folder_ / "tmp");
  std::filesystem::create_directories(folder_ / "cases/cases");
  std::filesystem::create_directories(folder_ / "cases/truth");
  write_file(folder_ / "cases/cases/001.csv", "");
  const std::string prove = "prove --cases 1 --quick ";
  EXPECT_EQ(tool(prove + "--report no/page.html > out"), 73);
  EXPECT_EQ(tool(prove + "--only invented --report page.html > out"), 64) << "it has no page, and says so";
  EXPECT_EQ(read_file(folder_ / "out"), "");  // before the first case, not after the last
  EXPECT_EQ(tool(prove + "--folder cases > out", "TMPDIR=tmp " STILLPOINT), 66);
  EXPECT_THAT(told_, HasSubstr("cases/truth/001.json: cannot be opened"));
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "tmp"));
}

TEST_F(Commands, AMessageQuotesNothingThatSteersATerminal) {
  const std::string evil = "\x1b[2J" + std::string(5000, 'k');
  write_file(folder_ / "column.csv", "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2," + evil + "\n0,1,2,3,4\n");
  write_file(folder_ / "number.csv", "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2\n0,1,2," + evil + "\n");
  write_file(folder_ / "key.yaml", "\"\\e[2J" + std::string(900, 'k') + "\": 1\n");  // YAML: at most 1024
  write_file(folder_ / "value.yaml", "rate_hz: \"\\e[2J" + std::string(5000, 'k') + "\"\n");
  for (const std::string name : {"column.csv", "number.csv", "key.yaml", "value.yaml"}) {
    tool("check " + name + " > out");
    const std::string said = told_ + read_file(folder_ / "out");
    EXPECT_THAT(said, HasSubstr("'?[2Jkkk")) << name;
    EXPECT_LT(said.size(), 600U) << name;
  }
}

}  // namespace
}  // namespace stillpoint::test
