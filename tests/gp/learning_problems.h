// Seeded learning problems, the default device, and GPML's demonstration data.
#pragma once

#include <cmath>
#include <iterator>
#include <memory>
#include <random>
#include <vector>

#include "gp/covariance/hyperparameters.h"
#include "gp/model/regression_model.h"
#include "kernels/base/status_macros.h"
#include "kernels/reference/covariance.h"
#include "kernels/runtime/context.h"
#include "tests/gp/linalg/random_matrices.h"
#include "tests/testing/status.h"

namespace egosieve::gp {

inline std::shared_ptr<kernels::Context> TestContext() {
  static const auto context = Value(kernels::OpenContext());
  return context;
}

struct Prediction {
  std::vector<double> mean;       // M x k
  std::vector<double> variance;   // of f, M; empty if not requested
  int64_t clamped_variances = 0;  // negative from rounding, set to 0
};

// The model's posterior in float64 at M x D points.
inline absl::StatusOr<Prediction> Predict(const RegressionModel& model,
                                          kernels::ConstMatrixView<double> points,
                                          PredictWhat what) {
  EGOSIEVE_ASSIGN_OR_RETURN(const auto posterior, model.MakeFloat64Posterior());
  Prediction prediction;
  prediction.mean.resize(points.rows * model.outputs());
  const bool wants_variance = what == PredictWhat::kMeanAndVariance;
  if (wants_variance) prediction.variance.resize(points.rows);
  EGOSIEVE_ASSIGN_OR_RETURN(
      prediction.clamped_variances,
      posterior->Evaluate(points, prediction.mean.data(),
                          wants_variance ? prediction.variance.data() : nullptr));
  return prediction;
}

struct LabelledPoints {
  RowMatrix inputs;
  std::vector<double> labels;  // in [0, 1]
  std::vector<double> targets() const {
    std::vector<double> y(labels);
    for (double& value : y) value = 2.0 * value - 1.0;
    return y;
  }
};

// Points in [-1, 1]^D; those with x_0 + x_1^2 > 1/2 (about one in four) are labelled high, with a
// tenth of the labels the wrong way round, all of them soft.
inline LabelledPoints NoisyBlobs(int64_t n, int64_t dimension, std::mt19937_64& generator) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  LabelledPoints points{.inputs = RandomPoints(n, dimension, generator)};
  for (int64_t i = 0; i < n; ++i) {
    const double u = points.inputs(i, 0);
    const double v = dimension > 1 ? points.inputs(i, 1) : 0.0;
    const bool high = (u + v * v > 0.5) != (uniform(generator) < 0.1);
    points.labels.push_back(high ? 0.7 + 0.3 * uniform(generator) : 0.3 * uniform(generator));
  }
  return points;
}

// Hyperparameters with no two scales alike.
inline Hyperparameters UnevenHyperparameters(kernels::CovarianceFunction function,
                                             int64_t dimension) {
  Hyperparameters hyperparameters = DefaultHyperparameters(function, dimension);
  double factor = 0.7;
  for (double& scale : hyperparameters.covariance.scales) scale *= factor *= 1.1;
  hyperparameters.covariance.signal_stddev = 1.3;
  hyperparameters.noise_stddev = 0.3;
  return hyperparameters;
}

inline constexpr double kGpmlDemo[20][2] = {
    {2.0839704277507316, 4.5492037463316981},    {-0.8210180661013794, 0.37198557443727098},
    {-0.61787069918259718, 0.7113079655147897},  {-1.183822608860694, -0.013212893618429908},
    {0.27408744227714388, 2.2554732553381913},   {0.59944172929559258, 1.0099157492957327},
    {1.7688979192044354, 3.7446759379650287},    {-0.46564554903192845, 0.4245927717932016},
    {0.58885278437593536, 1.3228336522958108},   {-0.83298221443805442, 0.27829829351001956},
    {-0.51210652796036327, 0.26722913094557377}, {0.27788314421011562, 2.2001122867238352},
    {-0.065870426922211331, 1.2006099833090067}, {-0.82141236380632532, 0.43997169723618523},
    {0.18539944377808751, 2.6285804335113081},   {-0.85829617499599753, 0.50377481733922291},
    {0.37078663003705881, 1.9425253138205281},   {-1.4098691624166388, 0.57913395001243706},
    {-0.14466841232502181, 0.67087442396856956}, {-0.55329961522037407, 0.3773537551002753},
};

struct RegressionData {
  RowMatrix inputs;
  std::vector<double> targets;
};

// The 20 points of GPML's regression demonstration.
inline RegressionData GpmlDemo() {
  RegressionData data;
  data.inputs.resize(std::size(kGpmlDemo), 1);
  for (const auto& [x, y] : kGpmlDemo) {
    data.inputs(static_cast<int64_t>(data.targets.size()), 0) = x;
    data.targets.push_back(y);
  }
  return data;
}

// covNNone with (log ell, log sf) and log sigma_n: 2 Sigma = I / ell^2.
inline Hyperparameters GpmlNeuralNetwork(double log_ell, double log_sf, double log_noise) {
  Hyperparameters hyperparameters;
  hyperparameters.covariance.function = kernels::CovarianceFunction::kArcsine;
  hyperparameters.covariance.scales.assign(2, std::exp(-log_ell) * M_SQRT1_2);
  hyperparameters.covariance.signal_stddev = std::exp(log_sf);
  hyperparameters.noise_stddev = std::exp(log_noise);
  return hyperparameters;
}

// k(a_i, b_j), by the reference.
inline RowMatrix Covariances(const Hyperparameters& theta, const RowMatrix& a, const RowMatrix& b) {
  RowMatrix k(a.rows(), b.rows());
  kernels::reference::CovarianceBlock(theta.covariance, ViewOf(a), ViewOf(b), false, ViewOf(k));
  return k;
}

// The same of one set, with the noise.
inline RowMatrix GramOf(const Hyperparameters& theta, const RowMatrix& x) {
  RowMatrix k = Covariances(theta, x, x);
  k.diagonal().array() += theta.noise_variance();
  return k;
}

}  // namespace egosieve::gp
