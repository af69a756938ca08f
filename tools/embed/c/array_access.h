// The caller's arrays: checked first, then read and written element by element with their strides,
// or in place if they are packed float32. Errors are InvalidArgument and name the argument.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/embed/include/egosieve/types.h"
#include "vision/image/image_view.h"

namespace egosieve::embed {

class InputArray {
 public:
  InputArray(const char* name, const egosieve_const_array* array);
  // Accepts N x 1 or 1 x N; the result is N x 1.
  static InputArray Vector(const char* name, const egosieve_const_array* array);
  // N x dimension, the inputs of a model.
  static InputArray Points(const char* name, const egosieve_const_array* array, int64_t dimension);

  int64_t rows() const { return array_.rows; }
  int64_t columns() const { return array_.columns; }
  // Rows begin to end - 1, packed, into `out`.
  template <typename T>
  void CopyRows(int64_t begin, int64_t end, T* out) const;
  // All of them, in float64.
  std::vector<double> Values() const;
  // If the rows are aligned float32 with adjacent columns: the first element, and in `row_stride`
  // the number of elements between rows. Otherwise null.
  const float* InPlace(int64_t& row_stride) const;
  // Every element must be finite, also after conversion to T.
  template <typename T>
  void CheckFinite() const;

 private:
  // In float64.
  double At(int64_t row, int64_t column) const;

  const char* name_;
  egosieve_const_array array_;
};

// Of the shape that a call needs; its data may be null.
class OutputArray {
 public:
  OutputArray() = default;
  // rows x columns; if columns = 1, also 1 x rows.
  OutputArray(const char* name, const egosieve_array* array, int64_t rows, int64_t columns);

  bool wanted() const { return array_.data != nullptr; }
  int64_t size() const { return array_.rows * array_.columns; }
  // Writes places begin to end - 1, in row-major order.
  template <typename T>
  void Write(int64_t begin, int64_t end, const T* values) const;
  // All of them, if they are wanted.
  template <typename T>
  void Write(const std::vector<T>& values) const {
    if (wanted()) Write(0, size(), values.data());
  }

 private:
  egosieve_array array_{};
};

// The image as blue, green, red or as grey; copied into `storage` if its channel order differs.
vision::ImageView ViewImage(const char* name, const egosieve_image* image,
                            std::vector<uint8_t>& storage);

}  // namespace egosieve::embed
