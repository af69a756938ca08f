#include "gp/linalg/matrix_product.h"

#include "gp/linalg/aligned_matrix.h"

namespace egosieve::gp {
namespace {

// Values of k in a block: the packed columns of B that meet all packed rows of A, two vectors of each
// value, are 16 KiB, half of a first-level cache, 32 KiB with AVX-512, or 8 KiB without AVX.
constexpr int64_t kDepth = 256;
// Rows of A packed at a time, 192 KiB for the second-level cache, and columns of B, 384 KiB.
constexpr int64_t kPackedRows = 96;
constexpr int64_t kPackedColumns = 192;

// The packed parts of a thread's operands.
double* PackedRows() {
  static thread_local AlignedMatrix rows(1, kPackedRows * kDepth);
  return rows.row(0);
}
double* PackedColumns() {
  static thread_local AlignedMatrix columns(1, kPackedColumns * kDepth);
  return columns.row(0);
}

#if defined(__x86_64__)
namespace avx512 {
#define EGOSIEVE_TARGET __attribute__((target("avx512f,avx2,fma")))
constexpr int kLanes = 8, kBlockRows = 12;
#include "gp/linalg/matrix_product_lanes.inc"
#undef EGOSIEVE_TARGET
}  // namespace avx512

namespace avx2 {
#define EGOSIEVE_TARGET __attribute__((target("avx2,fma")))
constexpr int kLanes = 4, kBlockRows = 6;
#include "gp/linalg/matrix_product_lanes.inc"
#undef EGOSIEVE_TARGET
}  // namespace avx2
#endif

namespace baseline {
#define EGOSIEVE_TARGET
constexpr int kLanes = 2, kBlockRows = 6;
#include "gp/linalg/matrix_product_lanes.inc"
#undef EGOSIEVE_TARGET
}  // namespace baseline

}  // namespace

std::vector<ProductFunction> ProductsOfThisProcessor() {
  std::vector<ProductFunction> products;
#if defined(__x86_64__)
  const bool has_fma = __builtin_cpu_supports("fma");
  if (has_fma && __builtin_cpu_supports("avx512f")) products.push_back(avx512::AddProduct);
  if (has_fma && __builtin_cpu_supports("avx2")) products.push_back(avx2::AddProduct);
#endif
  products.push_back(baseline::AddProduct);
  return products;
}

void AddProduct(double sign, ProductOperand a, ProductOperand b, int64_t depth,
                kernels::MatrixView<double> c) {
  static const ProductFunction fastest = ProductsOfThisProcessor().front();
  fastest(sign, a, b, depth, c);
}

}  // namespace egosieve::gp
