// Covariance functions for tests: every one that is registered, and compositions nested three deep.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "kernels/base/covariance_parameters.h"
#include "kernels/covariance/covariance_function.h"
#include "tests/testing/status.h"

namespace egosieve::kernels {

inline std::vector<std::string> Compositions() {
  return {"isotropic(matern52)",
          "isotropic(rational_quadratic) + white",
          "matern32 * periodic",
          "linear * isotropic(squared_exponential) + constant",
          "(squared_exponential + matern12 * (linear + constant)) * isotropic(periodic + arcsine)",
          "matern52 * (periodic + linear)[0]",
          "isotropic(matern32) * squared_exponential + constant + matern12[0]",
          "isotropic((arcsine + matern52) * (periodic + white * (constant + linear)))"};
}

// Of five inputs, not all of which matter.
inline constexpr char kOfColumns[] =
    "squared_exponential[3] * isotropic(matern32)[0,2] + (periodic + linear)[4]";

inline std::vector<std::string> Expressions() {
  std::vector<std::string> all = CovarianceFunction::Names();
  for (const std::string& composition : Compositions()) all.push_back(composition);
  return all;
}

inline CovarianceFunction Function(const std::string& text) {
  return Value(CovarianceFunction::Parse(text));
}

// Scales of which no two are alike. For inputs in [-1, 1], distances over length-scales and weighted
// inputs are of the order of one, whatever D; a length on the circle is one per input without a
// unit.
inline CovarianceParameters ParametersOf(const std::string& text, int64_t dimension) {
  CovarianceParameters parameters{
      .function = Function(text), .signal_stddev = 1.3, .dimension = dimension};
  const double root = std::sqrt(static_cast<double>(dimension));
  double factor = 0.8;
  for (const ScaleGroup& group : parameters.function.description().scale_groups()) {
    for (int64_t i = 0; i < group.ScaleCount(dimension); ++i) {
      factor = factor > 1.3 ? 0.8 : 1.07 * factor;
      const double unit = group.unit == ScaleGroup::Unit::kInverseInput               ? 1.0 / root
                          : group.unit == ScaleGroup::Unit::kInput || group.per_input ? root
                                                                                      : 1.0;
      parameters.scales.push_back(factor * unit);
    }
  }
  return parameters;
}

}  // namespace egosieve::kernels
