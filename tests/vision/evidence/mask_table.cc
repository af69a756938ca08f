// Prints how well fused evidence and the motion model's distance alone tell the marked object from
// the rest on hand-held video (DAVIS): the area under the ROC curve at the points of the flow grid,
// mean over the frames. EGOSIEVE_DATA names the data.
#include <cstdio>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "kernels/base/status_macros.h"
#include "tests/vision/evidence/labelled_clip.h"
#include "vision/evidence/evidence_accumulator.h"
#include "vision/features/flow_grid.h"
#include "vision/frame/frame_source.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/segmentation/labeller_factory.h"
#include "vision/tracking/grid_tracker.h"

namespace egosieve::vision {
namespace {

struct MaskScore {
  double epipolar = 0.0, all = 0.0, without_memory = 0.0;  // mean areas
  int64_t frames = 0, fundamental = 0;
};

EvidenceFrame FrameOf(const LabelledFrame& labelled, const std::vector<Track>& tracks,
                      const cv::Mat& grey) {
  EvidenceFrame frame;
  frame.index = labelled.frame_index;
  frame.size = grey.size();
  frame.grey = grey;
  if (labelled.outcome == LabelOutcome::kLabelled) {
    frame.motion_model = labelled.motion_model;
    for (int i = 0; i < 9; ++i) frame.motion_matrix(i / 3, i % 3) = labelled.motion_matrix.val[i];
  }
  for (const Track& track : tracks) frame.points.push_back(PointOfTrack(track, 1));
  return frame;
}

double AreaAgainst(const cv::Mat& mask, const EvidenceFrame& frame, const EvidenceResult& result,
                   bool& both) {
  std::vector<double> moving, resting;
  for (size_t i = 0; i < frame.points.size(); ++i) {
    if (!std::isfinite(frame.points[i].before.x)) continue;
    (mask.at<uint8_t>(frame.points[i].now) > 127 ? moving : resting)
        .push_back(result.points[i].probability);
  }
  both = !moving.empty() && !resting.empty();
  return AreaUnderCurve(moving, resting);
}

absl::StatusOr<MaskScore> ScoreSequence(const std::string& folder) {
  EGOSIEVE_ASSIGN_OR_RETURN(auto labeller, MakeFrameLabeller(FrameLabellerOptions()));
  EGOSIEVE_ASSIGN_OR_RETURN(auto source, OpenFrameSource(folder + "/frames"));
  EGOSIEVE_ASSIGN_OR_RETURN(auto masks, OpenFrameSource(folder + "/masks"));
  EGOSIEVE_ASSIGN_OR_RETURN(GridTracker tracker, GridTracker::Create({}));
  EvidenceOptions epipolar_options, memoryless;
  epipolar_options.negative_depth = false;
  epipolar_options.accumulation = false;
  memoryless.accumulation = false;
  EGOSIEVE_ASSIGN_OR_RETURN(EvidenceAccumulator all, EvidenceAccumulator::Create({}));
  EGOSIEVE_ASSIGN_OR_RETURN(EvidenceAccumulator now, EvidenceAccumulator::Create(memoryless));
  EGOSIEVE_ASSIGN_OR_RETURN(EvidenceAccumulator epipolar,
                            EvidenceAccumulator::Create(epipolar_options));
  MaskScore score;
  cv::Mat before;
  for (int64_t t = 0;; ++t) {
    EGOSIEVE_ASSIGN_OR_RETURN(FrameRead read, source->Next());
    EGOSIEVE_ASSIGN_OR_RETURN(FrameRead mask_read, masks->Next());
    if (!std::holds_alternative<Frame>(read) || !std::holds_alternative<Frame>(mask_read)) break;
    const Frame& frame = std::get<Frame>(read);
    cv::Mat grey, mask;
    cv::cvtColor(frame.image, grey, cv::COLOR_BGR2GRAY);
    cv::cvtColor(std::get<Frame>(mask_read).image, mask, cv::COLOR_BGR2GRAY);
    EGOSIEVE_ASSIGN_OR_RETURN(const LabelledFrame labelled, labeller->Process(frame));
    std::vector<PointPair> links;
    if (!before.empty()) {
      EGOSIEVE_ASSIGN_OR_RETURN(const FlowPair flow,
                                ComputeFlow(before, grey, FlowQuality::kMedium));
      links = TrackGrid(flow, before, grey, /*anchor_second=*/true, FlowGridOptions()).pairs;
    }
    before = grey;
    EGOSIEVE_RETURN_IF_ERROR(tracker.Advance(frame.index, grey.size(), links));
    const EvidenceFrame input = FrameOf(labelled, tracker.tracks(), grey);
    EGOSIEVE_ASSIGN_OR_RETURN(const EvidenceResult fused, all.Add(input));
    EGOSIEVE_ASSIGN_OR_RETURN(const EvidenceResult current, now.Add(input));
    EGOSIEVE_ASSIGN_OR_RETURN(const EvidenceResult plain, epipolar.Add(input));
    bool both = false;
    const double area = AreaAgainst(mask, input, fused, both);
    if (!both || labelled.outcome != LabelOutcome::kLabelled) continue;
    score.all += area;
    score.without_memory += AreaAgainst(mask, input, current, both);
    score.epipolar += AreaAgainst(mask, input, plain, both);
    score.fundamental += labelled.motion_model == MotionModelKind::kFundamental ? 1 : 0;
    ++score.frames;
  }
  const double count = static_cast<double>(std::max<int64_t>(1, score.frames));
  score.all /= count;
  score.epipolar /= count;
  score.without_memory /= count;
  return score;
}

}  // namespace
}  // namespace egosieve::vision

int main() {
  const char* data = std::getenv("EGOSIEVE_DATA");
  if (data == nullptr) {
    std::fprintf(stderr, "set EGOSIEVE_DATA to the folder of the test data\n");
    return 2;
  }
  std::printf("%-16s %9s %9s %9s %7s %12s\n", "", "epipolar", "all, now", "all", "frames",
              "fundamental");
  for (const char* name : {"car-shadow", "horsejump-high", "bmx-trees", "cows"}) {
    const auto score = egosieve::vision::ScoreSequence(std::string(data) + "/davis/" + name);
    if (!score.ok()) {
      std::fprintf(stderr, "%s\n", score.status().ToString().c_str());
      return 3;
    }
    std::printf("%-16s %9.4f %9.4f %9.4f %7d %12d\n", name, score->epipolar, score->without_memory,
                score->all, static_cast<int>(score->frames), static_cast<int>(score->fundamental));
    std::fflush(stdout);
  }
  return 0;
}
