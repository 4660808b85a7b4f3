// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

namespace geond {

// Very fast simulated re-annealing (Ingber; thesis 5.4.1), as the thesis uses it: the defaults are those of its section 6.2.
struct VfsrOptions {
  double start_temperature = 1.0;         // T_0 of every parameter, in units of its range
  double cooling = 0.0;                   // c of T_k = T_0 exp(-c k^(1/D)); 0: so that T_100 is 1e-5 T_0
  double acceptance_cooling = 0.0;        // the same of the temperature of acceptance
  int start_samples = 10;                 // random points whose mean objective is the first temperature of acceptance
  int reannealing_interval = 100;         // acceptances between two re-annealings; 0: never
  // The six stops of section 5.4.3:
  double least_temperature = 1e-10;       // (i) of the parameters' temperatures, the greatest
  double least_value = 0.0;               // (ii) of the objective
  int most_repeats = 200;                 // (iii) of the same value in a row, within 1e-12 of it
  int most_acceptances = 10000;           // (iv)
  int most_evaluations = 10000;           // (v)
  double relative_difference = 0.003;     // (vi) of the best value ...
  int step = 10;                          // ... over so many improvements
};

enum class VfsrStop { kTemperature, kValue, kRepeats, kAcceptances, kEvaluations, kDifference };

struct VfsrResult {
  std::vector<double> parameters;   // the best seen
  double value = 0.0;
  int evaluations = 0, acceptances = 0;
  VfsrStop stop = VfsrStop::kEvaluations;
};

// One parameter: its bounds, and whether it is an angle, for which the two bounds are the same.
struct VfsrRange {
  double low = 0.0, high = 1.0;
  bool wraps = false;
};

// The least of `objective` over the box, from a random point; the same for the same seed. Throws std::invalid_argument if a
// range is empty, and Cancelled.
VfsrResult Anneal(const std::function<double(std::span<const double>)>& objective, std::span<const VfsrRange> ranges,
                  std::uint64_t seed, const VfsrOptions& options = {}, std::stop_token stop = {});

}  // namespace geond
