// SPDX-License-Identifier: Apache-2.0
#include "core/picture/object_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <set>
#include <stdexcept>

#include "core/base/printed.h"
#include "core/picture/draw_scene.h"
#include "core/picture/stroke_font.h"

namespace geond {
namespace {

struct PanelName {
  Panel panel;
  const char* word;
  const char* heading;
};
constexpr std::array<PanelName, 5> kPanels = {{{Panel::kCloud, "cloud", "points"},
                                               {Panel::kMesh, "mesh", "surface"},
                                               {Panel::kCharge, "charge", "charge density"},
                                               {Panel::kParts, "parts", "parts"},
                                               {Panel::kGeons, "geons", "geons"}}};
const Color kInk = Color::Constant(0.16f);

bool HasData(const ObjectPictureData& data, Panel panel) {
  switch (panel) {
    case Panel::kCloud:
      return !data.cloud.empty();
    case Panel::kMesh:
      return !data.mesh.empty();
    case Panel::kCharge:
      return !data.mesh.empty() && !data.charge.empty();
    case Panel::kParts:
      return !data.mesh.empty() && !data.labels.empty();
    case Panel::kGeons:
      return !data.geons.empty();
  }
  return false;
}

std::vector<Panel> PanelsOf(const ObjectPictureData& data, const ObjectPictureOptions& options) {
  if (!options.panels.empty()) return options.panels;
  std::vector<Panel> panels;
  for (const PanelName& name : kPanels) {
    // A mesh by charge or part says what a plain one does.
    if (name.panel == Panel::kMesh && (HasData(data, Panel::kCharge) || HasData(data, Panel::kParts))) continue;
    if (HasData(data, name.panel)) panels.push_back(name.panel);
  }
  return panels;
}

// The charge of each triangle over the mean, as logarithm, and the value that gets the end of the colour scale.
struct ChargeScale {
  std::vector<double> values;
  double end = 0.0;
};

ChargeScale ScaleOfCharge(const ObjectPictureData& data) {
  const std::vector<double> areas = TriangleAreas(data.mesh);
  double total = 0.0, charge = 0.0;
  for (std::size_t t = 0; t < areas.size(); ++t) {
    total += areas[t];
    charge += areas[t] * data.charge[t];
  }
  const double mean = total > 0.0 ? charge / total : 0.0;
  ChargeScale scale;
  for (double density : data.charge) {
    const double ratio = mean != 0.0 ? density / mean : 1.0;
    scale.values.push_back(std::log(std::clamp(ratio, 1e-3, 1e3)));
  }
  // Between the ends lie all but five in a hundred of the area on either side.
  std::vector<std::size_t> order(areas.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return scale.values[a] != scale.values[b] ? scale.values[a] < scale.values[b] : a < b;
  });
  double below = 0.0, low = 0.0, high = 0.0;
  for (std::size_t t : order) {
    if (below <= 0.05 * total) low = scale.values[t];
    if (below <= 0.95 * total) high = scale.values[t];
    below += areas[t];
  }
  // To a whole doubling, so that the legend says round numbers.
  const double octaves = std::max(std::abs(low), std::abs(high)) / std::log(2.0);
  scale.end = std::clamp(std::ceil(octaves - 0.2), 1.0, 2.0) * std::log(2.0);
  return scale;
}

std::vector<Color> LabelColors(const std::vector<int>& labels) {
  std::vector<Color> colors;
  for (int label : labels) colors.push_back(PartColor(label));
  return colors;
}

Scene SceneOf(const ObjectPictureData& data, Panel panel) {
  Scene scene;
  switch (panel) {
    case Panel::kCloud:
      scene.Add(data.cloud);
      break;
    case Panel::kMesh:
      scene.Add(data.mesh);
      break;
    case Panel::kCharge: {
      const ChargeScale scale = ScaleOfCharge(data);
      MeshStyle style;
      for (double value : scale.values) style.triangle_colors.push_back(DivergingColor(value / scale.end));
      scene.Add(data.mesh, style);
      break;
    }
    case Panel::kParts: {
      MeshStyle style;
      style.triangle_colors = LabelColors(data.labels);
      scene.Add(data.mesh, style);
      LineStyle border;
      border.width = 1.6;
      scene.Add(BorderSegments(data.mesh, data.labels), border);
      break;
    }
    case Panel::kGeons: {
      for (std::size_t part = 0; part < data.geons.size(); ++part) {
        MeshStyle style;
        style.color = PartColor(static_cast<int>(part));
        style.opacity = data.cloud.empty() ? 1.0 : 0.82;
        scene.Add(data.geons[part].surface, style);
        LineStyle edge;
        edge.color = FromLight(0.35f * ToLight(style.color));
        scene.Add(CreaseSegments(data.geons[part].surface, 0.7), edge);
      }
      if (!data.cloud.empty()) {
        CloudStyle style;
        style.color = Color::Constant(0.12f);
        style.radius = 0.0014 * BoundingBox(data.cloud.points).diagonal().norm();
        PointCloud thin = data.cloud;
        if (thin.size() > 6000) {
          std::vector<int> every;
          for (std::size_t i = 0; i < 6000; ++i) every.push_back(static_cast<int>(i * thin.size() / 6000));
          thin = Select(data.cloud, every);
        }
        scene.Add(thin, style);
      }
      break;
    }
  }
  return scene;
}

// Pixels of the canvas, samples included.
struct Layout {
  int across = 1, down = 1;
  int panel_columns = 0, panel_rows = 0, heading = 0, legend = 0, title = 0;
  double letter = 0.0;
};

int LegendLines(const ObjectPictureData& data, Panel panel) {
  if (panel == Panel::kCharge) return 2;
  if (panel == Panel::kGeons) return static_cast<int>(data.geons.size());
  return 0;
}

void DrawChargeLegend(Canvas& canvas, const ObjectPictureData& data, const Layout& layout, double left, double top) {
  const double letter = layout.letter, width = std::min(0.62 * layout.panel_columns, 26.0 * letter);
  const double x0 = left + 0.5 * (layout.panel_columns - width);
  constexpr int kSteps = 128;
  for (int i = 0; i < kSteps; ++i) {
    canvas.FillRectangle(x0 + width * i / kSteps, top, x0 + width * (i + 1) / kSteps, top + 0.9 * letter,
                         DivergingColor(2.0 * (i + 0.5) / kSteps - 1.0));
  }
  const double end = std::exp(ScaleOfCharge(data).end);
  const auto centred = [&](const std::string& text, double x) {
    canvas.DrawText(text, x - 0.5 * TextWidth(text) * letter / 6.0, top + 2.4 * letter, letter, kInk);
  };
  centred(Printed("1/%.3g of mean", end), x0);
  centred("mean", x0 + 0.5 * width);
  centred(Printed("%.3g times", end), x0 + width);
}

void DrawGeonLegend(Canvas& canvas, const ObjectPictureData& data, const Layout& layout, double left, double top) {
  const double letter = layout.letter;
  double widest = 0.0;
  for (const ObjectPictureData::Geon& geon : data.geons)
    widest = std::max(widest, TextWidth(geon.label) * letter / 6.0);
  const double x0 = left + std::max(letter, 0.5 * (layout.panel_columns - widest - 2.0 * letter));
  int row = 0;
  for (std::size_t i = 0; i < data.geons.size(); ++i) {
    if (data.geons[i].label.empty()) continue;  // a part without a shape
    const double y = top + (1.9 * row++ + 1.0) * letter;
    canvas.FillRectangle(x0, y - 1.05 * letter, x0 + 1.1 * letter, y + 0.05 * letter, PartColor(static_cast<int>(i)));
    canvas.DrawText(data.geons[i].label, x0 + 2.0 * letter, y, letter, kInk);
  }
}

void CheckData(const ObjectPictureData& data, const ObjectPictureOptions& options, const std::vector<Panel>& panels) {
  if ((!data.charge.empty() && data.charge.size() != data.mesh.triangles.size()) ||
      (!data.labels.empty() && data.labels.size() != data.mesh.triangles.size())) {
    throw std::invalid_argument("ObjectPicture: one charge and one label a triangle of the mesh are wanted");
  }
  if (options.columns < 64 || options.columns > 8192 || options.rows < 0 || options.rows > 8192 ||
      options.samples < 1 || options.samples > 4 || (options.rows > 0 && options.rows < 64)) {
    throw std::invalid_argument("ObjectPicture: a picture has 64 to 8192 columns and rows, and 1 to 4 samples");
  }
  if (panels.empty()) throw std::invalid_argument("ObjectPicture: there is nothing to show");
}

// How wide the object looks over how high, from where it will be seen.
double ApparentAspect(const std::vector<const Scene*>& scenes, const ObjectPictureOptions& options) {
  const Eigen::Matrix3d rotation = ViewRotation(options.azimuth, options.elevation);
  Eigen::AlignedBox2d box;
  for (const Scene* scene : scenes) {
    for (const auto& item : scene->meshes)
      for (const auto& p : item.mesh.vertices) box.extend(Eigen::Vector2d((rotation * p).head<2>()));
    for (const auto& item : scene->clouds)
      for (const auto& p : item.cloud.points) box.extend(Eigen::Vector2d((rotation * p).head<2>()));
  }
  if (box.isEmpty()) return 1.0;
  return std::clamp(box.sizes().x() / std::max(box.sizes().y(), 1e-12), 0.4, 2.5);
}

}  // namespace

Panel PanelFromName(std::string_view name) {
  std::string names;
  for (const PanelName& panel : kPanels) {
    if (name == panel.word) return panel.panel;
    names += (names.empty() ? "" : ", ") + std::string(panel.word);
  }
  throw std::invalid_argument("no such panel: \"" + std::string(name) + "\"; there are " + names);
}

Image ObjectPicture(const ObjectPictureData& data, const ObjectPictureOptions& options) {
  const std::vector<Panel> panels = PanelsOf(data, options);
  CheckData(data, options, panels);
  std::vector<Scene> scenes;
  for (Panel panel : panels) scenes.push_back(HasData(data, panel) ? SceneOf(data, panel) : Scene{});
  std::vector<const Scene*> all;
  for (const Scene& scene : scenes) all.push_back(&scene);

  const int n = static_cast<int>(panels.size());
  const double aspect = ApparentAspect(all, options);
  Layout layout;
  // In one row if the object is narrow or the panels few, else in two.
  layout.across = n <= 3 || aspect < 0.85 ? n : (n + 1) / 2;
  layout.down = (n + layout.across - 1) / layout.across;
  const int columns = options.columns / layout.across;
  int lines = 0;
  for (Panel panel : panels) lines = std::max(lines, LegendLines(data, panel));
  layout.letter = std::clamp(0.026 * columns, 8.0, 15.0) * options.samples;
  layout.title = data.title.empty() ? 0 : static_cast<int>(3.2 * layout.letter);
  layout.heading = static_cast<int>(3.0 * layout.letter);
  layout.legend = static_cast<int>((1.9 * lines + (lines > 0 ? 1.5 : 0.5)) * layout.letter);
  layout.panel_columns = columns * options.samples;
  const int around = layout.heading + layout.legend;
  layout.panel_rows = options.rows > 0 ? (options.rows * options.samples - layout.title) / layout.down - around
                                       : static_cast<int>(layout.panel_columns * std::clamp(0.95 / aspect, 0.6, 1.7));
  layout.panel_rows = std::max(layout.panel_rows / options.samples, 16) * options.samples;

  RenderOptions render;
  render.columns = columns;
  render.rows = layout.panel_rows / options.samples;
  render.samples = options.samples;
  render.threads = options.threads;
  const Camera camera =
      Framing(all, options.azimuth, options.elevation, static_cast<double>(render.columns) / render.rows, 0.085);

  int rows = layout.title + layout.down * (layout.panel_rows + around);
  rows = options.rows > 0 ? options.rows * options.samples
                          : (rows + options.samples - 1) / options.samples * options.samples;
  Canvas canvas(options.columns * options.samples, rows, Color::Ones());
  if (!data.title.empty()) {
    const double height = std::min(1.35 * layout.letter, 0.95 * canvas.columns * 6.0 / TextWidth(data.title));
    canvas.DrawText(data.title, 0.5 * (canvas.columns - TextWidth(data.title) * height / 6.0), 2.4 * layout.letter,
                    height, kInk, 1.2);
  }
  for (int i = 0; i < n; ++i) {
    const int left = i % layout.across * layout.panel_columns;
    const int top = layout.title + i / layout.across * (layout.panel_rows + around);
    render.scale_bar = i == 0;
    render.axes = i == 0;
    canvas.Paste(DrawScene(scenes[i], camera, render), left, top + layout.heading);
    const auto* name =
        std::find_if(kPanels.begin(), kPanels.end(), [&](const PanelName& p) { return p.panel == panels[i]; });
    const double height = 1.15 * layout.letter;
    canvas.DrawText(name->heading, left + 0.5 * (layout.panel_columns - TextWidth(name->heading) * height / 6.0),
                    top + 2.3 * layout.letter, height, kInk, 1.15);
    const double legend_top = top + layout.heading + layout.panel_rows + 0.4 * layout.letter;
    if (panels[i] == Panel::kCharge && HasData(data, Panel::kCharge))
      DrawChargeLegend(canvas, data, layout, left, legend_top);
    if (panels[i] == Panel::kGeons) DrawGeonLegend(canvas, data, layout, left, legend_top);
  }
  return canvas.Reduced(options.samples);
}

}  // namespace geond
