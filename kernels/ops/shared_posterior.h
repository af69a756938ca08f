// One posterior on several devices: the queries of a call are shared out among them in pieces, one
// to each device first, and then to the one that is done.
//
// A query's result is that of the device that computed it, to the bit; devices of different kinds
// agree within the errors of kernels/ops/dense_posterior.h. Memory: the model on each device, and
// the results once more on the host, since a device may fail in any piece and nothing is written
// then.
#ifndef EGOSIEVE_KERNELS_OPS_SHARED_POSTERIOR_H_
#define EGOSIEVE_KERNELS_OPS_SHARED_POSTERIOR_H_

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/ops/dense_posterior.h"

namespace egosieve::kernels {

// Queries of a piece, of M queries on `devices` devices: eight pieces a device where that leaves
// 1,024 queries or more.
int64_t SharedPiece(int64_t query_count, int64_t devices);

// Errors as for DensePosterior::Create; InvalidArgument without a context. Enqueue of what is made
// is FailedPrecondition: a queue belongs to one device.
absl::StatusOr<std::unique_ptr<DensePosterior>> CreateSharedPosterior(
    const std::vector<std::shared_ptr<Context>>& contexts, const PosteriorModel& model,
    const DensePosteriorOptions& options = {});

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_OPS_SHARED_POSTERIOR_H_
