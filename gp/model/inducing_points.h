// Chooses m inducing inputs among n points.
//
//   kPivotedCholesky   greedy: the next point is the one that the points before explain least:
//                      d_i = k_ii - |l_i|^2, p = argmax d, l_.p = (k_.p - L l_p) / sqrt(d_p)   (1)
//                      n m^2 flops; stops early when the largest d is under 1e-8 of the first
//   kKMeans            centres of m clusters of the inputs, by Lloyd's iterations from a random
//                      start; they are not points of the data
//   kRandom            m points, seeded
//
// References: Fine & Scheinberg (2001), "Efficient SVM training using low-rank kernel
// representations" for (1); Quinonero-Candela & Rasmussen (2005), section 9.
#ifndef EGOSIEVE_GP_MODEL_INDUCING_POINTS_H_
#define EGOSIEVE_GP_MODEL_INDUCING_POINTS_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/base/covariance_parameters.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

enum class InducingChoice { kPivotedCholesky, kKMeans, kRandom };

// x: n x D, finite. Returns up to `count` inputs, one after another (rows x D): all n points if n
// <= count. Deterministic for a seed.
absl::StatusOr<std::vector<double>> ChooseInducingInputs(
    kernels::Context& context, const kernels::CovarianceParameters& covariance,
    kernels::ConstMatrixView<double> x, int64_t count, InducingChoice choice, uint64_t seed);

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_MODEL_INDUCING_POINTS_H_
