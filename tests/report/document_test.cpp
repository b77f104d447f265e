/// A page must stand alone, and no text of a recording may leave the place where it is put.
#include "report/document.h"

#include <gmock/gmock.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace stillpoint::report {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string kNasty = "</script><script>alert(1)</script>";

Plot example() {
  return {"here",
          kNasty,
          "y",
          {3.0, 1.0, 2.0},
          {{kNasty, Colour::kBefore, {30.0, 10.0, std::numeric_limits<double>::quiet_NaN()}, Mark::kDots}}};
}

/// What the page hands to its script.
nlohmann::json plots_of(const std::string& html) {
  const std::string begin = "id=\"plots\">";
  const auto at = html.find(begin) + begin.size();
  return nlohmann::json::parse(html.substr(at, html.find("</script>", at) - at));
}

TEST(Document, StandsAlone) {
  const std::string html = document_html("title", "<p>body</p>", {example()});
  for (const char* outside : {"src=", "<link", "@import", "url(", "fetch(", "XMLHttpRequest"})
    EXPECT_THAT(html, Not(HasSubstr(outside)));
  EXPECT_THAT(html, HasSubstr("<p>body</p>"));
}

TEST(Document, TextFromOutsideStaysText) {
  const std::string html = document_html(kNasty, "<p>" + escaped(kNasty) + "</p>", {example()});
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  EXPECT_EQ(plots_of(html).at(0).at("x_label"), kNasty);
}

TEST(Document, APlotKeepsItsNumbersAndHasHolesWhereThereAreNone) {
  const auto plot = plots_of(document_html("t", "", {example()})).at(0);
  EXPECT_EQ(plot.at("x"), nlohmann::json({3.0, 1.0, 2.0}));
  EXPECT_EQ(plot.at("curves").at(0).at("y"), nlohmann::json({30.0, 10.0, nullptr}));
  EXPECT_EQ(plot.at("curves").at(0).at("mark"), "dots");
}

TEST(Document, DigitsThatNobodySeesAreLeftOut) {
  Plot plot = example();
  plot.x = {1.0 / 3.0, 0.0, -123456789.0};
  EXPECT_EQ(plots_of(document_html("t", "", {plot})).at(0).at("x"), nlohmann::json({0.333333, 0.0, -123457000.0}));
}

TEST(Document, InOrderOfXEachPointKeepsItsY) {
  const Plot plot = in_order_of_x(example());
  EXPECT_EQ(plot.x, (std::vector<double>{1.0, 2.0, 3.0}));
  EXPECT_EQ(plot.curves[0].y[0], 10.0);
  EXPECT_TRUE(std::isnan(plot.curves[0].y[1]));
  EXPECT_EQ(plot.curves[0].y[2], 30.0);
}

}  // namespace
}  // namespace stillpoint::report
