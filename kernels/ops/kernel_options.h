// Build options of the .cl programs, and the layout of the prepared points that they read.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "kernels/base/aligned_array.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/prepared_points.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::kernels {

// Lanes of a vector of T.
template <typename T>
int Lanes(const Context& context) {
  return sizeof(T) == sizeof(float) ? context.tuning().float_lanes
                                    : std::max(context.tuning().float_lanes / 2, 1);
}

// The macros of kernels/cl/common.cl.
template <typename T>
std::string BuildOptions(const Context& context) {
  return absl::StrCat("-cl-std=CL1.2", sizeof(T) == sizeof(double) ? " -DREAL_IS_DOUBLE" : "",
                      " -DVEC=", Lanes<T>(context));
}

// Work-items per group for kernels with one value or one column of values per work-item: 64 on
// devices that run scalar work-items side by side, otherwise one, which processes vectors or a
// whole row.
inline int64_t SideBySide(const Context& context) {
  return context.tuning().work_group > 1 ? 64 : 1;
}

// The covariance's functions and macros, for use after common.cl. points: the model's prepared
// inputs.
inline std::string CovarianceCodeFor(const CovarianceParameters& parameters,
                                     const ConstMatrixView<float>& points) {
  // Loops over the values of a point are unrolled if the values then fit in registers.
  constexpr int64_t kMostUnrolled = 80;
  const int64_t width = PreparedWidth(parameters);
  DeviceCodeRequest request;
  request.dimension = parameters.input_dimension();
  request.points = points;
  return absl::StrCat("#define POINT ", width, "\n#define SCALES ", parameters.scales.size(),
                      "\n#define UNROLL ", width <= kMostUnrolled ? "_Pragma(\"unroll\")" : "",
                      "\n", parameters.function.description().DeviceCode(request));
}

// The same for unknown points. Kept, since it depends on the function and D alone.
inline const std::string& CovarianceCode(const CovarianceParameters& parameters) {
  static std::mutex mutex;
  static auto& codes = *new std::map<std::pair<std::string_view, int64_t>, std::string>;
  const std::lock_guard lock(mutex);
  std::string& code = codes[{parameters.function.text(), parameters.input_dimension()}];
  if (code.empty()) code = CovarianceCodeFor(parameters, {});
  return code;
}

// Prepared points, one per row.
template <typename Input, typename T>
std::vector<T> PrepareRows(const PointPreparation& preparation, ConstMatrixView<Input> points) {
  const int64_t width = preparation.width();
  std::vector<T> rows(points.rows * width);
  for (int64_t i = 0; i < points.rows; ++i) {
    preparation.Prepare(points.row(i), &rows[i * width], 1);
  }
  return rows;
}

// The same transposed, width x stride. The stride is a multiple of the vector; the padding is zero.
template <typename T>
struct PreparedColumns {
  AlignedArray<T> values;
  int64_t stride = 0;
};

template <typename Input, typename T>
PreparedColumns<T> PrepareColumns(const PointPreparation& preparation,
                                  ConstMatrixView<Input> points, int64_t multiple) {
  // Points per task: few enough to occupy all cores, enough to be worth distributing.
  constexpr int64_t kPiece = 2048;
  PreparedColumns<T> columns;
  columns.stride = (points.rows + multiple - 1) / multiple * multiple;
  const int64_t width = preparation.width();
  columns.values = AlignedArray<T>(std::max<int64_t>(width * columns.stride, 1));
  ParallelFor((columns.stride + kPiece - 1) / kPiece, [&](int64_t piece) {
    const int64_t begin = piece * kPiece;
    const int64_t end = std::min(begin + kPiece, columns.stride);
    for (int64_t i = begin; i < std::min(end, points.rows); ++i) {
      preparation.Prepare(points.row(i), &columns.values[i], columns.stride);
    }
    for (int64_t c = 0; c < width; ++c) {
      for (int64_t i = std::max(begin, points.rows); i < end; ++i)
        columns.values[c * columns.stride + i] = T{0};
    }
  });
  return columns;
}

}  // namespace egosieve::kernels
