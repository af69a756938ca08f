// C -= A B^T in float64 on one thread, beside Eigen's and OpenBLAS's. The three take turns.
#include <benchmark/benchmark.h>
#include <cblas.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <vector>

#include "gp/linalg/matrix_product.h"

extern "C" void openblas_set_num_threads(int count);

namespace egosieve::gp {
namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

// n x n results of depth k.
void BM_MatrixProduct(benchmark::State& state) {
  const int64_t n = state.range(0), k = state.range(1);
  const RowMatrix a = RowMatrix::Random(n, k), b = RowMatrix::Random(n, k);
  RowMatrix ours = RowMatrix::Zero(n, n), eigens = ours, openblas = ours;
  openblas_set_num_threads(1);
  const auto seconds = [](const auto& multiply) {
    const auto begin = std::chrono::steady_clock::now();
    multiply();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  std::vector<double> of_ours, of_eigen, of_openblas;
  for (auto _ : state) {
    of_ours.push_back(seconds([&] {
      AddProduct(-1, {a.data(), k, 1}, {b.data(), 1, k}, k, {ours.data(), n, n, n});
    }));
    of_eigen.push_back(seconds([&] { eigens.noalias() -= a * b.transpose(); }));
    of_openblas.push_back(seconds([&] {
      const int rows = static_cast<int>(n), depth = static_cast<int>(k);
      cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasTrans, rows, rows, depth, -1.0, a.data(), depth,
                  b.data(), depth, 1.0, openblas.data(), rows);
    }));
    state.SetIterationTime(of_ours.back());
  }
  const double scale = static_cast<double>(k) * static_cast<double>(of_ours.size());
  if (!((ours - openblas).cwiseAbs().maxCoeff() < 1e-12 * scale)) {
    return state.SkipWithError("another product than OpenBLAS's");
  }
  const double median = Median(of_ours);
  state.counters["flops_per_second"] = 2.0 * static_cast<double>(n * n * k) / median;
  state.counters["times_eigen"] = Median(of_eigen) / median;
  state.counters["times_openblas"] = Median(of_openblas) / median;
}
BENCHMARK(BM_MatrixProduct)
    ->ArgNames({"n", "depth"})
    ->ArgsProduct({{32, 64, 128, 256, 1024}, {64, 256, 4000}})
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace egosieve::gp
