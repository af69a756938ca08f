#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "kernels/base/argument_checks.h"
#include "kernels/base/exception_status.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/opencl_dense_posterior.h"

namespace egosieve::kernels {
namespace {

class SharedPosterior : public DensePosterior {
 public:
  SharedPosterior(std::vector<std::unique_ptr<DensePosterior>> devices, int64_t dimension)
      : devices_(std::move(devices)), dimension_(dimension) {}

  absl::StatusOr<PosteriorCounts> Evaluate(ConstMatrixView<float> queries,
                                           const PosteriorOutputs& outputs) const override {
    return EvaluateQueries(queries, outputs);
  }
  absl::StatusOr<PosteriorCounts> Evaluate(ConstMatrixView<double> queries,
                                           const PosteriorOutputs& outputs) const override {
    return EvaluateQueries(queries, outputs);
  }

  absl::StatusOr<cl_event> Enqueue(const BufferMatrix&, const DeviceOutputs&,
                                   const DeviceCall&) const override {
    return absl::FailedPreconditionError(
        "a queue belongs to one device; this posterior lies on several");
  }

 private:
  template <typename Query>
  absl::StatusOr<PosteriorCounts> EvaluateQueries(ConstMatrixView<Query> queries,
                                                  const PosteriorOutputs& outputs) const;

  std::vector<std::unique_ptr<DensePosterior>> devices_;
  int64_t dimension_;
};

// A call's results, and its pieces still to do.
template <typename Query>
class Work {
 public:
  Work(ConstMatrixView<Query> queries, const PosteriorOutputs& outputs, int64_t piece,
       int64_t devices)
      : queries_(queries), piece_(piece), next_(devices), staged_(outputs, queries.rows) {}

  // Evaluates piece `first`, and then pieces that no device has taken.
  void Run(const DensePosterior& device, int64_t first) {
    for (int64_t piece = first; piece * piece_ < queries_.rows && !failed_; piece = next_++) {
      const int64_t begin = piece * piece_, end = std::min(begin + piece_, queries_.rows);
      const auto counts = CatchExceptions(
          [&] { return device.Evaluate(queries_.rows_between(begin, end), staged_.From(begin)); });
      const std::lock_guard lock(mutex_);
      if (counts.ok()) {
        counts_.clamped_variances += counts->clamped_variances;
      } else {
        first_error_.Update(counts.status());
        failed_ = true;
      }
    }
  }

  absl::StatusOr<PosteriorCounts> Finish() {
    EGOSIEVE_RETURN_IF_ERROR(first_error_);
    staged_.Commit();
    return counts_;
  }

 private:
  ConstMatrixView<Query> queries_;
  int64_t piece_;
  std::atomic<int64_t> next_;
  StagedOutputs staged_;
  std::atomic<bool> failed_ = false;
  std::mutex mutex_;  // guards the members below
  PosteriorCounts counts_;
  absl::Status first_error_;
};

template <typename Query>
absl::StatusOr<PosteriorCounts> SharedPosterior::EvaluateQueries(
    ConstMatrixView<Query> queries, const PosteriorOutputs& outputs) const {
  EGOSIEVE_RETURN_IF_ERROR(CheckQueries(dimension_, queries));  // the row is that of the call
  const int64_t piece = SharedPiece(queries.rows, static_cast<int64_t>(devices_.size()));
  if (queries.rows <= piece) return devices_[0]->Evaluate(queries, outputs);
  const int64_t count = std::min<int64_t>(devices_.size(), (queries.rows + piece - 1) / piece);
  Work<Query> work(queries, outputs, piece, count);
  std::vector<std::thread> threads;
  threads.reserve(count - 1);
  int64_t started = 1;
  try {
    for (; started < count; ++started) {
      threads.emplace_back([&, device = started] { work.Run(*devices_[device], device); });
    }
  } catch (const std::exception&) {
    // The system refuses a thread or its memory: this thread evaluates those devices' first pieces.
  }
  work.Run(*devices_[0], 0);
  for (int64_t device = started; device < count; ++device) work.Run(*devices_[0], device);
  for (std::thread& thread : threads) thread.join();
  return work.Finish();
}

}  // namespace

int64_t SharedPiece(int64_t query_count, int64_t devices) {
  constexpr int64_t kPiecesPerDevice = 8, kLeast = 1024;
  const int64_t pieces = kPiecesPerDevice * devices;
  return std::max(kLeast, (query_count + pieces - 1) / pieces);
}

absl::StatusOr<std::unique_ptr<DensePosterior>> CreateSharedPosterior(
    const Contexts& contexts, const PosteriorModel& model, const DensePosteriorOptions& options) {
  EGOSIEVE_REQUIRE(InvalidArgument, !contexts.empty(), "no contexts to share a posterior among");
  std::vector<std::unique_ptr<DensePosterior>> devices;
  for (const std::shared_ptr<Context>& context : contexts) {
    EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<DensePosterior> device,
                              DensePosterior::Create(context, model, options));
    devices.push_back(std::move(device));
  }
  if (devices.size() == 1) return std::move(devices[0]);
  return std::make_unique<SharedPosterior>(std::move(devices), model.covariance.input_dimension());
}

}  // namespace egosieve::kernels
