// A device that fails in the middle of a frame: nothing is written, the frame has its place in the
// count, and the segmenter goes on, as does one that was saved and loaded, to the last bit.
#include <CL/cl.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "egosieve/segmenter.hpp"
#include "gtest/gtest.h"
#include "tests/kernels/failing_calls.h"

namespace egosieve {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr int64_t kRows = 25, kColumns = 33;
constexpr float kUntouched = -7.0f;

uint32_t Noise(uint32_t a, uint32_t b) {
  uint32_t h = (a * 73856093u) ^ (b * 19349663u);
  h = (h ^ (h >> 13)) * 0x5bd1e995u;
  return h ^ (h >> 15);
}

// A bright square that moves over a still background.
std::vector<uint8_t> Pixels(int t) {
  std::vector<uint8_t> pixels;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const int left = 30 + 6 * t;
      const bool inside = u >= left && u < left + 40 && v >= 40 && v < 80;
      const uint32_t grey =
          inside ? 128 + Noise((u - left) / 4 + 900, v / 4) % 128 : Noise(u / 4, v / 4) % 128;
      pixels.insert(pixels.end(), 3, static_cast<uint8_t>(grey));
    }
  }
  return pixels;
}

struct Answer {
  std::vector<float> probability = std::vector<float>(kRows * kColumns, kUntouched);
  Status status;
  int64_t frame = -1;
};

Answer Process(Segmenter& segmenter, int t) {
  const std::vector<uint8_t> pixels = Pixels(t);
  Answer answer;
  const Map map{.probability = {answer.probability.data(), kRows, kColumns}};
  const Result<FrameReport> report =
      segmenter.Process({pixels.data(), kWidth, kHeight}, 0.1 * t, map);
  answer.status = report.status();
  if (report.ok()) answer.frame = report->frame;
  return answer;
}

class SegmenterDeviceFailure : public testing::Test {
 protected:
  void SetUp() override {
    const char* device = std::getenv("EGOSIEVE_DEVICE");
    if (device != nullptr && std::string(device) == "reference") {
      GTEST_SKIP() << "the reference calls no driver";
    }
  }
  void TearDown() override { kernels::CallHasFailed(); }
  const std::string folder_ = testing::TempDir();
};

TEST_F(SegmenterDeviceFailure, LeavesASegmenterThatGoesOn) {
  const SegmenterOptions options{.budget = 200};
  const std::string before = folder_ + "/before.npz", after = folder_ + "/after.npz";
  {
    Segmenter segmenter = Segmenter::Create(options).value();
    for (int t = 0; t < 2; ++t) ASSERT_TRUE(Process(segmenter, t).status.ok());
    ASSERT_TRUE(segmenter.Save(before).ok());
  }
  // The second is no lack of the machine by its code, but no matter of the frame's data either.
  std::map<int, int> errors;
  for (int nth = 0, code = CL_DEVICE_NOT_AVAILABLE;; ++nth) {
    SCOPED_TRACE(nth);
    Segmenter segmenter = Segmenter::Load(before).value();
    kernels::FailCall("clEnqueueNDRangeKernel", nth, code);
    const Answer broken = Process(segmenter, 2);
    if (!kernels::CallHasFailed()) {  // a frame has no more such calls
      if (std::exchange(code, CL_INVALID_KERNEL) == CL_INVALID_KERNEL) break;
      nth = -1;
      continue;
    }
    if (!broken.status.ok()) {
      ++errors[code];
      EXPECT_EQ(std::count(broken.probability.begin(), broken.probability.end(), kUntouched),
                kRows * kColumns);
    }
    ASSERT_TRUE(segmenter.Save(after).ok());
    Segmenter loaded = Segmenter::Load(after).value();
    const Answer next = Process(segmenter, 3), same = Process(loaded, 3);
    EXPECT_TRUE(next.status.ok()) << next.status.message();
    EXPECT_EQ(next.frame, 3);
    EXPECT_EQ(same.frame, 3);
    EXPECT_TRUE(next.probability == same.probability);
  }
  EXPECT_GT(errors[CL_DEVICE_NOT_AVAILABLE], 1) << "the device was not asked";
  EXPECT_EQ(errors[CL_INVALID_KERNEL], errors[CL_DEVICE_NOT_AVAILABLE]);
}

}  // namespace
}  // namespace egosieve
