// SPDX-License-Identifier: Apache-2.0
#include "core/charge/gmres.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>

#include "core/base/parallel.h"
#include "core/base/progress.h"

namespace geond::charge {
namespace {

// Sums are taken over blocks of fixed size and the blocks added in order, so that threads change nothing.
constexpr std::size_t kBlock = 4096;

struct Blocks {
  std::size_t n;
  int threads;
  std::size_t count() const { return (n + kBlock - 1) / kBlock; }
  template <typename Body>
  void ForEach(const Body& body) const {
    const int used = n < 8 * kBlock ? 1 : threads;
    ParallelFor(static_cast<std::ptrdiff_t>(count()), used, 1, [&](std::ptrdiff_t block) {
      const std::size_t begin = block * kBlock;
      body(static_cast<std::size_t>(block), begin, std::min(n, begin + kBlock));
    });
  }
};

double Dot(const double* a, const double* b, std::size_t begin, std::size_t end) {
  double sum[8] = {};
  std::size_t i = begin;
  for (; i + 8 <= end; i += 8) {
    for (int lane = 0; lane < 8; ++lane) sum[lane] += a[i + lane] * b[i + lane];
  }
  for (; i < end; ++i) sum[0] += a[i] * b[i];
  return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

double WeightedDot(const double* w, const double* a, const double* b, std::size_t begin, std::size_t end) {
  double sum[8] = {};
  std::size_t i = begin;
  for (; i + 8 <= end; i += 8) {
    for (int lane = 0; lane < 8; ++lane) sum[lane] += w[i + lane] * a[i + lane] * b[i + lane];
  }
  for (; i < end; ++i) sum[0] += w[i] * a[i] * b[i];
  return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

double Norm(const Blocks& blocks, const double* a) {
  std::vector<double> parts(blocks.count());
  blocks.ForEach([&](std::size_t block, std::size_t begin, std::size_t end) { parts[block] = Dot(a, a, begin, end); });
  double sum = 0.0;
  for (double part : parts) sum += part;
  return std::sqrt(sum);
}

// Takes from w its components along the first `count` basis vectors and adds them to h. Returns |w| before.
double Orthogonalise(const Blocks& blocks, const std::vector<std::vector<double>>& basis, std::size_t count,
                     std::vector<double>& w, std::vector<double>& h) {
  std::vector<double> parts(blocks.count() * (count + 1)), along(count + 1, 0.0);
  blocks.ForEach([&](std::size_t block, std::size_t begin, std::size_t end) {
    for (std::size_t j = 0; j < count; ++j) parts[block * (count + 1) + j] = Dot(basis[j].data(), w.data(), begin, end);
    parts[block * (count + 1) + count] = Dot(w.data(), w.data(), begin, end);
  });
  for (std::size_t i = 0; i < parts.size(); ++i) along[i % (count + 1)] += parts[i];
  blocks.ForEach([&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t j = 0; j < count; ++j) {
      for (std::size_t i = begin; i < end; ++i) w[i] -= along[j] * basis[j][i];
    }
  });
  for (std::size_t j = 0; j < count; ++j) h[j] += along[j];
  return std::sqrt(along[count]);
}

// The weighted products of the preconditioned vectors z_j with each other, and their weighted means: from them the size
// of any combination follows without its being made.
class ErrorEstimate {
 public:
  ErrorEstimate(const Blocks& blocks, std::span<const double> weights) : blocks_(blocks), weights_(weights) {}

  void Add(const std::vector<std::vector<double>>& z) {
    const std::size_t count = z.size();
    std::vector<double> parts(blocks_.count() * (count + 1)), sums(count + 1, 0.0);
    blocks_.ForEach([&](std::size_t block, std::size_t begin, std::size_t end) {
      double* const part = &parts[block * (count + 1)];
      for (std::size_t j = 0; j < count; ++j) {
        part[j] = WeightedDot(weights_.data(), z[j].data(), z.back().data(), begin, end);
      }
      part[count] = Dot(weights_.data(), z.back().data(), begin, end);
    });
    for (std::size_t i = 0; i < parts.size(); ++i) sums[i % (count + 1)] += parts[i];
    means_.push_back(sums.back());
    sums.pop_back();
    products_.push_back(std::move(sums));
  }

  // |sum t_j z_j| over the mean of sum y_j z_j.
  double Relative(const std::vector<double>& t, const std::vector<double>& y) const {
    double squares = 0.0, mean = 0.0;
    for (std::size_t i = 0; i < t.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) squares += 2.0 * t[i] * t[j] * products_[i][j];
      squares += t[i] * t[i] * products_[i][i];
    }
    for (std::size_t i = 0; i < y.size(); ++i) mean += y[i] * means_[i];
    return std::sqrt(std::max(0.0, squares)) / std::abs(mean);
  }

 private:
  const Blocks& blocks_;
  std::span<const double> weights_;
  std::vector<std::vector<double>> products_;  // row j: with vectors 0 to j
  std::vector<double> means_;
};

// R y = g, R held by columns.
std::vector<double> BackSubstitute(const std::vector<std::vector<double>>& R, const std::vector<double>& g) {
  std::vector<double> y(R.size());
  for (std::size_t i = y.size(); i-- > 0;) {
    double sum = g[i];
    for (std::size_t j = i + 1; j < y.size(); ++j) sum -= R[j][i] * y[j];
    y[i] = sum / R[i][i];
  }
  return y;
}

}  // namespace

GmresResult SolveGmres(const LinearMap& A, const LinearMap& precondition, std::span<const double> b,
                       const GmresOptions& options, const std::stop_token& stop,
                       const std::function<void(int, double)>& on_iteration) {
  const auto start = std::chrono::steady_clock::now();
  const std::size_t n = b.size();
  const Blocks blocks{n, options.threads};
  GmresResult result;
  result.x.assign(n, 0.0);
  const double b_norm = Norm(blocks, b.data());
  if (b_norm == 0.0) {
    result.summary.converged = true;
    result.summary.message = "nothing to solve";
    return result;
  }

  std::vector<std::vector<double>> basis(1, std::vector<double>(b.begin(), b.end()));
  for (double& value : basis[0]) value /= b_norm;
  std::vector<std::vector<double>> R;               // upper triangle, a column an iteration
  std::vector<double> cosine, sine, g = {b_norm};   // Givens rotations, and the right-hand side they have turned
  std::vector<std::vector<double>> preconditioned;  // what each basis vector became
  ErrorEstimate estimate(blocks, options.weights);
  std::vector<double> corrections;  // sizes of the preconditioned residuals, iteration by iteration
  std::vector<double>
      last_correction;  // parts of the residual along the basis, when it has been preconditioned already
  std::vector<double> w(n);
  result.summary.residual = 1.0;
  std::size_t k = 0;
  for (; k < static_cast<std::size_t>(options.max_iterations); ++k) {
    if (result.summary.residual <= options.tolerance) break;
    ThrowIfStopped(stop);
    preconditioned.emplace_back(n);
    precondition(basis[k], preconditioned[k]);
    if (!options.weights.empty()) {
      estimate.Add(preconditioned);
      // The residual is g_k times the last basis vector, turned back: its parts along the basis.
      std::vector<double> parts(k + 1, 0.0);
      parts[k] = g[k];
      for (std::size_t j = k; j-- > 0;) {
        parts[j] = -sine[j] * parts[j + 1];
        parts[j + 1] *= cosine[j];
      }
      if (k > 0) {
        // The correction that is still to be made, and what it leaves: it falls short by about as much as each before
        // it fell below the last, here taken fourfold.
        corrections.push_back(estimate.Relative(parts, BackSubstitute(R, g)));
        result.error_estimate = corrections.back();
        if (k > 2) result.error_estimate *= std::min(1.0, 4.0 * std::sqrt(corrections[k - 1] / corrections[k - 3]));
      }
      if (k > 0 && result.error_estimate <= options.error_tolerance) {
        last_correction = std::move(parts);
        break;
      }
    }
    A(preconditioned[k], w);
    std::vector<double> h(k + 2, 0.0);
    const double before = Orthogonalise(blocks, basis, k + 1, w, h);
    Orthogonalise(blocks, basis, k + 1, w, h);  // twice is enough
    h[k + 1] = Norm(blocks, w.data());
    const bool exhausted = !(h[k + 1] > 1e-15 * before);
    for (std::size_t j = 0; j < k; ++j) {
      const double upper = cosine[j] * h[j] + sine[j] * h[j + 1];
      h[j + 1] = cosine[j] * h[j + 1] - sine[j] * h[j];
      h[j] = upper;
    }
    const double radius = std::hypot(h[k], h[k + 1]);
    if (!(radius > 0.0) || !std::isfinite(radius))
      break;  // nothing new: the matrix is singular, or a value is not finite
    cosine.push_back(h[k] / radius);
    sine.push_back(h[k + 1] / radius);
    const double last = h[k + 1];
    h[k] = radius;
    g.push_back(-sine[k] * g[k]);
    g[k] *= cosine[k];
    R.push_back(std::move(h));
    result.summary.residual = std::abs(g[k + 1]) / b_norm;
    if (on_iteration) on_iteration(static_cast<int>(k + 1), result.summary.residual);
    if (exhausted) {
      ++k;
      break;
    }
    basis.push_back(w);
    for (double& value : basis.back()) value /= last;
  }

  std::vector<double> y = BackSubstitute(R, g);
  y.resize(std::max(y.size(), last_correction.size()), 0.0);
  for (std::size_t j = 0; j < last_correction.size(); ++j) y[j] += last_correction[j];
  blocks.ForEach([&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t j = 0; j < y.size(); ++j) {
      for (std::size_t i = begin; i < end; ++i) result.x[i] += y[j] * preconditioned[j][i];
    }
  });
  result.summary.iterations = static_cast<int>(k);
  result.summary.converged = result.summary.residual <= options.tolerance ||
                             (!options.weights.empty() && k > 0 && result.error_estimate <= options.error_tolerance);
  result.summary.message = result.summary.converged ? "converged" : "the residual stopped above the tolerance";
  result.summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace geond::charge
