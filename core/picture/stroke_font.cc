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
    {2, ""}, {0, "0004 0606"}, {2, "0002 2022"}, {4, "1016 3036 0242 0444"}, {4, "~4130001023444546160605 2026"},
    {4, "4006 ~0010111202010000 ~3444454636353434"}, {4, "~46120201103122050616263643"}, {0, "0002"}, {2, "~2010020406171828"},
    {2, "~0010222426170808"}, {4, "2125 0244 0442"}, {4, "2125 0343"}, {1, "~16161718 "}, {3, "0333"}, {0, "0606"}, {3, "3006"},
    {4, "~200002040626464442404020 "}, {2, "022026"}, {4, "~010020404224 240646"}, {4, "~0000204041232344464626060605"},
    {4, "30044 40444 3036"}, {4, "400002 ~022242454646260605"}, {4, "~404020000305062646444323030304"}, {4, "004016"},
    {4, "~20000102234545462606060523414000 "}, {4, "~064616264643414020000002234241"}, {0, "0202 0606"}, {1, "1212 ~16161718"},
    {3, "310335"}, {4, "0242 0444"}, {3, "013305"}, {4, "~0100204042332324 2626"}, {5, "~3523130405263534 ~345456521030000206063656"},
    {4, "062046 0444"}, {4, "~0030414133330303 ~0333444556060606 0006"}, {4, "~4140200002040626464645"}, {4, "00062 ~0020404244462606 0006"},
    {4, "40000646 0333"}, {4, "400006 0333"}, {4, "~41402000020406264646444424"}, {4, "0006 4046 0343"}, {0, "0006"},
    {3, "~303536160605"}, {4, "0006 4004 1346"}, {4, "000646"}, {5, "0600245056"}, {4, "06004640"}, {5, "~301001050616365651503000 "},
    {4, "0600 ~0030404333330303"}, {5, "~3010010506163646555150300 3557"}, {4, "0600 ~0030404333330303 2346"},
    {4, "~4140200001023344454626060605"}, {4, "0040 2026"}, {4, "~00040626464440"}, {4, "002640"}, {6, "0016305660"}, {4, "0046 4006"},
    {4, "002340 2326"}, {4, "00400646"}, {2, "20000828"}, {3, "0036"}, {2, "00202808"}, {4, "022042"}, {4, "0747"}, {1, "0012"},
    {3, "~03021232343536 36 ~34140405062636 "}, {4, "0006 ~02224244462606"}, {3, "~3322020406263635"}, {4, "4046 ~42220204062646"},
    {4, "0444 ~4443222202040626464645"}, {2, "~201110 1116 0222"}, {4, "4246 ~422202040626464 ~42474838180807"},
    {4, "0006 ~0322424346"}, {0, "0206 0000"}, {1, "~12171808 1010"}, {3, "0006 3205 1336"}, {1, "~000516"}, {6, "0206 ~032232333336 ~335262636366"},
    {4, "0206 ~0322424346"}, {4, "~22020204060626464644424222 "}, {4, "0208 ~02224244462606"}, {4, "4248 ~42220204062646"}, {3, "0206 ~04032232"},
    {3, "~333212020314343536162605"}, {2, "~10151626 0222"}, {4, "~0205062646454 4246"}, {4, "022642"}, {6, "0216325662"}, {3, "0236 3206"},
    {4, "0226 ~42260808"}, {3, "02320636"}, {2, "~20100213130304041516280"}, {0, "0008"}, {2, "~0010021323130415060818"}, {4, "~0312233342"},
}};
constexpr Glyph kDegreeSign = {2, "~1000010212222120100 "};
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
