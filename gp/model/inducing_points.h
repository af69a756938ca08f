// Chooses m inducing inputs among n points by a pivoted Cholesky factorisation: the next point is
// the one that the points before explain least.
//
//   d_i = k_ii - |l_i|^2, p = argmax d, l_.p = (k_.p - L l_p) / sqrt(d_p)   (1)
//
// n m^2 flops; stops early when the largest d is under 1e-8 of the first.
//
// Reference: Fine & Scheinberg (2001), "Efficient SVM training using low-rank kernel
// representations".
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

// x: n x D, finite. Returns up to `count` inputs, one after another (rows x D): all n points if n
// <= count.
absl::StatusOr<std::vector<double>> ChooseInducingInputs(
    kernels::Context& context, const kernels::CovarianceParameters& covariance,
    kernels::ConstMatrixView<double> x, int64_t count);

}  // namespace egosieve::gp
