// Seeded models, images and queries like those of the segmenter.
#pragma once

#include <benchmark/benchmark.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "kernels/base/covariance_parameters.h"
#include "kernels/base/posterior_model.h"
#include "kernels/runtime/context.h"

namespace egosieve::kernels {

// The device of EGOSIEVE_DEVICE or the default one; ends the program with a message if there is
// none.
std::shared_ptr<Context> BenchmarkContext();

enum class BenchmarkKernel {
  kGentleArcsine,       // weights of about 0.4
  kSteepArcsine,        // squared weights up to e^6, as trained for positions
  kSquaredExponential,  // lengths of 0.3 and 0.6
  kMatern52,            // the same
};

CovarianceParameters BenchmarkCovariance(BenchmarkKernel kernel);

struct BenchmarkModel {
  CovarianceParameters covariance;
  int64_t count = 0;
  std::vector<double> inputs;
  std::vector<double> alpha;
  std::vector<double> cholesky;
  std::vector<double> inverse;  // of cholesky; for at most 1000 points
  PosteriorModel model(FactorKind kind) const;
};

// n points of an image's inputs, labels with a moving blob, noise 0.3. Made only once.
const BenchmarkModel& ModelOf(int64_t n, BenchmarkKernel kernel);

// Milliseconds of the wall clock, and of all threads' processors.
inline void TakeBothClocks(benchmark::internal::Benchmark* bench) {
  bench->MeasureProcessCPUTime()->UseRealTime()->Unit(benchmark::kMillisecond);
}

// Inputs at every `stride`-th pixel of a smooth image of 640 x 480 pixels, 6 values each.
std::vector<float> ImageQueries(int stride);

}  // namespace egosieve::kernels
