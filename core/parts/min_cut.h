// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

namespace geond {

// Cuts an undirected graph into a side of the sources and a side of the sinks, so that the capacity of the arcs between
// them is least (max flow by Dinic's blocking flows; whole-number capacities make the answer exact).
class MinCut {
 public:
  explicit MinCut(int nodes);
  void Connect(int u, int v, std::int64_t capacity);  // either way
  void AttachToSource(int u);
  void AttachToSink(int u);
  // True for the nodes on the source's side. Of several least cuts, the one nearest the sources.
  std::vector<bool> Solve(std::stop_token stop = {});

 private:
  struct Arc {
    int to;
    std::int64_t rest;
  };
  bool BuildLevels();
  std::int64_t Augment();

  int n_, source_, sink_;
  std::vector<Arc> arcs_;                  // arc i and its reverse i ^ 1
  std::vector<std::vector<int>> leaving_;  // a node: its arcs
  std::vector<int> level_;
  std::vector<std::size_t> next_;
};

}  // namespace geond
