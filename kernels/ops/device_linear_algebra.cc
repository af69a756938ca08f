#include "kernels/ops/device_linear_algebra.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/argument_checks.h"
#include "kernels/base/status_macros.h"
#include "kernels/runtime/buffer.h"

namespace egosieve::kernels::opencl {
namespace {

constexpr int64_t kGroup = 64;  // for kernels with one value per work-item
constexpr int64_t kBand = 256;  // rows of a matrix on the host at once while it is transferred

cl::NDRange Rounded(int64_t count) { return cl::NDRange((count + kGroup - 1) / kGroup * kGroup); }

}  // namespace

DeviceMatrix NewDeviceMatrix(const Context& context, int64_t rows, int64_t columns) {
  const size_t bytes = std::max<int64_t>(rows * columns, 1) * sizeof(double);
  return {cl::Buffer(context.cl_context(), CL_MEM_READ_WRITE, bytes), rows, columns};
}

absl::StatusOr<DeviceLinearAlgebra> DeviceLinearAlgebra::Create(const Context& context,
                                                                Workspace& workspace,
                                                                const LinearAlgebraShape& shape) {
  EGOSIEVE_REQUIRE(FailedPrecondition, context.info().float64,
                   "%s has no float64: factorise on the host", context.info().name);
  DeviceLinearAlgebra algebra;
  algebra.context_ = &context;
  algebra.queue_ = workspace.queue();
  algebra.shape_ = shape;
  const std::string options =
      absl::StrCat("-cl-std=CL1.2 -DREAL_IS_DOUBLE -DVEC=1 -DTILE=", shape.tile,
                   " -DITEM=", shape.item, " -DDEPTH=", shape.depth);
  const std::pair<cl::Kernel*, const char*> kernels[] = {
      {&algebra.multiply_, "multiply_tiles"}, {&algebra.factor_, "factor_diagonal"},
      {&algebra.noise_, "add_noise"},         {&algebra.identity_, "set_identity"},
      {&algebra.diagonal_, "get_diagonal"},   {&algebra.weights_, "likelihood_weights"},
      {&algebra.norms_, "column_norms"}};
  for (const auto& [kernel, name] : kernels) {
    EGOSIEVE_ASSIGN_OR_RETURN(*kernel, workspace.Kernel("linear_algebra.cl", options, name));
  }
  return algebra;
}

void DeviceLinearAlgebra::Multiply(const Extents& extents, double sign, bool add, int parts,
                                   const Operand& a, const Operand& b, const Operand& c) {
  if (extents.rows <= 0 || extents.columns <= 0) return;
  const auto first = [](const Operand& o) { return cl_long{o.row * o.matrix.columns + o.column}; };
  const auto row_step = [](const Operand& o) {
    return cl_long{o.transposed ? 1 : o.matrix.columns};
  };
  const auto column_step = [](const Operand& o) {
    return cl_long{o.transposed ? o.matrix.columns : 1};
  };
  SetArguments(multiply_, cl_long{extents.rows}, cl_long{extents.columns}, cl_long{extents.depth},
               cl_double{sign}, cl_int{add}, cl_int{parts}, a.matrix.buffer, first(a), row_step(a),
               column_step(a), b.matrix.buffer, first(b), row_step(b), column_step(b),
               c.matrix.buffer, first(c), row_step(c));
  const int64_t side = shape_.tile / shape_.item;
  const auto items = [&](int64_t count) { return (count + shape_.tile - 1) / shape_.tile * side; };
  queue_.enqueueNDRangeKernel(multiply_, cl::NullRange,
                              cl::NDRange(items(extents.columns), items(extents.rows)),
                              cl::NDRange(side, side));
}

void DeviceLinearAlgebra::AddNoise(DeviceMatrix& a, double noise, const DeviceMatrix& variances,
                                   double relative, DeviceMatrix& floors) {
  SetArguments(noise_, a.buffer, cl_long{a.columns}, cl_long{a.rows}, cl_double{noise},
               variances.buffer, cl_double{relative}, floors.buffer);
  queue_.enqueueNDRangeKernel(noise_, cl::NullRange, Rounded(a.rows), cl::NDRange(kGroup));
}

DeviceFactor DeviceLinearAlgebra::Factorize(DeviceMatrix a, const DeviceMatrix& floors,
                                            const cl::Buffer& bad) {
  const int64_t n = a.rows, tile = shape_.tile, blocks = (n + tile - 1) / tile;
  DeviceFactor factor{std::move(a), NewDeviceMatrix(*context_, blocks * tile, tile)};
  const DeviceMatrix& l = factor.lower;
  for (int64_t begin = 0; begin < n; begin += tile) {
    const int64_t size = std::min(tile, n - begin), below = begin + size, left = n - below;
    SetArguments(factor_, l.buffer, cl_long{begin * n + begin}, cl_long{n},
                 static_cast<cl_int>(size), floors.buffer, static_cast<cl_int>(begin),
                 factor.inverses.buffer, cl_long{begin * tile}, bad);
    queue_.enqueueNDRangeKernel(factor_, cl::NullRange, cl::NDRange(tile), cl::NDRange(tile));
    // X := X L_kk^-T, one tile wide.
    Multiply({left, size, size}, 1.0, false, kAll, {l, below, begin},
             {factor.inverses, begin, 0, true}, {l, below, begin});
    // Columns to the right of X: -= X X^T.
    Multiply({left, left, size}, -1.0, true, kLowerTiles, {l, below, begin},
             {l, below, begin, true}, {l, below, below});
  }
  return factor;
}

template <typename ColumnsOf>
void DeviceLinearAlgebra::SolveLower(const DeviceFactor& factor, DeviceMatrix& b,
                                     ColumnsOf columns_of) {
  const int64_t n = factor.lower.rows, tile = shape_.tile;
  for (int64_t begin = 0; begin < n; begin += tile) {
    const int64_t size = std::min(tile, n - begin), below = begin + size;
    const int64_t columns = columns_of(below);
    // One tile high.
    Multiply({size, columns, size}, 1.0, false, kAll, {factor.inverses, begin, 0}, {b, begin, 0},
             {b, begin, 0});
    Multiply({n - below, columns, size}, -1.0, true, kAll, {factor.lower, below, begin},
             {b, begin, 0}, {b, below, 0});
  }
}

void DeviceLinearAlgebra::SolveLower(const DeviceFactor& factor, DeviceMatrix& b) {
  SolveLower(factor, b, [&](int64_t) { return b.columns; });
}

void DeviceLinearAlgebra::SolveLowerTransposed(const DeviceFactor& factor, DeviceMatrix& b) {
  const int64_t n = factor.lower.rows, tile = shape_.tile;
  for (int64_t begin = (n - 1) / tile * tile; begin >= 0; begin -= tile) {
    const int64_t size = std::min(tile, n - begin);
    Multiply({size, b.columns, size}, 1.0, false, kAll, {factor.inverses, begin, 0, true},
             {b, begin, 0}, {b, begin, 0});
    Multiply({begin, b.columns, size}, -1.0, true, kAll, {factor.lower, begin, 0, true},
             {b, begin, 0}, {b, 0, 0});
  }
}

DeviceMatrix DeviceLinearAlgebra::InvertLower(const DeviceFactor& factor) {
  const int64_t n = factor.lower.rows;
  DeviceMatrix r = NewDeviceMatrix(*context_, n, n);
  SetArguments(identity_, r.buffer, cl_long{n}, cl_long{n});
  const int64_t across = (n + kGroup - 1) / kGroup * kGroup;
  queue_.enqueueNDRangeKernel(identity_, cl::NullRange, cl::NDRange(across, n),
                              cl::NDRange(kGroup, 1));
  // Elements to the right of the diagonal block are zero.
  SolveLower(factor, r, [](int64_t below) { return below; });
  return r;
}

void DeviceLinearAlgebra::MultiplyInverse(const DeviceMatrix& r, DeviceMatrix& out) {
  Multiply({r.rows, r.rows, r.rows}, 1.0, false, kLowerTiles | kFromTheRow, {r, 0, 0, true},
           {r, 0, 0}, {out, 0, 0});
}

DeviceMatrix DeviceLinearAlgebra::MultiplyTransposed(const DeviceMatrix& a, const DeviceMatrix& b) {
  DeviceMatrix out = NewDeviceMatrix(*context_, a.columns, b.columns);
  Multiply({a.columns, b.columns, a.rows}, 1.0, false, kAll, {a, 0, 0, true}, {b, 0, 0},
           {out, 0, 0});
  return out;
}

DeviceMatrix DeviceLinearAlgebra::MultiplyLower(const DeviceMatrix& r, const DeviceMatrix& b) {
  DeviceMatrix out = NewDeviceMatrix(*context_, r.rows, b.columns);
  Multiply({r.rows, b.columns, r.rows}, 1.0, false, kToTheRow, {r, 0, 0}, {b, 0, 0}, {out, 0, 0});
  return out;
}

DeviceMatrix DeviceLinearAlgebra::ColumnNorms(const DeviceMatrix& b) {
  DeviceMatrix out = NewDeviceMatrix(*context_, 1, b.columns);
  SetArguments(norms_, b.buffer, cl_long{b.rows}, cl_long{b.columns}, out.buffer);
  queue_.enqueueNDRangeKernel(norms_, cl::NullRange, Rounded(b.columns), cl::NDRange(kGroup));
  return out;
}

// width(i): values of row i that are copied; those behind them become 0.
template <typename Width>
DeviceMatrix DeviceLinearAlgebra::Upload(ConstMatrixView<double> a, Width width) {
  DeviceMatrix copy = NewDeviceMatrix(*context_, a.rows, a.cols);
  std::vector<double> band;
  for (int64_t first = 0; first < a.rows; first += kBand) {
    const int64_t rows = std::min(kBand, a.rows - first);
    band.assign(rows * a.cols, 0.0);
    for (int64_t i = 0; i < rows; ++i) {
      std::copy_n(a.row(first + i), width(first + i), &band[i * a.cols]);
    }
    queue_.enqueueWriteBuffer(copy.buffer, CL_TRUE, first * a.cols * sizeof(double),
                              band.size() * sizeof(double), band.data());
  }
  return copy;
}

DeviceMatrix DeviceLinearAlgebra::Upload(ConstMatrixView<double> a) {
  return Upload(a, [&](int64_t) { return a.cols; });
}

DeviceMatrix DeviceLinearAlgebra::UploadLower(ConstMatrixView<double> a) {
  return Upload(a, [](int64_t i) { return i + 1; });
}

DeviceFactor DeviceLinearAlgebra::UploadFactor(ConstMatrixView<double> lower) {
  const int64_t n = lower.rows, tile = shape_.tile, blocks = (n + tile - 1) / tile;
  std::vector<double> inverses(blocks * tile * tile, 0.0);
  for (int64_t row = 0; row < n; ++row) {  // row r of L_kk X = I, by forward substitution
    const int64_t begin = row / tile * tile, r = row - begin;
    double* block = &inverses[begin * tile];
    for (int64_t column = 0; column <= r; ++column) {
      double sum = column == r ? 1.0 : 0.0;
      for (int64_t k = column; k < r; ++k) {
        sum -= lower(row, begin + k) * block[k * tile + column];
      }
      block[r * tile + column] = sum / lower(row, row);
    }
  }
  return {UploadLower(lower), Upload({inverses.data(), blocks * tile, tile})};
}

void DeviceLinearAlgebra::DownloadLower(const DeviceMatrix& a, MatrixView<double> out) {
  std::vector<double> band;
  for (int64_t first = 0; first < a.rows; first += kBand) {
    const int64_t rows = std::min(kBand, a.rows - first), width = first + rows;
    band.resize(rows * width);
    const size_t row_bytes = width * sizeof(double);
    queue_.enqueueReadBufferRect(a.buffer, CL_TRUE, {0, static_cast<size_t>(first), 0}, {0, 0, 0},
                                 {row_bytes, static_cast<size_t>(rows), 1},
                                 a.columns * sizeof(double), 0, row_bytes, 0, band.data());
    for (int64_t i = 0; i < rows; ++i) {
      std::copy_n(&band[i * width], first + i + 1, out.row(first + i));
    }
  }
}

void DeviceLinearAlgebra::GetDiagonal(const DeviceMatrix& a, DeviceMatrix& out) {
  SetArguments(diagonal_, a.buffer, cl_long{a.columns}, cl_long{a.rows}, out.buffer);
  queue_.enqueueNDRangeKernel(diagonal_, cl::NullRange, Rounded(a.rows), cl::NDRange(kGroup));
}

void DeviceLinearAlgebra::LikelihoodWeights(const DeviceMatrix& u, DeviceMatrix& w) {
  SetArguments(weights_, w.buffer, cl_long{w.columns}, cl_long{w.rows}, u.buffer,
               static_cast<cl_int>(u.columns));
  const int64_t across = (w.columns + kGroup - 1) / kGroup * kGroup;
  queue_.enqueueNDRangeKernel(weights_, cl::NullRange, cl::NDRange(across, w.rows),
                              cl::NDRange(kGroup, 1));
}

}  // namespace egosieve::kernels::opencl
