// SPDX-License-Identifier: Apache-2.0
#include "core/charge/dense.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include <Eigen/LU>

#include "core/base/parallel.h"
#include "core/charge/gmres.h"

namespace geond::charge {
namespace {

constexpr double kResidual = 1e-13;

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// The matrix in strips of rows, each strip column by column: a triangle's column is written a strip at a time, and a
// product keeps a strip's sums in registers.
class StripMatrix {
 public:
  static constexpr std::ptrdiff_t kRows = 256;

  explicit StripMatrix(std::size_t n) : n_(static_cast<std::ptrdiff_t>(n)), values_(new double[n * n + kPadding]) {}

  std::ptrdiff_t size() const { return n_; }
  std::ptrdiff_t strips() const { return (n_ + kRows - 1) / kRows; }
  std::ptrdiff_t rows(std::ptrdiff_t strip) const { return std::min(kRows, n_ - strip * kRows); }
  double* column(std::ptrdiff_t strip, std::ptrdiff_t k) { return &values_[strip * kRows * n_ + k * rows(strip)]; }
  const double* column(std::ptrdiff_t strip, std::ptrdiff_t k) const {
    return &values_[strip * kRows * n_ + k * rows(strip)];
  }
  double diagonal(std::ptrdiff_t i) const { return column(i / kRows, i)[i % kRows]; }

 private:
  std::ptrdiff_t n_;
  std::unique_ptr<double[]> values_;
};

StripMatrix Assemble(const TriangleMesh& mesh, const Panels& panels, const Kernels& kernels, int threads,
                     const std::stop_token& stop, const StepObserver& on_step) {
  constexpr std::ptrdiff_t kSlice = 64;  // columns between two looks at the stop token
  const auto n = static_cast<std::ptrdiff_t>(panels.size());
  std::vector<TriangleFrame> frames(panels.size());
  for (std::size_t k = 0; k < frames.size(); ++k) frames[k] = FrameOf(mesh, k);
  StripMatrix A(panels.size());
  const std::ptrdiff_t slices = (n + kSlice - 1) / kSlice;
  const std::ptrdiff_t group = std::max<std::ptrdiff_t>(1, (1 << 22) / (n * kSlice));
  for (std::ptrdiff_t first = 0; first < slices; first += group) {
    ThrowIfStopped(stop);
    if (on_step) on_step("charge: matrix", static_cast<int>(first), static_cast<int>(slices));
    const std::ptrdiff_t count = std::min(group, slices - first);
    ParallelFor(count, threads, 1, [&](std::ptrdiff_t i) {
      const std::ptrdiff_t begin = (first + i) * kSlice, end = std::min(n, begin + kSlice);
      for (std::ptrdiff_t strip = 0; strip < A.strips(); ++strip) {
        const std::ptrdiff_t row = strip * StripMatrix::kRows;
        for (std::ptrdiff_t k = begin; k < end; ++k) {
          kernels.double_precision.triangle_potential(frames[k], &panels.x[row], &panels.y[row], &panels.z[row],
                                                      static_cast<int>(A.rows(strip)), A.column(strip, k));
        }
      }
    });
  }
  return A;
}

std::vector<double> SolveLu(const StripMatrix& A) {
  Eigen::MatrixXd matrix(A.size(), A.size());
  for (std::ptrdiff_t strip = 0; strip < A.strips(); ++strip) {
    for (std::ptrdiff_t k = 0; k < A.size(); ++k) {
      matrix.col(k).segment(strip * StripMatrix::kRows, A.rows(strip)) =
          Eigen::Map<const Eigen::VectorXd>(A.column(strip, k), A.rows(strip));
    }
  }
  const Eigen::PartialPivLU<Eigen::Ref<Eigen::MatrixXd>> lu(matrix);
  const Eigen::VectorXd x = lu.solve(Eigen::VectorXd::Ones(A.size()));
  return {x.data(), x.data() + x.size()};
}

}  // namespace

UnitPotentialSolution SolveDense(const TriangleMesh& mesh, const Panels& panels, DenseMethod method, int threads,
                                 const std::stop_token& stop, const StepObserver& on_step, const Kernels& kernels) {
  UnitPotentialSolution solution;
  const std::size_t n = panels.size();
  const auto start = std::chrono::steady_clock::now();
  const StripMatrix A = Assemble(mesh, panels, kernels, threads, stop, on_step);
  solution.setup_seconds = SecondsSince(start);
  solution.peak_bytes = n * n * sizeof(double);

  const LinearMap apply = [&](std::span<const double> x, std::span<double> y) {
    ParallelFor(A.strips(), n < 512 ? 1 : threads, 1, [&](std::ptrdiff_t strip) {
      double* const rows = &y[strip * StripMatrix::kRows];
      const int count = static_cast<int>(A.rows(strip));
      std::fill_n(rows, count, 0.0);
      kernels.double_precision.multiply(A.column(strip, 0), count, static_cast<std::ptrdiff_t>(n), x.data(), rows);
    });
  };
  const std::vector<double> ones(n, 1.0);
  if (method == DenseMethod::kGmres) {
    const LinearMap jacobi = [&](std::span<const double> x, std::span<double> y) {
      for (std::size_t i = 0; i < n; ++i) y[i] = x[i] / A.diagonal(static_cast<std::ptrdiff_t>(i));
    };
    GmresOptions options;
    options.tolerance = kResidual;
    options.max_iterations = static_cast<int>(std::min<std::size_t>(n, 300));
    options.threads = threads;
    GmresResult result = SolveGmres(apply, jacobi, ones, options, stop, [&](int iteration, double) {
      if (on_step) on_step("charge: solve", iteration, 0);
    });
    solution.x = std::move(result.x);
    solution.summary = std::move(result.summary);
  }
  if (!solution.summary.converged) {
    ThrowIfStopped(stop);
    if (on_step) on_step("charge: LU", 0, 0);
    solution.x = SolveLu(A);
    solution.peak_bytes *= 2;
    std::vector<double> potential(n);
    apply(solution.x, potential);
    double squares = 0.0;
    for (double value : potential) squares += (value - 1.0) * (value - 1.0);
    solution.summary.residual = std::sqrt(squares / static_cast<double>(n));
    solution.summary.converged = solution.summary.residual <= 1e-9;
    solution.summary.message = solution.summary.converged ? "solved by LU" : "the matrix is close to singular";
  }
  solution.solve_seconds = SecondsSince(start) - solution.setup_seconds;
  solution.summary.seconds = SecondsSince(start);
  return solution;
}

}  // namespace geond::charge
