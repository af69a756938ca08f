#include "tools/embed/c/prediction.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

#include "absl/strings/str_format.h"
#include "absl/types/span.h"
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

// A call's results in float32, and those in float64 that take their place.
struct Results {
  std::vector<float> mean, variance, probability;
  bool wide_means = false;  // all means are in float64
  bool wide_rest = false;   // and all variances and probabilities
  std::vector<double> wide_mean;
  std::vector<int64_t> rows;  // places whose variance and probability are in float64, increasing
  std::vector<double> rows_mean, rows_variance;
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
  const auto room = [](bool wanted, int64_t size) { return std::vector<float>(wanted ? size : 0); };
  results.mean = room(means, outputs.mean.size());
  results.variance = room(rest && (outputs.variance.wanted() || checks), count);
  results.probability = room(rest && outputs.probability.wanted(), count);
  const auto from = [](std::vector<float>& values, int64_t begin) {
    return values.empty() ? nullptr : values.data() + begin;
  };
  std::vector<T> scratch;
  for (int64_t begin = 0; begin < count; begin += piece) {
    const int64_t end = std::min(begin + piece, count);
    const kernels::ConstMatrixView<T> points = queries(begin, end, scratch);
    EGOSIEVE_ASSIGN_OR_RETURN(
        const kernels::PosteriorCounts counts,
        at.in_float32().Evaluate(
            points, {from(results.mean, begin * at.outputs()), from(results.variance, begin),
                     from(results.probability, begin)}));
    results.clamped += counts.clamped_variances;
    if (checks) {
      at.posterior->FindInsufficient(error, points, &results.variance[begin], begin, results.rows);
    }
  }
  // A place that is computed again is not counted twice.
  for (const int64_t row : results.rows) {
    results.clamped -= checks && results.variance[row] == 0.0f;
  }
  results.clamped = std::max<int64_t>(results.clamped, 0);
  return absl::OkStatus();
}

// Rows of `points`, which begin with the call's place `first`, in float64.
template <typename T>
std::vector<double> Gather(kernels::ConstMatrixView<T> points, int64_t first,
                           absl::Span<const int64_t> places) {
  std::vector<double> rows;
  rows.reserve(places.size() * points.cols);
  for (const int64_t place : places) {
    const T* x = points.row(place - first);
    rows.insert(rows.end(), x, x + points.cols);
  }
  return rows;
}

// The means of all places where they are wanted, and mean and variance of `results.rows`.
template <typename T>
absl::Status EvaluateInFloat64(const DevicePosterior& at, int64_t count, const Queries<T>& queries,
                               const Outputs& outputs, Results& results) {
  const gp::Float64Posterior& posterior = at.posterior->in_float64();
  const int64_t columns = at.outputs();
  const bool means = results.wide_means && outputs.needs_mean();
  results.wide_mean.resize(means ? count * columns : 0);
  results.rows_mean.resize(results.rows.size() * columns);
  results.rows_variance.resize(results.rows.size());
  std::vector<T> scratch;
  std::vector<int64_t> others;
  size_t next = 0;  // of results.rows
  for (int64_t begin = 0; begin < count; begin += kPiece) {
    const int64_t end = std::min(begin + kPiece, count);
    const size_t first = next;
    others.clear();
    for (int64_t i = begin; i < end; ++i) {
      if (next < results.rows.size() && results.rows[next] == i) {
        ++next;
      } else if (means) {
        others.push_back(i);
      }
    }
    if (next == first && others.empty()) continue;
    const kernels::ConstMatrixView<T> points = queries(begin, end, scratch);
    const auto evaluate = [&](absl::Span<const int64_t> places, double* mean, double* variance) {
      const std::vector<double> x = Gather(points, begin, places);
      return posterior.Evaluate({x.data(), static_cast<int64_t>(places.size()), points.cols}, mean,
                                variance);
    };
    const absl::Span<const int64_t> places(results.rows.data() + first, next - first);
    EGOSIEVE_ASSIGN_OR_RETURN(const int64_t clamped,
                              evaluate(places, results.rows_mean.data() + first * columns,
                                       results.rows_variance.data() + first));
    results.clamped += clamped;
    std::vector<double> mean(others.size() * columns);
    EGOSIEVE_RETURN_IF_ERROR(evaluate(others, mean.data(), nullptr).status());
    const auto put = [&](absl::Span<const int64_t> to, const double* values) {
      for (size_t i = 0; means && i < to.size(); ++i) {
        std::copy_n(values + i * columns, columns, &results.wide_mean[to[i] * columns]);
      }
    };
    put(places, results.rows_mean.data() + first * columns);
    put(others, mean.data());
  }
  return absl::OkStatus();
}

// Writes float32 values, and then those in float64 to their rows.
void Write(const OutputArray& output, const std::vector<float>& values,
           const std::vector<int64_t>& rows, const std::vector<double>& of_rows) {
  if (!output.wanted()) return;
  if (!values.empty()) output.Write(0, output.size(), values.data());
  for (size_t begin = 0, end = 0; begin < rows.size(); begin = end) {
    for (end = begin + 1; end < rows.size() && rows[end] == rows[end - 1] + 1;) ++end;
    output.Write(rows[begin], rows[end - 1] + 1, &of_rows[begin]);
  }
}

void WriteProbabilities(const gp::SquashParameters& squash, const OutputArray& output,
                        const Results& results) {
  std::vector<double> of_rows;
  for (size_t i = 0; i < results.rows.size(); ++i) {
    of_rows.push_back(squash.Probability(results.rows_mean[i], results.rows_variance[i]));
  }
  if (results.wide_rest || !results.wide_means) {
    return Write(output, results.probability, results.rows, of_rows);
  }
  // The means alone are in float64 where the variances suffice.
  std::vector<double> all(results.wide_mean.size());
  for (size_t i = 0, next = 0; i < all.size(); ++i) {
    const bool is_row = next < results.rows.size() && results.rows[next] == static_cast<int64_t>(i);
    all[i] =
        is_row ? of_rows[next++] : squash.Probability(results.wide_mean[i], results.variance[i]);
  }
  output.Write(0, output.size(), all.data());
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
  const int64_t piece = in_place ? std::max<int64_t>(count, 1) : kPiece;
  EGOSIEVE_RETURN_IF_ERROR(EvaluateInFloat32(at, count, piece, queries, outputs, error, results));
  EGOSIEVE_RETURN_IF_ERROR(EvaluateInFloat64(at, count, queries, outputs, results));
  // Nothing is written to the caller's arrays until all results are computed.
  if (outputs.probability.wanted()) {
    WriteProbabilities(at.in_float32().squash(), outputs.probability, results);
  }
  if (outputs.of_observation) {
    at.in_float32().AddNoiseVariance(absl::MakeSpan(results.variance));
    for (double& variance : results.rows_variance) {
      variance += at.in_float32().hyperparameters().noise_variance();
    }
  }
  Write(outputs.variance, results.variance, results.rows, results.rows_variance);
  if (!results.wide_mean.empty() && outputs.mean.wanted()) {
    outputs.mean.Write(0, outputs.mean.size(), results.wide_mean.data());
  } else {
    Write(outputs.mean, results.mean, {}, {});
  }
  WriteField(&egosieve_prediction::clamped_variances, results.clamped, prediction);
  const int64_t in_float64 =
      results.wide_mean.empty() ? static_cast<int64_t>(results.rows.size()) : count;
  WriteField(&egosieve_prediction::float64_count, in_float64, prediction);
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
