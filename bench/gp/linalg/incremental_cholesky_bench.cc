// Updates of the Cholesky factor compared with refactorisation by the faster of Eigen and OpenBLAS,
// at the size of the model. Removal takes the oldest rows: the worst case.
#include <benchmark/benchmark.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "gp/linalg/incremental_cholesky.h"

extern "C" void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);

namespace egosieve::gp {
namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Clock = std::chrono::steady_clock;

double Seconds(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// Covariances of points in [-1, 1]^6 plus a noise variance of 1/4.
RowMatrix Gram(int64_t n) {
  std::mt19937_64 generator(20110513);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  RowMatrix x(n, 6);
  for (int64_t i = 0; i < x.size(); ++i) x.data()[i] = uniform(generator);
  const Eigen::VectorXd squares = x.rowwise().squaredNorm();
  RowMatrix k = -2.0 * (x * x.transpose());
  k.colwise() += squares;
  k.rowwise() += squares.transpose();
  k = (-0.5 * k.array()).exp().matrix().eval();
  k.diagonal().array() += 0.25;
  return k;
}

const RowMatrix& SharedGram(int64_t n) {
  static RowMatrix gram;
  if (gram.rows() != n) gram = Gram(n);
  return gram;
}

kernels::ConstMatrixView<double> View(const RowMatrix& m) { return {m.data(), m.rows(), m.cols()}; }

void Factorize(const RowMatrix& k, IncrementalCholesky& cholesky) {
  const absl::Status status = cholesky.Factorize(k.rows(), [&](kernels::MatrixView<double> out) {
    for (int64_t i = 0; i < k.rows(); ++i) std::copy_n(k.row(i).data(), i + 1, out.row(i));
    return absl::OkStatus();
  });
  if (!status.ok()) std::abort();
}

// Seconds for an n x n Cholesky factorisation by the faster of Eigen and OpenBLAS, on copies.
double BestRefactorSeconds(const RowMatrix& k) {
  static int64_t measured_size = -1;
  static double best;
  if (measured_size == k.rows()) return best;
  measured_size = k.rows();
  best = std::numeric_limits<double>::infinity();
  const int n = static_cast<int>(k.rows());
  RowMatrix work = k;
  for (int repetition = 0; repetition < 5; ++repetition) {
    for (const char* triangle : {"U", "L"}) {
      work = k;
      int info = 0;
      const auto begin = Clock::now();
      dpotrf_(triangle, &n, work.data(), &n, &info);
      best = std::min(best, Seconds(begin));
    }
    work = k;
    const auto begin = Clock::now();
    Eigen::LLT<Eigen::Ref<RowMatrix>> llt(work);
    best = std::min(best, Seconds(begin));
  }
  return best;
}

double ResidualInUnits(const IncrementalCholesky& cholesky, const RowMatrix& k) {
  // Probabilistic: |(L L^T - K) v| for one random vector.
  const int64_t n = k.rows();
  Eigen::Map<const RowMatrix, 0, Eigen::OuterStride<>> l(
      cholesky.Factor().data, n, n, Eigen::OuterStride<>(cholesky.Factor().stride));
  const Eigen::VectorXd v = Eigen::VectorXd::Random(n);
  const Eigen::VectorXd lt_v = l.transpose() * v;
  const Eigen::VectorXd residual = l * lt_v - k * v;
  return residual.norm() /
         (n * std::numeric_limits<double>::epsilon() * k.norm() * v.norm() / std::sqrt(n));
}

// Runs `update` on fresh copies of `start` with manual timing; reports the speed-up.
template <typename Update>
void MeasureUpdate(benchmark::State& state, const RowMatrix& start, const RowMatrix& expected,
                   Update update) {
  const double refactor = BestRefactorSeconds(SharedGram(state.range(0)));
  IncrementalCholesky initial;
  Factorize(start, initial);
  const auto copy_initial = [&](kernels::MatrixView<double> out) -> absl::StatusOr<int64_t> {
    for (int64_t i = 0; i < out.rows; ++i) std::copy_n(initial.Factor().row(i), i + 1, out.row(i));
    return -1;
  };
  std::vector<double> seconds;
  for (auto _ : state) {
    IncrementalCholesky copy(state.range(0) + state.range(1));
    if (!copy.Adopt(initial.size(), copy_initial).ok()) std::abort();
    const auto begin = Clock::now();
    update(copy);
    seconds.push_back(Seconds(begin));
    state.SetIterationTime(seconds.back());
    if (seconds.size() == 1) {
      state.counters["residual_n_eps"] = ResidualInUnits(copy, expected);
    }
  }
  std::nth_element(seconds.begin(), seconds.begin() + seconds.size() / 2, seconds.end());
  state.counters["speedup_over_refactor"] = refactor / seconds[seconds.size() / 2];
}

std::vector<int64_t> Oldest(int64_t k) {
  std::vector<int64_t> rows(k);
  std::iota(rows.begin(), rows.end(), int64_t{0});
  return rows;
}

void BM_Remove(benchmark::State& state) {
  const int64_t n = state.range(0), k = state.range(1);
  const RowMatrix& gram = SharedGram(n);
  MeasureUpdate(state, gram, gram.bottomRightCorner(n - k, n - k),
                [&](IncrementalCholesky& cholesky) {
                  if (!cholesky.Remove(Oldest(k)).ok()) std::abort();
                });
}

void BM_Append(benchmark::State& state) {
  const int64_t n = state.range(0), k = state.range(1);
  const RowMatrix& gram = SharedGram(n);
  const RowMatrix below = gram.bottomLeftCorner(k, n - k);
  const RowMatrix corner = gram.bottomRightCorner(k, k);
  MeasureUpdate(state, gram.topLeftCorner(n - k, n - k), gram, [&](IncrementalCholesky& cholesky) {
    if (!cholesky.Append(View(below), View(corner)).ok()) std::abort();
  });
}

// The work of one frame: removes k old rows and adds k new ones.
void BM_RemoveAndAppend(benchmark::State& state) {
  const int64_t n = state.range(0), k = state.range(1);
  const RowMatrix& gram = SharedGram(n);
  const RowMatrix below = gram.block(n - k, k, k, n - 2 * k);
  const RowMatrix corner = gram.bottomRightCorner(k, k);
  MeasureUpdate(state, gram.topLeftCorner(n - k, n - k), gram.bottomRightCorner(n - k, n - k),
                [&](IncrementalCholesky& cholesky) {
                  if (!cholesky.Remove(Oldest(k)).ok()) std::abort();
                  if (!cholesky.Append(View(below), View(corner)).ok()) std::abort();
                });
}

void BM_Refactor(benchmark::State& state) {
  const RowMatrix& gram = SharedGram(state.range(0));
  const double refactor = BestRefactorSeconds(gram);
  IncrementalCholesky cholesky;
  std::vector<double> seconds;
  for (auto _ : state) {
    const auto begin = Clock::now();
    Factorize(gram, cholesky);
    seconds.push_back(Seconds(begin));
    state.SetIterationTime(seconds.back());
  }
  const double n = static_cast<double>(gram.rows());
  state.counters["residual_n_eps"] = ResidualInUnits(cholesky, gram);
  state.counters["flops"] =
      benchmark::Counter(n * n * n / 3.0 * state.iterations(), benchmark::Counter::kIsRate);
  std::nth_element(seconds.begin(), seconds.begin() + seconds.size() / 2, seconds.end());
  state.counters["speedup_over_refactor"] = refactor / seconds[seconds.size() / 2];
}

BENCHMARK(BM_Refactor)->ArgName("n")->Arg(4000)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Remove)
    ->ArgNames({"n", "k"})
    ->ArgsProduct({{4000}, {1, 8, 64, 256}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Append)
    ->ArgNames({"n", "k"})
    ->ArgsProduct({{4000}, {1, 8, 64, 256}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(BM_RemoveAndAppend)
    ->ArgNames({"n", "k"})
    ->ArgsProduct({{4000}, {64, 300}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace egosieve::gp
