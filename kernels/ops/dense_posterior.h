// The posterior of a Gaussian process at many points; the model is uploaded once.
//
//   mean(x)        = k*.alpha                                              (paper, eq. 3)
//   variance(x)    = k** - |L^-1 k*|^2       of f; clamped at 0            (paper, eq. 4)
//   probability(x) = Phi( (a mean + b) / sqrt(1 + a^2 variance) )          (eq. 6 with the square
//                    root of Rasmussen & Williams eq. 6.41)
//
//   k*_i = k(x, x_i), k** = k(x, x), alpha = (L L^T)^-1 y
//
// For a sparse model `inputs` are the inducing inputs, and the factor is an R of kind
// kInverseCholesky with variance(x) = k** - |R k*|^2: K_mm^-1 - Sigma^-1 is positive semidefinite,
// so one triangular R suffices.
//
// Cost per query: n (D + 10) multiply-adds for the mean, n^2 / 2 more for the variance. Arithmetic
// is float32 on the device (float64 with "reference"); L is not inverted, except for its diagonal
// blocks (kernels/ops/opencl_posterior_model.h). The error of the covariances depends on the function (see
// its file in kernels/covariance; arcsine: e = 1e-6). That of the mean is at most sigma_f^2
// |alpha|_1 (e + (66 + n / 64) 2^-24 f_max), f_max = pi / 2 for the arcsine. Queries are processed
// in tiles within a memory limit; the bits of a query's result do not depend on its tile.
#pragma once

#include <cstdint>
#include <memory>

#include "absl/status/statusor.h"
#include "kernels/base/matrix_view.h"
#include "kernels/base/posterior_model.h"
#include "kernels/ops/device_call.h"
#include "kernels/runtime/context.h"

namespace egosieve::kernels {

struct DensePosteriorOptions {
  // Device memory for tiles and their queries, without the model. 0: 256 MiB, or for a device with
  // its own memory an eighth of it, if that is more.
  int64_t memory_cap_bytes = 0;
  // InvalidArgument if negative.
  absl::Status Validate() const;
};

// Caller's arrays, one value per query; null: not computed.
struct PosteriorOutputs {
  float* mean = nullptr;
  float* variance = nullptr;
  float* probability = nullptr;
};

// Arrays in OpenCL buffers of the posterior's context (kernels/runtime/opencl_context.h), float32
// unless said otherwise.
struct DeviceOutput {
  cl_mem memory = nullptr;  // null: not computed, at no cost
  int64_t first = 0;        // element of the first value; the M values are contiguous
};

struct DeviceOutputs {
  DeviceOutput mean;
  DeviceOutput variance;
  DeviceOutput probability;
  // int32: the number of clamped variances.
  DeviceOutput clamped;
};

struct PosteriorCounts {
  int64_t clamped_variances = 0;  // negative from rounding, set to 0
};

// Immutable after Create: safe to use from several threads.
class DensePosterior {
 public:
  // The model's views (kernels/base/posterior_model.h) are read during Create only.
  static absl::StatusOr<std::unique_ptr<DensePosterior>> Create(
      std::shared_ptr<Context> context, const PosteriorModel& model,
      const DensePosteriorOptions& options = {});

  virtual ~DensePosterior() = default;

  // queries: M x D. InvalidArgument, naming the first bad row, for NaN or infinite inputs;
  // ResourceExhausted or Unavailable if the device has no memory or is lost. After an error nothing
  // is written, and the posterior can be evaluated again.
  virtual absl::StatusOr<PosteriorCounts> Evaluate(ConstMatrixView<float> queries,
                                                   const PosteriorOutputs& outputs) const = 0;
  // Queries in float64 are rounded only after they are prepared (kernels/base/prepared_points.h):
  // far from zero, float32 cannot hold them. Of float32 values the results are the same bits.
  virtual absl::StatusOr<PosteriorCounts> Evaluate(ConstMatrixView<double> queries,
                                                   const PosteriorOutputs& outputs) const = 0;

  // The same without waiting, from and to the device's memory: no data passes through the host. The
  // queries are prepared on the device, in float64 (FailedPrecondition on devices without it). A
  // query with a NaN or infinite input gets a NaN mean and a variance of 0. Results equal those of
  // Evaluate to the bit, except for functions whose preparation calls the device's sine or
  // contracts multiplications: these differ by a rounding of the prepared query.
  //
  // The caller releases the event, which completes with the last command. Commands keep everything
  // they need: this object and the caller's handles may be released before. InvalidArgument for
  // handles of other contexts and for arrays that are too small. After an error, commands that were
  // enqueued before it may still write to the outputs.
  virtual absl::StatusOr<cl_event> Enqueue(const BufferMatrix& queries,
                                           const DeviceOutputs& outputs,
                                           const DeviceCall& call) const = 0;
};

// One posterior on several devices: DensePosterior::Create for each. A context may be there more than
// once. The queries of a call are divided into pieces: first one for each device, and then the next
// one for each device that has finished. A query's result equals that of the device that computed it,
// to the bit; devices of different kinds agree within the errors above. Memory: the model on each
// device, and a second copy of the results on the host, since a device may fail in any piece and
// nothing may be written then. InvalidArgument without a context. Enqueue on the posterior of several
// is FailedPrecondition, since a queue belongs to one device.
absl::StatusOr<std::unique_ptr<DensePosterior>> CreateSharedPosterior(
    const Contexts& contexts, const PosteriorModel& model,
    const DensePosteriorOptions& options = {});

// Queries per piece, for M queries on `devices` devices: eight pieces per device, so that one that is
// last waits for an eighth of a device's share at most, if each then has at least 1,024 queries.
int64_t SharedPiece(int64_t query_count, int64_t devices);

}  // namespace egosieve::kernels
