#include "kernels/base/kept_memory.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>

namespace egosieve::kernels {
namespace {

constexpr int kBlocks = 6;
constexpr size_t kBlockBytes = 8 << 20, kPageBytes = 4096;

int64_t PageFaults() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_minflt;
}

void UseAndFree() {
  void* blocks[kBlocks];
  for (void*& block : blocks) {
    block = std::malloc(kBlockBytes);
    ASSERT_NE(block, nullptr);
    std::memset(block, 1, kBlockBytes);
  }
  for (void* block : blocks) std::free(block);
}

TEST(KeptMemory, FreedBlocksServeAgainWithoutPageFaults) {
#if !defined(__GLIBC__) || defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "another allocator";
#endif
  KeepFreedMemory();
  UseAndFree();
  const int64_t before = PageFaults();
  for (int round = 0; round < 3; ++round) UseAndFree();
  EXPECT_LT(PageFaults() - before, static_cast<int64_t>(kBlockBytes / kPageBytes));
}

}  // namespace
}  // namespace egosieve::kernels
