#include "tools/embed/c/array_access.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <type_traits>
#include <utility>

#include "tools/embed/c/call.h"

namespace egosieve::embed {
namespace {

constexpr int64_t kMaximumElements = int64_t{1} << 40;
constexpr int64_t kMaximumStride = int64_t{1} << 48;
constexpr int32_t kMaximumImageSide = 16384;

// Calls `body` with a zero of the elements' type.
template <typename Body>
auto WithType(egosieve_type type, const Body& body) {
  return type == EGOSIEVE_FLOAT32 ? body(0.0f) : body(0.0);
}

// Whether elements do not overlap: neither along an axis, nor between the axes.
bool StridesSeparate(int64_t rows, int64_t columns, int64_t row_stride, int64_t column_stride,
                     int64_t element) {
  const int64_t down = std::abs(row_stride), along = std::abs(column_stride);
  if ((rows > 1 && down < element) || (columns > 1 && along < element)) return false;
  return rows <= 1 || columns <= 1 || down >= along * (columns - 1) + element ||
         along >= down * (rows - 1) + element;
}

bool Reaches(int64_t stride, int64_t count) {
  const int64_t furthest = kMaximumStride / std::max<int64_t>(count, 1);
  return stride >= -furthest && stride <= furthest;
}

// Array: egosieve_array or egosieve_const_array, whose elements may lie on each other, as where one
// row stands for all. Resolves strides of 0.
template <typename Array>
void CheckLayout(const char* name, Array& array) {
  Require(array.type == EGOSIEVE_FLOAT32 || array.type == EGOSIEVE_FLOAT64,
          "%s.type = %d; it must be EGOSIEVE_FLOAT32 or EGOSIEVE_FLOAT64", name, array.type);
  Require(array.rows != -1,
          "%s: -1 x %d; of a std::vector in C++: its size is no multiple of the columns", name,
          array.columns);
  Require(array.rows >= 0 && array.columns >= 0 && array.rows <= kMaximumElements &&
              array.columns <= kMaximumElements &&
              (array.columns == 0 || array.rows <= kMaximumElements / array.columns),
          "%s: %d x %d; rows and columns must not be negative, nor elements more than 2^40", name,
          array.rows, array.columns);
  const int64_t element = WithType(array.type, [](auto zero) -> int64_t { return sizeof zero; });
  if (array.row_stride == 0 && array.column_stride == 0) {
    array.row_stride = array.columns * element;
    array.column_stride = element;
  }
  Require(Reaches(array.row_stride, array.rows) && Reaches(array.column_stride, array.columns),
          "%s: strides of %d and %d bytes reach too far", name, array.row_stride,
          array.column_stride);
  Require(std::is_same_v<Array, egosieve_const_array> ||
              StridesSeparate(array.rows, array.columns, array.row_stride, array.column_stride,
                              element),
          "%s: row_stride = %d and column_stride = %d bytes make the elements of %d x %d values of "
          "%d bytes overlap",
          name, array.row_stride, array.column_stride, array.rows, array.columns, element);
}

template <typename T>
T Load(const char* place) {
  T value;
  std::memcpy(&value, place, sizeof value);
  return value;
}

}  // namespace

InputArray::InputArray(const char* name, const egosieve_const_array* array) : name_(name) {
  RequirePointer(name, array);
  array_ = *array;
  CheckLayout(name, array_);
  Require(array_.data != nullptr || array_.rows == 0 || array_.columns == 0, "%s.data is null",
          name);
}

InputArray InputArray::Vector(const char* name, const egosieve_const_array* array) {
  InputArray vector(name, array);
  egosieve_const_array& view = vector.array_;
  if (view.columns != 1 && view.rows == 1) {
    std::swap(view.rows, view.columns);
    std::swap(view.row_stride, view.column_stride);
  }
  Require(view.rows == 0 || view.columns == 1, "%s: %d x %d; it must have one row or one column",
          name, view.rows, view.columns);
  return vector;
}

InputArray InputArray::Points(const char* name, const egosieve_const_array* array,
                              int64_t dimension) {
  InputArray points(name, array);
  Require(points.columns() == dimension, "%s: %d columns; the model has %d inputs", name,
          points.columns(), dimension);
  return points;
}

double InputArray::At(int64_t row, int64_t column) const {
  const char* place = static_cast<const char*>(array_.data) + row * array_.row_stride +
                      column * array_.column_stride;
  return WithType(array_.type, [&](auto zero) -> double { return Load<decltype(zero)>(place); });
}

template <typename T>
void InputArray::CopyRows(int64_t begin, int64_t end, T* out) const {
  WithType(array_.type, [&](auto zero) {
    for (int64_t i = begin; i < end; ++i) {
      const char* place = static_cast<const char*>(array_.data) + i * array_.row_stride;
      for (int64_t j = 0; j < array_.columns; ++j, place += array_.column_stride) {
        *out++ = static_cast<T>(Load<decltype(zero)>(place));
      }
    }
  });
}
template void InputArray::CopyRows(int64_t, int64_t, double*) const;

std::vector<double> InputArray::Values() const {
  std::vector<double> values(rows() * columns());
  CopyRows(0, rows(), values.data());
  return values;
}

const float* InputArray::InPlace(int64_t& row_stride) const {
  const int64_t stride =
      array_.rows > 1 ? array_.row_stride : array_.columns * int64_t{sizeof(float)};
  const bool aligned = reinterpret_cast<uintptr_t>(array_.data) % alignof(float) == 0 &&
                       stride % int64_t{alignof(float)} == 0;
  if (array_.type != EGOSIEVE_FLOAT32 || !aligned ||
      (array_.columns > 1 && array_.column_stride != sizeof(float))) {
    return nullptr;
  }
  row_stride = stride / int64_t{sizeof(float)};
  const bool forward = array_.rows <= 1 || row_stride > 0;
  return forward && row_stride >= array_.columns ? static_cast<const float*>(array_.data) : nullptr;
}

template <typename T>
void InputArray::CheckFinite() const {
  for (int64_t i = 0; i < rows(); ++i) {
    for (int64_t j = 0; j < columns(); ++j) {
      const double value = At(i, j);
      if (std::isfinite(static_cast<T>(value))) continue;
      Require(false, "%s(%d, %d) = %g; it must be finite%s", name_, i, j, value,
              std::is_same_v<T, float> ? " in float32" : "");
    }
  }
}
template void InputArray::CheckFinite<float>() const;
template void InputArray::CheckFinite<double>() const;

OutputArray::OutputArray(const char* name, const egosieve_array* array, int64_t rows,
                         int64_t columns) {
  RequirePointer(name, array);
  if (array->data == nullptr) return;
  array_ = *array;
  CheckLayout(name, array_);
  const bool fits = array->rows == rows && array->columns == columns;
  const bool transposed = columns == 1 && array->rows == 1 && array->columns == rows;
  Require(fits || transposed, "%s: %d x %d; the result is %d x %d", name, array->rows,
          array->columns, rows, columns);
}

template <typename T>
void OutputArray::Write(int64_t begin, int64_t end, const T* values) const {
  WithType(array_.type, [&](auto zero) {
    const int64_t columns = std::max<int64_t>(array_.columns, 1);
    for (int64_t k = begin, i = begin / columns, j = begin % columns; k < end; ++k) {
      const auto value = static_cast<decltype(zero)>(values[k - begin]);
      char* row = static_cast<char*>(array_.data) + i * array_.row_stride;
      std::memcpy(row + j * array_.column_stride, &value, sizeof value);
      if (++j == columns) j = 0, ++i;
    }
  });
}
template void OutputArray::Write(int64_t, int64_t, const float*) const;
template void OutputArray::Write(int64_t, int64_t, const double*) const;

vision::ImageView ViewImage(const char* name, const egosieve_image* image,
                            std::vector<uint8_t>& storage) {
  RequirePointer(name, image);
  const auto [data, width, height, row_stride, channel_order] = *image;
  Require(data != nullptr, "%s.data is null", name);
  Require(width >= 1 && height >= 1 && width <= kMaximumImageSide && height <= kMaximumImageSide,
          "%s: %d x %d pixels; each side must be 1 to %d", name, width, height, kMaximumImageSide);
  Require(channel_order >= EGOSIEVE_GREY && channel_order <= EGOSIEVE_RGB,
          "%s.channels = %d; it must be EGOSIEVE_GREY, _BGR or _RGB", name, channel_order);
  const bool is_rgb = channel_order == EGOSIEVE_RGB;
  const int channels = channel_order == EGOSIEVE_GREY ? 1 : 3;
  const int64_t row_bytes = int64_t{width} * channels;
  const int64_t stride = row_stride == 0 ? row_bytes : row_stride;
  Require(Reaches(stride, height) && std::abs(stride) >= row_bytes,
          "%s.row_stride = %d bytes; a row of %d pixels takes %d", name, row_stride, width,
          row_bytes);
  if (!is_rgb && stride > 0) return vision::ImageView{data, width, height, channels, stride};
  storage.resize(row_bytes * height);
  for (int64_t y = 0; y < height; ++y) {
    uint8_t* to = &storage[y * row_bytes];
    std::memcpy(to, data + y * stride, row_bytes);
    for (int64_t x = 0; is_rgb && x < width; ++x) std::swap(to[3 * x], to[3 * x + 2]);
  }
  return vision::ImageView{storage.data(), width, height, channels, row_bytes};
}

}  // namespace egosieve::embed
