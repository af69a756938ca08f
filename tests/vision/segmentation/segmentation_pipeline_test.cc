#include "vision/segmentation/segmentation_pipeline.h"

#include <memory>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "kernels/runtime/context.h"
#include "tests/testing/status.h"
#include "tests/vision/frame/fake_source.h"
#include "tests/vision/segmentation/moving_square.h"
#include "vision/labelling/stopwatch.h"
#include "vision/segmentation/bounded_queue.h"

namespace egosieve::vision {
namespace {

// The moving square as an input of `count` frames, of which `damaged` cannot be read.
class MovingSquareSource : public FakeSource {
 public:
  MovingSquareSource(int64_t count, std::set<int64_t> damaged)
      : FakeSource(count, std::move(damaged),
                   [drive = MovingSquare()](int64_t index) { return drive.At(index); }) {}
};

std::unique_ptr<OnlineSegmenter> MakeSegmenter(ModelKind kind = ModelKind::kExact) {
  OnlineSegmenterOptions options = OnlineSegmenterOptions::Default();
  options.learner.model.kind = kind;
  options.learner.model.sparse.inducing_points = 60;
  options.labeller.focal_ratio = 0.9;  // labels rest on the pictures ahead, too
  options.learner.training.annealing_evaluations = 10;
  // Points leave and the factor is never rebuilt for training's sake: its bits carry its history.
  options.learner.budget.budget = 150;
  options.learner.arrival_share = 0.1;
  options.learner.training.rebuild_threshold = 1000.0;
  options.residual_weight = 0.3;
  auto context = Value(kernels::OpenContext());
  return Value(OnlineSegmenter::Create(context, options));
}

struct DriveRun {
  absl::StatusOr<PipelineSummary> summary = absl::UnknownError("not run");
  std::vector<SegmentedFrame> frames;
};

DriveRun RunDrive(FrameSource& source, const PipelineOptions& options,
                  const std::function<bool()>& stop_requested = nullptr,
                  ModelKind kind = ModelKind::kExact) {
  DriveRun run;
  auto segmenter = MakeSegmenter(kind);
  run.summary =
      RunPipeline(source, *segmenter, options, stop_requested, [&run](const SegmentedFrame& frame) {
        run.frames.push_back(frame);
        return absl::OkStatus();
      });
  return run;
}

// One frame after the other, the stages' times are parts of the whole: work that two of them told
// would make the sum the greater.
TEST(SegmentationPipelineTest, StagesTellTheirWorkOnce) {
  for (OnlineSegmenterOptions options :
       {OnlineSegmenterOptions::Default(), OnlineSegmenterOptions::Paper()}) {
    options.learner.budget.budget = 50;
    options.stride_pixels = 20;
    auto segmenter = *OnlineSegmenter::Create(*kernels::OpenContext(), options);
    MovingSquareSource source(6, {});
    const PipelineOptions in_turn{.overlap = false};
    double told = 0.0;
    Stopwatch watch;
    const auto summary =
        RunPipeline(source, *segmenter, in_turn, nullptr, [&](const SegmentedFrame& frame) {
          told += frame.read_milliseconds + frame.record.milliseconds.total();
          EXPECT_TRUE(frame.index == 0 || frame.record.milliseconds.features > 0.0);
          return absl::OkStatus();
        });
    ASSERT_TRUE(summary.ok()) << summary.status();
    EXPECT_LE(told, watch.LapMilliseconds()) << options.labeller.is_paper;
  }
}

class PipelineOfBothModels : public testing::TestWithParam<ModelKind> {};

INSTANTIATE_TEST_SUITE_P(Models, PipelineOfBothModels,
                         testing::Values(ModelKind::kExact, ModelKind::kSparse),
                         [](const auto& kind) {
                           return kind.param == ModelKind::kExact ? "Exact" : "Sparse";
                         });

TEST_P(PipelineOfBothModels, GoesOnFromACheckpointAsIfNothingHadHappened) {
  PipelineOptions options{.checkpoint_interval = 4};
  MovingSquareSource source(9, {3});
  const DriveRun whole = RunDrive(source, options, nullptr, GetParam());
  ASSERT_TRUE(whole.summary.ok()) << whole.summary.status();
  ASSERT_EQ(whole.frames.size(), 9u);
  for (const SegmentedFrame& frame : whole.frames) {
    EXPECT_EQ(frame.checkpoint.empty(), frame.index != 3 && frame.index != 7) << frame.index;
  }
  for (const int64_t last : {3, 7}) {  // frame 3 is damaged: frame 2 is the recent one
    auto segmenter = MakeSegmenter(GetParam());
    MovingSquareSource again(9, {3});
    std::vector<Frame> recent;
    for (int64_t index = 0; index <= last; ++index) {
      const FrameRead read = *again.Next();
      if (const auto* frame = std::get_if<Frame>(&read)) recent.push_back(*frame);
    }
    const auto history = segmenter->options().labeller.HistoryFrames();
    if (static_cast<int>(recent.size()) > history)
      recent.erase(recent.begin(), recent.end() - history);
    ASSERT_TRUE(segmenter->Restore(whole.frames[last].checkpoint, recent).ok());
    options.first_frame = last + 1;
    std::vector<SegmentedFrame> rest;
    ASSERT_TRUE(RunPipeline(again, *segmenter, options, nullptr, [&](const SegmentedFrame& frame) {
                  rest.push_back(frame);
                  return absl::OkStatus();
                }).ok());
    ASSERT_EQ(rest.size(), static_cast<size_t>(8 - last));
    for (const SegmentedFrame& frame : rest) {
      const SegmentedFrame& before = whole.frames[frame.index];
      EXPECT_EQ(frame.map.probability, before.map.probability) << frame.index;
      EXPECT_EQ(frame.map.deviation, before.map.deviation) << frame.index;
      EXPECT_EQ(frame.record.theta, before.record.theta) << frame.index;
      EXPECT_EQ(frame.record.log_likelihood_per_point, before.record.log_likelihood_per_point)
          << frame.index;
      EXPECT_TRUE(frame.checkpoint == before.checkpoint) << frame.index;
    }
  }
  auto segmenter = MakeSegmenter(GetParam());
  EXPECT_FALSE(segmenter->Restore("rubbish", {}).ok());
}

TEST(SegmentationPipelineTest, OverlappedStagesGiveTheBytesOfOneFrameAfterTheOther) {
  std::vector<DriveRun> runs;
  for (const bool overlap : {false, true}) {
    MovingSquareSource source(6, {3});
    runs.push_back(RunDrive(source, {.overlap = overlap, .queue_capacity = 2}));
    ASSERT_TRUE(runs.back().summary.ok()) << runs.back().summary.status();
    EXPECT_EQ(runs.back().summary->segmented_frames, 5);
    EXPECT_EQ(runs.back().summary->damaged_frames, 1);
    EXPECT_EQ(runs.back().summary->warning, "the end");
    EXPECT_FALSE(runs.back().summary->stopped);
  }
  ASSERT_EQ(runs[0].frames.size(), 6u);
  ASSERT_EQ(runs[1].frames.size(), 6u);
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(runs[1].frames[i].index, static_cast<int64_t>(i));
    EXPECT_EQ(runs[1].frames[i].damage.has_value(), i == 3);
    EXPECT_EQ(runs[1].frames[i].map.probability, runs[0].frames[i].map.probability);
    EXPECT_EQ(runs[1].frames[i].map.deviation, runs[0].frames[i].map.deviation);
    EXPECT_EQ(runs[1].frames[i].record.theta, runs[0].frames[i].record.theta);
  }
}

TEST(SegmentationPipelineTest, TakesTheFramesBetweenFirstAndEnd) {
  MovingSquareSource source(6, {});
  const DriveRun run = RunDrive(source, {.first_frame = 2, .end_frame = 4});
  ASSERT_TRUE(run.summary.ok());
  ASSERT_EQ(run.frames.size(), 2u);
  EXPECT_EQ(run.frames[0].index, 2);
  EXPECT_EQ(run.frames[1].index, 3);
}

// Frames whose pictures ahead were not all read are left to the run that goes on: their labels
// would be others.
TEST(SegmentationPipelineTest, FinishesWhatIsCompleteWhenAskedToStop) {
  for (const bool overlap : {false, true}) {
    MovingSquareSource source(50, {});
    const int ahead = MakeSegmenter()->options().ahead_frames;
    ASSERT_GT(ahead, 0);
    const std::thread::id reader = std::this_thread::get_id();
    const DriveRun run = RunDrive(source, {.overlap = overlap}, [&] {
      return std::this_thread::get_id() == reader && source.next_index() >= 3 + ahead;
    });
    ASSERT_TRUE(run.summary.ok());
    EXPECT_TRUE(run.summary->stopped);
    EXPECT_EQ(run.frames.size(), 3u);
  }
}

TEST(SegmentationPipelineTest, LeavesOutWhatWaitsToBeLearntWhenAskedToStop) {
  MovingSquareSource source(30, {});
  const std::thread::id reader = std::this_thread::get_id();
  PipelineOptions options;
  options.queue_capacity = 30;  // everything can be read before the third frame is learnt
  int learnt = 0;
  const DriveRun run = RunDrive(
      source, options, [&] { return std::this_thread::get_id() != reader && ++learnt > 3; });
  ASSERT_TRUE(run.summary.ok());
  EXPECT_TRUE(run.summary->stopped);
  EXPECT_EQ(run.frames.size(), 3u);
}

// What --max_frames cuts off is looked at all the same, so that a longer run has the same bytes.
TEST(SegmentationPipelineTest, FramesBeforeAnEndAreThoseOfALongerRun) {
  MovingSquareSource source(9, {});
  PipelineOptions options;
  const DriveRun whole = RunDrive(source, options);
  options.end_frame = 4;
  const DriveRun part = RunDrive(source, options);
  ASSERT_EQ(part.frames.size(), 4u);
  for (size_t i = 0; i < part.frames.size(); ++i) {
    EXPECT_EQ(part.frames[i].map.probability, whole.frames[i].map.probability) << i;
  }
}

TEST(SegmentationPipelineTest, TheFirstFrameIsLabelledFromTheNext) {
  MovingSquareSource source(4, {});
  const DriveRun run = RunDrive(source, PipelineOptions());
  ASSERT_EQ(run.frames.size(), 4u);
  EXPECT_EQ(run.frames[0].labels.outcome, LabelOutcome::kLabelled);
  EXPECT_EQ(run.frames[0].labels.labelled.index, 0);
  EXPECT_EQ(run.frames[0].labels.second_index > 0, true);
}

TEST(SegmentationPipelineTest, AnErrorOfTheSinkEndsTheRun) {
  for (const bool overlap : {false, true}) {
    MovingSquareSource source(50, {});
    auto segmenter = MakeSegmenter();
    const PipelineOptions options{.overlap = overlap};
    int seen = 0;
    const auto summary =
        RunPipeline(source, *segmenter, options, nullptr, [&seen](const SegmentedFrame&) {
          return ++seen == 2 ? absl::ResourceExhaustedError("disk full") : absl::OkStatus();
        });
    EXPECT_EQ(summary.status(), absl::ResourceExhaustedError("disk full"));
    EXPECT_EQ(seen, 2);
    EXPECT_LT(source.next_index(), 50);
  }
}

TEST(BoundedQueueTest, DeliversInOrderAndEndsWhenClosed) {
  BoundedQueue<int> queue(3);
  EXPECT_TRUE(queue.Push(1));
  EXPECT_TRUE(queue.Push(2));
  queue.Close();
  EXPECT_FALSE(queue.Push(3));
  EXPECT_EQ(queue.Pop(), 1);
  EXPECT_EQ(queue.Pop(), 2);
  EXPECT_EQ(queue.Pop(), std::nullopt);
}

TEST(BoundedQueueTest, CancelDropsWhatIsInside) {
  BoundedQueue<int> queue(3);
  queue.Push(1);
  queue.Cancel();
  EXPECT_EQ(queue.Pop(), std::nullopt);
}

}  // namespace
}  // namespace egosieve::vision
