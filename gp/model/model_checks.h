// What every model checks before it takes a device, hyperparameters or labelled points.
#ifndef EGOSIEVE_GP_MODEL_MODEL_CHECKS_H_
#define EGOSIEVE_GP_MODEL_MODEL_CHECKS_H_

#include <cstdint>

#include "absl/status/status.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/point_set.h"
#include "kernels/base/matrix_view.h"
#include "kernels/runtime/context.h"

namespace egosieve::gp {

// InvalidArgument where there is no context or the hyperparameters are not valid.
absl::Status CheckSetUp(const kernels::Context* context, const Hyperparameters& hyperparameters);

// InvalidArgument unless the hyperparameters are valid and fit the `size` points of `dimension`
// inputs that a model holds.
absl::Status CheckReplacement(const Hyperparameters& hyperparameters, int64_t size,
                              int64_t dimension);

// InvalidArgument unless the observations are valid and, where there are points, of as many outputs
// as these.
absl::Status CheckAddition(const Observations& added, const PointSet& points, int64_t dimension);

// Gives the points new targets. InvalidArgument, unchanged, unless there are as many and of as many
// outputs as before, all finite.
absl::Status ReplaceTargets(kernels::ConstMatrixView<double> targets, int64_t dimension,
                            PointSet& points);

}  // namespace egosieve::gp

#endif  // EGOSIEVE_GP_MODEL_MODEL_CHECKS_H_
