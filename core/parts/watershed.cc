// SPDX-License-Identifier: Apache-2.0
// Labelling of triangles by height and by connection.
#include "core/parts/watershed.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace geond {

std::vector<int> Watershed(const SurfaceGraph& surface, const std::vector<double>& height) {
  std::vector<int> order(surface.n());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return height[a] > height[b]; });
  std::vector<int> labels(surface.n(), -1);
  int n_labels = 0;
  for (int t : order) {
    int best = -1;
    for (int next : surface.Neighbors(t)) {
      if (labels[next] < 0) continue;
      if (best < 0 || height[next] > height[best] || (height[next] == height[best] && next < best)) best = next;
    }
    labels[t] = best >= 0 ? labels[best] : n_labels++;
  }
  return labels;
}

std::vector<int> LabelComponents(const SurfaceGraph& surface, const std::vector<bool>& keep) {
  std::vector<int> labels(surface.n(), -1), queue;
  int n_labels = 0;
  for (int start = 0; start < surface.n(); ++start) {
    if (!keep[start] || labels[start] >= 0) continue;
    queue.assign(1, start);
    labels[start] = n_labels;
    for (std::size_t i = 0; i < queue.size(); ++i) {
      for (int next : surface.Neighbors(queue[i])) {
        if (!keep[next] || labels[next] >= 0) continue;
        labels[next] = n_labels;
        queue.push_back(next);
      }
    }
    ++n_labels;
  }
  return labels;
}

void FillUnlabelled(const SurfaceGraph& surface, std::vector<int>& labels) {
  std::vector<int> queue;
  for (int t = 0; t < surface.n(); ++t) {
    if (labels[t] >= 0) queue.push_back(t);
  }
  for (std::size_t i = 0; i < queue.size(); ++i) {
    for (int next : surface.Neighbors(queue[i])) {
      if (labels[next] >= 0) continue;
      labels[next] = labels[queue[i]];
      queue.push_back(next);
    }
  }
  for (int& label : labels) label = std::max(label, 0);
}

bool JoinSplinters(const SurfaceGraph& surface, std::vector<int>& labels) {
  // Pieces: components over edges between triangles of one label.
  std::vector<int> piece(surface.n(), -1), queue, label_of;
  std::vector<double> area_of;
  for (int start = 0; start < surface.n(); ++start) {
    if (piece[start] >= 0) continue;
    const int p = static_cast<int>(label_of.size());
    label_of.push_back(labels[start]);
    area_of.push_back(0.0);
    queue.assign(1, start);
    piece[start] = p;
    for (std::size_t i = 0; i < queue.size(); ++i) {
      area_of[p] += surface.areas[queue[i]];
      for (int next : surface.Neighbors(queue[i])) {
        if (piece[next] >= 0 || labels[next] != labels[start]) continue;
        piece[next] = p;
        queue.push_back(next);
      }
    }
  }
  std::map<int, int> largest;  // label to piece
  for (int p = 0; p < static_cast<int>(label_of.size()); ++p) {
    const auto [at, is_new] = largest.try_emplace(label_of[p], p);
    if (!is_new && area_of[p] > area_of[at->second]) at->second = p;
  }
  if (largest.size() == label_of.size()) return false;
  std::vector<std::map<int, double>> shared(label_of.size());
  for (int t = 0; t < surface.n(); ++t) {
    for (int arc = surface.first[t]; arc < surface.first[t + 1]; ++arc) {
      const int next = surface.to[arc];
      if (piece[next] != piece[t]) shared[piece[t]][piece[next]] += surface.lengths[arc];
    }
  }
  // Smallest first, so that a splinter within a splinter finds its way out.
  std::vector<int> splinters;
  for (int p = 0; p < static_cast<int>(label_of.size()); ++p) {
    if (largest[label_of[p]] != p) splinters.push_back(p);
  }
  std::stable_sort(splinters.begin(), splinters.end(), [&](int a, int b) { return area_of[a] > area_of[b]; });
  std::vector<int> new_label = label_of;
  bool changed = false;
  for (int p : splinters) {
    int best = -1;
    double length = 0.0;
    for (const auto& [q, l] : shared[p]) {
      if (l > length) best = q, length = l;
    }
    if (best < 0) continue;  // an island: a component of its own
    new_label[p] = new_label[best];
    changed = true;
  }
  for (int t = 0; t < surface.n(); ++t) labels[t] = new_label[piece[t]];
  return changed;
}

}  // namespace geond
