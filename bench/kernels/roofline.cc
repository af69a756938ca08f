#include "bench/kernels/roofline.h"

#include <cblas.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cstring>
#include <string>
#include <vector>

#include "kernels/base/parallel_for.h"
#include "kernels/runtime/buffer.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels {
namespace {

double SecondsOf(const std::function<void()>& body) {
  const auto begin = std::chrono::steady_clock::now();
  body();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

template <typename T>
double FmaPerSecond(Context& context) {
  if (context.is_reference() || (sizeof(T) == sizeof(double) && !context.info().float64))
    return 0.0;
  static double best = 0.0;
  constexpr int kSteps = 1 << 20;
  constexpr int kChains = 16;
  // On GPUs, as many work-items as a unit can hold.
  const int group = context.tuning().work_group > 1 ? 128 : 1;
  constexpr int kItemsOfAUnit = 2048;
  const bool is_double = sizeof(T) == sizeof(double);
  const int lanes =
      is_double ? std::max(context.tuning().float_lanes / 2, 1) : context.tuning().float_lanes;
  const std::string options = "-cl-std=CL1.2 -DVEC=" + std::to_string(lanes) +
                              " -DCHAINS=" + std::to_string(kChains) +
                              (is_double ? " -DREAL_IS_DOUBLE" : "");
  auto workspace = context.Borrow("measuring the roofline");
  if (!workspace.ok()) return 0.0;
  auto kernel = (*workspace)->Kernel("roofline.cl", options, "multiply_add");
  if (!kernel.ok()) return 0.0;
  const int64_t items = int64_t{context.info().compute_units} * (group > 1 ? kItemsOfAUnit : 1);
  std::vector<T> out(items * lanes);
  for (int repeat = 0; repeat < 10; ++repeat) {
    OutputBuffer<T> result(context, MatrixView<T>(out.data(), 1, items * lanes));
    SetArguments(*kernel, cl_int{kSteps}, T{0.999}, T{1e-3}, result.buffer());
    const cl::CommandQueue& queue = (*workspace)->queue();
    const double seconds = SecondsOf([&] {
      queue.enqueueNDRangeKernel(*kernel, cl::NullRange, cl::NDRange(items), cl::NDRange(group));
      result.Finish(queue);
    });
    best = std::max(best, static_cast<double>(kSteps) * kChains * lanes * items / seconds);
  }
  return best;
}

template double FmaPerSecond<float>(Context&);
template double FmaPerSecond<double>(Context&);

double StrsmSeconds(int64_t n, int64_t m) {
  std::vector<float> factor(n * n, 0.0f);
  for (int64_t i = 0; i < n; ++i) {
    for (int64_t j = 0; j < i; ++j)
      factor[i * n + j] = 1e-3f * static_cast<float>((i * 31 + j * 17) % 7 - 3);
    factor[i * n + i] = 1.0f;
  }
  std::vector<float> right(n * m, 1.0f);
  const double blas = SecondsOf([&] {
    cblas_strsm(CblasColMajor, CblasLeft, CblasUpper, CblasTrans, CblasNonUnit, static_cast<int>(n),
                static_cast<int>(m), 1.0f, factor.data(), static_cast<int>(n), right.data(),
                static_cast<int>(n));
  });
  std::fill(right.begin(), right.end(), 1.0f);
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor> lower(factor.data(), n, n);
  const int64_t pieces = 8;
  const double eigen = SecondsOf([&] {
    ParallelFor(pieces, [&](int64_t p) {
      const int64_t begin = m * p / pieces;
      Eigen::Map<Eigen::MatrixXf> columns(right.data() + begin * n, n,
                                          m * (p + 1) / pieces - begin);
      lower.triangularView<Eigen::Lower>().solveInPlace(columns);
    });
  });
  return std::min(blas, eigen);
}

double CopyBytesPerSecond() {
  constexpr int64_t kPieces = 64;
  constexpr int64_t kPieceBytes = int64_t{4} << 20;
  std::vector<char> from(kPieces * kPieceBytes, 1);
  std::vector<char> to(kPieces * kPieceBytes, 2);
  double best = 0.0;
  for (int repeat = 0; repeat < 3; ++repeat) {
    const double seconds = SecondsOf([&] {
      ParallelFor(kPieces, [&](int64_t p) {
        std::memcpy(to.data() + p * kPieceBytes, from.data() + p * kPieceBytes, kPieceBytes);
      });
    });
    best = std::max(best, 2.0 * kPieces * kPieceBytes / seconds);
  }
  return best;
}

}  // namespace egosieve::kernels
