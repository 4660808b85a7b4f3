// SPDX-License-Identifier: Apache-2.0
#include "core/geon/vfsr.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>
#include <stdexcept>

#include "core/base/progress.h"

namespace geond {
namespace {

// Uniform in [0, 1), the same with every standard library.
double Uniform(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1p-53; }

// Ingber's generating function: in [-1, 1], the closer to 0 the colder.
double Generate(std::mt19937_64& engine, double temperature) {
  const double u = Uniform(engine);
  const double y = temperature * (std::pow(1.0 + 1.0 / temperature, std::abs(2.0 * u - 1.0)) - 1.0);
  return u < 0.5 ? -y : y;
}

class Annealer {
 public:
  Annealer(const std::function<double(std::span<const double>)>& objective, std::span<const VfsrRange> ranges,
           std::uint64_t seed, const VfsrOptions& options)
      : objective_(objective), ranges_(ranges.begin(), ranges.end()), options_(options), engine_(seed),
        dimension_(static_cast<double>(ranges.size())), clock_(ranges.size(), 0.0),
        temperature_(ranges.size(), options.start_temperature) {
    const double usual = std::log(1e5) / std::pow(100.0, 1.0 / dimension_);
    if (options_.cooling == 0.0) options_.cooling = usual;
    if (options_.acceptance_cooling == 0.0) options_.acceptance_cooling = usual;
  }

  VfsrResult Run(const std::stop_token& stop) {
    Begin();
    while (!Ended()) {
      ThrowIfStopped(stop);
      const std::vector<double> trial = Neighbour();
      const double value = Evaluate(trial);
      Cool();
      if (std::abs(value - value_) <= 1e-12 * std::abs(value_)) ++repeats_;
      else repeats_ = 0;
      if (value <= value_ || Uniform(engine_) < std::exp(-(value - value_) / acceptance_temperature_)) {
        current_ = trial;
        value_ = value;
        acceptance_clock_ += 1.0;
        ++result_.acceptances;
        if (options_.reannealing_interval > 0 && result_.acceptances % options_.reannealing_interval == 0) Reanneal();
      }
    }
    return result_;
  }

 private:
  double Width(std::size_t i) const { return ranges_[i].high - ranges_[i].low; }

  double Evaluate(const std::vector<double>& at) {
    const double value = objective_(at);
    ++result_.evaluations;
    if (result_.parameters.empty() || value < result_.value) {
      result_.parameters = at;
      result_.value = value;
      improvements_.push_back(value);
      if (static_cast<int>(improvements_.size()) > options_.step + 1) improvements_.pop_front();
    }
    return value;
  }

  void Begin() {
    double sum = 0.0;
    for (int k = 0; k < std::max(1, options_.start_samples); ++k) {
      std::vector<double> at(ranges_.size());
      for (std::size_t i = 0; i < at.size(); ++i) at[i] = ranges_[i].low + Width(i) * Uniform(engine_);
      const double value = Evaluate(at);
      sum += value;
      if (k == 0 || value < value_) {
        current_ = at;
        value_ = value;
      }
    }
    first_acceptance_ = acceptance_temperature_ = std::max(1e-300, sum / std::max(1, options_.start_samples));
  }

  std::vector<double> Neighbour() {
    std::vector<double> trial(current_);
    for (std::size_t i = 0; i < trial.size(); ++i) {
      // A place outside is drawn again; an angle goes round.
      double x = 0.0;
      int tries = 0;
      do {
        x = current_[i] + Generate(engine_, temperature_[i]) * Width(i);
      } while (!ranges_[i].wraps && (x < ranges_[i].low || x > ranges_[i].high) && ++tries < 100);
      if (ranges_[i].wraps) x -= Width(i) * std::floor((x - ranges_[i].low) / Width(i));
      trial[i] = std::clamp(x, ranges_[i].low, ranges_[i].high);
    }
    return trial;
  }

  void Cool() {
    for (std::size_t i = 0; i < clock_.size(); ++i) {
      clock_[i] += 1.0;
      temperature_[i] = options_.start_temperature * std::exp(-options_.cooling * std::pow(clock_[i], 1.0 / dimension_));
    }
    acceptance_temperature_ =
        std::max(1e-300, first_acceptance_ *
                             std::exp(-options_.acceptance_cooling * std::pow(acceptance_clock_, 1.0 / dimension_)));
  }

  // Parameters the best value hardly depends on are warmed, by the ratio of the greatest slope to theirs; the temperature of
  // acceptance starts again from the best value.
  void Reanneal() {
    std::vector<double> slope(ranges_.size());
    std::vector<double> at = result_.parameters;
    const double best = result_.value;
    for (std::size_t i = 0; i < at.size() && result_.evaluations < options_.most_evaluations; ++i) {
      const double x = at[i], h = 1e-3 * Width(i);
      const double moved = x + h > ranges_[i].high ? x - h : x + h;
      at[i] = moved;
      slope[i] = std::abs(Evaluate(at) - best) / h * Width(i);
      at[i] = x;
    }
    const double greatest = *std::max_element(slope.begin(), slope.end());
    if (greatest > 0.0) {
      for (std::size_t i = 0; i < slope.size(); ++i) {
        const double warmed = std::min(options_.start_temperature, temperature_[i] * greatest / std::max(slope[i], 1e-9 * greatest));
        clock_[i] = std::pow(std::max(0.0, std::log(options_.start_temperature / warmed) / options_.cooling), dimension_);
      }
    }
    const double target = std::clamp(best, 1e-300, first_acceptance_);
    first_acceptance_ = std::max(target, std::min(first_acceptance_, value_));
    acceptance_clock_ = std::pow(std::max(0.0, std::log(first_acceptance_ / target) / options_.acceptance_cooling), dimension_);
  }

  bool Ended() {
    const auto end = [&](VfsrStop stop) {
      result_.stop = stop;
      return true;
    };
    if (*std::max_element(temperature_.begin(), temperature_.end()) <= options_.least_temperature) {
      return end(VfsrStop::kTemperature);
    }
    if (result_.value <= options_.least_value) return end(VfsrStop::kValue);
    if (repeats_ >= options_.most_repeats) return end(VfsrStop::kRepeats);
    if (result_.acceptances >= options_.most_acceptances) return end(VfsrStop::kAcceptances);
    if (result_.evaluations >= options_.most_evaluations) return end(VfsrStop::kEvaluations);
    if (static_cast<int>(improvements_.size()) > options_.step) {
      const double before = improvements_.front();
      if ((before - improvements_.back()) / before < options_.relative_difference) return end(VfsrStop::kDifference);
    }
    return false;
  }

  const std::function<double(std::span<const double>)>& objective_;
  std::vector<VfsrRange> ranges_;
  VfsrOptions options_;
  std::mt19937_64 engine_;
  double dimension_;
  std::vector<double> clock_, temperature_;   // a parameter each
  double first_acceptance_ = 1.0, acceptance_temperature_ = 1.0, acceptance_clock_ = 0.0;
  std::vector<double> current_;
  double value_ = 0.0;
  int repeats_ = 0;
  std::deque<double> improvements_;   // the last step + 1 best values
  VfsrResult result_;
};

}  // namespace

VfsrResult Anneal(const std::function<double(std::span<const double>)>& objective, std::span<const VfsrRange> ranges,
                  std::uint64_t seed, const VfsrOptions& options, std::stop_token stop) {
  if (ranges.empty()) throw std::invalid_argument("annealing needs at least one parameter");
  for (const VfsrRange& range : ranges) {
    if (!(range.high > range.low)) throw std::invalid_argument("a parameter to anneal has an empty range");
  }
  if (!(options.start_temperature > 0.0) || !(options.cooling >= 0.0) || !(options.acceptance_cooling >= 0.0)) {
    throw std::invalid_argument("the annealing's temperature must be positive, its cooling rates not negative");
  }
  return Annealer(objective, ranges, seed, options).Run(stop);
}

}  // namespace geond
