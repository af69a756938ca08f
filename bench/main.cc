// Runs the benchmarks that are linked in. --json=FILE writes Google Benchmark's JSON to FILE; all
// other flags are those of Google Benchmark.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "kernels/runtime/device.h"
#include "kernels/runtime/driver_check.h"

namespace {

// Removes the kind of timing ("/real_time") from a benchmark's name.
template <typename Reporter>
class ShortNames : public Reporter {
 public:
  using Reporter::Reporter;
  void ReportRuns(const std::vector<benchmark::BenchmarkReporter::Run>& runs) override {
    std::vector<benchmark::BenchmarkReporter::Run> renamed = runs;
    for (auto& run : renamed) run.run_name.time_type.clear();
    Reporter::ReportRuns(renamed);
  }
};

// Adds the device's name to the results.
void NameDevice() {
  const auto devices = egosieve::kernels::ListDevices();
  if (!devices.ok()) return;
  const char* choice = std::getenv("EGOSIEVE_DEVICE");
  const auto device = egosieve::kernels::ChooseDevice(*devices, choice == nullptr ? "" : choice);
  if (device.ok()) benchmark::AddCustomContext("device", device->name);
}

}  // namespace

int main(int argc, char** argv) {
  egosieve::kernels::LetPoclWrite();
  std::vector<std::string> arguments;
  bool writes_json = false;
  for (int i = 0; i < argc; ++i) {
    const std::string argument = argv[i];
    constexpr char kJson[] = "--json=";
    if (argument.rfind(kJson, 0) == 0) {
      arguments.push_back("--benchmark_out=" + argument.substr(sizeof(kJson) - 1));
      arguments.push_back("--benchmark_out_format=json");
      writes_json = true;
    } else {
      arguments.push_back(argument);
    }
  }
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  int count = static_cast<int>(pointers.size());
  benchmark::Initialize(&count, pointers.data());
  if (benchmark::ReportUnrecognizedArguments(count, pointers.data())) return 2;
  NameDevice();
  ShortNames<benchmark::ConsoleReporter> console(isatty(STDOUT_FILENO)
                                                     ? benchmark::ConsoleReporter::OO_Color
                                                     : benchmark::ConsoleReporter::OO_None);
  ShortNames<benchmark::JSONReporter> json;
  if (writes_json) {
    benchmark::RunSpecifiedBenchmarks(&console, &json);
  } else {
    benchmark::RunSpecifiedBenchmarks(&console);
  }
  benchmark::Shutdown();
  return 0;
}
