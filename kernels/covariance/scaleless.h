// Functions without scales that are 1 at x = x'.
#pragma once

#include <cstdint>

#include "kernels/covariance/covariance_function.h"

namespace egosieve::kernels {

// The function is constant wherever it is smooth, so that all gradients are 0.
class Scaleless : public CovarianceDescription {
 public:
  Scaleless() : CovarianceDescription({}) {}

  void AddGradient(int64_t /*dimension*/, const double* /*a*/, const double* /*b*/,
                   double /*weight*/, double* /*gradient*/) const override {}
  void AddInputGradient(const double* /*scales*/, int64_t /*dimension*/, const double* /*a*/,
                        const double* /*b*/, double /*weight*/,
                        double* /*gradient*/) const override {}
  double Variance(const double* /*scales*/, int64_t /*dimension*/,
                  const double* /*x*/) const override {
    return 1.0;
  }
};

}  // namespace egosieve::kernels
