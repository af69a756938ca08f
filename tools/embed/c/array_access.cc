#include "tools/embed/c/array_access.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"

namespace egosieve::embed {
namespace {

constexpr int64_t kMaximumElements = int64_t{1} << 40;
constexpr int64_t kMaximumStride = int64_t{1} << 48;
constexpr int32_t kMaximumImageSide = 16384;

absl::Status Refuse(const char* name, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat(name, what));
}

int64_t ElementSize(egosieve_type type) {
  return type == EGOSIEVE_FLOAT32 ? sizeof(float) : sizeof(double);
}

// Whether elements do not overlap: neither along an axis, nor between the axes.
bool StridesSeparate(int64_t rows, int64_t columns, int64_t row_stride, int64_t column_stride,
                     int64_t element) {
  const int64_t down = std::abs(row_stride), along = std::abs(column_stride);
  if (rows > 1 && down < element) return false;
  if (columns > 1 && along < element) return false;
  if (rows <= 1 || columns <= 1) return true;
  return down >= along * (columns - 1) + element || along >= down * (rows - 1) + element;
}

// Array: egosieve_array or egosieve_const_array, whose elements may lie on each other, as where one
// row stands for all. Resolves strides of 0.
template <typename Array>
absl::Status CheckLayout(const char* name, Array& array) {
  if (array.type != EGOSIEVE_FLOAT32 && array.type != EGOSIEVE_FLOAT64) {
    return Refuse(name, absl::StrFormat(".type = %d; it must be EGOSIEVE_FLOAT32 or "
                                        "EGOSIEVE_FLOAT64",
                                        array.type));
  }
  if (array.rows < 0 || array.columns < 0 || array.rows > kMaximumElements ||
      array.columns > kMaximumElements ||
      (array.columns > 0 && array.rows > kMaximumElements / array.columns)) {
    return Refuse(name, absl::StrFormat(": %d x %d; rows and columns must not be negative, nor "
                                        "elements more than 2^40",
                                        array.rows, array.columns));
  }
  const int64_t element = ElementSize(array.type);
  if (array.row_stride == 0 && array.column_stride == 0) {
    array.row_stride = array.columns * element;
    array.column_stride = element;
  }
  if (array.row_stride > kMaximumStride || array.row_stride < -kMaximumStride ||
      array.column_stride > kMaximumStride || array.column_stride < -kMaximumStride ||
      std::abs(array.column_stride) > kMaximumStride / std::max<int64_t>(array.columns, 1) ||
      std::abs(array.row_stride) > kMaximumStride / std::max<int64_t>(array.rows, 1)) {
    return Refuse(name, absl::StrFormat(": strides of %d and %d bytes reach too far",
                                        array.row_stride, array.column_stride));
  }
  constexpr bool kIsWritten = std::is_same_v<Array, egosieve_array>;
  if (kIsWritten &&
      !StridesSeparate(array.rows, array.columns, array.row_stride, array.column_stride, element)) {
    return Refuse(
        name,
        absl::StrFormat(": row_stride = %d and column_stride = %d bytes make the elements "
                        "of %d x %d values of %d bytes overlap",
                        array.row_stride, array.column_stride, array.rows, array.columns, element));
  }
  return absl::OkStatus();
}

template <typename T>
T Load(const char* place) {
  T value;
  std::memcpy(&value, place, sizeof value);
  return value;
}

template <typename T>
bool Aligned(const void* data, int64_t stride) {
  return reinterpret_cast<uintptr_t>(data) % alignof(T) == 0 && stride % int64_t{alignof(T)} == 0;
}

}  // namespace

absl::StatusOr<InputArray> InputArray::Matrix(const char* name, const egosieve_const_array* array) {
  if (array == nullptr) return Refuse(name, " is null");
  egosieve_const_array checked = *array;
  EGOSIEVE_RETURN_IF_ERROR(CheckLayout(name, checked));
  if (checked.data == nullptr && checked.rows > 0 && checked.columns > 0) {
    return Refuse(name, ".data is null");
  }
  return InputArray(name, checked);
}

absl::StatusOr<InputArray> InputArray::Vector(const char* name, const egosieve_const_array* array) {
  EGOSIEVE_ASSIGN_OR_RETURN(InputArray vector, Matrix(name, array));
  egosieve_const_array& view = vector.array_;
  if (view.columns != 1 && view.rows == 1) {
    std::swap(view.rows, view.columns);
    std::swap(view.row_stride, view.column_stride);
  }
  if (view.rows > 0 && view.columns != 1) {
    return Refuse(name, absl::StrFormat(": %d x %d; it must have one row or one column", view.rows,
                                        view.columns));
  }
  return vector;
}

double InputArray::operator()(int64_t row, int64_t column) const {
  const char* place = static_cast<const char*>(array_.data) + row * array_.row_stride +
                      column * array_.column_stride;
  return array_.type == EGOSIEVE_FLOAT32 ? Load<float>(place) : Load<double>(place);
}

template <typename T>
void InputArray::CopyRows(int64_t begin, int64_t end, T* out) const {
  const auto copy = [&](auto zero) {
    using Stored = decltype(zero);
    for (int64_t i = begin; i < end; ++i) {
      const char* place = static_cast<const char*>(array_.data) + i * array_.row_stride;
      for (int64_t j = 0; j < array_.columns; ++j, place += array_.column_stride) {
        *out++ = static_cast<T>(Load<Stored>(place));
      }
    }
  };
  array_.type == EGOSIEVE_FLOAT32 ? copy(0.0f) : copy(0.0);
}
template void InputArray::CopyRows(int64_t, int64_t, float*) const;
template void InputArray::CopyRows(int64_t, int64_t, double*) const;

std::vector<double> InputArray::Values() const {
  std::vector<double> values(rows() * columns());
  CopyRows(0, rows(), values.data());
  return values;
}

const float* InputArray::InPlace(int64_t& row_stride) const {
  const bool neighbours = array_.columns <= 1 || array_.column_stride == sizeof(float);
  const bool forward = array_.rows <= 1 || array_.row_stride > 0;
  if (array_.type != EGOSIEVE_FLOAT32 || !neighbours || !forward ||
      !Aligned<float>(array_.data, array_.rows > 1 ? array_.row_stride : 0)) {
    return nullptr;
  }
  row_stride = array_.rows > 1 ? array_.row_stride / int64_t{sizeof(float)} : array_.columns;
  return row_stride >= array_.columns ? static_cast<const float*>(array_.data) : nullptr;
}

template <typename T>
absl::Status InputArray::CheckFinite() const {
  for (int64_t i = 0; i < rows(); ++i) {
    for (int64_t j = 0; j < columns(); ++j) {
      const double value = (*this)(i, j);
      if (!std::isfinite(static_cast<T>(value))) {
        return Refuse(name_, absl::StrFormat("(%d, %d) = %g; it must be finite%s", i, j, value,
                                             std::is_same_v<T, float> ? " in float32" : ""));
      }
    }
  }
  return absl::OkStatus();
}
template absl::Status InputArray::CheckFinite<float>() const;
template absl::Status InputArray::CheckFinite<double>() const;

absl::StatusOr<OutputArray> OutputArray::Create(const char* name, const egosieve_array& array,
                                                int64_t rows, int64_t columns) {
  OutputArray output;
  if (array.data == nullptr) return output;
  output.array_ = array;
  EGOSIEVE_RETURN_IF_ERROR(CheckLayout(name, output.array_));
  const bool fits = array.rows == rows && array.columns == columns;
  const bool transposed = columns == 1 && array.rows == 1 && array.columns == rows;
  if (!fits && !transposed) {
    return Refuse(name, absl::StrFormat(": %d x %d; the result is %d x %d", array.rows,
                                        array.columns, rows, columns));
  }
  return output;
}

template <typename T>
void OutputArray::Write(int64_t begin, int64_t end, const T* values) const {
  const auto write = [&](auto zero) {
    using Stored = decltype(zero);
    int64_t i = begin / std::max<int64_t>(array_.columns, 1);
    int64_t j = begin - i * array_.columns;
    for (int64_t k = begin; k < end; ++k) {
      const Stored value = static_cast<Stored>(values[k - begin]);
      std::memcpy(
          static_cast<char*>(array_.data) + i * array_.row_stride + j * array_.column_stride,
          &value, sizeof value);
      if (++j == array_.columns) {
        j = 0;
        ++i;
      }
    }
  };
  array_.type == EGOSIEVE_FLOAT32 ? write(0.0f) : write(0.0);
}
template void OutputArray::Write(int64_t, int64_t, const float*) const;
template void OutputArray::Write(int64_t, int64_t, const double*) const;

absl::StatusOr<kernels::ImageView> ViewImage(const char* name, const egosieve_image* image,
                                             std::vector<uint8_t>& storage) {
  if (image == nullptr) return Refuse(name, " is null");
  if (image->data == nullptr) return Refuse(name, ".data is null");
  if (image->width < 1 || image->height < 1 || image->width > kMaximumImageSide ||
      image->height > kMaximumImageSide) {
    return Refuse(name, absl::StrFormat(": %d x %d pixels; each side must be 1 to %d", image->width,
                                        image->height, kMaximumImageSide));
  }
  if (image->channels < EGOSIEVE_GREY || image->channels > EGOSIEVE_RGB) {
    return Refuse(name, absl::StrFormat(".channels = %d; it must be EGOSIEVE_GREY, _BGR or _RGB",
                                        image->channels));
  }
  const int channels = image->channels == EGOSIEVE_GREY ? 1 : 3;
  const int64_t row_bytes = int64_t{image->width} * channels;
  const int64_t stride = image->row_stride == 0 ? row_bytes : image->row_stride;
  const int64_t furthest = kMaximumStride / image->height;
  if (stride > furthest || stride < -furthest || std::abs(stride) < row_bytes) {
    return Refuse(name, absl::StrFormat(".row_stride = %d bytes; a row of %d pixels takes %d",
                                        image->row_stride, image->width, row_bytes));
  }
  if (image->channels != EGOSIEVE_RGB && stride > 0) {
    return kernels::ImageView{image->data, image->width, image->height, channels, stride};
  }
  storage.resize(row_bytes * image->height);
  for (int64_t y = 0; y < image->height; ++y) {
    const uint8_t* from = image->data + y * stride;
    uint8_t* to = &storage[y * row_bytes];
    std::memcpy(to, from, row_bytes);
    for (int64_t x = 0; image->channels == EGOSIEVE_RGB && x < image->width; ++x) {
      std::swap(to[3 * x], to[3 * x + 2]);
    }
  }
  return kernels::ImageView{storage.data(), image->width, image->height, channels, row_bytes};
}

}  // namespace egosieve::embed
