// SPDX-License-Identifier: Apache-2.0
#include "core/picture/stroke_font.h"

#include <array>
#include <cstdint>

namespace geond {
namespace {

constexpr double kGap = 1.6;  // between letters

// Strokes parted by blanks, each a list of points of two digits, x and y; a stroke after ~ is made round (its ends stay, or,
// if they are the same point, the ring is round there too).
struct Glyph {
  int width;
  const char* strokes;
};

// From blank (32) to tilde (126).
constexpr std::array<Glyph, 95> kGlyphs = {{
    {2, ""}, {0, "0004 0606"}, {2, "0002 2022"}, {4, "1016 3036 0242 0444"}, {4, "~413010011223344546361605 2007"},
    {4, "4006 ~1000011110 ~3525364535"}, {4, "~461201102031120426163543"}, {0, "0002"}, {2, "~2011020304051626"},
    {2, "~0011222324251606"}, {2, "0323 1214 0224 2204"}, {4, "2125 0343"}, {1, "1607"}, {3, "0333"}, {0, "0606"},
    {3, "3006"}, {4, "~200003062646434020"}, {2, "022026"}, {4, "~0100204042240646 0646"},
    {4, "~01002040423313 ~13334546260605"}, {4, "300444 3136"}, {4, "400002 ~0222424446260605"},
    {4, "~4140200002040626464443230304"}, {4, "004016"}, {4, "~200001123345462606051331414020"},
    {4, "~42230302002040424446260605"}, {0, "0202 0606"}, {1, "1212 1607"}, {3, "310335"}, {4, "0242 0444"},
    {3, "013305"}, {4, "~01002040422324 2626"}, {5, "~3432221214253534 ~343555535130100104162646"}, {4, "062046 0444"},
    {4, "0600 ~00304042433303 ~03334345463606"}, {4, "~41402000020406264645"}, {4, "0006 ~0030404244463606"},
    {4, "40000646 0333"}, {4, "400006 0333"}, {4, "~41402000020406264644 4424"}, {4, "0006 4046 0343"}, {0, "0006"},
    {3, "~303536160605"}, {4, "0006 4004 1346"}, {4, "000646"}, {5, "0600255056"}, {4, "06004640"},
    {5, "~300002063656545030"}, {4, "0600 ~004042433303"}, {5, "~300002063656545030 3456"},
    {4, "0600 ~004042433303 2346"}, {4, "~414020000213334446260605"}, {4, "0040 2026"}, {4, "~00040626464440"},
    {4, "002640"}, {6, "0016305660"}, {4, "0046 4006"}, {4, "002340 2326"}, {4, "00400646"}, {2, "20000828"},
    {3, "0036"}, {2, "00202808"}, {4, "022042"}, {4, "0747"}, {1, "0012"}, {4, "4246 ~434222020406264645"},
    {4, "0006 ~030222424446260605"}, {3, "~333212020406163635"}, {4, "4046 ~434222020406264645"},
    {4, "0444 ~44434222020406264645"}, {2, "~201011 1116 0222"}, {4, "4246 ~464748280807 ~434222020406264645"},
    {4, "0006 ~040322424346"}, {0, "0206 0000"}, {1, "~1217181808 1010"}, {3, "0006 3205 1336"}, {1, "~00050616"},
    {6, "0206 ~040222323336 ~343252626366"}, {4, "0206 ~040322424346"}, {4, "~220204062646444222"},
    {4, "0208 ~030222424446260605"}, {4, "4248 ~434222020406264645"}, {3, "0206 ~04032232"},
    {3, "~33321202033436160605"}, {2, "~10151626 0222"}, {4, "~020506264645 4246"}, {4, "022642"}, {6, "0216325662"},
    {3, "0236 3206"}, {4, "0226 4208"}, {3, "02320636"}, {2, "~20101304 ~04151828"}, {0, "0008"},
    {2, "~00101324 ~24151808"}, {4, "~0312233342"},
}};
constexpr Glyph kDegreeSign = {2, "~100001122110"};
constexpr Glyph kTimesSign = {4, "0246 4206"};
constexpr Glyph kBox = {4, "0040460600"};

// Twice cutting the corners at a quarter and three quarters of each side (Chaikin's way to a smooth curve).
Stroke Rounded(Stroke stroke) {
  const bool ring = stroke.size() > 3 && stroke.front() == stroke.back();
  for (int round = 0; round < 3; ++round) {
    Stroke next;
    if (!ring) next.push_back(stroke.front());
    for (std::size_t i = 0; i + 1 < stroke.size(); ++i) {
      next.push_back(0.75 * stroke[i] + 0.25 * stroke[i + 1]);
      next.push_back(0.25 * stroke[i] + 0.75 * stroke[i + 1]);
    }
    next.push_back(ring ? next.front() : stroke.back());
    stroke = std::move(next);
  }
  return stroke;
}

void AddGlyph(const Glyph& glyph, double at, std::vector<Stroke>& strokes) {
  std::string_view text = glyph.strokes;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    std::string_view word = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const bool round = !word.empty() && word[0] == '~';
    if (round) word.remove_prefix(1);
    Stroke stroke;
    for (std::size_t i = 0; i + 1 < word.size(); i += 2) stroke.push_back({at + word[i] - '0', word[i + 1] - '0'});
    if (stroke.size() > 1) strokes.push_back(round && stroke.size() > 2 ? Rounded(std::move(stroke)) : std::move(stroke));
  }
}

// Calls on_glyph for each character of a UTF-8 text.
template <typename OnGlyph>
void ForEachGlyph(std::string_view text, const OnGlyph& on_glyph) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte >= 32 && byte < 127) {
      on_glyph(kGlyphs[byte - 32]);
    } else if (byte >= 0xc0) {
      const std::string_view sign = text.substr(i, 2);
      on_glyph(sign == "\xc2\xb0" ? kDegreeSign : sign == "\xc3\x97" ? kTimesSign : kBox);
      while (i + 1 < text.size() && (static_cast<unsigned char>(text[i + 1]) & 0xc0) == 0x80) ++i;
    } else {
      on_glyph(kBox);
    }
  }
}

}  // namespace

std::vector<Stroke> TextStrokes(std::string_view text) {
  std::vector<Stroke> strokes;
  double at = 0.0;
  ForEachGlyph(text, [&](const Glyph& glyph) {
    AddGlyph(glyph, at, strokes);
    at += glyph.width + kGap;
  });
  return strokes;
}

double TextWidth(std::string_view text) {
  double width = 0.0;
  ForEachGlyph(text, [&](const Glyph& glyph) { width += glyph.width + kGap; });
  return width > 0.0 ? width - kGap : 0.0;
}

}  // namespace geond
