// Owned row-major float64 storage, aligned to 64 bytes, with rows padded to whole cache lines.
// Contents are not initialised. Large matrices request huge pages, since a tile touches many rows,
// each on different pages.
#pragma once

#include <sys/mman.h>

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

class AlignedMatrix {
 public:
  AlignedMatrix() = default;
  AlignedMatrix(int64_t rows, int64_t cols) : rows_(rows), cols_(cols), stride_(Padded(cols)) {
    const size_t bytes = static_cast<size_t>(rows * stride_) * sizeof(double);
    if (bytes > 0) {
      data_.reset(Allocate(bytes));
      if (data_ == nullptr) throw std::bad_alloc();
    }
  }

  int64_t rows() const { return rows_; }
  int64_t cols() const { return cols_; }
  int64_t stride() const { return stride_; }
  double* row(int64_t i) { return data_.get() + i * stride_; }
  const double* row(int64_t i) const { return data_.get() + i * stride_; }
  // The leading rows x cols block.
  kernels::MatrixView<double> block(int64_t rows, int64_t cols) {
    return {data_.get(), rows, cols, stride_};
  }
  kernels::ConstMatrixView<double> block(int64_t rows, int64_t cols) const {
    return {data_.get(), rows, cols, stride_};
  }
  kernels::MatrixView<double> view() { return block(rows_, cols_); }
  kernels::ConstMatrixView<double> view() const { return block(rows_, cols_); }

 private:
  static constexpr int64_t kAlignmentBytes = 64;
  static constexpr size_t kHugePageBytes = size_t{2} << 20;

  static double* Allocate(size_t bytes) {
    if (bytes < 4 * kHugePageBytes) {
      return static_cast<double*>(std::aligned_alloc(kAlignmentBytes, bytes));
    }
    const size_t whole = (bytes + kHugePageBytes - 1) / kHugePageBytes * kHugePageBytes;
    void* data = std::aligned_alloc(kHugePageBytes, whole);
#ifdef MADV_HUGEPAGE
    if (data != nullptr) madvise(data, whole, MADV_HUGEPAGE);  // advice: a failure is harmless
#endif
    return static_cast<double*>(data);
  }

  // With a stride that is a multiple of 4096 bytes, a column's elements would share one cache set.
  static int64_t Padded(int64_t cols) {
    const int64_t line = kAlignmentBytes / static_cast<int64_t>(sizeof(double));
    const int64_t padded = (cols + line - 1) / line * line;
    return padded % 64 == 0 && padded > 0 ? padded + line : padded;
  }
  struct Free {
    void operator()(double* data) const { std::free(data); }
  };

  int64_t rows_ = 0;
  int64_t cols_ = 0;
  int64_t stride_ = 0;
  std::unique_ptr<double, Free> data_;
};

}  // namespace egosieve::gp
