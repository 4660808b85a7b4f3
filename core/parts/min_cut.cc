// SPDX-License-Identifier: Apache-2.0
// Maximum flow by blocking flows in level graphs (Dinic 1970).
#include "core/parts/min_cut.h"

#include <algorithm>
#include <limits>

#include "core/base/progress.h"

namespace geond {

constexpr std::int64_t kUnlimited = std::numeric_limits<std::int64_t>::max() / 4;

MinCut::MinCut(int nodes) : n_(nodes + 2), source_(nodes), sink_(nodes + 1), leaving_(n_) {}

void MinCut::Connect(int u, int v, std::int64_t capacity) {
  leaving_[u].push_back(static_cast<int>(arcs_.size()));
  arcs_.push_back({v, capacity});
  leaving_[v].push_back(static_cast<int>(arcs_.size()));
  arcs_.push_back({u, capacity});
}

void MinCut::AttachToSource(int u) {
  Connect(source_, u, kUnlimited);
  arcs_.back().rest = 0;
}

void MinCut::AttachToSink(int u) {
  Connect(u, sink_, kUnlimited);
  arcs_.back().rest = 0;
}

bool MinCut::BuildLevels() {
  level_.assign(n_, -1);
  std::vector<int> queue = {source_};
  level_[source_] = 0;
  for (std::size_t i = 0; i < queue.size() && level_[sink_] < 0; ++i) {
    for (int arc : leaving_[queue[i]]) {
      const int to = arcs_[arc].to;
      if (arcs_[arc].rest <= 0 || level_[to] >= 0) continue;
      level_[to] = level_[queue[i]] + 1;
      queue.push_back(to);
    }
  }
  return level_[sink_] >= 0;
}

// One path from source to sink along the levels, by depth-first search with its own stack; 0 if there is none left.
std::int64_t MinCut::Augment() {
  std::vector<int> path;
  int at = source_;
  while (at != sink_) {
    bool stepped = false;
    for (; next_[at] < leaving_[at].size(); ++next_[at]) {
      const int arc = leaving_[at][next_[at]];
      if (arcs_[arc].rest <= 0 || level_[arcs_[arc].to] != level_[at] + 1) continue;
      path.push_back(arc);
      at = arcs_[arc].to;
      stepped = true;
      break;
    }
    if (stepped) continue;
    if (at == source_) return 0;
    at = arcs_[path.back() ^ 1].to;
    path.pop_back();
    ++next_[at];
  }
  std::int64_t flow = kUnlimited;
  for (int arc : path) flow = std::min(flow, arcs_[arc].rest);
  for (int arc : path) {
    arcs_[arc].rest -= flow;
    arcs_[arc ^ 1].rest += flow;
  }
  return flow;
}

std::vector<bool> MinCut::Solve(std::stop_token stop) {
  while (BuildLevels()) {
    ThrowIfStopped(stop);
    next_.assign(n_, 0);
    std::int64_t total = 0;
    for (std::int64_t flow; (flow = Augment()) > 0;) {
      total += flow;
      if (total >= kUnlimited) return std::vector<bool>(n_ - 2, true);  // a source that is a sink: nothing to cut
    }
  }
  std::vector<bool> at_source(n_ - 2);
  for (int u = 0; u < n_ - 2; ++u) at_source[u] = level_[u] >= 0;
  return at_source;
}

}  // namespace geond
