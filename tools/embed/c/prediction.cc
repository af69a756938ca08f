#include "tools/embed/c/prediction.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "kernels/base/image_grid.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/box_means.h"
#include "tools/embed/c/array_access.h"
#include "tools/embed/c/options.h"

namespace egosieve::embed {
namespace {

constexpr int64_t kPiece = int64_t{1} << 16;

// The requested outputs, checked against the shape of the result.
struct Outputs {
  OutputArray mean, variance, probability;
  bool of_observation = false;

  // outputs_of_model: the mean has this many times the columns of the other outputs.
  static absl::StatusOr<Outputs> Create(const egosieve_prediction* prediction, int64_t rows,
                                        int64_t columns, int64_t outputs_of_model = 1) {
    egosieve_prediction wishes;
    egosieve_prediction_init(&wishes);
    EGOSIEVE_RETURN_IF_ERROR(ReadStruct("prediction", prediction, wishes));
    Outputs outputs;
    EGOSIEVE_ASSIGN_OR_RETURN(outputs.mean, OutputArray::Create("prediction.mean", wishes.mean,
                                                                rows, columns * outputs_of_model));
    EGOSIEVE_ASSIGN_OR_RETURN(
        outputs.variance,
        OutputArray::Create("prediction.variance", wishes.variance, rows, columns));
    EGOSIEVE_ASSIGN_OR_RETURN(
        outputs.probability,
        OutputArray::Create("prediction.probability", wishes.probability, rows, columns));
    outputs.of_observation = wishes.of_observation != 0;
    if (wishes.in_float64 != 0) {
      return absl::InvalidArgumentError(
          "prediction.in_float64: only egosieve_gp_predict() computes in float64");
    }
    return outputs;
  }
};

// Queries begin to end - 1 as packed rows, copied to `scratch` or in place. Copies are float64, so
// that nothing is rounded before it is prepared (kernels/base/prepared_points.h).
template <typename T>
using Queries =
    std::function<kernels::ConstMatrixView<T>(int64_t begin, int64_t end, std::vector<T>& scratch)>;

template <typename T>
absl::Status Evaluate(const DevicePosterior& at, int64_t count, bool in_place,
                      const Queries<T>& queries, const Outputs& outputs,
                      egosieve_prediction* prediction) {
  const gp::Posterior& posterior = *at.posterior;
  if (outputs.probability.wanted()) EGOSIEVE_RETURN_IF_ERROR(at.labels);
  // Nothing is written to the caller's arrays until all results are computed.
  const auto room = [&](const OutputArray& output) {
    return std::vector<float>(output.wanted() ? output.size() : 0);
  };
  std::vector<float> mean = room(outputs.mean), variance = room(outputs.variance),
                     probability = room(outputs.probability);
  const auto from = [](std::vector<float>& values, int64_t begin) {
    return values.empty() ? nullptr : values.data() + begin;
  };
  const int64_t columns = at.outputs();
  const int64_t piece = in_place ? std::max<int64_t>(count, 1) : kPiece;
  std::vector<T> scratch;
  int64_t clamped = 0;
  for (int64_t begin = 0; begin < count; begin += piece) {
    const int64_t end = std::min(begin + piece, count);
    EGOSIEVE_ASSIGN_OR_RETURN(
        const kernels::PosteriorCounts counts,
        posterior.Evaluate(
            queries(begin, end, scratch),
            {from(mean, begin * columns), from(variance, begin), from(probability, begin)}));
    clamped += counts.clamped_variances;
  }
  if (outputs.of_observation) posterior.AddNoiseVariance(absl::MakeSpan(variance));
  for (const auto& [output, values] :
       {std::pair(&outputs.mean, &mean), std::pair(&outputs.variance, &variance),
        std::pair(&outputs.probability, &probability)}) {
    if (output->wanted()) output->Write(0, output->size(), values->data());
  }
  WriteField(&egosieve_prediction::clamped_variances, clamped, prediction);
  return absl::OkStatus();
}

absl::Status CheckDimension(const DevicePosterior& at, int64_t needed, const char* what) {
  if (at.outputs() > 1) {
    return absl::FailedPreconditionError(
        absl::StrFormat("%s needs a model of one output; this one has %d", what, at.outputs()));
  }
  if (at.dimension() == needed) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrFormat(
      "%s needs a model of %d inputs; this one has %d", what, needed, at.dimension()));
}

}  // namespace

absl::Status PredictPoints(const DevicePosterior& at, const egosieve_const_array* x,
                           egosieve_prediction* prediction) {
  EGOSIEVE_ASSIGN_OR_RETURN(const InputArray points, InputArray::Matrix("x", x));
  if (points.columns() != at.dimension()) {
    return absl::InvalidArgumentError(absl::StrFormat("x: %d columns; the model has %d inputs",
                                                      points.columns(), at.dimension()));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const Outputs outputs,
                            Outputs::Create(prediction, points.rows(), 1, at.outputs()));
  EGOSIEVE_RETURN_IF_ERROR(points.CheckFinite<float>());
  int64_t stride = 0;
  if (const float* place = points.InPlace(stride); place != nullptr) {
    const Queries<float> in_place = [&](int64_t begin, int64_t end, std::vector<float>&) {
      return kernels::ConstMatrixView<float>(place + begin * stride, end - begin, points.columns(),
                                             stride);
    };
    return Evaluate(at, points.rows(), true, in_place, outputs, prediction);
  }
  const Queries<double> copied = [&](int64_t begin, int64_t end, std::vector<double>& scratch) {
    scratch.resize((end - begin) * points.columns());
    points.CopyRows(begin, end, scratch.data());
    return kernels::ConstMatrixView<double>(scratch.data(), end - begin, points.columns());
  };
  return Evaluate(at, points.rows(), false, copied, outputs, prediction);
}

absl::Status PredictGrid(const DevicePosterior& at, const egosieve_grid* grid,
                         egosieve_prediction* prediction) {
  constexpr int64_t kMaximumPoints = int64_t{1} << 40;
  if (grid == nullptr) return absl::InvalidArgumentError("grid is null");
  if (grid->rows < 1 || grid->columns < 1 || grid->rows > kMaximumPoints / grid->columns) {
    return absl::InvalidArgumentError(
        absl::StrFormat("grid: %d rows x %d columns; each must be at least 1, and points at most "
                        "2^40",
                        grid->rows, grid->columns));
  }
  const auto x = [&](int64_t column) { return grid->x0 + static_cast<double>(column) * grid->dx; };
  const auto y = [&](int64_t row) { return grid->y0 + static_cast<double>(row) * grid->dy; };
  const auto is_finite = [](double value) { return std::isfinite(static_cast<float>(value)); };
  if (!is_finite(x(0)) || !is_finite(x(grid->columns - 1)) || !is_finite(y(0)) ||
      !is_finite(y(grid->rows - 1))) {
    return absl::InvalidArgumentError(
        absl::StrFormat("grid: (%g, %g) in steps of (%g, %g); its points must be finite in float32",
                        grid->x0, grid->y0, grid->dx, grid->dy));
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckDimension(at, 2, "a grid"));
  EGOSIEVE_ASSIGN_OR_RETURN(const Outputs outputs,
                            Outputs::Create(prediction, grid->rows, grid->columns));
  const Queries<double> queries = [&](int64_t begin, int64_t end, std::vector<double>& scratch) {
    scratch.resize((end - begin) * 2);
    for (int64_t k = begin; k < end; ++k) {
      scratch[(k - begin) * 2] = x(k % grid->columns);
      scratch[(k - begin) * 2 + 1] = y(k / grid->columns);
    }
    return kernels::ConstMatrixView<double>(scratch.data(), end - begin, 2);
  };
  return Evaluate(at, grid->rows * grid->columns, false, queries, outputs, prediction);
}

absl::Status PredictImage(const DevicePosterior& at, const egosieve_image* image, int32_t stride,
                          egosieve_prediction* prediction) {
  std::vector<uint8_t> storage;
  EGOSIEVE_ASSIGN_OR_RETURN(const kernels::ImageView view, ViewImage("image", image, storage));
  if (stride < 1 || stride > 16384) {
    return absl::InvalidArgumentError(
        absl::StrFormat("stride = %d pixels; it must be 1 to 16384", stride));
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckDimension(at, kernels::kBoxMeanColumns, "an image"));
  const kernels::ImageGrid grid{view.width, view.height, stride};
  EGOSIEVE_ASSIGN_OR_RETURN(const Outputs outputs,
                            Outputs::Create(prediction, grid.rows(), grid.columns()));
  std::vector<float> field(grid.size() * kernels::kBoxMeanColumns);
  EGOSIEVE_RETURN_IF_ERROR(kernels::BoxMeansOnGrid(
      *at.context, view, grid, {},
      kernels::MatrixView<float>(field.data(), grid.size(), kernels::kBoxMeanColumns)));
  const Queries<float> queries = [&](int64_t begin, int64_t end, std::vector<float>&) {
    return kernels::ConstMatrixView<float>(&field[begin * kernels::kBoxMeanColumns], end - begin,
                                           kernels::kBoxMeanColumns);
  };
  return Evaluate(at, grid.size(), true, queries, outputs, prediction);
}

}  // namespace egosieve::embed
