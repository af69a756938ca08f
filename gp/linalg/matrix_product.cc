#include "gp/linalg/matrix_product.h"

#include <algorithm>

#include "gp/linalg/aligned_matrix.h"

namespace egosieve::gp {
namespace {

// Lanes of a vector and rows of a block of C, which is two vectors wide. The block, a row of B and an
// element of A lie in the processor's 32 or 16 registers.
#if defined(__AVX512F__)
constexpr int kLanes = 8, kBlockRows = 12;
#elif defined(__AVX__)
constexpr int kLanes = 4, kBlockRows = 6;
#else
constexpr int kLanes = 2, kBlockRows = 6;
#endif
constexpr int kVectors = 2;
constexpr int kBlockColumns = kLanes * kVectors;
// Values of k in a block: kBlockColumns packed columns of B, which meet all packed rows of A, are 16
// KiB, half of a first-level cache, 32 KiB with AVX-512, or 8 KiB without AVX.
constexpr int64_t kDepth = 256;
// Rows of A packed at a time, 192 KiB for the second-level cache, and columns of B, 384 KiB.
constexpr int64_t kPackedRows = 96;
constexpr int64_t kPackedColumns = 192;

typedef double Vector __attribute__((vector_size(kLanes * sizeof(double))));
typedef double UnalignedVector
    __attribute__((vector_size(kLanes * sizeof(double)), aligned(sizeof(double)), may_alias));

// `count` rows of the operand and `depth` columns of each, in groups of kGroup rows, each column by
// column; rows that are missing in the last group are zero.
template <int kGroup>
void Pack(ProductOperand m, int64_t count, int64_t depth, double* packed) {
  for (int64_t first = 0; first < count; first += kGroup) {
    const int rows = static_cast<int>(std::min<int64_t>(kGroup, count - first));
    const double* source = m.data + first * m.row_stride;
    if (rows < kGroup) std::fill_n(packed, kGroup * depth, 0.0);
    for (int64_t k = 0; k < depth; ++k, packed += kGroup, source += m.column_stride) {
      if (rows < kGroup) {
        for (int r = 0; r < rows; ++r) packed[r] = source[r * m.row_stride];
      } else {
        for (int r = 0; r < kGroup; ++r) packed[r] = source[r * m.row_stride];
      }
    }
  }
}

// sums(r, v) = sum over k of a(k, r) b(k, v).
inline void Multiply(const double* a, const double* b, int64_t depth,
                     Vector (&sums)[kBlockRows][kVectors]) {
  for (int64_t k = 0; k < depth; ++k, a += kBlockRows, b += kBlockColumns) {
    Vector row[kVectors];
#pragma GCC unroll 2
    for (int64_t v = 0; v < kVectors; ++v) {
      row[v] = *reinterpret_cast<const UnalignedVector*>(b + v * kLanes);
    }
#pragma GCC unroll 12
    for (int r = 0; r < kBlockRows; ++r) {
#pragma GCC unroll 2
      for (int v = 0; v < kVectors; ++v) sums[r][v] += a[r] * row[v];
    }
  }
}

// c (rows x columns, at most one block) += or -= A B of packed operands.
template <int kSign>
void AddBlock(const double* a, const double* b, int64_t depth, int rows, int columns, double* c,
              int64_t stride) {
  Vector sums[kBlockRows][kVectors] = {};
  Multiply(a, b, depth, sums);
  if (rows == kBlockRows && columns == kBlockColumns) {
    for (int r = 0; r < kBlockRows; ++r) {
      for (int64_t v = 0; v < kVectors; ++v) {
        *reinterpret_cast<UnalignedVector*>(c + r * stride + v * kLanes) +=
            kSign > 0 ? sums[r][v] : -sums[r][v];
      }
    }
    return;
  }
  for (int r = 0; r < rows; ++r) {
    for (int j = 0; j < columns; ++j) {
      c[r * stride + j] += kSign * sums[r][j / kLanes][j % kLanes];
    }
  }
}

// The packed parts of a thread's operands.
struct Packed {
  AlignedMatrix a{1, kPackedRows* kDepth};
  AlignedMatrix b{1, kPackedColumns* kDepth};
};

}  // namespace

void AddProduct(double sign, ProductOperand a, ProductOperand b, int64_t depth,
                kernels::MatrixView<double> c) {
  if (c.empty()) return;
  static thread_local Packed packed;
  const auto add_block = sign > 0 ? AddBlock<1> : AddBlock<-1>;
  double *const rows_of_a = packed.a.row(0), *const columns_of_b = packed.b.row(0);
  for (int64_t column = 0; column < c.cols; column += kPackedColumns) {
    const int64_t columns = std::min(kPackedColumns, c.cols - column);
    for (int64_t k = 0; k < depth; k += kDepth) {
      const int64_t deep = std::min(kDepth, depth - k);
      Pack<kBlockColumns>(
          {b.data + k * b.row_stride + column * b.column_stride, b.column_stride, b.row_stride},
          columns, deep, columns_of_b);
      for (int64_t row = 0; row < c.rows; row += kPackedRows) {
        const int64_t rows = std::min(kPackedRows, c.rows - row);
        Pack<kBlockRows>(
            {a.data + row * a.row_stride + k * a.column_stride, a.row_stride, a.column_stride},
            rows, deep, rows_of_a);
        for (int64_t j = 0; j < columns; j += kBlockColumns) {
          for (int64_t i = 0; i < rows; i += kBlockRows) {
            add_block(rows_of_a + i * deep, columns_of_b + j * deep, deep,
                      static_cast<int>(std::min<int64_t>(kBlockRows, rows - i)),
                      static_cast<int>(std::min<int64_t>(kBlockColumns, columns - j)),
                      c.row(row + i) + column + j, c.stride);
          }
        }
      }
    }
  }
}

}  // namespace egosieve::gp
