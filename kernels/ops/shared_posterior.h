// One posterior on several devices. The queries of a call are divided into pieces: first one for
// each device, and then the next one for each device that has finished.
//
// A query's result equals that of the device that computed it, to the bit; devices of different
// kinds agree within the errors of kernels/ops/dense_posterior.h. Memory: the model on each device,
// and a second copy of the results on the host, since a device may fail in any piece and nothing
// may be written then.
#pragma once

#include <cstdint>
#include <memory>

#include "absl/status/statusor.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/runtime/context.h"

namespace egosieve::kernels {

// Queries per piece, for M queries on `devices` devices: eight pieces per device, so that one that is
// last waits for an eighth of a device's share at most, if each then has at least 1,024 queries.
int64_t SharedPiece(int64_t query_count, int64_t devices);

// Of one context: DensePosterior::Create. A context may be there more than once. Errors as for
// DensePosterior::Create; InvalidArgument without a context. Enqueue on the posterior of several is
// FailedPrecondition, since a queue belongs to one device.
absl::StatusOr<std::unique_ptr<DensePosterior>> CreateSharedPosterior(
    const Contexts& contexts, const PosteriorModel& model,
    const DensePosteriorOptions& options = {});

}  // namespace egosieve::kernels
