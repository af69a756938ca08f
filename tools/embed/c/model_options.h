// The caller's egosieve_gp_options as options of the model and of its posterior. All errors are
// InvalidArgument and name the field.
#ifndef EGOSIEVE_TOOLS_EMBED_C_MODEL_OPTIONS_H_
#define EGOSIEVE_TOOLS_EMBED_C_MODEL_OPTIONS_H_

#include <optional>

#include "absl/status/statusor.h"
#include "gp/covariance/hyperparameters.h"
#include "gp/model/sparse_model.h"
#include "kernels/ops/dense_posterior.h"
#include "tools/embed/include/egosieve/gaussian_process.h"

namespace egosieve::embed {

absl::StatusOr<gp::Hyperparameters> HyperparametersOf(const egosieve_gp_options& options);
// Nothing for an exact model.
absl::StatusOr<std::optional<gp::SparseModelOptions>> SparseOptionsOf(
    const egosieve_gp_options& options);
absl::StatusOr<kernels::DensePosteriorOptions> PosteriorOptionsOf(
    const egosieve_gp_options& options);

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_MODEL_OPTIONS_H_
