// Runs the benchmarks that are linked in. --json=FILE writes Google Benchmark's JSON to FILE; all
// other flags are its own.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

int main(int argc, char** argv) {
  std::vector<std::string> arguments;
  for (int i = 0; i < argc; ++i) {
    const std::string argument = argv[i];
    constexpr char kJson[] = "--json=";
    if (argument.rfind(kJson, 0) == 0) {
      arguments.push_back("--benchmark_out=" + argument.substr(sizeof(kJson) - 1));
      arguments.push_back("--benchmark_out_format=json");
    } else {
      arguments.push_back(argument);
    }
  }
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  int count = static_cast<int>(pointers.size());
  benchmark::Initialize(&count, pointers.data());
  if (benchmark::ReportUnrecognizedArguments(count, pointers.data())) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
