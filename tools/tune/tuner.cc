#include "tools/tune/tuner.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "kernels/ops/dense_posterior.h"
#include "kernels/runtime/opencl_context.h"

namespace egosieve::tune {
namespace {

using kernels::DensePosterior;
using kernels::KernelTuning;

constexpr int kDimension = 6;

// A model with arbitrary numbers: times do not depend on them, and its results stay of order one.
struct Problem {
  explicit Problem(const TuneOptions& options)
      : inputs(options.training_points * kDimension),
        alpha(options.training_points),
        factor(options.training_points * options.training_points, 0.0),
        queries(std::max(options.mean_queries, options.variance_queries) * kDimension) {
    std::mt19937_64 random(1);
    const auto uniform = [&] { return std::ldexp(static_cast<double>(random() >> 11), -52) - 1.0; };
    const int64_t n = options.training_points;
    for (double& value : inputs) value = uniform();
    for (double& value : alpha) value = uniform() / std::sqrt(n);
    for (float& value : queries) value = static_cast<float>(uniform());
    for (int64_t i = 0; i < n; ++i) {
      for (int64_t j = 0; j < i; ++j) factor[i * n + j] = 0.5 * uniform() / std::sqrt(n);
      factor[i * n + i] = 2.0 * std::sqrt(n);
    }
    model.covariance = {
        kernels::CovarianceFunction::kArcsine, {1.0, 5.0, 4.0, 1.5, 1.0, 1.0, 1.0}, 1.0};
    model.inputs = kernels::ConstMatrixView<double>(inputs.data(), n, kDimension);
    model.alpha = alpha.data();
    model.factor_kind = kernels::FactorKind::kCholesky;
    model.factor = kernels::ConstMatrixView<double>(factor.data(), n, n);
  }

  std::vector<double> inputs;
  std::vector<double> alpha;
  std::vector<double> factor;
  std::vector<float> queries;
  kernels::PosteriorModel model;
};

enum class Workload { kMean, kVariance };

struct Timing {
  double seconds = std::numeric_limits<double>::infinity();
  std::vector<float> answers;
};

// On a CPU device, this process's processor time divided by the device's cores, which other
// programs disturb least; on other devices, wall-clock time.
double Seconds(const kernels::DeviceInfo& device) {
  timespec now;
  const bool is_cpu = device.type == kernels::DeviceType::kCpu;
  clock_gettime(is_cpu ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &now);
  return (now.tv_sec + 1e-9 * now.tv_nsec) / (is_cpu ? std::max(device.compute_units, 1) : 1);
}

class Search {
 public:
  explicit Search(const TuneOptions& options) : options_(options), problem_(options) {}

  absl::StatusOr<TuneResult> Run();

 private:
  // Stops early if `hopeless_seconds` is exceeded.
  absl::StatusOr<Timing> Time(const KernelTuning& tuning, Workload workload,
                              double hopeless_seconds = std::numeric_limits<double>::infinity());
  void TryField(const char* name, int KernelTuning::*field, const std::vector<int>& values,
                Workload workload, Timing& best);
  void SearchLocalTiles(Timing& mean, Timing& variance);
  void SearchVectors(Timing& mean, Timing& variance);
  bool AnswersAgree(const std::vector<float>& a, const std::vector<float>& b) const;

  TuneOptions options_;
  Problem problem_;
  TuneResult result_;
};

absl::StatusOr<Timing> Search::Time(const KernelTuning& tuning, Workload workload,
                                    double hopeless_seconds) {
  kernels::ContextOptions context_options;
  context_options.device = options_.device;
  context_options.tuning = tuning;
  EGOSIEVE_ASSIGN_OR_RETURN(auto context, kernels::OpenContext(context_options));
  EGOSIEVE_ASSIGN_OR_RETURN(auto posterior, DensePosterior::Create(context, problem_.model));
  const bool mean_only = workload == Workload::kMean;
  const int64_t count = mean_only ? options_.mean_queries : options_.variance_queries;
  const kernels::ConstMatrixView<float> queries(problem_.queries.data(), count, kDimension);
  Timing timing;
  timing.answers.resize(count);
  kernels::PosteriorOutputs outputs;
  (mean_only ? outputs.mean : outputs.variance) = timing.answers.data();
  // The first run compiles and is not timed. A shape several times slower than the best gets no
  // second run.
  for (int run = 0; run <= options_.repeats; ++run) {
    const double begin = Seconds(context->info());
    EGOSIEVE_RETURN_IF_ERROR(posterior->Evaluate(queries, outputs).status());
    const double seconds = Seconds(context->info()) - begin;
    if (run > 0) timing.seconds = std::min(timing.seconds, seconds);
    if (timing.seconds > hopeless_seconds && run > 0) break;
  }
  return timing;
}

// Shapes change the order of sums of order one; results differ only by rounding.
bool Search::AnswersAgree(const std::vector<float>& a, const std::vector<float>& b) const {
  for (size_t i = 0; i < a.size(); ++i) {
    if (!(std::abs(a[i] - b[i]) <= 1e-4f * (1.0f + std::abs(a[i])))) return false;
  }
  return true;
}

void Search::TryField(const char* name, int KernelTuning::*field, const std::vector<int>& values,
                      Workload workload, Timing& best) {
  if (!options_.fields.empty() &&
      std::find(options_.fields.begin(), options_.fields.end(), name) == options_.fields.end()) {
    return;
  }
  const int held = result_.after.*field;  // the value that `best` was timed with
  for (const int value : values) {
    if (value == held) continue;
    KernelTuning candidate = result_.after;
    candidate.*field = value;
    if (!candidate.Validate().ok()) continue;
    const auto timing = Time(candidate, workload, 3.0 * best.seconds);
    ++result_.shapes_timed;
    const bool usable = timing.ok() && AnswersAgree(timing->answers, best.answers);
    if (!usable) ++result_.shapes_dropped;
    if (options_.progress) {
      options_.progress(usable ? absl::StrFormat("%s %d: %.3f ms (best %.3f)", name, value,
                                                 1e3 * timing->seconds, 1e3 * best.seconds)
                               : absl::StrFormat("%s %d: dropped", name, value));
    }
    if (usable && timing->seconds < best.seconds * (1.0 - options_.least_gain)) {
      best.seconds = timing->seconds;
      result_.after = candidate;
    }
  }
}

absl::StatusOr<TuneResult> Search::Run() {
  kernels::ContextOptions context_options;
  context_options.device = options_.device;
  context_options.tuning = options_.begin;
  EGOSIEVE_ASSIGN_OR_RETURN(const auto context, kernels::OpenContext(context_options));
  if (context->is_reference()) {
    return absl::FailedPreconditionError(
        "the reference has no shapes to tune; choose an OpenCL device");
  }
  result_.device = context->info().name;
  result_.before = result_.after = context->tuning();
  EGOSIEVE_ASSIGN_OR_RETURN(Timing mean, Time(result_.before, Workload::kMean));
  EGOSIEVE_ASSIGN_OR_RETURN(Timing variance, Time(result_.before, Workload::kVariance));
  result_.mean_seconds_before = mean.seconds;
  result_.variance_seconds_before = variance.seconds;
  if (context->is_gpu()) {
    TryField("local_tiles", &KernelTuning::local_tiles, {0, 1}, Workload::kVariance, variance);
  }
  if (result_.after.local_tiles) {
    SearchLocalTiles(mean, variance);
  } else {
    SearchVectors(mean, variance);
  }
  if (context->is_gpu()) {
    TryField("groups_per_unit", &KernelTuning::groups_per_unit, {1, 2, 4, 8, 16, 32},
             Workload::kVariance, variance);
  }
  result_.mean_seconds_after = mean.seconds;
  result_.variance_seconds_after = variance.seconds;
  return result_;
}

// Combinations of shapes that do not fit together are skipped.
void Search::SearchLocalTiles(Timing& mean, Timing& variance) {
  TryField("mean_width", &KernelTuning::mean_width, {1, 2, 4, 8}, Workload::kMean, mean);
  TryField("width", &KernelTuning::width, {2, 4, 8}, Workload::kVariance, variance);
  TryField("panel", &KernelTuning::panel, {4, 8}, Workload::kVariance, variance);
  TryField("panels_per_group", &KernelTuning::panels_per_group, {4, 8, 16, 32}, Workload::kVariance,
           variance);
  TryField("work_group", &KernelTuning::work_group, {32, 64, 128, 256}, Workload::kVariance,
           variance);
  TryField("depth", &KernelTuning::depth, {8, 16, 32}, Workload::kVariance, variance);
}

void Search::SearchVectors(Timing& mean, Timing& variance) {
  TryField("float_lanes", &KernelTuning::float_lanes, {1, 4, 8, 16}, Workload::kMean, mean);
  TryField("mean_width", &KernelTuning::mean_width, {1, 2, 3, 4}, Workload::kMean, mean);
  TryField("width", &KernelTuning::width, {1, 2, 3, 4}, Workload::kVariance, variance);
  TryField("panel", &KernelTuning::panel, {4, 6, 8, 9, 10, 12, 14}, Workload::kVariance, variance);
  TryField("depth", &KernelTuning::depth, {64, 128, 192, 256, 384, 512}, Workload::kVariance,
           variance);
  TryField("panels_per_group", &KernelTuning::panels_per_group, {4, 8, 12, 16, 24},
           Workload::kVariance, variance);
  TryField("micro_tiles", &KernelTuning::micro_tiles, {1, 2, 4, 8}, Workload::kVariance, variance);
}

}  // namespace

absl::StatusOr<TuneResult> Tune(const TuneOptions& options) { return Search(options).Run(); }

}  // namespace egosieve::tune
