#include "kernels/ops/opencl_dense_posterior.h"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "kernels/base/status_macros.h"
#include "kernels/ops/device_preparation.h"
#include "kernels/ops/enqueued_call.h"
#include "kernels/ops/kernel_options.h"
#include "kernels/ops/opencl_posterior_model.h"
#include "kernels/ops/posterior_tiling.h"
#include "kernels/runtime/buffer.h"
#include "kernels/runtime/driver_check.h"
#include "kernels/runtime/opencl_error.h"

namespace egosieve::kernels::opencl {
namespace {

enum OutputBits { kWantMean = 1, kWantVariance = 2, kWantProbability = 4 };

int OutputMask(bool mean, bool variance, bool probability) {
  return (mean ? kWantMean : 0) | (variance ? kWantVariance : 0) |
         (probability ? kWantProbability : 0);
}

int OutputMask(const PosteriorOutputs& outputs) {
  return OutputMask(outputs.mean != nullptr, outputs.variance != nullptr,
                    outputs.probability != nullptr);
}

int OutputMask(const DeviceOutputs& outputs) {
  return OutputMask(outputs.mean.memory != nullptr, outputs.variance.memory != nullptr,
                    outputs.probability.memory != nullptr);
}

bool NeedsVariance(int mask) { return (mask & (kWantVariance | kWantProbability)) != 0; }

int64_t MemoryCapBytes(const DensePosteriorOptions& options, const Context& context) {
  if (options.memory_cap_bytes > 0) return options.memory_cap_bytes;
  constexpr int64_t kLeastCapBytes = int64_t{256} << 20;
  return context.shares_host_memory() ? kLeastCapBytes
                                      : std::max(kLeastCapBytes, context.info().memory_bytes / 8);
}

// Some prepared queries of a call, and the place of their results.
struct Chunk {
  PreparedColumns<float> columns;
  int64_t count = 0;
  PosteriorOutputs outputs;
};

// InvalidArgument, naming the array, unless each belongs to this context and is large enough.
absl::Status CheckArrays(const Context& context, int64_t dimension, const BufferMatrix& queries,
                         const DeviceOutputs& outputs) {
  EGOSIEVE_RETURN_IF_ERROR(
      CheckBufferMatrix(context, "queries", queries, dimension, sizeof(float)));
  struct Named {
    const char* name;
    const DeviceOutput& output;
    int64_t elements;
  };
  for (const Named& one : {Named{"mean", outputs.mean, queries.rows},
                           Named{"variance", outputs.variance, queries.rows},
                           Named{"probability", outputs.probability, queries.rows},
                           Named{"clamped", outputs.clamped, 1}}) {
    if (one.output.memory == nullptr) continue;
    EGOSIEVE_RETURN_IF_ERROR(CheckDeviceArray(context, one.name, one.output.memory,
                                              one.output.first, one.elements, sizeof(float)));
  }
  return absl::OkStatus();
}

class OpenClPosterior : public DensePosterior {
 public:
  OpenClPosterior(std::shared_ptr<Context> context, const PosteriorModel& model,
                  const DensePosteriorOptions& options)
      : context_(std::move(context)),
        options_(options),
        shapes_(*context_, PreparedWidth(model.covariance)),
        model_(std::make_shared<const DeviceModel>(*context_, model, shapes_.blocking())),
        preparation_(std::make_shared<const DevicePreparation>(*context_, model_->covariance,
                                                               model_->preparation)) {}

  absl::StatusOr<PosteriorCounts> Evaluate(ConstMatrixView<float> queries,
                                           const PosteriorOutputs& outputs) const override {
    return EvaluateQueries(queries, outputs);
  }
  absl::StatusOr<PosteriorCounts> Evaluate(ConstMatrixView<double> queries,
                                           const PosteriorOutputs& outputs) const override {
    return EvaluateQueries(queries, outputs);
  }
  absl::StatusOr<cl_event> Enqueue(const BufferMatrix& queries, const DeviceOutputs& outputs,
                                   const DeviceCall& call) const override;

 private:
  // Common data of a kernel's commands.
  struct Launch {
    cl::Kernel kernel;
    PosteriorTiling tiling;
    int mask = 0;
    const cl::Buffer& scratch;
  };

  FactorKind KindFor(int mask) const {
    return NeedsVariance(mask) ? model_->factor_kind : FactorKind::kNone;
  }
  absl::StatusOr<cl::Kernel> Kernel(Workspace& workspace, FactorKind kind) const {
    return workspace.Kernel(shapes_.file(), shapes_.BuildOptions(*context_, kind),
                            "dense_posterior", model_->covariance_code);
  }
  template <typename Query>
  absl::StatusOr<PosteriorCounts> EvaluateQueries(ConstMatrixView<Query> queries,
                                                  const PosteriorOutputs& outputs) const;
  template <typename Query>
  Chunk Prepare(ConstMatrixView<Query> queries, int64_t begin, const PosteriorTiling& tiling,
                StagedOutputs& staged) const;
  // Throws cl::Error. Returns the number of clamped variances. `meanwhile` runs while the device
  // works.
  template <typename Meanwhile>
  int64_t Evaluate(Launch& launch, const cl::CommandQueue& queue, Chunk& chunk,
                   Meanwhile meanwhile) const;
  // Throws cl::Error. Starts the kernel on `count` prepared queries.
  void Start(Launch& launch, const cl::CommandQueue& queue, const cl::Buffer& queries,
             int64_t stride, int64_t count, const cl::Buffer& counters, const cl::Buffer& mean,
             const cl::Buffer& variance, const cl::Buffer& probability,
             const std::array<int64_t, 3>& first_results,
             const std::vector<cl::Event>* after = nullptr, cl::Event* done = nullptr) const;
  // Throws cl::Error. Each command waits for `last` and then becomes `last`.
  void EnqueueChunks(Launch& launch, cl::Kernel& prepare, Workspace& workspace,
                     const BufferMatrix& queries, const DeviceOutputs& outputs,
                     const cl::CommandQueue& queue, std::vector<cl::Event>& last) const;

  std::shared_ptr<Context> context_;
  DensePosteriorOptions options_;
  PosteriorShapes shapes_;
  std::shared_ptr<const DeviceModel> model_;
  std::shared_ptr<const DevicePreparation> preparation_;
};

void OpenClPosterior::Start(Launch& launch, const cl::CommandQueue& queue,
                            const cl::Buffer& queries, int64_t stride, int64_t count,
                            const cl::Buffer& counters, const cl::Buffer& mean,
                            const cl::Buffer& variance, const cl::Buffer& probability,
                            const std::array<int64_t, 3>& first_results,
                            const std::vector<cl::Event>* after, cl::Event* done) const {
  const double signal_stddev = model_->covariance.signal_stddev;
  const PosteriorTiling& tiling = launch.tiling;
  SetArguments(launch.kernel, queries, cl_long{stride}, cl_long{count}, model_->inputs,
               model_->alpha, static_cast<cl_int>(model_->count),
               static_cast<cl_int>(PaddedCount(model_->count, shapes_.blocking().panel)),
               model_->factor, static_cast<float>(signal_stddev * signal_stddev), model_->squash_a,
               model_->squash_b, cl_int{tiling.micro_tiles}, cl_int{launch.mask}, launch.scratch,
               cl_long{tiling.scratch_floats}, counters, mean, variance, probability,
               cl_long{first_results[0]}, cl_long{first_results[1]}, cl_long{first_results[2]});
  queue.enqueueNDRangeKernel(launch.kernel, cl::NullRange, cl::NDRange(tiling.work_items),
                             cl::NDRange(tiling.work_group), after, done);
}

template <typename Query>
Chunk OpenClPosterior::Prepare(ConstMatrixView<Query> queries, int64_t begin,
                               const PosteriorTiling& tiling, StagedOutputs& staged) const {
  const int64_t end = std::min(begin + tiling.chunk_queries, queries.rows);
  return {PrepareColumns<Query, float>(model_->preparation, queries.rows_between(begin, end),
                                       tiling.tile_queries),
          end - begin, staged.From(begin)};
}

template <typename Meanwhile>
int64_t OpenClPosterior::Evaluate(Launch& launch, const cl::CommandQueue& queue, Chunk& chunk,
                                  Meanwhile meanwhile) const {
  std::vector<cl_int> counters = {0, 0};  // the next tile, clamped variances
  // A kernel never writes an unwanted output: any array can take its place.
  float unused = 0.0f;
  const auto output = [&](float* data) {
    if (data == nullptr) return OutputBuffer<float>(*context_, MatrixView<float>(&unused, 1, 1));
    return OutputBuffer<float>(*context_, MatrixView<float>(data, 1, chunk.count),
                               Unwritten::kNone);
  };
  OutputBuffer<float> mean = output(chunk.outputs.mean);
  OutputBuffer<float> variance = output(chunk.outputs.variance);
  OutputBuffer<float> probability = output(chunk.outputs.probability);
  OutputBuffer<cl_int> counter_buffer(*context_, MatrixView<cl_int>(counters.data(), 1, 2));
  const cl::Buffer query_buffer = InputBuffer(*context_, chunk.columns.values);
  const CommandsEnd end(queue);
  Start(launch, queue, query_buffer, chunk.columns.stride, chunk.count, counter_buffer.buffer(),
        mean.buffer(), variance.buffer(), probability.buffer(), {0, 0, 0});
  queue.flush();
  meanwhile();
  for (OutputBuffer<float>* result : {&mean, &variance, &probability}) result->Finish(queue);
  counter_buffer.Finish(queue);
  return counters[1];
}

template <typename Query>
absl::StatusOr<PosteriorCounts> OpenClPosterior::EvaluateQueries(
    ConstMatrixView<Query> queries, const PosteriorOutputs& outputs) const {
  EGOSIEVE_RETURN_IF_ERROR(CheckQueries(model_->covariance.input_dimension(), queries));
  const int mask = OutputMask(outputs);
  EGOSIEVE_RETURN_IF_ERROR(CheckOutputs(NeedsVariance(mask), model_->factor_kind, model_->count));
  PosteriorCounts counts;
  if (queries.rows == 0 || mask == 0) return counts;
  constexpr char kDoing[] = "evaluating a dense posterior";
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<Workspace> workspace, context_->Borrow(kDoing));
  const FactorKind kind = KindFor(mask);
  EGOSIEVE_ASSIGN_OR_RETURN(const cl::Kernel kernel, Kernel(*workspace, kind));
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors(kDoing, [&] {
    const PosteriorTiling tiling = shapes_.Tile(*context_, kind, model_->count, queries.rows,
                                                MemoryCapBytes(options_, *context_));
    Launch launch{
        kernel, tiling, mask,
        workspace->Scratch(Workspace::Memory::kTiles, tiling.all_scratch_floats * sizeof(float))};
    StagedOutputs staged(outputs, queries.rows);
    Chunk chunk = Prepare(queries, 0, tiling, staged);
    for (int64_t begin = 0; begin < queries.rows; begin += tiling.chunk_queries) {
      Chunk next;
      counts.clamped_variances += Evaluate(launch, workspace->queue(), chunk, [&] {
        const int64_t end = begin + tiling.chunk_queries;
        if (end < queries.rows) next = Prepare(queries, end, tiling, staged);
      });
      chunk = std::move(next);
    }
    staged.Commit();
  }));
  context_->GiveBack(std::move(workspace));
  return counts;
}

void OpenClPosterior::EnqueueChunks(Launch& launch, cl::Kernel& prepare, Workspace& workspace,
                                    const BufferMatrix& queries, const DeviceOutputs& outputs,
                                    const cl::CommandQueue& queue,
                                    std::vector<cl::Event>& last) const {
  const PosteriorTiling& tiling = launch.tiling;
  const int64_t width = model_->preparation.width();
  const cl::Buffer prepared =
      workspace.Scratch(Workspace::Memory::kQueries, width * tiling.chunk_queries * sizeof(float));
  const cl::Buffer counters = workspace.Scratch(Workspace::Memory::kCounters, 2 * sizeof(cl_int));
  const cl::Buffer points(queries.memory, /*retainObject=*/true);
  const auto or_any = [&](const DeviceOutput& output) {
    return output.memory != nullptr ? cl::Buffer(output.memory, /*retainObject=*/true) : counters;
  };
  const int64_t stride =
      queries.stride == 0 ? model_->covariance.input_dimension() : queries.stride;
  cl::Event done;
  const auto next = [&] { last = {done}; };
  for (int64_t begin = 0; begin < queries.rows; begin += tiling.chunk_queries) {
    const int64_t count = std::min(tiling.chunk_queries, queries.rows - begin);
    // The tile counter, and for the first chunk also the number of clamped variances.
    queue.enqueueFillBuffer(counters, cl_int{0}, 0, (begin == 0 ? 2 : 1) * sizeof(cl_int), &last,
                            &done);
    next();
    const int64_t padded =
        (count + tiling.tile_queries - 1) / tiling.tile_queries * tiling.tile_queries;
    done = preparation_->Enqueue(prepare, queue,
                                 {points, queries.first + begin * stride, stride, count},
                                 {prepared, padded, 1, padded}, last);
    next();
    Start(launch, queue, prepared, padded, count, counters, or_any(outputs.mean),
          or_any(outputs.variance), or_any(outputs.probability),
          {outputs.mean.first + begin, outputs.variance.first + begin,
           outputs.probability.first + begin},
          &last, &done);
    next();
  }
  if (outputs.clamped.memory != nullptr) {
    queue.enqueueCopyBuffer(counters, cl::Buffer(outputs.clamped.memory, /*retainObject=*/true),
                            sizeof(cl_int), outputs.clamped.first * sizeof(cl_int), sizeof(cl_int),
                            &last, &done);
    next();
  }
}

absl::StatusOr<cl_event> OpenClPosterior::Enqueue(const BufferMatrix& queries,
                                                  const DeviceOutputs& outputs,
                                                  const DeviceCall& call) const {
  const int mask = OutputMask(outputs);
  EGOSIEVE_RETURN_IF_ERROR(CheckOutputs(NeedsVariance(mask), model_->factor_kind, model_->count));
  EGOSIEVE_RETURN_IF_ERROR(CheckDeviceCall(*context_, call));
  EGOSIEVE_RETURN_IF_ERROR(
      CheckArrays(*context_, model_->covariance.input_dimension(), queries, outputs));
  constexpr char kDoing[] = "enqueuing a dense posterior";
  EGOSIEVE_ASSIGN_OR_RETURN(std::unique_ptr<Workspace> workspace, context_->Borrow(kDoing));
  auto in_use = std::make_unique<CallInUse>(
      CallInUse{context_, std::move(workspace), {model_, preparation_}});
  const FactorKind kind = KindFor(mask);
  EGOSIEVE_ASSIGN_OR_RETURN(const cl::Kernel kernel, Kernel(*in_use->workspace, kind));
  EGOSIEVE_ASSIGN_OR_RETURN(cl::Kernel prepare,
                            preparation_->Kernel<float>(*context_, *in_use->workspace));
  Workspace& used = *in_use->workspace;
  return EnqueueCall(
      kDoing, call, std::move(in_use),
      [&](const cl::CommandQueue& queue, std::vector<cl::Event>& last) {
        if (mask == 0 || queries.rows == 0) return Mark(queue, last);
        const PosteriorTiling tiling = shapes_.Tile(*context_, kind, model_->count, queries.rows,
                                                    MemoryCapBytes(options_, *context_));
        Launch launch{
            kernel, tiling, mask,
            used.Scratch(Workspace::Memory::kTiles, tiling.all_scratch_floats * sizeof(float))};
        EnqueueChunks(launch, prepare, used, queries, outputs, queue, last);
      });
}

}  // namespace

absl::StatusOr<std::unique_ptr<DensePosterior>> CreateDensePosterior(
    std::shared_ptr<Context> context, const PosteriorModel& model,
    const DensePosteriorOptions& options) {
  EGOSIEVE_RETURN_IF_ERROR(CheckNotForked());
  std::unique_ptr<DensePosterior> posterior;
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors("uploading a posterior", [&] {
    posterior = std::make_unique<OpenClPosterior>(std::move(context), model, options);
  }));
  return posterior;
}

}  // namespace egosieve::kernels::opencl
