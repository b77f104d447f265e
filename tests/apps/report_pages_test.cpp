/// The pages of `calibrate`, `estimate` and `noise`: what they say, and that a browser draws every plot of theirs.
#include <gmock/gmock.h>

#include "tests/apps/tool_in_folder.h"

namespace stillpoint::test {
namespace {

using ::testing::HasSubstr;

class ReportPages : public ToolInFolder {
 protected:
  void SetUp() override {
    write_file(folder_ / "sim.yaml",
               "accelerometer: {noise_mps2: 0.02, bias: [0.1, -0.05, 0.08]}\n"
               "gyroscope: {noise_radps: 0.001, bias: [0.01, -0.02, 0.005]}\nmagnetometer: {noise_uT: 0.4}\n"
               "motion: {kind: rest_poses, duration_s: 120}\n");
    write_file(folder_ / "config.yaml", "sensor: {id: a}\n");
    ASSERT_EQ(tool("simulate --simulation sim.yaml --output poses.csv"), 0) << told_;
  }
  void draws_all(const std::string& page) {
    const std::string html = read_file(folder_ / page);
    const auto count = [](const std::string& text, const std::string& what) {
      std::size_t n = 0;
      for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
      return n;
    };
    const std::size_t places = count(html, "<div class=\"plot\"");
    EXPECT_GT(places, 1U);
    if (run("command -v chromium > /dev/null", folder_ / "err") != 0) GTEST_SKIP() << "LOUD: SKIPPED, no chromium here";
    ASSERT_EQ(run("chromium --headless --no-sandbox --disable-gpu --virtual-time-budget=3000 --dump-dom file://" +
                      (folder_ / page) + " > " + (folder_ / "dom"),
                  folder_ / "err"),
              0);
    EXPECT_EQ(count(read_file(folder_ / "dom"), "<canvas"), places) << page;
  }
};

TEST_F(ReportPages, ACalibrationShowsWhatIsKnownAndWhatIsMissing) {
  ASSERT_EQ(tool("calibrate --recording poses.csv --report page.html > out"), 0) << told_;
  const std::string html = read_file(folder_ / "page.html");
  for (const char* text :
       {"quantities are known", "gyroscope, temperature", "let it rest while it warms", "Accelerometer: ok",
        "covariance of the bias, (°/s)²", "z down", "id=\"course-gyr\"", "id=\"temperature\"", "assumed"})
    EXPECT_THAT(html, HasSubstr(text));
  draws_all("page.html");
}

TEST_F(ReportPages, OfNoRestAtAllTheCalibrationSaysSo) {
  write_file(folder_ / "walk.yaml", "motion: {kind: walking, duration_s: 10}\naccelerometer: {}\ngyroscope: {}\n");
  ASSERT_EQ(tool("simulate --simulation walk.yaml --output walk.csv"), 0) << told_;
  ASSERT_EQ(tool("calibrate --recording walk.csv --report page.html > out"), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "page.html"), HasSubstr("no window of rest"));
}

TEST_F(ReportPages, AttitudesStandBesideTheReference) {
  ASSERT_EQ(tool("estimate --config config.yaml --recording poses.csv --output att.csv --report page.html > out"), 0)
      << told_;
  const std::string html = read_file(folder_ / "page.html");
  for (const char* text : {"1 of 1 recordings estimated", "poses.csv", "id=\"heading-0\"", "(100.0 %)"})
    EXPECT_THAT(html, HasSubstr(text));
  draws_all("page.html");
}

TEST_F(ReportPages, ARecordingThatFailsHasItsReasonInTheTable) {
  write_file(folder_ / "broken.csv", "no recording\n");
  EXPECT_NE(
      tool("estimate --config config.yaml --recording poses.csv broken.csv --output all --report page.html > out"), 0);
  EXPECT_THAT(read_file(folder_ / "page.html"), HasSubstr("1 of 2 recordings estimated"));
  EXPECT_THAT(read_file(folder_ / "page.html"), HasSubstr("<b>failed</b>"));
}

TEST_F(ReportPages, NoiseIsDrawnForEachSensor) {
  ASSERT_EQ(tool("noise --recording poses.csv --report page.html > out"), 0) << told_;
  EXPECT_THAT(read_file(folder_ / "page.html"), HasSubstr("Kalibr imu.yaml"));
  draws_all("page.html");
}

}  // namespace
}  // namespace stillpoint::test
