// The flag --threads: how many threads a command takes. Commands without it take what
// kernels/base/parallel_for.h says.
#ifndef EGOSIEVE_TOOLS_CLI_THREADS_FLAG_H_
#define EGOSIEVE_TOOLS_CLI_THREADS_FLAG_H_

#include <CLI/CLI.hpp>

namespace egosieve::tools {

class ThreadsFlag {
 public:
  void AddFlag(CLI::App& app);

  // Limits what this process starts from now on: the libraries' threads, OpenCV's, and those of the
  // devices that --device opens. Returns the limit, at least 1.
  int Apply() const;

 private:
  int threads_ = 0;  // 0: MaximumThreads()
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_CLI_THREADS_FLAG_H_
