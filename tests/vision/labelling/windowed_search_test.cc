// Features searched where the last motion leads, against a search of the whole picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <string>
#include <variant>
#include <vector>

#include "tests/vision/labelling/feature_evaluation.h"
#include "tests/vision/labelling/textured_scene.h"
#include "vision/features/flow_grid.h"
#include "vision/frame/frame_source.h"
#include "vision/labelling/frame_labeller.h"

namespace egosieve::vision {
namespace {

FrameLabellerOptions Features(bool windowed) {
  FrameLabellerOptions options;
  options.features = FeatureSource::kSiftCorners;
  options.windowed_search = windowed;
  return options;
}

// A camera that turns by 3 pixels a frame, and once by 60, where no window of 24 pixels reaches:
// from the second pair on windows are used, and where they find nothing the whole picture is.
TEST(WindowedSearch, ASuddenTurnIsSearchedEverywhere) {
  const auto windowed = MakeLabeller(Features(true)), full = MakeLabeller(Features(false));
  for (const int64_t t : {0, 1, 2, 22, 23}) {
    const auto with_windows = windowed->Process(WallFrame(t));
    const auto without = full->Process(WallFrame(t));
    ASSERT_TRUE(with_windows.ok() && without.ok());
    if (t == 0) continue;
    ASSERT_EQ(with_windows->outcome, LabelOutcome::kLabelled) << t << with_windows->reason;
    // Nothing is predicted for the first pair, and wrongly for the fourth frame.
    if (t == 1 || t == 22) {
      EXPECT_EQ(with_windows->match_count, without->match_count) << t;
    }
    EXPECT_GE(with_windows->match_count, without->match_count) << t;
  }
}

TEST(WindowedSearch, ThePaperSearchesEverywhere) {
  FrameLabellerOptions options = FrameLabellerOptions::Paper();
  EXPECT_FALSE(options.windowed_search);
  const auto paper = MakeLabeller(options);
  for (int64_t t = 0; t < 3; ++t) ASSERT_TRUE(paper->Process(WallFrame(t)).ok());
  const std::string state = paper->state();
  options.windowed_search = true;
  const auto windowed = MakeLabeller(options);
  for (int64_t t = 0; t < 3; ++t) ASSERT_TRUE(windowed->Process(WallFrame(t)).ok());
  EXPECT_NE(windowed->state(), state) << "no motion was kept to predict from";
}

// Counts of places whose displacement is known by other means than matching, and of those that it
// confirms.
struct Verdict {
  int64_t judged = 0, right = 0;
  double milliseconds = 0.0;  // of matching
};

double Apart(const PointPair& a, const PointPair& b) {
  return std::hypot(a.x2 - a.x1 - b.x2 + b.x1, a.y2 - a.y1 - b.y2 + b.y1);
}

// By hand-labelled tracks: the nearest within 10 pixels moves the same but for 3, as depth differs
// between the two.
void JudgeByTracks(const LabelledFrame& frame, const std::vector<LabelledTrack>& tracks,
                   Verdict& verdict) {
  const TrackPairs truth = PairsOfTracks(tracks, frame.first_index, frame.second_index);
  for (int64_t i = 0; i < frame.size(); ++i) {
    const PointPair place{frame.other_positions[2 * i], frame.other_positions[2 * i + 1],
                          frame.positions[2 * i], frame.positions[2 * i + 1]};
    const PointPair* nearest = nullptr;
    double least = 10.0;
    for (const PointPair& pair : truth.pairs) {
      const double distance = std::hypot(pair.x1 - place.x1, pair.y1 - place.y1);
      if (distance < least) {
        least = distance;
        nearest = &pair;
      }
    }
    if (nearest == nullptr) continue;
    ++verdict.judged;
    verdict.right += Apart(place, *nearest) < 3.0;
  }
}

// By dense flow, where it holds forwards and backwards.
void JudgeByFlow(const LabelledFrame& frame, const FlowPair& flow, Verdict& verdict) {
  for (int64_t i = 0; i < frame.size(); ++i) {
    const PointPair place{frame.other_positions[2 * i], frame.other_positions[2 * i + 1],
                          frame.positions[2 * i], frame.positions[2 * i + 1]};
    const cv::Point2f p(static_cast<float>(place.x1), static_cast<float>(place.y1));
    const cv::Point2f there = SampleField(flow.forward, p);
    const cv::Point2f back = SampleField(flow.backward, p + there);
    if (!(std::hypot(there.x + back.x, there.y + back.y) < 1.0)) continue;
    ++verdict.judged;
    verdict.right += Apart(place, {p.x, p.y, p.x + there.x, p.y + there.y}) < 2.0;
  }
}

cv::Mat Grey(const cv::Mat& image) {
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

TEST(WindowedSearch, FindsMoreOfTheTrueMatchesOnDrives) {
  const char* data = std::getenv("EGOSIEVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "EGOSIEVE_DATA does not name a folder of real data";
  for (const char* clip : {"kt3dmoseg/Seq005_Clip01", "kt3dmoseg/Seq013_Clip02",
                           "kt3dmoseg/Seq028_Clip01", "kitti-residential"}) {
    const std::string folder = std::string(data) + "/" + clip;
    auto source = OpenFrameSource(folder + "/frames");
    ASSERT_TRUE(source.ok()) << source.status();
    const auto tracks = ReadLabelledTracks(folder + "/tracks.csv", 1);
    const std::unique_ptr<FrameLabeller> labellers[] = {MakeLabeller(Features(false)),
                                                        MakeLabeller(Features(true))};
    Verdict verdicts[2];
    cv::Mat before;
    for (int t = 0; t < 7; ++t) {
      const auto read = (*source)->Next();
      ASSERT_TRUE(read.ok() && std::holds_alternative<Frame>(*read));
      // Features are the same for both.
      const auto extracted = labellers[0]->Extract(std::get<Frame>(*read));
      ASSERT_TRUE(extracted.ok()) << extracted.status();
      const cv::Mat grey = Grey(std::get<Frame>(*read).image);
      for (int k = 0; k < 2; ++k) {
        const auto frame = labellers[k]->Label(*extracted);
        ASSERT_TRUE(frame.ok()) << frame.status();
        if (t < 2) continue;  // the first pair is searched everywhere
        ASSERT_EQ(frame->outcome, LabelOutcome::kLabelled) << frame->reason;
        verdicts[k].milliseconds += frame->times.matching_milliseconds;
        if (tracks.ok()) {
          JudgeByTracks(*frame, *tracks, verdicts[k]);
        } else {
          const auto flow = ComputeFlow(before, grey, FlowQuality::kMedium);
          ASSERT_TRUE(flow.ok()) << flow.status();
          JudgeByFlow(*frame, *flow, verdicts[k]);
        }
      }
      before = grey;
    }
    const auto& [full, windowed] = verdicts;
    const auto share = [](const Verdict& v) {
      return static_cast<double>(v.right) / static_cast<double>(std::max<int64_t>(v.judged, 1));
    };
    std::printf(
        "%-26s true matches: full %lld (%.3f of the judged), windowed %lld (%.3f); %.1f "
        "and %.1f ms a pair\n",
        clip, static_cast<long long>(full.right), share(full),
        static_cast<long long>(windowed.right), share(windowed), full.milliseconds / 5,
        windowed.milliseconds / 5);
    // Measured: 6 % to 8 % more. What is found besides is harder, so that the share may fall.
    EXPECT_GE(static_cast<double>(windowed.right), 1.03 * static_cast<double>(full.right)) << clip;
    EXPECT_GE(share(windowed), share(full) - 0.05) << clip;
  }
}

}  // namespace
}  // namespace egosieve::vision
