// Covariance matrices and their gradient on an OpenCL device, in float64. Arguments must be valid.
//
// On an H200 (33.5 TFLOP/s in float64 without tensor cores, 4.8 TB/s, 132 units of 2,048
// work-items), counted, not measured, for the arcsine, D = 6 and the lower triangle of n = 4000,
// 8.0 million pairs. A work-group of 64 takes 4 rows, so there are 1,000 groups on 132 units: 485
// work-items per unit, 0.24 of the slots. Local memory: 0.5 kB for the gradient.
//
//   kernel               flops                          bytes of device memory    least time
//   covariance_block     98 per pair: 0.8 G, 0.023 ms   64 MB written, 0.013 ms   0.023 ms
//   covariance_gradient  170 per pair: 1.4 G, 0.041 ms  64 MB read, 0.013 ms      0.041 ms
//
// Each group reads the prepared columns, 0.26 MB: 128 MB in all from the cache. Division counts as
// one operation, square root as five.
#pragma once

#include <CL/opencl.hpp>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/ops/kernel_options.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels::opencl {

// C(i, j) = k(x_i, z_j); with `lower_only` only j <= i.
absl::Status CovarianceBlock(Context& context, const CovarianceParameters& parameters,
                             ConstMatrixView<double> x, ConstMatrixView<double> z, bool lower_only,
                             MatrixView<double> out);

// The points of a covariance block in buffers, as kernels read them: rows point by point, columns
// value by value.
struct PreparedBlock {
  cl::Buffer rows, columns;
  int64_t row_count = 0, column_count = 0;
  int64_t column_stride = 0;  // the columns' count up to whole vectors
};

// The points of a covariance block, as kernels read them. Keep it until their commands have ended.
class CovariancePoints {
 public:
  // Throws cl::Error.
  CovariancePoints(const Context& context, const CovarianceParameters& parameters,
                   ConstMatrixView<double> x, ConstMatrixView<double> z);

  const PreparedBlock& block() const { return block_; }

 private:
  std::vector<double> rows_;
  PreparedColumns<double> columns_;
  PreparedBlock block_;
};

// Writes C(i, j), or with `lower_only` its lower triangle, to a device buffer. Throws cl::Error.
class CovarianceKernels {
 public:
  enum What { kBlock = 1, kGradient = 2 };
  // what: bits of What.
  static absl::StatusOr<CovarianceKernels> Create(Context& context, Workspace& workspace,
                                                  const CovarianceParameters& parameters, int what);

  // C(0, 0) goes to element `out_first`. The command waits for `after`.
  void EnqueueBlock(const cl::CommandQueue& queue, const PreparedBlock& points, bool lower_only,
                    const cl::Buffer& out, int64_t out_first, int64_t out_stride,
                    const std::vector<cl::Event>* after = nullptr, cl::Event* done = nullptr);
  // Writes GradientRows() x GradientColumns() partial sums to `out`.
  void EnqueueGradient(const cl::CommandQueue& queue, const PreparedBlock& points, bool lower_only,
                       const cl::Buffer& weights, int64_t weight_stride, const cl::Buffer& out);
  static int64_t GradientRows(int64_t rows);
  int64_t GradientColumns() const { return scales_ + 1; }
  // Adds the partial sums in the order of rows, so that the sum does not depend on the execution.
  std::vector<double> GradientOf(const std::vector<double>& partial_sums) const;

 private:
  cl::Kernel block_;
  cl::Kernel gradient_;
  int64_t work_group_ = 1;
  int64_t scales_ = 0;
  double signal_variance_ = 1.0;
};

// As kernels/ops/covariance_matrix.h; needs float64. With `lower_only` z is x and w symmetric
// with the lower triangle read.
absl::StatusOr<std::vector<double>> CovarianceGradient(Context& context,
                                                       const CovarianceParameters& parameters,
                                                       ConstMatrixView<double> x,
                                                       ConstMatrixView<double> z,
                                                       ConstMatrixView<double> w, bool lower_only);

}  // namespace egosieve::kernels::opencl
