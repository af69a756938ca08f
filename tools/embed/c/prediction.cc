// Predictions from a posterior into the caller's arrays. Queries that are packed float32 are
// computed in one pass, others in pieces of 2^16 in float64. What needs float64 arithmetic, by the
// caller's wish or by gp/model/adaptive_posterior.h, is computed in a second pass. A query's result
// does not depend on other queries, so the pieces do not affect the results.
//
// Nothing is written until all results are computed, in memory of the call's own.
#include "tools/embed/include/egosieve/prediction.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "tools/embed/c/array_access.h"
#include "tools/embed/c/learning_model.h"
#include "vision/image/box_means.h"
#include "vision/image/image_grid.h"

namespace egosieve::embed {
namespace {

constexpr int64_t kPiece = int64_t{1} << 16;
constexpr int64_t kImageInputs = vision::kBoxMeanColumns;

// The requested outputs, checked against the shape of the result. The mean has `outputs_of_model`
// times the columns of the others.
struct Outputs {
  OutputArray mean, variance, probability;
  bool of_observation, needs_mean, needs_variance;
  int64_t precision;

  Outputs(const egosieve_prediction* prediction, int64_t rows, int64_t columns,
          int64_t outputs_of_model = 1) {
    const auto wishes = Read("prediction", prediction, egosieve_prediction_init);
    mean = {"prediction.mean", &wishes.mean, rows, columns * outputs_of_model};
    variance = {"prediction.variance", &wishes.variance, rows, columns};
    probability = {"prediction.probability", &wishes.probability, rows, columns};
    of_observation = wishes.of_observation != 0;
    needs_mean = mean.wanted() || probability.wanted();
    needs_variance = variance.wanted() || probability.wanted();
    precision = wishes.precision;
    Require(precision >= EGOSIEVE_AUTO_PRECISION && precision <= EGOSIEVE_IN_FLOAT32,
            "prediction.precision = %d; it must be EGOSIEVE_AUTO_PRECISION, EGOSIEVE_IN_FLOAT64 or "
            "EGOSIEVE_IN_FLOAT32",
            precision);
  }
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
void EvaluateInFloat32(const DevicePosterior& at, int64_t count, int64_t piece,
                       const Queries<T>& queries, const Outputs& outputs,
                       const gp::Float32Error& error, Results& results) {
  const bool rest = outputs.needs_variance && !results.wide_rest;
  const bool means = outputs.mean.wanted() && !results.wide_means;
  if (!rest && !means) return;
  const bool checks = rest && outputs.precision == EGOSIEVE_AUTO_PRECISION;
  const auto room = [](bool wanted, int64_t size, std::vector<float>& values) {
    values.resize(wanted ? size : 0);
    return wanted ? values.data() : nullptr;
  };
  std::vector<T> scratch;
  std::vector<float> mean, variance, probability;
  for (int64_t begin = 0; begin < count; begin += piece) {
    const int64_t end = std::min(begin + piece, count), size = end - begin;
    const kernels::ConstMatrixView<T> points = queries(begin, end, scratch);
    results.clamped +=
        Take(at.in_float32().Evaluate(
                 points, {room(means, size * at.outputs(), mean),
                          room(rest && (outputs.variance.wanted() || checks), size, variance),
                          room(rest && outputs.probability.wanted(), size, probability)}))
            .clamped_variances;
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
}

// The means of all places where they are wanted, and the other results of `results.rows`.
template <typename T>
void EvaluateInFloat64(const DevicePosterior& at, int64_t count, const Queries<T>& queries,
                       const Outputs& outputs, Results& results) {
  const int64_t columns = at.outputs();
  const bool means = results.wide_means && outputs.needs_mean;
  std::vector<T> scratch;
  size_t next = 0;  // of results.rows
  for (int64_t begin = 0; begin < count; begin += kPiece) {
    const int64_t end = std::min(begin + kPiece, count);
    std::vector<int64_t> places,
        others;  // of results.rows, and those whose mean alone is computed
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
      results.clamped += Take(at.posterior->in_float64().Evaluate(
          {x.data(), static_cast<int64_t>(to->size()), points.cols}, mean.data(),
          with_variance ? variance.data() : nullptr));
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
}

template <typename T>
void Evaluate(const DevicePosterior& at, int64_t count, bool in_place, const Queries<T>& queries,
              const Outputs& outputs, egosieve_prediction* prediction) {
  if (outputs.probability.wanted()) Check(at.labels);
  Results results;
  gp::Float32Error error;
  if (outputs.precision == EGOSIEVE_AUTO_PRECISION && count > 0 &&
      (outputs.needs_mean || outputs.needs_variance)) {
    error = Take(at.posterior->Error(outputs.needs_variance));
    results.wide_means = !error.SufficesForMeans();
    results.wide_rest = outputs.needs_variance && std::isinf(error.variance);
  } else if (outputs.precision == EGOSIEVE_IN_FLOAT64) {
    results.wide_means = true;
    results.wide_rest = outputs.needs_variance;
  }
  if (results.wide_rest) {
    results.rows.resize(count);
    std::iota(results.rows.begin(), results.rows.end(), int64_t{0});
  }
  results.mean.resize(outputs.needs_mean ? count * at.outputs() : 0);
  results.variance.resize(outputs.needs_variance ? count : 0);
  results.probability.resize(outputs.probability.wanted() ? count : 0);
  const int64_t piece = in_place ? std::max<int64_t>(count, 1) : kPiece;
  EvaluateInFloat32(at, count, piece, queries, outputs, error, results);
  EvaluateInFloat64(at, count, queries, outputs, results);
  if (outputs.of_observation) {
    const double noise = at.in_float32().hyperparameters().noise_variance();
    for (double& variance : results.variance) variance += noise;
  }
  outputs.mean.Write(results.mean);
  outputs.variance.Write(results.variance);
  outputs.probability.Write(results.probability);
  WriteField(&egosieve_prediction::clamped_variances, results.clamped, prediction);
  const bool all = results.wide_means && outputs.needs_mean;
  WriteField(&egosieve_prediction::float64_count,
             all ? count : static_cast<int64_t>(results.rows.size()), prediction);
}

void CheckDimension(const DevicePosterior& at, int64_t needed, const char* what) {
  RequireState(at.outputs() == 1, "%s needs a model of one output; this one has %d", what,
               at.outputs());
  RequireState(at.dimension() == needed, "%s needs a model of %d inputs; this one has %d", what,
               needed, at.dimension());
}

void PredictPoints(const DevicePosterior& at, const egosieve_const_array* x,
                   egosieve_prediction* prediction) {
  const auto points = InputArray::Points("x", x, at.dimension());
  const Outputs outputs(prediction, points.rows(), 1, at.outputs());
  points.CheckFinite<float>();
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
  Evaluate(at, points.rows(), false, copied, outputs, prediction);
}

void PredictGrid(const DevicePosterior& at, const egosieve_grid* grid,
                 egosieve_prediction* prediction) {
  constexpr int64_t kMaximumPoints = int64_t{1} << 40;
  RequirePointer("grid", grid);
  const double x0 = grid->x0, y0 = grid->y0, dx = grid->dx, dy = grid->dy;
  const int64_t rows = grid->rows, columns = grid->columns;
  Require(rows >= 1 && columns >= 1 && rows <= kMaximumPoints / columns,
          "grid: %d rows x %d columns; each must be at least 1, and points at most 2^40", rows,
          columns);
  const auto x = [=](int64_t column) { return x0 + static_cast<double>(column) * dx; };
  const auto y = [=](int64_t row) { return y0 + static_cast<double>(row) * dy; };
  for (const double end : {x(0), x(columns - 1), y(0), y(rows - 1)}) {
    Require(std::isfinite(static_cast<float>(end)),
            "grid: (%g, %g) in steps of (%g, %g); its points must be finite in float32", x0, y0, dx,
            dy);
  }
  CheckDimension(at, 2, "a grid");
  const Outputs outputs(prediction, rows, columns);
  const Queries<double> queries = [&](int64_t begin, int64_t end, std::vector<double>& scratch) {
    scratch.resize((end - begin) * 2);
    for (int64_t k = begin; k < end; ++k) {
      scratch[(k - begin) * 2] = x(k % columns);
      scratch[(k - begin) * 2 + 1] = y(k / columns);
    }
    return kernels::ConstMatrixView<double>(scratch.data(), end - begin, 2);
  };
  Evaluate(at, rows * columns, false, queries, outputs, prediction);
}

void PredictImage(const DevicePosterior& at, const egosieve_image* image, int32_t stride,
                  egosieve_prediction* prediction) {
  std::vector<uint8_t> storage;
  const vision::ImageView view = ViewImage("image", image, storage);
  Require(stride >= 1 && stride <= 16384, "stride = %d pixels; it must be 1 to 16384", stride);
  CheckDimension(at, kImageInputs, "an image");
  const vision::ImageGrid grid{view.width, view.height, stride};
  const Outputs outputs(prediction, grid.rows(), grid.columns());
  const std::vector<float> field = vision::BoxMeansOnGrid(view, grid);
  const Queries<float> queries = [&](int64_t begin, int64_t end, std::vector<float>&) {
    return kernels::ConstMatrixView<float>(&field[begin * kImageInputs], end - begin, kImageInputs);
  };
  Evaluate(at, grid.size(), true, queries, outputs, prediction);
}

// One of the above, from a posterior or that of a model's current state.
template <typename Handle, typename... Parameters>
egosieve_status PredictBy(void (*predict)(const DevicePosterior&, Parameters...),
                          const char* function, Handle* handle, Parameters... arguments) {
  return With(function, handle, [&](auto& found) {
    if constexpr (std::is_same_v<Handle, egosieve_gp>) {
      predict(found.Posterior(), arguments...);
    } else {
      predict(found, arguments...);
    }
  });
}

}  // namespace

extern "C" {

void egosieve_prediction_init(egosieve_prediction* prediction) { Initialise(prediction); }

egosieve_status egosieve_gp_predict(egosieve_gp* gp, const egosieve_const_array* x,
                                    egosieve_prediction* prediction) {
  return PredictBy(PredictPoints, __func__, gp, x, prediction);
}

egosieve_status egosieve_gp_predict_grid(egosieve_gp* gp, const egosieve_grid* grid,
                                         egosieve_prediction* prediction) {
  return PredictBy(PredictGrid, __func__, gp, grid, prediction);
}

egosieve_status egosieve_gp_predict_image(egosieve_gp* gp, const egosieve_image* image,
                                          int32_t stride, egosieve_prediction* prediction) {
  return PredictBy(PredictImage, __func__, gp, image, stride, prediction);
}

egosieve_status egosieve_posterior_predict(egosieve_posterior* posterior,
                                           const egosieve_const_array* x,
                                           egosieve_prediction* prediction) {
  return PredictBy(PredictPoints, __func__, posterior, x, prediction);
}

egosieve_status egosieve_posterior_predict_grid(egosieve_posterior* posterior,
                                                const egosieve_grid* grid,
                                                egosieve_prediction* prediction) {
  return PredictBy(PredictGrid, __func__, posterior, grid, prediction);
}

egosieve_status egosieve_posterior_predict_image(egosieve_posterior* posterior,
                                                 const egosieve_image* image, int32_t stride,
                                                 egosieve_prediction* prediction) {
  return PredictBy(PredictImage, __func__, posterior, image, stride, prediction);
}

egosieve_status egosieve_gp_describe_pixels(egosieve_gp* gp, const egosieve_image* image,
                                            const egosieve_const_array* places,
                                            const egosieve_array* out) {
  return With(__func__, gp, [&](LearningModel&) {
    std::vector<uint8_t> storage;
    const vision::ImageView view = ViewImage("image", image, storage);
    const InputArray points("places", places);
    Require(points.columns() == 2, "places: %d columns; a place is (x, y)", points.columns());
    points.CheckFinite<double>();
    const OutputArray output("out", out, points.rows(), kImageInputs);
    Require(output.wanted(), "out.data is null");
    const std::vector<double> at = points.Values();
    const absl::StatusOr<std::vector<float>> descriptors =
        vision::BoxMeansAt(view, {at.data(), points.rows(), 2});
    Check(Named("places", descriptors.status()));
    output.Write(*descriptors);
  });
}

egosieve_status egosieve_gp_posterior(egosieve_gp* gp, egosieve_posterior** posterior) {
  return NewFrom(__func__, gp, posterior, [](LearningModel& model) {
    return std::make_shared<const DevicePosterior>(model.Posterior());
  });
}

egosieve_status egosieve_posterior_float32_error(egosieve_posterior* posterior, double* mean,
                                                 double* variance, double* deviation) {
  return With(__func__, posterior, [&](const DevicePosterior& found) {
    const gp::Float32Error error = Take(found.posterior->Error(/*with_variance=*/true));
    if (mean != nullptr) *mean = error.mean;
    if (variance != nullptr) *variance = error.variance;
    if (deviation != nullptr) *deviation = error.deviation;
  });
}

egosieve_status egosieve_posterior_free(egosieve_posterior* posterior) {
  return Free(__func__, posterior);
}

}  // extern "C"

}  // namespace egosieve::embed
