// One posterior on several devices. The queries of a call are divided into pieces: first one for
// each device, and then the next one for each device that has finished.
//
// A query's result equals that of the device that computed it, to the bit; devices of different
// kinds agree within the errors of kernels/ops/dense_posterior.h. Memory: the model on each device,
// and a second copy of the results on the host, since a device may fail in any piece and nothing
// may be written then.
#ifndef EGOSIEVE_KERNELS_OPS_SHARED_POSTERIOR_H_
#define EGOSIEVE_KERNELS_OPS_SHARED_POSTERIOR_H_

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/ops/dense_posterior.h"

namespace egosieve::kernels {

// Queries per piece, for M queries on `devices` devices: eight pieces per device, if each then has
// at least 1,024 queries.
int64_t SharedPiece(int64_t query_count, int64_t devices);

// Errors as for DensePosterior::Create; InvalidArgument without a context. Enqueue on the result is
// FailedPrecondition, since a queue belongs to one device.
absl::StatusOr<std::unique_ptr<DensePosterior>> CreateSharedPosterior(
    const std::vector<std::shared_ptr<Context>>& contexts, const PosteriorModel& model,
    const DensePosteriorOptions& options = {});

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_OPS_SHARED_POSTERIOR_H_
