// The caller's arrays: checked against their rules, then read and written element by element as
// their strides say, or in place where they are packed float32.
#ifndef EGOSIEVE_TOOLS_EMBED_C_ARRAY_ACCESS_H_
#define EGOSIEVE_TOOLS_EMBED_C_ARRAY_ACCESS_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "kernels/base/image_view.h"
#include "tools/embed/include/egosieve/types.h"

namespace egosieve::embed {

// Every error of this file is InvalidArgument and begins with the argument's name.

// An egosieve_const_array that keeps its rules.
class InputArray {
 public:
  static absl::StatusOr<InputArray> Matrix(const char* name, const egosieve_const_array* array);
  // N x 1 or 1 x N, given back as N x 1.
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
  // Where the rows are aligned float32 with neighbouring columns: their first element and the
  // elements between rows; else null.
  const float* InPlace(int64_t& row_stride) const;
  // Every element finite, also as a T.
  template <typename T>
  absl::Status CheckFinite() const;

 private:
  InputArray(const char* name, const egosieve_const_array& array) : name_(name), array_(array) {}

  const char* name_;
  egosieve_const_array array_;
};

// An egosieve_array that keeps its rules, of a shape that the call asks for; data may be null.
class OutputArray {
 public:
  OutputArray() = default;
  // rows x columns; with columns = 1 also its transpose.
  static absl::StatusOr<OutputArray> Create(const char* name, const egosieve_array& array,
                                            int64_t rows, int64_t columns);

  bool wanted() const { return array_.data != nullptr; }
  int64_t size() const { return array_.rows * array_.columns; }
  // values: those of the row-major places begin to end - 1.
  template <typename T>
  void Write(int64_t begin, int64_t end, const T* values) const;

 private:
  egosieve_array array_{};
};

// The image as blue, green, red or grey; a copy in `storage` where the order differs.
absl::StatusOr<kernels::ImageView> ViewImage(const char* name, const egosieve_image* image,
                                             std::vector<uint8_t>& storage);

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_ARRAY_ACCESS_H_
