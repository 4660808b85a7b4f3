// SPDX-License-Identifier: Apache-2.0
#include "daemon/reproduce/report.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace geond::reproduce {
namespace {

using testing::HasSubstr;
using testing::Not;

// The number of times `what` stands in `text`.
int Count(const std::string& text, const std::string& what) {
  int count = 0;
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += what.size()) ++count;
  return count;
}

Experiment Sample() {
  Experiment e;
  e.name = "sample";
  e.title = "Pins & <owls>";
  e.what = "what";
  e.judgement = "judged";
  e.figures = {{"rms", "rms", "%", {}, 2.0, 1.0, Figure::Better::kLess, 0.1, 0.0, 1.5},
               {"ratio", "ratio", "", 4.9, {}, 3.0, Figure::Better::kMore, 0.1, 0.0, 4.0},
               {"seconds", "seconds", "s", 80.0, {}, std::numeric_limits<double>::quiet_NaN(), Figure::Better::kFree, 0.1, 0.0, {}}};
  e.tables = {{"table", {"", "1"}, {{"row", "*0.5"}}}};
  e.plots = {{"plot", {"x, mm"}, {"y, %"}, {{"line", {1, 2, 3}, {1, std::nan(""), 2}}}}};
  Image image{2, 1, {255, 0, 0, 0, 255, 0}};
  e.pictures = {{"two pixels", image}};
  return e;
}

TEST(ReportJson, HoldsEveryFigureAndWhetherItsBarIsMet) {
  const auto json = ReportJson({Sample()}, true);
  EXPECT_EQ(json["bars"], 2);
  EXPECT_EQ(json["bars_met"], 1);
  const auto& figures = json["experiments"][0]["figures"];
  ASSERT_EQ(figures.size(), 3u);
  EXPECT_EQ(figures[0]["bar_met"], true);
  EXPECT_EQ(figures[1]["bar_met"], false);
  EXPECT_TRUE(figures[0]["thesis"].is_null());
  EXPECT_EQ(figures[1]["thesis"], 4.9);
  EXPECT_TRUE(figures[2]["today"].is_null()) << "what is no number has no place in JSON";
}

TEST(ReportHtml, NeedsNothingOutsideItself) {
  const std::string html = ReportHtml({Sample()}, false);
  EXPECT_THAT(html, HasSubstr("Pins &amp; &lt;owls&gt;"));
  EXPECT_THAT(html, HasSubstr("data:image/png;base64,iVBORw0KGgo"));
  EXPECT_THAT(html, HasSubstr("<b>0.5</b>"));
  EXPECT_EQ(Count(html, "<svg"), Count(html, "</svg>"));
  EXPECT_EQ(Count(html, "<table"), Count(html, "</table>"));
  EXPECT_EQ(Count(html, "src="), Count(html, "src=\"data:"));
  EXPECT_THAT(html, Not(HasSubstr("href=\"http")));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
}

TEST(ToSvg, LabelsItsAxesAndLeavesOutWhatIsNoNumber) {
  Plot plot{"title", {"eta, mm", true}, {"density, 1/mm", true}, {{"measured", {0.1, 0.0, 10.0}, {1.0, 5.0, -1.0}, Series::Kind::kMarks}}};
  const std::string svg = ToSvg(plot);
  EXPECT_THAT(svg, HasSubstr("eta, mm"));
  EXPECT_THAT(svg, HasSubstr("density, 1/mm"));
  EXPECT_THAT(svg, HasSubstr("measured"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
  EXPECT_EQ(Count(svg, "fill-opacity"), 1) << "only one of the places is positive in both";
}

TEST(ToSvg, DrawsWhatIsEmptyOrFlat) {
  EXPECT_THAT(ToSvg(Plot{}), Not(HasSubstr("nan")));
  EXPECT_THAT(ToSvg(Plot{"flat", {"x"}, {"y"}, {{"one", {1, 1}, {2, 2}}}}), Not(HasSubstr("nan")));
  EXPECT_THAT(ToSvg(Outline{}), Not(HasSubstr("nan")));
  EXPECT_THAT(ToSvg(Outline{"square", "v", {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {1, 1, 1, 1}}), Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace geond::reproduce
