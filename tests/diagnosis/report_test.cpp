/// The report must stand alone, say what the diagnosis says, and survive whatever text it is given.
#include "diagnosis/report/report.h"

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

namespace stillpoint::diag {
namespace {

using testing::HasSubstr;
using testing::Not;

Diagnosis example() {
  Diagnosis d;
  d.verdict = Verdict::kExplained;
  d.summary = "Missing physics: the offset follows <temperature> & more";
  Finding f;
  f.effect = "gyr_temp_lin";
  f.channels = {"gyr_x"};
  f.parameters = {{"k_x", 5e-4, {4e-4, 6e-4}, "rad/s/K"}};
  f.figures.t_s = {0, 1, 2};
  f.figures.residual_before = {1, 2, 3};
  f.figures.residual_after = {0, 0, 0};
  f.figures.held_out = {false, true, true};
  f.figures.driver_label = "</script><script>alert(1)</script>";
  d.findings.push_back(f);
  d.ranking = {{"gyr_temp_lin", 412.5}, {"gyr_drift", 3.0}};
  d.abstention_nats = 7;
  d.heat_channels = {"gyr_x"};
  d.heat_t_s = {0, 2};
  d.heat_nats = {{0.0, 20.0}};
  return d;
}

TEST(Report, StandsAlone) {
  const auto html =
      report_html(example(), {.recording = "a.csv", .simulation = "a.yaml", .validation = "", .blocks_to_paste = ""});
  EXPECT_THAT(html, Not(HasSubstr("src=")));
  for (const char* outside : {"<link", "@import", "url(", "fetch(", "XMLHttpRequest"})
    EXPECT_EQ(html.find(outside), std::string::npos) << outside;
  EXPECT_THAT(html, HasSubstr("uPlot"));
}

TEST(Report, SaysVerdictParametersRankingAndAbstention) {
  const auto html = report_html(
      example(), {.recording = "a.csv", .simulation = "a.yaml", .validation = "", .blocks_to_paste = "effects: []"});
  EXPECT_LT(html.find("Mismatch found and explained"), html.find("Parameters"));
  for (const char* text : {"gyr_temp_lin", "0.0004 … 0.0006", "412.5", "no name below 7.0 nats", "effects: []",
                           "&lt;temperature&gt; &amp; more"})
    EXPECT_THAT(html, HasSubstr(text));
}

TEST(Report, GivesNoHeldOutFiguresOfWhatWasNotFitted) {
  Diagnosis d = example();
  d.findings[0].held_out.gain_nats = 87.6;  // of the readings themselves
  EXPECT_THAT(report_html(d, {}), HasSubstr("Shows without a fit"));
  EXPECT_THAT(report_html(d, {}), Not(HasSubstr("On data not used")));
  d.findings[0].held_out.blocks = 30;
  EXPECT_THAT(report_html(d, {}), HasSubstr("On data not used"));
}

/// A sensor is searched in several rounds; in the ranking a law stands once, with its best gain.
TEST(Report, RanksEachLawOnce) {
  Diagnosis d = example();
  d.ranking = {{"mag_gradient", 30.0}, {"mag_gradient", 12.0}, {"mag_cubic", 8.0}};
  const auto html = report_html(d, {});
  EXPECT_EQ(html.find(">mag_gradient<"), html.rfind(">mag_gradient<"));
  EXPECT_THAT(html, HasSubstr(">30.0<"));
  EXPECT_THAT(html, HasSubstr(">mag_cubic<"));
}

/// Without what else was weighed, a formula is a claim; without the panels nobody sees what is still missing.
TEST(Report, ShowsWhatADiscoveredLawWasWeighedAgainst) {
  Diagnosis d = example();
  Finding& f = d.findings[0];
  f.effect = "unknown:norm(w) * (T - 25)";
  f.weighed = {{"norm(w) * (T - 25)", 31, 512, 480},
               {"norm(w)", 12, 95, 80},
               {"norm(w) * (T - 25) * f_x", 44, 515, 470},
               {"m * f", 20, 530, 500}};
  f.figures.against_each = {{"T, degC", {20, 30}, {1, 2}, {0, 0}}};
  const auto html = report_html(d, {.recording = "",
                                    .simulation = "",
                                    .validation = "",
                                    .blocks_to_paste = "",
                                    .code = {{"law_1.py", "def law_1(t, w, T): return a < b"}}});
  for (const char* text : {"shorter; explains 417 nats less", "longer; explains 3 nats more, which do not pay for it",
                           "shorter; explains 18 nats more, by more numbers, or by such as are open or fail elsewhere",
                           "<b>stated</b>", "heating of the drive loop", "id=\"each-0-0\"", "id=\"weighed-0\"",
                           "\"id\":\"weighed-0\"", "T, degC", "law_1.py", "return a &lt; b"})
    EXPECT_THAT(html, HasSubstr(text));
  EXPECT_THAT(report_html(example(), {}), Not(HasSubstr("weighed against")));
}

TEST(Report, CannotBeBrokenByTextFromTheRecording) {
  const auto html = report_html(
      example(), {.recording = "<img onerror=x>.csv", .simulation = "b", .validation = "", .blocks_to_paste = ""});
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  EXPECT_THAT(html, Not(HasSubstr("</script><script>alert")));
  EXPECT_THAT(html, HasSubstr("\"id\":\"driver-0\""));
}

}  // namespace
}  // namespace stillpoint::diag
