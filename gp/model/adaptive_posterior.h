// A posterior in float32 on devices, and in float64 where float32 does not suffice.
//
// Each covariance that a device computes has an error e_i from rounding, some u = 2^-24 of its
// size. So a query x has, to first order, with the weights alpha of the mean and beta = K_y^-1
// k*(x) (for a sparse model R^T R k*) of the variance,
//
//   error of the mean      sum_i alpha_i e_i + u O(partial sums of alpha.k* and the result)  (AP1)
//   error of the variance  2 sum_i beta_i e_i + u O(partial sums of L^-1 k*, k**)            (AP2)
//
// The worst case, |alpha|_1 max e and its like, is of no use: signs cancel, so that the errors are
// about |alpha|_2 e and |beta|_2 e, often a hundredth of it, and e differs between covariances,
// scales and devices. But e_i are fixed by the last bits of x and x_i, so that (AP1) at different x
// is a draw from one distribution. So is (AP2), but for |beta|_2, which is at most s(x) / sigma_n:
// the variance s(x)^2 = E (f(x) - beta.y)^2 has the part sigma_n^2 |beta|_2^2. Both widths are
// taken from S = 16 places x_s where the device's results are compared with those in float64: 8 of
// the model's inputs, evenly spaced in their order, and beside each, alternately, the middle
// between it and its successor and that middle's reflection in it.
//
//   E_mean = 4 rms_s error of the mean                                                      (AP3)
//   E_variance(x) = 4 rms_s error of the variance max(1, s(x) / min_s s(x_s),
//                   k**(x) / max_s k**(x_s))                                                (AP4)
//
// The root of a mean of 16 squares is known to 0.18 of itself (its deviation, for normal errors),
// so that E is 3.3 to 4.7 deviations of an error: of 1000 queries a few have a larger error, by
// little. No property of the covariance is used, so that this holds for every one. Rounding of the
// results to float32 counts. Where one of the 16 variances is clamped, its error is unknown, and
// E_variance infinite. The last factor of (AP4) is left out for functions with bounded k**. Float32
// suffices if
//
//   for the mean:      E_mean <= 0.01 min_s s(x_s): one decision for all queries             (AP5)
//   for the variance:  E_variance(x) <= 0.02 s(x)^2: an error of 0.01 s(x)                   (AP6)
//
// (AP6) is decided for each query by its own float32 variance. Both conditions depend on the model
// and the query alone: a query's result does not depend on the others of a call. A probability
// needs both.
//
// Cost: (AP3), (AP4) are measured once per posterior, at the first call that needs it: S n^2 flops
// and a call of S queries. On several devices they are those of the first.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "gp/model/float64_posterior.h"
#include "gp/model/posterior.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::gp {

// Of one posterior, in the units of y and of its square.
struct Float32Error {
  double mean = 0.0;       // E_mean
  double variance = 0.0;   // E_variance where the factor is 1; infinite: unknown
  double deviation = 0.0;  // min_s s(x_s)
  double prior = 0.0;      // max_s k**(x_s); 0: k** is bounded

  bool SufficesForMeans() const { return mean <= 0.01 * deviation; }  // (AP5)
};

class AdaptivePosterior {
 public:
  // Both of the same model.
  AdaptivePosterior(std::shared_ptr<const Posterior> in_float32,
                    std::shared_ptr<const Float64Posterior> in_float64)
      : in_float32_(std::move(in_float32)), in_float64_(std::move(in_float64)) {}

  const Posterior& in_float32() const { return *in_float32_; }
  const Float64Posterior& in_float64() const { return *in_float64_; }

  // (AP3), (AP4). with_variance: `variance` is needed; else it may be 0. Zero for a model without
  // points, infinite for one without a factor, whose deviations are unknown.
  absl::StatusOr<Float32Error> Error(bool with_variance) const;

  // Appends `first` + i for every query i that (AP6) refuses. variances: of the queries, in
  // float32.
  template <typename Query>
  void FindInsufficient(const Float32Error& error, kernels::ConstMatrixView<Query> queries,
                        const float* variances, int64_t first, std::vector<int64_t>& rows) const;

 private:
  // The places x_s and their results in float64.
  struct Places {
    std::vector<double> points, means, variances;
    Float32Error error;
    bool has_variance_error = false;
  };

  absl::StatusOr<Places> MakePlaces() const;

  std::shared_ptr<const Posterior> in_float32_;
  std::shared_ptr<const Float64Posterior> in_float64_;
  mutable std::mutex mutex_;  // guards the measurement
  mutable std::optional<Places> measured_;
};

}  // namespace egosieve::gp
