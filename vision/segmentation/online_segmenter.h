// The online segmenter: from frames to maps of moving things. It is the only place where the labels
// (vision/labelling) and the Gaussian process (gp) meet.
//
//   Extract      frame -> features               any order, any thread; of labeller()
//   Label        features -> labels              frames in order, one thread; of labeller()
//   LearnLabels  labels -> model -> posterior    frames in order, one thread, perhaps not Label's
//   Infer        frame, posterior -> map         any order, any thread
//
// The map of a frame combines the process's posterior, the residual of the frame's own labels
// (label_residual.h), and the location prior (location_prior.h).
//
// Learn is Label and LearnLabels. The map of frame t is evaluated on frame t after learning the pair
// that ends in t; frames before the first pair get the prior. No picture content is an error: if
// nothing can be learnt from a frame, its map comes from the present model, and the record gives the
// reason.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "gp/model/posterior.h"
#include "kernels/runtime/context.h"
#include "vision/frame/frame.h"
#include "vision/image/box_means.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/segmentation/frame_record.h"
#include "vision/segmentation/label_residual.h"
#include "vision/segmentation/location_prior.h"
#include "vision/segmentation/online_learner.h"
#include "vision/segmentation/segmentation_map.h"

namespace egosieve::vision {

struct OnlineSegmenterOptions {
  FrameLabellerOptions labeller;
  OnlineLearnerOptions learner;
  LocationPriorOptions location_prior;
  double residual_weight = 0.0;       // w of label_residual.h; in [0, 1]; 0: no residual
  int window_pixels = kWindowPixels;  // of the descriptors (box_means.h)
  // Number of later frames that a frame's labels may use, if the caller has them (in a recording,
  // not from a live camera). From 0 to 100.
  int ahead_frames = FrameLabellerOptions::kLongestAutoGap;
  int stride_pixels = 5;  // of the grid on which the posterior is evaluated; at least 1

  // Best for hand-held and driving video.
  static OnlineSegmenterOptions Default();
  // As in the paper's sections III to V.
  static OnlineSegmenterOptions Paper();
  // Default, but with labels from pictures of 640 pixels and neighbouring frames, and with 128
  // instead of 256 inducing inputs.
  static OnlineSegmenterOptions Fast();

  // One seed for all random choices.
  void SetSeed(uint64_t seed);
  absl::Status Validate() const;
};

// All that a frame's map is computed from. A value: the segmenter can continue without it.
struct MapPosterior {
  std::shared_ptr<const gp::Posterior> process;
  LocationPrior location;
  LabelResidual residual;  // of the last learnt frame
};

class OnlineSegmenter {
 public:
  static absl::StatusOr<std::unique_ptr<OnlineSegmenter>> Create(
      std::shared_ptr<kernels::Context> context, const OnlineSegmenterOptions& options);

  struct Learnt {
    std::optional<MapPosterior> posterior;  // if one is wanted
    LabelledFrame labels;
    FrameRecord record;
  };

  // Extracts and labels. Frames ahead: at most options().ahead_frames, none for a live camera.
  FrameLabeller& labeller() { return *labeller_; }
  // Without `with_posterior` no posterior is made.
  absl::StatusOr<Learnt> LearnLabels(const Frame& frame, LabelledFrame labels,
                                     bool with_posterior = true);
  absl::StatusOr<Learnt> Learn(const Frame& frame, std::shared_ptr<const ExtractedFrame> extracted,
                               bool with_posterior,
                               const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead);
  // Also fills `record.milliseconds.inference`, `dynamic_share`, `expected_overlap`
  // and `clamped_variances`.
  absl::StatusOr<SegmentationMap> Infer(const Frame& frame, const MapPosterior& posterior,
                                        FrameRecord& record) const;

  // The state after the last learnt frame, as the bytes of a model file (gp/io/model_file.h). Call
  // it between two frames. This segmenter and one restored from the bytes continue with the same
  // bits.
  absl::StatusOr<std::string> Checkpoint() { return Checkpoint(labeller_->state()); }
  // The same where Label is ahead of LearnLabels: `labeller_state` is labeller().state(), taken
  // right after the frame's Label on the labelling thread.
  absl::StatusOr<std::string> Checkpoint(absl::string_view labeller_state);
  // Continues from a checkpoint. `recent`: the frames of the last HistoryFrames() pictures before
  // it (repeated_picture.h; all, if there were fewer), oldest first.
  absl::Status Restore(absl::string_view checkpoint, const std::vector<Frame>& recent);

  const OnlineSegmenterOptions& options() const { return options_; }
  const OnlineLearner& learner() const { return *learner_; }

 private:
  OnlineSegmenter(const OnlineSegmenterOptions& options, std::unique_ptr<FrameLabeller> labeller,
                  std::unique_ptr<OnlineLearner> learner);

  // Residual of the frame's labels against the process right after learning them.
  absl::Status TakeResidual(const LabelledFrame& labels, kernels::ConstMatrixView<float> places);

  // The picture for the descriptors: equalised if requested.
  cv::Mat Equalized(const Frame& frame) const;

  OnlineSegmenterOptions options_;
  std::unique_ptr<FrameLabeller> labeller_;
  std::unique_ptr<OnlineLearner> learner_;
  LocationPrior location_prior_;
  LabelResidual residual_;
  std::shared_ptr<const gp::Posterior> process_;  // of the present learner; null: to be made
};

}  // namespace egosieve::vision
