// The online segmenter: frames in, maps of what moves by itself out. The one place where the front
// end (vision/labelling) and the Gaussian process (gp) meet.
//
//   Extract      frame -> features               any order, any thread
//   Label        features -> labels              frames in order, one thread
//   LearnLabels  labels -> model -> posterior    frames in order, one thread, not Label's perhaps
//   Infer        frame, posterior -> map         any order, any thread
//
// The posterior of a frame is the process's, what it leaves of the frame's own labels near them
// (label_residual.h), and where things have moved so far (location_prior.h). Beside it, where that
// is asked for, a slow model tells what looks like the things that move (potential_model.h).
//
// Learn is the second and third, Process all. The map of frame t is evaluated on frame t after the
// pair that ends in t was learnt; frames before the first pair get the prior. No frame is an error
// for what it shows: where nothing can be learnt the map comes from the model as it is, and the
// record says why.
#ifndef EGOSIEVE_VISION_SEGMENTATION_ONLINE_SEGMENTER_H_
#define EGOSIEVE_VISION_SEGMENTATION_ONLINE_SEGMENTER_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "gp/model/posterior.h"
#include "kernels/ops/descriptor_field.h"
#include "kernels/runtime/context.h"
#include "vision/frame/frame.h"
#include "vision/labelling/frame_labeller.h"
#include "vision/segmentation/frame_record.h"
#include "vision/segmentation/label_residual.h"
#include "vision/segmentation/location_prior.h"
#include "vision/segmentation/online_learner.h"
#include "vision/segmentation/potential_model.h"
#include "vision/segmentation/segmentation_map.h"

namespace egosieve::vision {

struct OnlineSegmenterOptions {
  FrameLabellerOptions labeller;
  OnlineLearnerOptions learner;
  LocationPriorOptions location_prior;
  PotentialOptions potential;
  double residual_weight = 0.0;  // w of label_residual.h; in [0, 1], 0: the process alone
  kernels::DescriptorOptions descriptor;
  // Later frames that a frame's labels may use, where the caller has them: a recording, not a live
  // camera. From 0 to 100.
  int ahead_frames = FrameLabellerOptions::kLongestAutoGap;
  int stride_pixels = 5;  // of the grid on which the posterior is evaluated; at least 1

  // What works best on handheld and driving video.
  static OnlineSegmenterOptions Default();
  // Faithful to the paper's sections III to V.
  static OnlineSegmenterOptions Paper();
  // Default with labels from pictures of 640 pixels and neighbouring frames, and 128 inducing
  // inputs instead of 256.
  static OnlineSegmenterOptions Fast();

  // One seed for everything that is random.
  void SetSeed(uint64_t seed);
  absl::Status Validate() const;
};

// What a frame's map is made of. A value: the segmenter goes on without it.
struct MapPosterior {
  std::shared_ptr<const gp::Posterior> process;
  LocationPrior location;
  std::shared_ptr<const gp::Posterior> potential;  // null before it has learnt
  LabelResidual residual;                          // of the frame learnt last
};

class OnlineSegmenter {
 public:
  static absl::StatusOr<std::unique_ptr<OnlineSegmenter>> Create(
      std::shared_ptr<kernels::Context> context, const OnlineSegmenterOptions& options);

  struct Learnt {
    std::shared_ptr<const MapPosterior> posterior;
    LabelledFrame labels;
    FrameRecord record;
  };
  struct Result {
    SegmentationMap map;
    LabelledFrame labels;
    FrameRecord record;
  };

  absl::StatusOr<std::shared_ptr<const ExtractedFrame>> Extract(const Frame& frame) const;
  // `ahead`: of the frames after this one, in order, as many as there are of
  // options().ahead_frames; none for a live camera.
  absl::StatusOr<LabelledFrame> Label(
      std::shared_ptr<const ExtractedFrame> extracted,
      const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead = {});
  // Without `with_posterior` none is made.
  absl::StatusOr<Learnt> LearnLabels(const Frame& frame, LabelledFrame labels,
                                     bool with_posterior = true);
  absl::StatusOr<Learnt> Learn(
      const Frame& frame, std::shared_ptr<const ExtractedFrame> extracted,
      bool with_posterior = true,
      const std::vector<std::shared_ptr<const ExtractedFrame>>& ahead = {});
  // Fills `record.milliseconds.inference`, `dynamic_share` and `clamped_variances` as well.
  absl::StatusOr<SegmentationMap> Infer(const Frame& frame, const MapPosterior& posterior,
                                        FrameRecord& record) const;

  absl::StatusOr<Result> Process(const Frame& frame);

  // Learning once more what another segmenter, alike in state and options, has learnt already:
  // RecordSteps before its first frame, TakeStep after each Learn, as bytes (learning_step.h);
  // Replay with those bytes instead of Extract and Learn, frame by frame, gives the posteriors that
  // Learn gave, to the last bit. Checkpoint where the other did. Errors of bytes that are no step:
  // ParseStep's; the segmenter may have changed then.
  void RecordSteps() { learner_->RecordSteps(); }
  absl::StatusOr<std::string> TakeStep();
  absl::Status Replay(absl::string_view step);
  absl::StatusOr<std::shared_ptr<const MapPosterior>> MakePosterior();

  // The state after the frame learnt last, as the bytes of a model file (gp/io/model_file.h).
  // Between two frames; this segmenter and one restored from the bytes go on alike to the last bit.
  absl::StatusOr<std::string> Checkpoint() { return Checkpoint(LabellerState()); }
  // The same where Label is ahead of LearnLabels: LabellerState() was asked behind the frame's
  // Label, on the thread that labels.
  absl::StatusOr<std::string> Checkpoint(absl::string_view labeller_state);
  std::string LabellerState() const { return labeller_->state(); }
  // Goes on from a checkpoint. `recent`: the last HistoryFrames() frames before it that could be
  // read (all where there were fewer), oldest first.
  absl::Status Restore(absl::string_view checkpoint, const std::vector<Frame>& recent);

  const OnlineSegmenterOptions& options() const { return options_; }
  const OnlineLearner& learner() const { return *learner_; }

 private:
  OnlineSegmenter(std::shared_ptr<kernels::Context> context, const OnlineSegmenterOptions& options,
                  std::unique_ptr<FrameLabeller> labeller, std::unique_ptr<OnlineLearner> learner);

  // Of the frame's labels and the process as it has just learnt them.
  absl::Status TakeResidual(const LabelledFrame& labels, kernels::ConstMatrixView<float> places);
  absl::Status InferPotential(const MapPosterior& posterior, kernels::ConstMatrixView<float> field,
                              SegmentationMap& map) const;

  // The frame as the descriptors see it: equalised where that is asked for.
  Frame Equalized(const Frame& frame) const;

  std::shared_ptr<kernels::Context> context_;
  OnlineSegmenterOptions options_;
  std::unique_ptr<FrameLabeller> labeller_;
  std::unique_ptr<OnlineLearner> learner_;
  LocationPrior location_prior_;
  PotentialModel potential_;
  LabelResidual residual_;
  std::shared_ptr<const gp::Posterior> process_;   // of the learner as it is; null: to be made
  std::shared_ptr<const MapPosterior> posterior_;  // of the model as it is; null: to be made
};

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_SEGMENTATION_ONLINE_SEGMENTER_H_
