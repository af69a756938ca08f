// The caller's arrays: checked first, then read and written element by element with their strides,
// or in place if they are packed float32.
#ifndef EGOSIEVE_TOOLS_EMBED_C_ARRAY_ACCESS_H_
#define EGOSIEVE_TOOLS_EMBED_C_ARRAY_ACCESS_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "kernels/base/image_view.h"
#include "tools/embed/include/egosieve/types.h"

namespace egosieve::embed {

// All errors of this file are InvalidArgument and begin with the argument's name.

// An egosieve_const_array that passed its checks.
class InputArray {
 public:
  static absl::StatusOr<InputArray> Matrix(const char* name, const egosieve_const_array* array);
  // Accepts N x 1 or 1 x N; the result is N x 1.
  static absl::StatusOr<InputArray> Vector(const char* name, const egosieve_const_array* array);

  int64_t rows() const { return array_.rows; }
  int64_t columns() const { return array_.columns; }
  // In float64.
  double operator()(int64_t row, int64_t column) const;
  // Rows begin to end - 1, packed, into `out`.
  template <typename T>
  void CopyRows(int64_t begin, int64_t end, T* out) const;
  // All of them, in float64.
  std::vector<double> Values() const;
  // If the rows are aligned float32 with adjacent columns: the first element, and in `row_stride`
  // the number of elements between rows. Otherwise null.
  const float* InPlace(int64_t& row_stride) const;
  // Checks that every element is finite, also after conversion to T.
  template <typename T>
  absl::Status CheckFinite() const;

 private:
  InputArray(const char* name, const egosieve_const_array& array) : name_(name), array_(array) {}

  const char* name_;
  egosieve_const_array array_;
};

// An egosieve_array that passed its checks, of the shape that a call needs; its data may be null.
class OutputArray {
 public:
  OutputArray() = default;
  // rows x columns; if columns = 1, also 1 x rows.
  static absl::StatusOr<OutputArray> Create(const char* name, const egosieve_array& array,
                                            int64_t rows, int64_t columns);

  bool wanted() const { return array_.data != nullptr; }
  int64_t size() const { return array_.rows * array_.columns; }
  // Writes places begin to end - 1, in row-major order.
  template <typename T>
  void Write(int64_t begin, int64_t end, const T* values) const;

 private:
  egosieve_array array_{};
};

// The image as blue, green, red or as grey; copied into `storage` if its channel order differs.
absl::StatusOr<kernels::ImageView> ViewImage(const char* name, const egosieve_image* image,
                                             std::vector<uint8_t>& storage);

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_ARRAY_ACCESS_H_
