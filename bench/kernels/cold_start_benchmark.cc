// Time from the start of a process to its first posterior, with empty and with filled caches (the
// library's own and PoCL's).
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>

#include "kernels/reference/covariance.h"

namespace egosieve::kernels {
namespace {

// The program first_posterior, built beside this one.
std::string ProgramPath() {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "kernels" /
          "first_posterior")
      .string();
}

// The mean that the program must print.
double ExpectedMean() {
  const CovarianceParameters parameters = {CovarianceFunction::kArcsine, {1.0, 1.0, 1.0}, 1.0};
  const double query[] = {0.125, 0.5};
  const double first[] = {-0.5, 0.25};
  const double second[] = {0.5, -0.25};
  return reference::Covariance(parameters, query, first) -
         reference::Covariance(parameters, query, second);
}

// Runs the program with its caches in `folder`; false unless it printed the right result.
bool RunProgram(const std::string& folder) {
  const std::string command =
      "EGOSIEVE_CACHE_DIR=" + folder + "/own POCL_CACHE_DIR=" + folder + "/pocl " + ProgramPath();
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return false;
  double mean = 1e30;
  const int fields = std::fscanf(pipe, "%lf", &mean);
  const double error = mean - ExpectedMean();
  return pclose(pipe) == 0 && fields == 1 && error < 3e-6 && error > -3e-6;
}

void BM_ColdStart(benchmark::State& state, bool warm) {
  const std::string folder =
      (std::filesystem::temp_directory_path() / ("egosieve-cold-start-" + std::to_string(getpid())))
          .string();
  std::error_code ignored;
  const auto clear = [&] {
    std::filesystem::remove_all(folder, ignored);
    std::filesystem::create_directories(folder + "/pocl", ignored);
  };
  clear();
  if (warm && !RunProgram(folder)) return state.SkipWithError("first_posterior failed");
  for (auto _ : state) {
    if (!warm) {
      state.PauseTiming();
      clear();
      state.ResumeTiming();
    }
    if (!RunProgram(folder)) return state.SkipWithError("first_posterior failed");
  }
  std::filesystem::remove_all(folder, ignored);
}
BENCHMARK_CAPTURE(BM_ColdStart, empty_cache, false)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_ColdStart, warm_cache, true)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace egosieve::kernels
