// SPDX-License-Identifier: Apache-2.0
#include "core/surface/view_field.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/progress.h"

namespace geond {
namespace {

// What one view says of one node: shares (of 1) of the four pixels around the node's image.
struct Verdict {
  double free = 0.0;
  double near = 0.0;
  double distance = 0.0;  // mean of the near pixels, m
  double cosine = 0.0;    // of their incidence
};

// Pixels that look past the object: table or background, but not lone ones among pixels of the object, which are no gap in
// it but a false return.
std::vector<std::uint8_t> FreePixels(const RangeView& view) {
  std::vector<std::uint8_t> free(view.classes.size(), 0);
  const auto looks_past = [&](int column, int row) {
    if (!view.image.contains(column, row)) return true;
    const PixelClass c = view.classes[view.image.index(column, row)];
    return c == PixelClass::kTable || c == PixelClass::kBackground;
  };
  for (int row = 0; row < view.image.rows; ++row) {
    for (int column = 0; column < view.image.columns; ++column) {
      if (!looks_past(column, row)) continue;
      int alike = -1;
      for (int k = 0; k < 9; ++k) alike += looks_past(column + k % 3 - 1, row + k / 3 - 1);
      free[view.image.index(column, row)] = alike >= 3;
    }
  }
  return free;
}

Verdict Judge(const RangeView& view, const std::vector<std::uint8_t>& free_pixels, const Eigen::Vector3d& p_S, double truncation) {
  Verdict verdict;
  const auto at = Project(view.sensor, p_S);
  if (!at || !(at->x() > -1.0 && at->y() > -1.0 && at->x() < view.image.columns && at->y() < view.image.rows)) return verdict;
  const int column = static_cast<int>(std::floor(at->x())), row = static_cast<int>(std::floor(at->y()));
  const double s = at->x() - column, t = at->y() - row;
  for (int corner = 0; corner < 4; ++corner) {
    const int c = column + (corner & 1), r = row + (corner >> 1);
    const double share = ((corner & 1) ? s : 1.0 - s) * ((corner >> 1) ? t : 1.0 - t);
    if (share <= 0.0 || !view.image.contains(c, r)) continue;
    const std::size_t pixel = view.image.index(c, r);
    const double depth = view.image.depth[pixel];
    const bool has_depth = std::isfinite(depth);
    switch (view.classes[pixel]) {
      case PixelClass::kNothing:
        break;
      case PixelClass::kTable:
        if (free_pixels[pixel] && has_depth && p_S.z() < depth) verdict.free += share;
        break;
      case PixelClass::kBackground:
        if (free_pixels[pixel] && (!has_depth || p_S.z() < depth)) verdict.free += share;
        break;
      case PixelClass::kRejected:
        if (has_depth && p_S.z() < depth - 4.0 * truncation) verdict.free += share;
        break;
      case PixelClass::kObject: {
        if (!has_depth) break;
        const Eigen::Vector3f& normal = view.normals_S[pixel];
        if (!normal.allFinite()) {
          if (p_S.z() < depth - 4.0 * truncation) verdict.free += share;
          break;
        }
        const Eigen::Vector3d n = normal.cast<double>();
        const double distance = n.dot(p_S - Unproject(view.sensor, c, r, depth));
        if (distance >= truncation) {
          verdict.free += share;
        } else if (distance > -truncation) {
          verdict.near += share;
          verdict.distance += share * distance;
          verdict.cosine -= share * n.dot(RayDirection(view.sensor, c, r));
        }
        break;
      }
    }
  }
  if (verdict.near > 0.0) {
    verdict.distance /= verdict.near;
    verdict.cosine /= verdict.near;
  }
  return verdict;
}

}  // namespace

ViewField FuseViews(std::span<const RangeView> views, SignedGrid grid, double truncation, int threads,
                    const std::stop_token& stop) {
  ViewField field{std::move(grid), {}, truncation};
  SignedGrid& distance = field.distance;
  field.state.assign(distance.count(), NodeState::kUnknown);
  std::vector<Pose> X_ST;
  std::vector<std::vector<std::uint8_t>> free_pixels;
  for (const RangeView& view : views) {
    X_ST.push_back(Inverse(view.X_TS));
    free_pixels.push_back(FreePixels(view));
  }

  ParallelFor(static_cast<std::ptrdiff_t>(distance.size[1]) * distance.size[2], threads, 8, [&](std::ptrdiff_t line) {
    ThrowIfStopped(stop);
    const int j = static_cast<int>(line % distance.size[1]), k = static_cast<int>(line / distance.size[1]);
    for (int i = 0; i < distance.size[0]; ++i) {
      const Eigen::Vector3d p = distance.node(i, j, k);
      double sum = 0.0, weights = 0.0;
      double freest = 0.0;
      for (std::size_t v = 0; v < views.size(); ++v) {
        const Verdict verdict = Judge(views[v], free_pixels[v], X_ST[v] * p, truncation);
        freest = std::max(freest, verdict.free);
        if (verdict.free <= 0.5 && verdict.near > 0.25) {
          // The nearer a surface is, the more it has to say; one seen from its far side hides no other face of the object.
          const double reach = verdict.distance / (0.4 * truncation);
          const double weight = verdict.near * verdict.cosine * verdict.cosine / (1.0 + std::pow(reach, 4));
          sum += weight * verdict.distance;
          weights += weight;
        }
      }
      const std::size_t node = distance.index(i, j, k);
      const double value = weights > 0.0 ? sum / weights : 0.0;
      if (weights > 0.0) {
        // Where one view looks past what another one takes for the inside, the first is right; but a little within the
        // outline its pixels may be too coarse to tell.
        const bool outside = value < 0.0 && (freest > 0.95 || (freest > 0.5 && value < -0.4 * distance.step));
        distance.value[node] = static_cast<float>(outside ? 0.25 * distance.step : value);
        field.state[node] = NodeState::kNear;
      } else if (freest > 0.5) {
        distance.value[node] = static_cast<float>(truncation);
        field.state[node] = NodeState::kFree;
      } else {
        distance.value[node] = static_cast<float>(-truncation);
      }
    }
  });
  return field;
}

void DiffuseUnknown(ViewField& field, bool closed_by_table, int threads, const std::stop_token& stop) {
  SignedGrid& grid = field.distance;
  const int nx = grid.size[0], ny = grid.size[1], nz = grid.size[2];
  const int table_layer = static_cast<int>(std::lround(-grid.origin.z() / grid.step));
  const int bottom = closed_by_table ? std::clamp(table_layer, 0, nz - 1) : 0;
  // The border of the grid is outside.
  for (int k = bottom; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        const bool border = i == 0 || j == 0 || i + 1 == nx || j + 1 == ny || k + 1 == nz || (k == 0 && !closed_by_table);
        if (!border) continue;
        grid.value[grid.index(i, j, k)] = static_cast<float>(field.truncation);
        field.state[grid.index(i, j, k)] = NodeState::kFree;
      }
    }
  }
  // Only unknown nodes within reach of the zero level matter; those deep inside settle quickly as they begin at -truncation.
  constexpr double kOverRelaxation = 1.7;
  constexpr int kSweeps = 120;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    ThrowIfStopped(stop);
    for (int colour = 0; colour < 2; ++colour) {
      ParallelFor(nz - bottom, threads, 1, [&](std::ptrdiff_t layer) {
        const int k = bottom + static_cast<int>(layer);
        for (int j = 0; j < ny; ++j) {
          for (int i = (j + k + colour) % 2; i < nx; i += 2) {
            const std::size_t node = grid.index(i, j, k);
            if (field.state[node] != NodeState::kUnknown) continue;
            double sum = 0.0;
            int n = 0;
            const auto add = [&](int a, int b, int c) {
              if (a < 0 || b < 0 || c < bottom || a >= nx || b >= ny || c >= nz) return;
              sum += grid.value[grid.index(a, b, c)];
              ++n;
            };
            add(i - 1, j, k), add(i + 1, j, k), add(i, j - 1, k), add(i, j + 1, k), add(i, j, k - 1), add(i, j, k + 1);
            const double old = grid.value[node];
            grid.value[node] = static_cast<float>(old + kOverRelaxation * (sum / n - old));
          }
        }
      });
    }
  }
}

}  // namespace geond
