// The flag --threads: how many threads a command uses. Commands without it use the limit of
// kernels/base/parallel_for.h.
#pragma once

namespace CLI {
class App;
}

namespace egosieve::tools {

class ThreadsFlag {
 public:
  void AddFlag(CLI::App& app);

  // Limits the threads that this process starts from now on: those of the libraries, of OpenCV, and
  // of the devices that --device opens. Returns the limit, at least 1.
  int Apply() const;

 private:
  int threads_ = 0;  // 0: MaximumThreads()
};

}  // namespace egosieve::tools
