// C += sign A B in float64, on the calling thread, for large matrices; tile_operations.h uses it in
// factorisations and solves.
//
// Blocks of A and B are packed so that the innermost loop reads them in order and keeps a block of C
// in registers (Goto & van de Geijn, Anatomy of high-performance matrix multiplication, 2008). Every
// element of C gets the sums over blocks of values of k, in order: its bits do not depend on the rows
// and columns that are computed with it.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

// A matrix or its transpose: element (i, j) is data[i * row_stride + j * column_stride].
struct ProductOperand {
  const double* data = nullptr;
  int64_t row_stride = 0, column_stride = 0;
};

inline ProductOperand AsIs(kernels::ConstMatrixView<double> m) { return {m.data, m.stride, 1}; }
inline ProductOperand Transposed(kernels::ConstMatrixView<double> m) {
  return {m.data, 1, m.stride};
}

// c += sign A B with A c.rows x depth and B depth x c.cols, neither of them part of c. sign: 1 or -1.
void AddProduct(double sign, ProductOperand a, ProductOperand b, int64_t depth,
                kernels::MatrixView<double> c);

// AddProduct for each width of vectors that this processor has, the widest first, which AddProduct
// itself takes: a program for any processor of its kind is as fast as one built for this one. Their
// roundings differ.
using ProductFunction = void (*)(double sign, ProductOperand a, ProductOperand b, int64_t depth,
                                 kernels::MatrixView<double> c);
std::vector<ProductFunction> ProductsOfThisProcessor();

}  // namespace egosieve::gp
