#include "tools/embed/c/prediction.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
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
  int64_t precision = EGOSIEVE_AUTO_PRECISION;

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
    outputs.precision = wishes.precision;
    if (outputs.precision < EGOSIEVE_AUTO_PRECISION || outputs.precision > EGOSIEVE_IN_FLOAT32) {
      return absl::InvalidArgumentError(
          absl::StrFormat("prediction.precision = %d; it must be EGOSIEVE_AUTO_PRECISION, "
                          "EGOSIEVE_IN_FLOAT64 or EGOSIEVE_IN_FLOAT32",
                          outputs.precision));
    }
    return outputs;
  }

  bool needs_mean() const { return mean.wanted() || probability.wanted(); }
  bool needs_variance() const { return variance.wanted() || probability.wanted(); }
};

// Queries begin to end - 1 as packed rows, copied to `scratch` or in place. Copies are float64, so
// that nothing is rounded before it is prepared (kernels/base/prepared_points.h).
template <typename T>
using Queries =
    std::function<kernels::ConstMatrixView<T>(int64_t begin, int64_t end, std::vector<T>& scratch)>;

// A call's results; what float32 gave is wider here, too.
struct Results {
  std::vector<double> mean, variance, probability;
  bool wide_means = false;    // all means are computed in float64
  bool wide_rest = false;     // and all variances and probabilities
  std::vector<int64_t> rows;  // places whose variance and probability are, increasing
  int64_t clamped = 0;
};

// What float32 computes, and which places need float64.
template <typename T>
absl::Status EvaluateInFloat32(const DevicePosterior& at, int64_t count, int64_t piece,
                               const Queries<T>& queries, const Outputs& outputs,
                               const gp::Float32Error& error, Results& results) {
  const bool rest = outputs.needs_variance() && !results.wide_rest;
  const bool means = outputs.mean.wanted() && !results.wide_means;
  if (!rest && !means) return absl::OkStatus();
  const bool checks = rest && outputs.precision == EGOSIEVE_AUTO_PRECISION;
  std::vector<T> scratch;
  std::vector<float> mean, variance, probability;
  for (int64_t begin = 0; begin < count; begin += piece) {
    const int64_t end = std::min(begin + piece, count);
    const kernels::ConstMatrixView<T> points = queries(begin, end, scratch);
    const auto room = [](bool wanted, int64_t size, std::vector<float>& values) {
      values.resize(wanted ? size : 0);
      return wanted ? values.data() : nullptr;
    };
    EGOSIEVE_ASSIGN_OR_RETURN(
        const kernels::PosteriorCounts counts,
        at.in_float32().Evaluate(
            points, {room(means, (end - begin) * at.outputs(), mean),
                     room(rest && (outputs.variance.wanted() || checks), end - begin, variance),
                     room(rest && outputs.probability.wanted(), end - begin, probability)}));
    results.clamped += counts.clamped_variances;
    const size_t known = results.rows.size();
    if (checks) {
      at.posterior->FindInsufficient(error, points, variance.data(), begin, results.rows);
    }
    for (size_t i = known; i < results.rows.size(); ++i) {  // none is counted twice
      results.clamped -= variance[results.rows[i] - begin] == 0.0f;
    }
    std::copy(mean.begin(), mean.end(), results.mean.begin() + begin * at.outputs());
    std::copy(variance.begin(), variance.end(), results.variance.begin() + begin);
    std::copy(probability.begin(), probability.end(), results.probability.begin() + begin);
  }
  results.clamped = std::max<int64_t>(results.clamped, 0);
  return absl::OkStatus();
}

// The means of all places where they are wanted, and the other results of `results.rows`.
template <typename T>
absl::Status EvaluateInFloat64(const DevicePosterior& at, int64_t count, const Queries<T>& queries,
                               const Outputs& outputs, Results& results) {
  const int64_t columns = at.outputs();
  const bool means = results.wide_means && outputs.needs_mean();
  std::vector<T> scratch;
  size_t next = 0;  // of results.rows
  for (int64_t begin = 0; begin < count; begin += kPiece) {
    const int64_t end = std::min(begin + kPiece, count);
    std::vector<int64_t> places, others;  // of results.rows, and those whose mean alone is computed
    for (int64_t i = begin; i < end; ++i) {
      if (next < results.rows.size() && results.rows[next] == i) {
        places.push_back(results.rows[next++]);
      } else if (means) {
        others.push_back(i);
      }
    }
    if (places.empty() && others.empty()) continue;
    const kernels::ConstMatrixView<T> points = queries(begin, end, scratch);
    for (const auto& [to, with_variance] : {std::pair(&places, true), std::pair(&others, false)}) {
      std::vector<double> x, mean(to->size() * columns), variance(with_variance ? to->size() : 0);
      x.reserve(to->size() * points.cols);
      for (const int64_t place : *to) {
        const T* row = points.row(place - begin);
        x.insert(x.end(), row, row + points.cols);
      }
      EGOSIEVE_ASSIGN_OR_RETURN(const int64_t clamped,
                                at.posterior->in_float64().Evaluate(
                                    {x.data(), static_cast<int64_t>(to->size()), points.cols},
                                    mean.data(), with_variance ? variance.data() : nullptr));
      results.clamped += clamped;
      for (size_t i = 0; i < to->size(); ++i) {
        const int64_t place = (*to)[i];
        if (means) std::copy_n(&mean[i * columns], columns, &results.mean[place * columns]);
        if (with_variance) results.variance[place] = variance[i];
        if (outputs.probability.wanted()) {
          results.probability[place] =
              at.in_float32().squash().Probability(mean[i], results.variance[place]);
        }
      }
    }
  }
  return absl::OkStatus();
}

template <typename T>
absl::Status Evaluate(const DevicePosterior& at, int64_t count, bool in_place,
                      const Queries<T>& queries, const Outputs& outputs,
                      egosieve_prediction* prediction) {
  if (outputs.probability.wanted()) EGOSIEVE_RETURN_IF_ERROR(at.labels);
  Results results;
  gp::Float32Error error;
  if (outputs.precision == EGOSIEVE_AUTO_PRECISION && count > 0 &&
      (outputs.needs_mean() || outputs.needs_variance())) {
    EGOSIEVE_ASSIGN_OR_RETURN(error, at.posterior->Error(outputs.needs_variance()));
    results.wide_means = !error.SufficesForMeans();
    results.wide_rest = outputs.needs_variance() && std::isinf(error.variance);
  } else if (outputs.precision == EGOSIEVE_IN_FLOAT64) {
    results.wide_means = true;
    results.wide_rest = outputs.needs_variance();
  }
  if (results.wide_rest) {
    results.rows.resize(count);
    std::iota(results.rows.begin(), results.rows.end(), int64_t{0});
  }
  results.mean.resize(outputs.needs_mean() ? count * at.outputs() : 0);
  results.variance.resize(outputs.needs_variance() ? count : 0);
  results.probability.resize(outputs.probability.wanted() ? count : 0);
  const int64_t piece = in_place ? std::max<int64_t>(count, 1) : kPiece;
  EGOSIEVE_RETURN_IF_ERROR(EvaluateInFloat32(at, count, piece, queries, outputs, error, results));
  EGOSIEVE_RETURN_IF_ERROR(EvaluateInFloat64(at, count, queries, outputs, results));
  if (outputs.of_observation) {
    const double noise = at.in_float32().hyperparameters().noise_variance();
    for (double& variance : results.variance) variance += noise;
  }
  // Nothing is written to the caller's arrays until all results are computed.
  for (const auto& [output, values] :
       {std::pair(&outputs.mean, &results.mean), std::pair(&outputs.variance, &results.variance),
        std::pair(&outputs.probability, &results.probability)}) {
    if (output->wanted()) output->Write(0, output->size(), values->data());
  }
  WriteField(&egosieve_prediction::clamped_variances, results.clamped, prediction);
  const bool all = results.wide_means && outputs.needs_mean();
  WriteField(&egosieve_prediction::float64_count,
             all ? count : static_cast<int64_t>(results.rows.size()), prediction);
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
