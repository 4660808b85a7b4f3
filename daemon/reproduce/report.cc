// SPDX-License-Identifier: Apache-2.0
#include "daemon/reproduce/report.h"

#include <cmath>
#include <cstdint>
#include <fstream>

#include "core/base/error.h"
#include "core/base/printed.h"

namespace geond::reproduce {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kStyle = R"(
body{font:16px/1.5 system-ui,sans-serif;color:#222;max-width:62em;margin:2em auto;padding:0 1em}
h1{line-height:1.2}h2{margin-top:2.4em;border-top:1px solid #ccc;padding-top:1em;line-height:1.25}
table{border-collapse:collapse;margin:1em 0;font-size:14px;font-variant-numeric:tabular-nums}
caption{text-align:left;font-weight:600;padding:.2em 0}th,td{padding:.22em .7em;border-bottom:1px solid #ddd;text-align:right}
th:first-child,td:first-child{text-align:left}thead th{border-bottom:2px solid #888}
figure{display:inline-block;max-width:100%;margin:.6em 1em .6em 0;vertical-align:top}figcaption{font-size:14px;color:#444;max-width:44em}
img,svg{max-width:100%;height:auto}.judgement{border-left:4px solid #0072b2;padding:.3em .9em;background:#f2f7fb}
.met{color:#00694c}.missed{color:#b03a00;font-weight:600}.small{font-size:14px;color:#555}
)";

std::string Base64(const std::vector<std::uint8_t>& bytes) {
  constexpr const char* kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const std::uint32_t word = bytes[i] << 16 | (left > 1 ? bytes[i + 1] << 8 : 0) | (left > 2 ? bytes[i + 2] : 0);
    text += kLetters[word >> 18];
    text += kLetters[word >> 12 & 63];
    text += left > 1 ? kLetters[word >> 6 & 63] : '=';
    text += left > 2 ? kLetters[word & 63] : '=';
  }
  return text;
}

const char* Name(Figure::Better better) {
  switch (better) {
    case Figure::Better::kLess: return "less";
    case Figure::Better::kMore: return "more";
    case Figure::Better::kSame: return "same";
    case Figure::Better::kFree: return "free";
  }
  return "";
}

Json Number(const std::optional<double>& value) { return value && std::isfinite(*value) ? Json(*value) : Json(nullptr); }

std::string Cell(const std::optional<double>& value) { return value ? Escaped(Printed("%.4g", *value)) : "&ndash;"; }

std::string FiguresHtml(const Experiment& experiment) {
  std::string html =
      "<table><thead><tr><th>figure</th><th>thesis</th><th>its algorithm, repaired</th><th>today</th><th>bar</th></tr>"
      "</thead><tbody>\n";
  for (const Figure& figure : experiment.figures) {
    std::string bar = "&ndash;";
    if (figure.has_bar()) {
      bar = Printed("<span class=\"%s\">%s %.4g: %s</span>", figure.bar_met() ? "met" : "missed",
                 figure.better == Figure::Better::kMore ? "&ge;" : "&le;", *figure.bar, figure.bar_met() ? "met" : "missed");
    }
    html += "<tr><td>" + Escaped(figure.text) + (figure.unit.empty() ? "" : ", " + Escaped(figure.unit)) + "</td><td>" +
            Cell(figure.thesis) + "</td><td>" + Cell(figure.repaired) + "</td><td>" + Cell(figure.today) + "</td><td>" + bar +
            "</td></tr>\n";
  }
  return html + "</tbody></table>\n";
}

std::string TableHtml(const Table& table) {
  std::string html = "<table><caption>" + Escaped(table.caption) + "</caption><thead><tr>";
  for (const std::string& head : table.heads) html += "<th>" + Escaped(head) + "</th>";
  html += "</tr></thead><tbody>\n";
  for (const std::vector<std::string>& row : table.rows) {
    html += "<tr>";
    for (const std::string& cell : row) {
      const bool bold = !cell.empty() && cell[0] == '*';
      html += "<td>" + (bold ? "<b>" + Escaped(cell.substr(1)) + "</b>" : Escaped(cell)) + "</td>";
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table>\n";
}

std::string ExperimentHtml(const Experiment& e) {
  std::string html = "<h2 id=\"" + Escaped(e.name) + "\">" + Escaped(e.title) + "</h2>\n<p>" + Escaped(e.what) + "</p>\n";
  html += FiguresHtml(e);
  for (const Table& table : e.tables) html += TableHtml(table);
  for (const Plot& plot : e.plots) html += "<figure>" + ToSvg(plot) + "</figure>\n";
  for (const Outline& outline : e.outlines) html += "<figure>" + ToSvg(outline) + "</figure>\n";
  for (const Picture& picture : e.pictures) {
    html += Printed("<figure style=\"width:%dpx\"><img width=\"%d\" height=\"%d\" alt=\"", picture.image.columns, picture.image.columns, picture.image.rows) +
            Escaped(picture.caption) + "\" src=\"data:image/png;base64," + Base64(EncodePng(picture.image)) +
            "\"><figcaption>" + Escaped(picture.caption) + "</figcaption></figure>\n";
  }
  return html + "<p class=\"judgement\">" + Escaped(e.judgement) + "</p>\n" +
         Printed("<p class=\"small\">%.1f s, <code>geon reproduce %s</code></p>\n", e.seconds, e.name.c_str());
}

struct Bars {
  int all = 0, met = 0;
};
Bars CountBars(const std::vector<Experiment>& experiments) {
  Bars bars;
  for (const Experiment& experiment : experiments) {
    for (const Figure& figure : experiment.figures) {
      bars.all += figure.has_bar();
      bars.met += figure.has_bar() && figure.bar_met();
    }
  }
  return bars;
}

void WriteText(const std::string& text, const std::filesystem::path& path) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (!file) {
    throw FileError(path.string(), "write the report", "the file cannot be written", "Check folder, permissions and free space");
  }
}

}  // namespace

Json ReportJson(const std::vector<Experiment>& experiments, bool quick) {
  const Bars bars = CountBars(experiments);
  Json json = {{"version", GEOND_VERSION}, {"quick", quick}, {"bars", bars.all}, {"bars_met", bars.met},
               {"experiments", Json::array()}};
  for (const Experiment& e : experiments) {
    Json one = {{"name", e.name}, {"title", e.title}, {"what", e.what}, {"judgement", e.judgement}, {"seconds", e.seconds},
                {"figures", Json::array()}, {"tables", Json::array()}};
    for (const Figure& f : e.figures) {
      one["figures"].push_back({{"key", f.key}, {"text", f.text}, {"unit", f.unit}, {"thesis", Number(f.thesis)},
                                {"repaired", Number(f.repaired)}, {"today", Number(f.today)}, {"better", Name(f.better)},
                                {"tolerance", f.tolerance}, {"slack", f.slack}, {"bar", Number(f.bar)},
                                {"bar_met", f.has_bar() ? Json(f.bar_met()) : Json(nullptr)}});
    }
    for (const Table& table : e.tables) {
      one["tables"].push_back({{"caption", table.caption}, {"heads", table.heads}, {"rows", table.rows}});
    }
    json["experiments"].push_back(std::move(one));
  }
  return json;
}

std::string ReportHtml(const std::vector<Experiment>& experiments, bool quick) {
  const Bars bars = CountBars(experiments);
  std::string html = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>The thesis reproduced</title><style>";
  html += kStyle;
  html += "</style></head><body>\n<h1>The thesis reproduced</h1>\n"
          "<p>The experiments of Kenong Wu, <i>Computing Parametric Geon Descriptions of 3D Multi-Part Objects</i> (McGill "
          "University, 1996), run again by geond " GEOND_VERSION ". Beside each printed figure stand that of the thesis' own "
          "algorithm with its errors corrected, and that of today's default. The thesis' scans are not public: all objects here "
          "were built by us, from geons or by the rules said with each, and scanned by a simulated station; so absolute "
          "residuals cannot be compared with the printed ones, ratios and decisions can. Every number is made anew from fixed "
          "seeds.</p>\n";
  if (quick) html += "<p><b>A quick run: fewer objects and seeds than the full one.</b></p>\n";
  html += Printed("<p>Bars met: %d of %d.</p>\n<table><thead><tr><th>experiment</th><th>bars</th><th>seconds</th></tr></thead><tbody>\n",
               bars.met, bars.all);
  for (const Experiment& e : experiments) {
    const Bars own = CountBars({e});
    html += "<tr><td><a href=\"#" + Escaped(e.name) + "\">" + Escaped(e.title) + "</a></td><td>" +
            (own.all == 0 ? "&ndash;" : Printed("<span class=\"%s\">%d of %d</span>", own.met == own.all ? "met" : "missed", own.met, own.all)) +
            Printed("</td><td>%.1f</td></tr>\n", e.seconds);
  }
  html += "</tbody></table>\n";
  for (const Experiment& e : experiments) html += ExperimentHtml(e);
  return html + "</body></html>\n";
}

void WriteReport(const std::vector<Experiment>& experiments, bool quick, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw FileError(folder.string(), "make the folder", error.message());
  WriteText(ReportHtml(experiments, quick), folder / "report.html");
  WriteText(ReportJson(experiments, quick).dump(1) + "\n", folder / "figures.json");
}

}  // namespace geond::reproduce
