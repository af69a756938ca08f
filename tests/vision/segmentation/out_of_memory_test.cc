// A model that has no memory for a moment is no reason to go on with another: what it answers would
// differ from an undisturbed run's, and nothing would tell.
#include <cstdint>
#include <cstdlib>

#include "kernels/base/exception_status.h"
#include "kernels/runtime/context.h"
#include "tests/testing/status.h"
#include "tests/vision/segmentation/moving_square.h"
#include "vision/segmentation/online_segmenter.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define EGOSIEVE_SANITIZER_ALLOCATES
#endif

namespace {

// Which call from now on is refused, from 0; below 0: none. The factor is allocated by these.
thread_local int64_t calls_until_refusal = -1;

}  // namespace

#ifndef EGOSIEVE_SANITIZER_ALLOCATES
extern "C" {
void* __libc_memalign(size_t alignment, size_t size);
void* aligned_alloc(size_t alignment, size_t size) {
  return calls_until_refusal-- == 0 ? nullptr : __libc_memalign(alignment, size);
}
}
#endif

namespace egosieve::vision {
namespace {

TEST(OutOfMemory, IsAnErrorWhicheverAllocationFails) {
#ifdef EGOSIEVE_SANITIZER_ALLOCATES
  GTEST_SKIP() << "the sanitizer has its own allocation";
#endif
  const MovingSquare drive;
  auto options = OnlineSegmenterOptions::Default();
  options.learner.training.annealing_evaluations = 20;
  auto context = Value(kernels::OpenContext());
  constexpr int64_t kCalls = 12;
  for (int64_t call = 0; call <= kCalls; ++call) {
    auto segmenter = Value(OnlineSegmenter::Create(context, options));
    ASSERT_TRUE(
        segmenter->Learn(drive.At(0), Value(segmenter->labeller().Extract(drive.At(0))), true, {})
            .ok());
    auto extracted = Value(segmenter->labeller().Extract(drive.At(1)));
    calls_until_refusal = call < kCalls ? call : -1;
    const auto learnt = kernels::CatchExceptions(
        [&] { return segmenter->Learn(drive.At(1), extracted, false, {}); });
    const bool was_refused = call < kCalls && calls_until_refusal < 0;
    calls_until_refusal = -1;
    EXPECT_EQ(was_refused, call < kCalls) << "call " << call;
    EXPECT_EQ(learnt.status().code(),
              was_refused ? absl::StatusCode::kResourceExhausted : absl::StatusCode::kOk)
        << "call " << call << ": " << learnt.status();
  }
}

}  // namespace
}  // namespace egosieve::vision
