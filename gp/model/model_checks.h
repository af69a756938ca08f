// Checks that all models share, of context, hyperparameters and labelled points.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/point_set.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

// InvalidArgument if there is no context or the hyperparameters are invalid.
absl::Status CheckSetUp(const kernels::Context* context, const Hyperparameters& hyperparameters);

// Unimplemented, naming the kind of model, for mean functions but zero.
absl::Status CheckZeroMean(const char* kind, const Hyperparameters& hyperparameters);

// InvalidArgument unless the hyperparameters are valid and fit a model with `size` points of
// `dimension` inputs.
absl::Status CheckReplacement(const Hyperparameters& hyperparameters, int64_t size,
                              int64_t dimension);

// InvalidArgument unless the observations are valid and have as many outputs as the model's points,
// if there are any.
absl::Status CheckAddition(const Observations& added, const PointSet& points, int64_t dimension);

// Replaces the targets of the points. InvalidArgument, unchanged, unless the numbers of points and
// outputs are as before and all targets finite.
absl::Status ReplaceTargets(kernels::ConstMatrixView<double> targets, int64_t dimension,
                            PointSet& points);

}  // namespace egosieve::gp
