#include "kernels/runtime/pocl_threads.h"

#include <algorithm>
#include <cstdlib>
#include <string>

namespace egosieve::kernels {

void LimitPoclThreads(int threads) {
  // The second name is used since PoCL 4.
  for (const char* name : {"POCL_MAX_PTHREAD_COUNT", "POCL_CPU_MAX_CU_COUNT"}) {
    const char* said = std::getenv(name);
    const int before = said != nullptr ? std::atoi(said) : 0;
    const int limit = std::max(1, before > 0 ? std::min(before, threads) : threads);
    setenv(name, std::to_string(limit).c_str(), /*overwrite=*/1);
  }
}

}  // namespace egosieve::kernels
