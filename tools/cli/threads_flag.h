// The flag --threads: how many threads of the host a command takes, beside those of the device.
#ifndef EGOSIEVE_TOOLS_CLI_THREADS_FLAG_H_
#define EGOSIEVE_TOOLS_CLI_THREADS_FLAG_H_

#include <CLI/CLI.hpp>

namespace egosieve::tools {

class ThreadsFlag {
 public:
  void AddFlag(CLI::App& app);

  // Limits what this process starts from now on: the libraries' threads, and OpenCV's. Returns the
  // limit, at least 1.
  int Apply() const;

 private:
  int threads_ = 0;  // 0: the machine's cores
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_THREADS_FLAG_H_
