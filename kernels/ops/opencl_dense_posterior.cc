#include "kernels/ops/opencl_dense_posterior.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/aligned_array.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/kernel_options.h"
#include "kernels/ops/packed_factor.h"
#include "kernels/runtime/buffer.h"
#include "kernels/runtime/fork_guard.h"
#include "kernels/runtime/opencl_error.h"

namespace egosieve::kernels::opencl {
namespace {

// Tiles in local memory hold the points of a block of rows: where points are too wide for that,
// each work-item has a tile of its own.
KernelTuning TuningFor(const Context& context, int64_t point_width) {
  constexpr int64_t kSumBlock = 64;  // SUM_BLOCK of kernels/cl/posterior_outputs.cl
  const KernelTuning& tuning = context.tuning();
  if (!tuning.local_tiles) return tuning;
  const int64_t rows = std::max<int64_t>(tuning.panel * tuning.panels_a_group, kSumBlock);
  const int64_t local_bytes =
      static_cast<int64_t>(context.cl_device().getInfo<CL_DEVICE_LOCAL_MEM_SIZE>());
  if (rows * (point_width + 1) * static_cast<int64_t>(sizeof(float)) <= local_bytes) return tuning;
  return DefaultTuning(1);
}

// With local tiles a whole group is read column by column.
FactorBlocking BlockingOf(const KernelTuning& tuning) {
  const int group = tuning.panel * tuning.panels_a_group;
  return {tuning.local_tiles ? group : tuning.panel, group, tuning.depth};
}

constexpr int64_t kMaxChunkQueries = 65536;

enum OutputBits { kWantMean = 1, kWantVariance = 2, kWantProbability = 4 };

int OutputMask(const PosteriorOutputs& outputs) {
  return (outputs.mean != nullptr ? kWantMean : 0) |
         (outputs.variance != nullptr ? kWantVariance : 0) |
         (outputs.probability != nullptr ? kWantProbability : 0);
}

int64_t MemoryCapBytes(const DensePosteriorOptions& options, const Context& context) {
  if (options.memory_cap_bytes != DensePosteriorOptions::kCapOfTheDevice) {
    return options.memory_cap_bytes;
  }
  constexpr int64_t kLeastCapBytes = int64_t{256} << 20;
  return context.shares_host_memory() ? kLeastCapBytes
                                      : std::max(kLeastCapBytes, context.info().memory_bytes / 8);
}

// Results before all of them are there: a device may fail in any chunk.
class StagedOutputs {
 public:
  StagedOutputs(const PosteriorOutputs& outputs, int64_t count)
      : count_(count), targets_{outputs.mean, outputs.variance, outputs.probability} {
    for (int i = 0; i < 3; ++i) {
      if (targets_[i] != nullptr) values_[i] = AlignedArray<float>(count);
    }
  }

  PosteriorOutputs From(int64_t first) {
    const auto at = [&](int i) { return targets_[i] ? values_[i].data() + first : nullptr; };
    return {at(0), at(1), at(2)};
  }

  void Commit() {
    for (int i = 0; i < 3; ++i) {
      if (targets_[i] != nullptr) std::copy_n(values_[i].data(), count_, targets_[i]);
    }
  }

 private:
  int64_t count_;
  std::array<float*, 3> targets_;
  std::array<AlignedArray<float>, 3> values_;
};

// The arrays that the kernel reads, prepared on the host. Kept because a device that shares the
// host's memory reads them where they are.
struct HostArrays {
  std::vector<float> inputs;  // prepared points
  std::vector<float> alpha;   // sigma_f^2 alpha
  AlignedArray<float> factor;
};

class DeviceModel {
 public:
  // `covariance` is the model's, and outlives this.
  DeviceModel(const Context& context, const PosteriorModel& model,
              const CovarianceParameters& covariance, const FactorBlocking& blocking)
      : count_(model.inputs.rows), preparation_(covariance, CentreOfModel(model)) {
    const double signal_variance = covariance.signal_stddev * covariance.signal_stddev;
    host_.inputs = PrepareRows<double, float>(preparation_, model.inputs);
    const ConstMatrixView<float> points(host_.inputs.data(), count_, preparation_.width());
    code_ = CovarianceCodeFor(covariance, points);
    DeviceCodeRequest request;
    request.dimension = covariance.input_dimension();
    request.points = points;
    note_ = covariance.function.description().DeviceNote(request);
    for (int64_t i = 0; i < count_; ++i) {
      host_.alpha.push_back(static_cast<float>(signal_variance * model.alpha[i]));
    }
    // Buffers must not be empty.
    host_.inputs.resize(std::max<size_t>(host_.inputs.size(), 1));
    host_.alpha.resize(std::max<size_t>(host_.alpha.size(), 1));
    inputs_ = InputBuffer(context, host_.inputs);
    alpha_ = InputBuffer(context, host_.alpha);
    if (model.factor_kind != FactorKind::kNone && count_ > 0) {
      host_.factor = PackFactor(model.factor_kind, model.factor, blocking);
      factor_ = InputBuffer(context, host_.factor);
    } else {
      factor_ = alpha_;
    }
  }

  int64_t count() const { return count_; }
  const PointPreparation& preparation() const { return preparation_; }
  const std::string& covariance_code() const { return code_; }
  const std::string& note() const { return note_; }
  const cl::Buffer& inputs() const { return inputs_; }
  const cl::Buffer& alpha() const { return alpha_; }
  const cl::Buffer& factor() const { return factor_; }

 private:
  static std::vector<double> CentreOfModel(const PosteriorModel& model) {
    const int64_t dimension = model.covariance.input_dimension();
    return model.inputs.rows > 0 ? CentreOf(model.inputs) : std::vector<double>(dimension, 0.0);
  }

  int64_t count_;
  PointPreparation preparation_;
  std::string code_;
  std::string note_;
  HostArrays host_;
  cl::Buffer inputs_;
  cl::Buffer alpha_;
  cl::Buffer factor_;
};

class OpenClPosterior : public DensePosterior {
 public:
  OpenClPosterior(std::shared_ptr<Context> context, const PosteriorModel& model,
                  const DensePosteriorOptions& options)
      : context_(std::move(context)),
        options_(options),
        covariance_(model.covariance),
        factor_kind_(model.inputs.rows == 0 ? FactorKind::kNone : model.factor_kind),
        squash_a_(static_cast<float>(model.squash_a)),
        squash_b_(static_cast<float>(model.squash_b)),
        tuning_(TuningFor(*context_, PreparedWidth(covariance_))),
        blocking_(BlockingOf(tuning_)),
        model_(*context_, model, covariance_, blocking_) {}

  absl::StatusOr<PosteriorCounts> Evaluate(ConstMatrixView<float> queries,
                                           const PosteriorOutputs& outputs) const override;

  std::string description() const override;

 private:
  // Sizes that the memory cap leaves.
  struct Tiling {
    int micro_tiles = 1;
    int work_groups = 1;
    int work_items = 1;
    int tiles_at_once = 1;
    int64_t scratch_floats = 0;  // of a tile: a work-item's or, with local tiles, a group's
    int64_t tile_queries = 0;
    int64_t chunk_queries = 0;
  };
  Tiling ChooseTiling(FactorKind kind, int64_t query_count) const;
  std::string ProgramOptions(FactorKind kind) const;
  int Width(FactorKind kind) const {
    return kind == FactorKind::kNone ? tuning_.mean_width : tuning_.width;
  }
  // Work-items side by side along rows, with local tiles.
  int Panels(FactorKind kind) const {
    return kind == FactorKind::kNone ? 1 : tuning_.panels_a_group;
  }
  int MicroTileQueries(FactorKind kind) const {
    return Width(kind) *
           (tuning_.local_tiles ? tuning_.work_group / Panels(kind) : tuning_.float_lanes);
  }
  // Throws cl::Error. Returns the number of clamped variances.
  int64_t EvaluateChunk(cl::Kernel& kernel, const cl::CommandQueue& queue, const Tiling& tiling,
                        const cl::Buffer& scratch, ConstMatrixView<float> queries,
                        const PosteriorOutputs& outputs) const;

  std::shared_ptr<Context> context_;
  DensePosteriorOptions options_;
  CovarianceParameters covariance_;
  FactorKind factor_kind_;
  float squash_a_;
  float squash_b_;
  KernelTuning tuning_;
  FactorBlocking blocking_;
  DeviceModel model_;
};

std::string OpenClPosterior::description() const {
  const std::string function(covariance_.function.text());
  return absl::StrCat(context_->info().name, ": float32, ",
                      model_.note().empty() ? function : model_.note());
}

std::string OpenClPosterior::ProgramOptions(FactorKind kind) const {
  const int factor = kind == FactorKind::kNone ? 0 : kind == FactorKind::kCholesky ? 1 : 2;
  const std::string shared =
      absl::StrCat(BuildOptions<float>(*context_), " -DFACTOR=", factor, " -DPANEL=", tuning_.panel,
                   " -DWIDTH=", Width(kind), " -DDEPTH=", tuning_.depth);
  if (tuning_.local_tiles) {
    return absl::StrCat(shared, " -DPOINT_SPACE=__local -DPANELS=", Panels(kind),
                        " -DCOLUMNS=", tuning_.work_group / Panels(kind));
  }
  return absl::StrCat(shared, " -DGROUP=", blocking_.group, " -DWORK_GROUP=", tuning_.work_group);
}

OpenClPosterior::Tiling OpenClPosterior::ChooseTiling(FactorKind kind, int64_t query_count) const {
  const int64_t rows = kind == FactorKind::kNone ? 0 : PaddedCount(model_.count(), blocking_.panel);
  // Without local tiles a tile's sums lie beside it.
  const int64_t micro_floats = (rows + (tuning_.local_tiles ? 0 : 2)) * MicroTileQueries(kind);
  const int64_t query_floats = model_.preparation().width() + 3;  // prepared, and the outputs
  const int64_t cap_floats =
      MemoryCapBytes(options_, *context_) / static_cast<int64_t>(sizeof(float));
  const int tiles_a_group = tuning_.local_tiles ? 1 : tuning_.work_group;
  Tiling tiling;
  tiling.micro_tiles = tuning_.local_tiles ? 1 : tuning_.micro_tiles;
  tiling.work_groups = std::max(context_->info().compute_units, 1) * tuning_.groups_a_unit;
  // Half of the cap for scratch, the other half for queries; a work-group of single micro-tiles is
  // the least there can be.
  const auto scratch = [&] {
    return int64_t{tiling.micro_tiles} * tiling.work_groups * tiles_a_group * micro_floats;
  };
  while (tiling.micro_tiles > 1 && scratch() > cap_floats / 2) tiling.micro_tiles /= 2;
  while (tiling.work_groups > 1 && scratch() > cap_floats / 2) --tiling.work_groups;
  const int64_t tile = int64_t{tiling.micro_tiles} * MicroTileQueries(kind);
  // Groups without a tile of their own would take scratch for nothing.
  tiling.work_groups =
      static_cast<int>(std::min<int64_t>(tiling.work_groups, (query_count + tile - 1) / tile));
  tiling.tiles_at_once = tiling.work_groups * tiles_a_group;
  tiling.work_items = tiling.work_groups * tuning_.work_group;
  tiling.scratch_floats = tiling.micro_tiles * micro_floats;
  tiling.tile_queries = tile;
  const int64_t most = std::min({kMaxChunkQueries, cap_floats / 2 / query_floats, query_count});
  tiling.chunk_queries = std::max<int64_t>((most + tile - 1) / tile, 1) * tile;
  return tiling;
}

int64_t OpenClPosterior::EvaluateChunk(cl::Kernel& kernel, const cl::CommandQueue& queue,
                                       const Tiling& tiling, const cl::Buffer& scratch,
                                       ConstMatrixView<float> queries,
                                       const PosteriorOutputs& outputs) const {
  const PreparedColumns<float> columns =
      PrepareColumns<float, float>(model_.preparation(), queries, tiling.tile_queries);
  std::vector<cl_int> counters = {0, 0};  // the next tile, clamped variances
  // An output that is not wanted is never written: any array serves in its place.
  float unused = 0.0f;
  const auto output = [&](float* data) {
    if (data == nullptr) return OutputBuffer<float>(*context_, MatrixView<float>(&unused, 1, 1));
    return OutputBuffer<float>(*context_, MatrixView<float>(data, 1, queries.rows),
                               Unwritten::kNone);
  };
  OutputBuffer<float> mean = output(outputs.mean);
  OutputBuffer<float> variance = output(outputs.variance);
  OutputBuffer<float> probability = output(outputs.probability);
  OutputBuffer<cl_int> counter_buffer(*context_, MatrixView<cl_int>(counters.data(), 1, 2));
  const cl::Buffer query_buffer = InputBuffer(*context_, columns.values);
  const float signal_variance =
      static_cast<float>(covariance_.signal_stddev * covariance_.signal_stddev);
  SetArguments(kernel, query_buffer, cl_long{columns.stride}, cl_long{queries.rows},
               model_.inputs(), model_.alpha(), static_cast<cl_int>(model_.count()),
               static_cast<cl_int>(PaddedCount(model_.count(), blocking_.panel)), model_.factor(),
               signal_variance, squash_a_, squash_b_, cl_int{tiling.micro_tiles},
               cl_int{OutputMask(outputs)}, scratch, cl_long{tiling.scratch_floats},
               counter_buffer.buffer(), mean.buffer(), variance.buffer(), probability.buffer());
  const CommandsEnd end(queue);
  queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(tiling.work_items),
                             cl::NDRange(tuning_.work_group));
  for (OutputBuffer<float>* result : {&mean, &variance, &probability}) result->Finish(queue);
  counter_buffer.Finish(queue);
  return counters[1];
}

absl::StatusOr<PosteriorCounts> OpenClPosterior::Evaluate(ConstMatrixView<float> queries,
                                                          const PosteriorOutputs& outputs) const {
  EGOSIEVE_RETURN_IF_ERROR(CheckQueries(covariance_.input_dimension(), queries));
  const bool needs_variance = outputs.variance != nullptr || outputs.probability != nullptr;
  EGOSIEVE_RETURN_IF_ERROR(CheckOutputs(needs_variance, factor_kind_, model_.count()));
  PosteriorCounts counts;
  if (queries.rows == 0 || OutputMask(outputs) == 0) return counts;
  const FactorKind kind = needs_variance ? factor_kind_ : FactorKind::kNone;
  const Tiling tiling = ChooseTiling(kind, queries.rows);
  EGOSIEVE_ASSIGN_OR_RETURN(
      cl::Kernel kernel,
      context_->Kernel(tuning_.local_tiles ? "dense_posterior_local.cl" : "dense_posterior.cl",
                       ProgramOptions(kind), "dense_posterior", model_.covariance_code()));
  EGOSIEVE_RETURN_IF_ERROR(CatchOpenClErrors("evaluating a dense posterior", [&] {
    const cl::CommandQueue queue = context_->NewQueue();
    const cl::Buffer scratch = ScratchBuffer(
        *context_,
        std::max<int64_t>(tiling.tiles_at_once * tiling.scratch_floats, 1) * sizeof(float));
    StagedOutputs staged(outputs, queries.rows);
    for (int64_t begin = 0; begin < queries.rows; begin += tiling.chunk_queries) {
      const int64_t end = std::min(begin + tiling.chunk_queries, queries.rows);
      counts.clamped_variances += EvaluateChunk(
          kernel, queue, tiling, scratch, queries.rows_between(begin, end), staged.From(begin));
    }
    staged.Commit();
  }));
  return counts;
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
