/**
 * @file arrays.hpp
 * Views of the caller's memory: pointer, shape and strides, with elements of float or double.
 *
 * Element (i, j) is data[i * row_stride + j * column_stride]; strides are in elements and may be
 * negative. Vectors have one column. egosieve/eigen.hpp makes views of Eigen's matrices.
 */
#ifndef EGOSIEVE_ARRAYS_HPP_
#define EGOSIEVE_ARRAYS_HPP_

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "types.h"

namespace egosieve {

namespace detail {

/** Fills a matrix of the C interface; strides in elements. */
template <typename T, typename Array>
void Describe(T* data, int64_t rows, int64_t columns, int64_t row_stride, int64_t column_stride,
              Array& array) {
  constexpr bool is_float = std::is_same_v<std::remove_const_t<T>, float>;
  static_assert(is_float || std::is_same_v<std::remove_const_t<T>, double>,
                "elements are float or double");
  array.data = data;
  array.rows = rows;
  array.columns = columns;
  array.row_stride = row_stride * static_cast<int64_t>(sizeof(T));
  array.column_stride = column_stride * static_cast<int64_t>(sizeof(T));
  array.type = is_float ? EGOSIEVE_FLOAT32 : EGOSIEVE_FLOAT64;
}

/** Rows of a packed matrix; -1, which calls refuse, where `size` is no multiple of `columns`. */
inline int64_t Rows(size_t size, int64_t columns) {
  const auto values = static_cast<int64_t>(size);
  return columns > 0 && values % columns == 0 ? values / columns : -1;
}

}  // namespace detail

/** A matrix that is read. Cheap to copy; the memory must outlive the call that uses the view. */
class ConstArray {
 public:
  /** No elements. */
  ConstArray() { array_.type = EGOSIEVE_FLOAT64; }
  /** A row-major, packed matrix, or a vector of `rows` values; T is float or double. */
  template <typename T>
  ConstArray(const T* data, int64_t rows, int64_t columns = 1)
      : ConstArray(data, rows, columns, columns, 1) {}
  /** A matrix with strides in elements; T is float or double. */
  template <typename T>
  ConstArray(const T* data, int64_t rows, int64_t columns, int64_t row_stride,
             int64_t column_stride) {
    detail::Describe(data, rows, columns, row_stride, column_stride, array_);
  }
  /** A vector. */
  template <typename T>
  ConstArray(const std::vector<T>& values)
      : ConstArray(values.data(), static_cast<int64_t>(values.size())) {}
  /** A row-major matrix of this many columns; calls refuse it where the size is no multiple. */
  template <typename T>
  ConstArray(const std::vector<T>& values, int64_t columns)
      : ConstArray(values.data(), detail::Rows(values.size(), columns), columns) {}

  /** The struct of the C interface. */
  const egosieve_const_array* c() const { return &array_; }

 private:
  egosieve_const_array array_{};
};

/** A matrix that is written; a default-constructed one is a result that is not wanted. */
class Array {
 public:
  /** A result that is not wanted and not computed. */
  Array() = default;
  /** A row-major, packed matrix, or a vector of `rows` values; T is float or double. */
  template <typename T>
  Array(T* data, int64_t rows, int64_t columns = 1) : Array(data, rows, columns, columns, 1) {}
  /** A matrix with strides in elements; T is float or double. */
  template <typename T>
  Array(T* data, int64_t rows, int64_t columns, int64_t row_stride, int64_t column_stride) {
    detail::Describe(data, rows, columns, row_stride, column_stride, array_);
  }
  /** A vector with its present size. */
  template <typename T>
  Array(std::vector<T>& values) : Array(values.data(), static_cast<int64_t>(values.size())) {}

  /** The struct of the C interface. */
  const egosieve_array& c() const { return array_; }

 private:
  egosieve_array array_{};
};

/** An image of 8-bit pixels, channels interleaved. */
struct Image {
  const uint8_t* data = nullptr;             /**< The first pixel of the first row. */
  int32_t width = 0;                         /**< Pixels, 1 to 16384. */
  int32_t height = 0;                        /**< Pixels, 1 to 16384. */
  egosieve_channels channels = EGOSIEVE_BGR; /**< Order of the channels. */
  int64_t row_stride_bytes = 0;              /**< From one row to the next; 0: packed. */

  /** The struct of the C interface. */
  egosieve_image c() const {
    egosieve_image image{};
    image.data = data;
    image.width = width;
    image.height = height;
    image.row_stride = row_stride_bytes;
    image.channels = channels;
    return image;
  }
};

}  // namespace egosieve

#endif  // EGOSIEVE_ARRAYS_HPP_
