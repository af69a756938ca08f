// Cholesky factorisation, triangular solves and inverses of matrices in the device's memory, in
// float64, in tiles of T = 64 (kernels/cl/linear_algebra.cl). Matrices are row-major. Of symmetric
// matrices only the lower triangle is used, and the upper one may be overwritten.
//
//   function              result                            flops        bytes of device memory
//   Factorize             L, A = L L^T, and L_kk^-1         n^3 / 3      8 n^3 / (3 T) + 8 n^2
//   SolveLower            L^-1 B, c columns                 c n^2        4 n^2 ceil(c / T)
//   SolveLowerTransposed  L^-T B                            c n^2        4 n^2 ceil(c / T)
//   InvertLower           R = L^-1                          n^3 / 3      16 n^3 / (3 T)
//   MultiplyInverse       R^T R = (L L^T)^-1, lower         n^3 / 3      16 n^3 / (3 T)
//   MultiplyLower         R B for lower R, c columns        c n^2        4 n^2 ceil(c / T)
//
// Right-looking: one work-group factorises and inverts block k, the rows below are multiplied by
// L_kk^-T, and their products are subtracted from the columns to the right (Golub & Van Loan, 4th
// ed., 4.2.5). Inverting L_kk loses accuracy in proportion to cond(L_kk), which is at most cond(L).
//
// On an H200 (33.5 TFLOP/s in float64 without tensor cores, 4.8 TB/s, 132 units of 4 x 16 lanes),
// counted, not measured: at n = 4000 Factorize has 21 GFLOP and moves 2.8 GB, 0.64 and 0.58 ms. The
// 63 diagonal blocks, one after the other with 64 steps of 4 barriers each, take longer, about 4
// ms. A work-group of 16 x 16 has 16 sums per work-item and 16.6 kB of local memory: 8 of them, all
// 2,048 work-items of a unit, fit; the 1,953 tiles of the first update fill 132 x 8 slots 1.8
// times.
#pragma once

#include <CL/opencl.hpp>
#include <cstdint>

#include "absl/status/statusor.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels::opencl {

// A matrix with packed rows in the device's memory; the buffer is never empty.
struct DeviceMatrix {
  cl::Buffer buffer;
  int64_t rows = 0;
  int64_t columns = 0;
};

// Throws cl::Error.
DeviceMatrix NewDeviceMatrix(const Context& context, int64_t rows, int64_t columns);

struct LinearAlgebraShape {
  int tile = 64;  // T
  int item = 4;   // each work-item computes item x item values of a tile; it divides `tile`
  int depth = 16;
};

// A factor L and the inverses of its diagonal blocks.
struct DeviceFactor {
  DeviceMatrix lower;
  DeviceMatrix inverses;  // T x T each, one after the other
};

// Enqueues on one in-order queue. All functions except Create throw cl::Error.
class DeviceLinearAlgebra {
 public:
  // FailedPrecondition on devices without float64.
  static absl::StatusOr<DeviceLinearAlgebra> Create(const Context& context, Workspace& workspace,
                                                    const LinearAlgebraShape& shape = {});

  // A(i, i) += noise + variances(i), and floors(i) = relative A(i, i). variances: n x 1.
  void AddNoise(DeviceMatrix& a, double noise, const DeviceMatrix& variances, double relative,
                DeviceMatrix& floors);
  // L replaces A. bad: one int32, negative before. When the commands have ended, it is the first
  // row, if any, whose pivot (square of L(i, i)) is not above its floor or not finite.
  DeviceFactor Factorize(DeviceMatrix a, const DeviceMatrix& floors, const cl::Buffer& bad);
  // B := L^-1 B and B := L^-T B.
  void SolveLower(const DeviceFactor& factor, DeviceMatrix& b);
  void SolveLowerTransposed(const DeviceFactor& factor, DeviceMatrix& b);
  // With zeros above the diagonal.
  DeviceMatrix InvertLower(const DeviceFactor& factor);
  // The lower triangle of `out` := that of R^T R.
  void MultiplyInverse(const DeviceMatrix& r, DeviceMatrix& out);
  // A^T B, R B for a lower triangle R with zeros above, and the squared norms of B's columns.
  DeviceMatrix MultiplyTransposed(const DeviceMatrix& a, const DeviceMatrix& b);
  DeviceMatrix MultiplyLower(const DeviceMatrix& r, const DeviceMatrix& b);
  DeviceMatrix ColumnNorms(const DeviceMatrix& b);
  // Copies of the host's: the matrix; a factor, n x n, of which the lower triangle is read.
  DeviceMatrix Upload(ConstMatrixView<double> a);
  DeviceMatrix UploadLower(ConstMatrixView<double> a);
  DeviceFactor UploadFactor(ConstMatrixView<double> lower);
  // Copies the lower triangle to `out`, which may be partly written after an error.
  void DownloadLower(const DeviceMatrix& a, MatrixView<double> out);
  // out(i) = A(i, i).
  void GetDiagonal(const DeviceMatrix& a, DeviceMatrix& out);
  // In the lower triangle, W := sum_c u_c u_c^T - k W; u: n x k.
  void LikelihoodWeights(const DeviceMatrix& u, DeviceMatrix& w);

 private:
  // An operand: its first element and its strides.
  struct Operand {
    const DeviceMatrix& matrix;
    int64_t row = 0;
    int64_t column = 0;
    bool transposed = false;
  };
  struct Extents {
    int64_t rows = 0;
    int64_t columns = 0;
    int64_t depth = 0;
  };
  enum Parts { kAll = 0, kLowerTiles = 1, kFromTheRow = 2, kToTheRow = 4 };
  // c := sign a b, or c += sign a b.
  void Multiply(const Extents& extents, double sign, bool add, int parts, const Operand& a,
                const Operand& b, const Operand& c);
  // Solves for the rows of B block by block; columns_of(k): the number of columns that block k may
  // change.
  template <typename ColumnsOf>
  void SolveLower(const DeviceFactor& factor, DeviceMatrix& b, ColumnsOf columns_of);

  template <typename Width>
  DeviceMatrix Upload(ConstMatrixView<double> a, Width width);

  const Context* context_ = nullptr;
  cl::CommandQueue queue_;
  LinearAlgebraShape shape_;
  cl::Kernel multiply_, factor_, noise_, identity_, diagonal_, weights_, norms_;
};

}  // namespace egosieve::kernels::opencl
